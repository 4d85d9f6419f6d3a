//! Commands: from arguments to options.

use super::args::{BlurArgs, BuildArgs, InspectArgs, MachiningArgs, ToleranceArgs, VerifyArgs};
use super::picture_args::{FrameArgs, MapFormatArg, RenderArgs, RowsArg, TableArgs, UnwrapArgs};
use crate::pipeline::{
    BlurOptions, BuildOptions, Effort, FrameOptions, InspectOptions, MachiningOptions, MapFormat,
    RenderOptions, ReplayOptions, Rows, TableOptions, ToleranceOptions, Unwrap, UnwrapOptions,
    UnwrapPicture, Verify, VerifyOptions,
};
use crate::results::Aperture;
use std::num::NonZeroUsize;

impl BuildArgs {
    pub(super) fn options(&self) -> BuildOptions {
        let effort = match (self.no_skip, self.force) {
            (true, _) => Effort::Most,
            (_, true) => Effort::Afresh,
            _ => Effort::Least,
        };
        BuildOptions { effort }
    }
}

impl VerifyArgs {
    pub(super) fn command(&self) -> Verify<'_> {
        let (units, align) = (self.units.map(Into::into), self.align);
        let (probe_mm, ball_mm) = (self.probe_mm, self.ball_mm);
        let options = VerifyOptions { units, align, probe_mm, ball_mm };
        Verify { path: &self.file, options }
    }
}

impl InspectArgs {
    pub(super) fn options(&self) -> InspectOptions {
        InspectOptions { degree: self.degree, margin_mm: self.margin_mm }
    }
}

impl RenderArgs {
    pub(super) fn options(&self) -> RenderOptions<'_> {
        RenderOptions {
            scene: &self.scene,
            smooth: self.smooth,
            square_mm: self.square_mm,
            unit_mm: self.unit_mm,
            allow_outside: self.allow_outside,
        }
    }
}

impl FrameArgs {
    pub(super) fn options(&self) -> FrameOptions {
        FrameOptions { min: self.min }
    }
}

impl UnwrapArgs {
    pub(super) fn command(&self) -> Unwrap<'_> {
        let [width, height] = [self.width, self.height].map(|pixels| pixels.map(NonZeroUsize::get));
        let (range_mm, mm_per_px) = (self.range_mm, self.mm_per_px);
        let picture = match (self.view, self.ground) {
            (Some(angles), _) => UnwrapPicture::View { angles, width, height },
            (_, Some(height_mm)) => UnwrapPicture::Ground { height_mm, range_mm, mm_per_px },
            _ => {
                let projection = self.projection.map(Into::into);
                UnwrapPicture::Panorama { projection, width }
            }
        };
        let (map, pose) = (self.map.map(Into::into), self.pose.as_deref());
        let remap = UnwrapOptions::Remap { picture, map, pose };
        Unwrap { photo: &self.photo, options: if self.cuts { UnwrapOptions::Cuts } else { remap } }
    }
}

impl TableArgs {
    pub(super) fn options(&self) -> TableOptions<'_> {
        TableOptions {
            every: self.every,
            floor_mm: self.floor_mm,
            range_mm: self.range_mm,
            mm_per_px: self.mm_per_px,
            deg_per_px: self.deg_per_px,
            pose: self.pose.as_deref(),
        }
    }
}

impl BlurArgs {
    pub(super) fn options(&self) -> BlurOptions {
        let pupil = self.pupil_mm.map(|pupil_mm| Aperture::Pupil { pupil_mm });
        let aperture = pupil.or(self.na.map(|na| Aperture::Na { na }));
        BlurOptions { aperture, focus_mm: self.focus_mm }
    }
}

impl ToleranceArgs {
    pub(super) fn options(&self) -> ToleranceOptions {
        ToleranceOptions { range: self.trials.clone(), seed: self.seed, until: self.until }
    }

    pub(super) fn replay(&self, trial: u64) -> ReplayOptions<'_> {
        ReplayOptions { trial, seed: self.seed, without: &self.without }
    }
}

impl MachiningArgs {
    pub(super) fn options(&self) -> MachiningOptions {
        MachiningOptions {
            ball_mm: self.ball_mm,
            stepover_mm: self.stepover_mm,
            angle_deg: self.angle_deg,
            budget_px: self.budget_px,
            scallop_um: self.scallop_um,
            allowance_mm: self.allowance_mm,
            as_cut: !self.no_as_cut,
        }
    }
}

impl From<RowsArg> for Rows {
    fn from(rows: RowsArg) -> Self {
        match rows {
            RowsArg::Cylindrical => Self::Cylindrical,
            RowsArg::Equirectangular => Self::Equirectangular,
            RowsArg::Mercator => Self::Mercator,
        }
    }
}

impl From<MapFormatArg> for MapFormat {
    fn from(format: MapFormatArg) -> Self {
        match format {
            MapFormatArg::Npy => Self::Npy,
            MapFormatArg::Exr => Self::Exr,
        }
    }
}
