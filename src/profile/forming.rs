//! A tool in the place of the part: the mould or mandrel on which a sheet is formed, or that a resin is cast in.

use serde::{Deserialize, Serialize};

/// A forming tool, and the sheet that is formed on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FormingSpec {
    /// The tool.
    pub form: ToolForm,
    /// Thickness of the formed sheet, mm; 0 of what is cast, or deposited on the tool.
    pub sheet_mm: f64,
    /// The sheet's side that mirrors.
    pub mirror_side: MirrorSide,
    /// What the piece shrinks by when it leaves the tool, parts per million of its lengths.
    pub shrinkage_ppm: f64,
    /// Angle of the walls beside the tool's face to the direction in which the piece is lifted, degrees.
    pub draft_deg: f64,
    /// Material of a mould behind the deepest place of its face, mm.
    pub back_mm: f64,
    /// Vents around the foot of a mandrel's walls.
    pub vents: Vents,
}

/// Form of a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ToolForm {
    /// The negative: its face is on the camera's side of the mirror.
    Mould,
    /// The positive: its face is on the other side.
    Mandrel,
}

/// Side of a formed sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum MirrorSide {
    /// The side that lies on the tool.
    Tool,
    /// The other one.
    Free,
}

/// Round holes through a mandrel, evenly along the foot of its walls, where air is shut in last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vents {
    /// How many there are.
    pub count: usize,
    /// Their diameter, mm.
    pub diameter_mm: f64,
}

impl ToolForm {
    /// Its name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mould => "mould",
            Self::Mandrel => "mandrel",
        }
    }

    /// The sheet's side that the camera sees without looking through the sheet.
    #[must_use]
    pub fn seen_side(self) -> MirrorSide {
        match self {
            Self::Mould => MirrorSide::Tool,
            Self::Mandrel => MirrorSide::Free,
        }
    }
}

impl MirrorSide {
    /// Its name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tool => "tool",
            Self::Free => "free",
        }
    }
}

impl FormingSpec {
    /// Usual draft, degrees: that of polished moulds for thermoforming and casting.
    pub const USUAL_DRAFT_DEG: f64 = 3.0;
    /// Usual diameter of vents, mm: what leaves no mark on sheets of 1 mm and more.
    pub const USUAL_VENT_MM: f64 = 0.6;

    /// Distance of the tool's face from the mirror along the mirror's normal, mm: negative behind the mirror.
    #[must_use]
    pub fn offset_mm(&self) -> f64 {
        match (self.mirror_side, self.form) {
            (MirrorSide::Tool, _) => 0.0,
            (MirrorSide::Free, ToolForm::Mould) => self.sheet_mm,
            (MirrorSide::Free, ToolForm::Mandrel) => -self.sheet_mm,
        }
    }

    /// Distance of the sheet's side that does not mirror from the mirror along the mirror's normal, mm.
    #[must_use]
    pub fn other_side_mm(&self) -> f64 {
        match (self.mirror_side, self.form) {
            (MirrorSide::Free, _) => self.offset_mm(),
            (MirrorSide::Tool, ToolForm::Mould) => -self.sheet_mm,
            (MirrorSide::Tool, ToolForm::Mandrel) => self.sheet_mm,
        }
    }

    /// Whether the camera looks through the sheet at its mirror, which refracts what it sees.
    #[must_use]
    pub fn is_behind_sheet(&self) -> bool {
        self.sheet_mm > 0.0 && self.mirror_side != self.form.seen_side()
    }

    /// Lengths of the tool over those of the piece that has shrunk.
    #[must_use]
    pub fn growth(&self) -> f64 {
        1.0 / (1.0 - self.shrinkage_ppm * 1e-6)
    }
}
