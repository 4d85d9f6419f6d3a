//! The bound of a whole mesh, near the largest errors that its facets attain.

use super::branch_and_bound::{Enclosure, NEGLIGIBLE};
use super::error_bound::{ErrorBound, ErrorKind, Limits};
use super::error_bounder::ErrorBounder;
use super::tuning::TUNING;
use super::vertex::SurfaceVertex;
use crate::parallel;

/// Facets that a thread takes at a time, at least: some microseconds of work.
const CHUNK: usize = 32;

/// A mesh whose facets are bounded one by one.
pub(crate) struct MeshBound<'a> {
    /// The bounder of its facets.
    pub bounder: &'a ErrorBounder<'a>,
    /// Its vertices.
    pub vertices: &'a [SurfaceVertex],
    /// Its facets, as numbers of vertices.
    pub facets: &'a [[u32; 3]],
}

impl<'a> MeshBound<'a> {
    /// Bounds over all facets, within `limits`, from the bounds of each: they exceed attained errors by some per cent,
    /// as far as division of facets can bring them there. Facets that are likely to have the largest errors are
    /// `largest`.
    pub(crate) fn bound(
        &self,
        bounds: &[ErrorBound],
        largest: &[u32],
        limits: &Limits,
    ) -> ErrorBound {
        let mut bound = bounds.iter().copied().fold(ErrorBound::default(), ErrorBound::max);
        // Mostly the bound is near what one of these attains.
        let attained = parallel::map_slice(largest, CHUNK, |&t| {
            let (_, attained) = self.bounder.enclose(self.corners(t));
            attained
        });
        let more = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        let attained = attained.into_iter().fold([0.0; 2], more);
        for kind in ErrorKind::ALL {
            let known = kind.of(&bound);
            let ceiling = kind.limit(limits).unwrap_or(f64::INFINITY);
            let found = self.largest(kind, bounds, [known, ceiling], kind.of_both(attained));
            kind.set(&mut bound, found);
        }
        bound
    }

    fn corners(&self, t: u32) -> [&'a SurfaceVertex; 3] {
        self.facets[t as usize].map(|v| &self.vertices[v as usize])
    }

    /// A bound of one error over all facets, mm, at most `known`, where some facet attains `attained`. The facets whose
    /// bounds are well over what is attained are divided, those of the largest bounds first.
    fn largest(
        &self,
        kind: ErrorKind,
        bounds: &[ErrorBound],
        [known, ceiling]: [f64; 2],
        mut attained: f64,
    ) -> f64 {
        let is_tight = |attained: f64| self.bounder.is_tight(&Enclosure { bound: known, attained });
        if is_tight(attained) {
            return known;
        }
        let least = NEGLIGIBLE * self.bounder.mirror().outline.bounds().size().max_element();
        let enough = |attained: f64| ((1.0 + TUNING.tightness) * attained).max(least).min(ceiling);
        let (mut rest, loose) = split_by_bound(kind, bounds, enough(attained));
        let slow = kind == ErrorKind::Facet && !self.bounder.direction_only;
        let [most, divisions] = if slow {
            [TUNING.most_slow_batches, TUNING.most_slow_batch_divisions]
        } else {
            [usize::MAX; 2]
        };
        for (k, batch) in loose.chunks(TUNING.mesh_batch).enumerate() {
            if is_tight(attained) {
                return known;
            }
            let goal = enough(attained).max(rest);
            if batch[0].0 <= goal || k == most {
                return rest.max(batch[0].0).min(known);
            }
            let look = |&(quick, t): &(f64, u32)| {
                let mut left = divisions;
                self.bounder.branch_and_bound(self.corners(t), kind, quick, |found: &Enclosure| {
                    left -= 1;
                    left == 0
                        || found.bound <= goal
                        || (self.bounder.is_tight(found) && found.bound <= ceiling)
                        || is_tight(found.attained)
                })
            };
            for one in parallel::map_slice(batch, 1, look) {
                (rest, attained) = (rest.max(one.bound), attained.max(one.attained));
            }
        }
        rest.min(known)
    }
}

/// The largest bound that is at most `enough`, and the facets with larger bounds, the largest first.
fn split_by_bound(kind: ErrorKind, bounds: &[ErrorBound], enough: f64) -> (f64, Vec<(f64, u32)>) {
    let mut rest = 0.0f64;
    let mut loose: Vec<(f64, u32)> = Vec::new();
    for (t, bound) in bounds.iter().enumerate() {
        let bound = kind.of(bound);
        if bound <= enough {
            rest = rest.max(bound);
        } else {
            let bound = if bound.is_nan() { f64::INFINITY } else { bound };
            loose.push((bound, t as u32));
        }
    }
    loose.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    (rest, loose)
}
