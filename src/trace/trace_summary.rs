//! Numbers and errors of the rays of a frame, of which strip after strip is traced and forgotten.

use super::digest::ErrorList;
use super::outcome_counts::OutcomeCounts;
use super::trace_strip::TraceStrip;
use crate::num::stats::{Summary, SummaryBuilder};
use crate::parallel;

/// Numbers of the rays aimed at the mirror by outcome, and their errors.
#[derive(Debug, Clone, Default)]
pub struct TraceSummary {
    /// Numbers of the rays.
    pub counts: OutcomeCounts,
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
        digests.iter().for_each(|digest| self.counts.add(&digest.counts));
        let facet: Vec<&ErrorList> = digests.iter().map(|digest| &digest.facet).collect();
        self.facet.add(&facet);
        let mut smooth = ErrorList::default();
        digests.iter().flat_map(|digest| &digest.smooth).for_each(|errors| smooth.push(*errors));
        self.smooth.add(&[&smooth]);
    }

    /// Summaries of the angles, radians, of the distances in the image from where the content belongs, mm, and
    /// of those from what the designed mirror shows, mm: by facets, and by the file's interpolated normals.
    #[must_use]
    pub fn errors(self) -> [[Option<Summary>; 3]; 2] {
        [self.facet.finish(), self.smooth.finish()]
    }
}
