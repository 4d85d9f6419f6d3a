//! Commands: from arguments to options.

use super::args::{BlurArgs, BuildArgs, InspectArgs, MachiningArgs, ToleranceArgs, VerifyArgs};
use super::picture_args::{
    FrameArgs, MapFormatArg, RawFormatArg, RenderArgs, RowsArg, TableArgs, UnwrapArgs,
};
use crate::pipeline::{
    BlurOptions, BuildOptions, Effort, FrameOptions, InspectOptions, MachiningOptions, MapFormat,
    RawFormat, RawFrames, RenderOptions, ReplayOptions, Rows, TableOptions, ToleranceOptions,
    Unwrap, UnwrapFolder, UnwrapOptions, UnwrapPicture, UnwrapStream, Verify, VerifyOptions,
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
        let options = VerifyOptions {
            units: self.units.map(Into::into),
            align: self.align,
            probe_mm: self.probe_mm,
            ball_mm: self.ball_mm,
            cutter_mm: self.cutter_mm,
            corner_mm: self.corner_mm,
            nose_mm: self.nose_mm,
        };
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
    fn picture(&self) -> UnwrapPicture {
        let [width, height] = [self.width, self.height].map(|pixels| pixels.map(NonZeroUsize::get));
        let (range_mm, mm_per_px) = (self.range_mm, self.mm_per_px);
        match (self.view, self.ground) {
            (Some(angles), _) => UnwrapPicture::View { angles, width, height },
            (_, Some(height_mm)) => UnwrapPicture::Ground { height_mm, range_mm, mm_per_px },
            _ => {
                let projection = self.projection.map(Into::into);
                UnwrapPicture::Panorama { projection, width }
            }
        }
    }

    pub(super) fn command(&self) -> Unwrap<'_> {
        let (map, pose) = (self.map.map(Into::into), self.pose.as_deref());
        let remap = UnwrapOptions::Remap { picture: self.picture(), map, pose };
        Unwrap { photo: &self.photo, options: if self.cuts { UnwrapOptions::Cuts } else { remap } }
    }

    /// The command for a folder of photos.
    pub(super) fn folder(&self) -> UnwrapFolder<'_> {
        let (map, pose) = (self.map.map(Into::into), self.pose.as_deref());
        UnwrapFolder { photos: &self.photo, picture: self.picture(), map, pose }
    }

    /// The command for a stream of frames.
    pub(super) fn stream(&self) -> UnwrapStream<'_> {
        let raw = self.raw.map(|format| RawFrames { format: format.into(), pixels: self.pixels });
        UnwrapStream { picture: self.picture(), pose: self.pose.as_deref(), raw }
    }

    /// What is asked for, but not of such a photo: why, and what to do.
    pub(super) fn misplaced(&self) -> Option<&'static str> {
        let is_stream = self.is_stream();
        let is_folder = !is_stream && self.photo.is_dir();
        match self {
            Self { raw: Some(_), .. } if !is_stream => {
                Some("--raw is for frames on standard input; write - in the place of the photo")
            }
            Self { cuts: true, .. } if is_stream || is_folder => {
                Some("--cuts is for one photo; leave it out, or name a photo")
            }
            Self { map: Some(_), .. } if is_stream => Some(
                "--map writes a file, and a stream is none; unwrap one of its frames, a PNG, with --map",
            ),
            Self { out: Some(_), .. } if is_stream => Some(
                "--out is a folder, and frames of a stream go to standard output; write > FILE in its place",
            ),
            _ => None,
        }
    }
}

impl From<RawFormatArg> for RawFormat {
    fn from(format: RawFormatArg) -> Self {
        match format {
            RawFormatArg::Rgb24 => Self::Rgb24,
            RawFormatArg::Gray8 => Self::Gray8,
        }
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
