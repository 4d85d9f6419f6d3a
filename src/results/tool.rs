//! The forming tool that is made in the part's place.

use crate::forming::FormingTool;
use crate::profile::{FormingSpec, MirrorSide, ToolForm};
use serde::{Deserialize, Serialize};

/// A mould or a mandrel, and the sheet that is formed on it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ToolFacts {
    /// The tool.
    pub form: ToolForm,
    /// The sheet's side that mirrors.
    pub mirror_side: MirrorSide,
    /// Thickness of the sheet, mm; 0 of what is cast, or deposited on the tool.
    pub sheet_mm: f64,
    /// Distance of the tool's face from the mirror along the mirror's normal, mm; negative behind the mirror.
    pub offset_mm: f64,
    /// What the piece shrinks by when it leaves the tool, parts per million.
    pub shrinkage_ppm: f64,
    /// Angle of the walls to the vertical, degrees.
    pub draft_deg: f64,
    /// Length of the tool along each axis, mm.
    pub size_mm: [f64; 3],
    /// Length of the foot of its walls along X and Y, mm.
    pub foot_mm: [f64; 2],
    /// Z of the plane in which its walls end, in the tool's frame, mm.
    pub flange_mm: f64,
    /// Its volume, mm^3.
    pub volume_mm3: f64,
    /// Least length of the sheet's sides over that of the mirror: near 0 the sheet is almost as thick as the mirror's radius
    /// of curvature.
    pub least_stretch: f64,
}

impl ToolFacts {
    /// Those of `tool`.
    pub(crate) fn of(tool: &FormingTool) -> Self {
        let FormingSpec { form, mirror_side, sheet_mm, shrinkage_ppm, draft_deg, .. } = tool.spec;
        let foot_mm = tool.foot.bounds().size().to_array();
        Self {
            form,
            mirror_side,
            sheet_mm,
            offset_mm: tool.spec.offset_mm(),
            shrinkage_ppm,
            draft_deg,
            size_mm: tool.size_mm,
            foot_mm,
            flange_mm: tool.flange_mm,
            volume_mm3: tool.volume_mm3,
            least_stretch: tool.least_stretch,
        }
    }

    /// What no figure of a build with this sheet counts, where there is something.
    pub(crate) fn warning(sheet: &FormingSpec) -> Option<String> {
        sheet.is_behind_sheet().then(|| {
            format!(
                "the camera looks through the sheet of {} mm at its mirror, and what the sheet refracts is not counted; \
                 forming.mirror_side = \"{}\" mirrors on the side that it sees",
                sheet.sheet_mm,
                sheet.form.seen_side().name()
            )
        })
    }
}
