//! Numbers and errors of the rays of a frame, of which strip after strip is traced and forgotten.

use super::digest::ErrorList;
use super::trace_result::TraceStrip;
use crate::num::stats::{Summary, SummaryBuilder};
use crate::parallel;

/// Numbers of the rays aimed at the mirror by outcome, and their errors.
#[derive(Debug, Clone, Default)]
pub struct TraceSummary {
    /// Rays aimed at the mirror.
    pub aimed: usize,
    /// Of these, reflected into the world.
    pub hit: usize,
    /// Meeting nothing.
    pub missed: usize,
    /// Reflected against the part itself.
    pub shadowed: usize,
    /// Meeting the back of a facet.
    pub back_face: usize,
    /// Hidden by an obstacle.
    pub obstructed: usize,
    facet: ErrorSummary,
    smooth: ErrorSummary,
}

/// Summaries of the errors of rays.
#[derive(Debug, Clone, Default)]
struct ErrorSummary {
    angle_rad: SummaryBuilder,
    image_mm: SummaryBuilder,
    facet_mm: SummaryBuilder,
}

impl ErrorSummary {
    fn add(&mut self, lists: &[&ErrorList]) {
        let add = |to: &mut SummaryBuilder, list: fn(&ErrorList) -> &[f64]| {
            lists.iter().for_each(|errors| to.extend(list(errors)));
        };
        let Self { angle_rad, image_mm, facet_mm } = self;
        parallel::join(
            || add(angle_rad, |list| &list.angle_rad),
            || {
                parallel::join(
                    || add(image_mm, |list| &list.image_mm),
                    || add(facet_mm, |list| &list.facet_mm),
                )
            },
        );
    }

    fn finish(self) -> [Option<Summary>; 3] {
        let Self { angle_rad, image_mm, facet_mm } = self;
        let (angle_rad, (image_mm, facet_mm)) = parallel::join(
            || angle_rad.finish(),
            || parallel::join(|| image_mm.finish(), || facet_mm.finish()),
        );
        [angle_rad, image_mm, facet_mm]
    }
}

impl TraceSummary {
    /// Adds a strip, which follows those that were added before.
    pub fn add(&mut self, strip: &TraceStrip) {
        let digests = &strip.digests;
        for digest in digests {
            self.aimed += digest.aimed;
            self.hit += digest.hit;
            self.missed += digest.missed;
            self.shadowed += digest.shadowed;
            self.back_face += digest.back_face;
            self.obstructed += digest.obstructed;
        }
        let [facet, smooth]: [Vec<&ErrorList>; 2] = [
            digests.iter().map(|digest| &digest.facet).collect(),
            digests.iter().map(|digest| &digest.smooth).collect(),
        ];
        self.facet.add(&facet);
        self.smooth.add(&smooth);
    }

    /// Summaries of the angles, radians, of the distances in the image from where the content belongs, mm, and
    /// of those from what the designed mirror shows, mm: by facets, and by the file's interpolated normals.
    #[must_use]
    pub fn errors(self) -> [[Option<Summary>; 3]; 2] {
        [self.facet.finish(), self.smooth.finish()]
    }
}
