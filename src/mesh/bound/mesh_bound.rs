//! The bound of a whole mesh, near the largest errors that its facets have.

use super::branch_and_bound::{Enclosure, ErrorKind, LOOSE, NOTHING};
use super::error_bounder::{ErrorBound, ErrorBounder, SurfaceVertex};
use crate::mesh::Limits;
use crate::parallel;

/// Facets a thread looks at at a time, at least.
const FEW: usize = 32;
/// Facets that are taken apart before what they reach decides about the others; fixed, so that
/// results do not depend on the thread count.
const BATCH: usize = 32;
/// Batches after which the bound is left as it is where taking facets apart takes long, and splits
/// after which that of one is.
const SLOW_BATCHES: usize = 64;
const SLOW_SPLITS: usize = 48;

/// A mesh whose facets are proven.
pub struct MeshBound<'a> {
    /// By whom.
    pub prover: &'a ErrorBounder<'a>,
    /// Its corners.
    pub vertices: &'a [SurfaceVertex],
    /// Their numbers.
    pub facets: &'a [[u32; 3]],
}

impl<'a> MeshBound<'a> {
    /// Bounds over all facets, of which `bounds` are those of each, within `limits`: within some per
    /// cent of errors that are reached, as far as facets can be taken apart for it. Some of the
    /// facets that may have large errors are `largest`.
    pub fn bound(&self, bounds: &[ErrorBound], largest: &[u32], limits: &Limits) -> ErrorBound {
        let mut bound = bounds.iter().copied().fold(ErrorBound::default(), ErrorBound::max);
        // Mostly, that is near what one of these reaches.
        let reached = parallel::map_slice(largest, FEW, |&t| {
            let (_, reached) = self.prover.estimate(self.corners(t));
            reached
        });
        let more = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        let reached = reached.into_iter().fold([0.0; 2], more);
        for kind in [ErrorKind::Chord, ErrorKind::Facet] {
            let known = kind.of(&bound);
            let ceiling = kind.limit(limits).unwrap_or(f64::INFINITY);
            let found = self.largest(kind, bounds, [known, ceiling], kind.of_both(reached));
            kind.set(&mut bound, found);
        }
        bound
    }

    fn corners(&self, t: u32) -> [&'a SurfaceVertex; 3] {
        self.facets[t as usize].map(|v| &self.vertices[v as usize])
    }

    /// A bound of one error, at most the one that is `known`; `reached` is reached. The facets whose
    /// bounds are well over that are taken apart, the largest first.
    fn largest(
        &self,
        kind: ErrorKind,
        bounds: &[ErrorBound],
        [known, ceiling]: [f64; 2],
        mut reached: f64,
    ) -> f64 {
        let is_near = |reached: f64| self.prover.is_near(&Enclosure { bound: known, reached });
        if is_near(reached) {
            return known;
        }
        let least = NOTHING * self.prover.mirror().outline.bounds().size().max_element();
        let enough = |reached: f64| ((1.0 + LOOSE) * reached).max(least).min(ceiling);
        let mut rest = 0.0f64;
        let mut loose: Vec<(f64, u32)> = Vec::new();
        for (t, bound) in bounds.iter().enumerate() {
            let bound = kind.of(bound);
            if bound <= enough(reached) {
                rest = rest.max(bound);
            } else {
                let bound = if bound.is_nan() { f64::INFINITY } else { bound };
                loose.push((bound, t as u32));
            }
        }
        loose.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let slow = kind == ErrorKind::Facet && !self.prover.plain;
        let [most, splits] = if slow { [SLOW_BATCHES, SLOW_SPLITS] } else { [usize::MAX; 2] };
        for (k, batch) in loose.chunks(BATCH).enumerate() {
            if is_near(reached) {
                return known;
            }
            let goal = enough(reached).max(rest);
            if batch[0].0 <= goal || k == most {
                return rest.max(batch[0].0).min(known);
            }
            let look = |&(quick, t): &(f64, u32)| {
                let mut left = splits;
                let near = |found: &Enclosure| {
                    left -= 1;
                    left == 0
                        || found.bound <= goal
                        || (self.prover.is_near(found) && found.bound <= ceiling)
                        || is_near(found.reached)
                };
                self.prover.search(self.corners(t), kind, quick, near)
            };
            for one in parallel::map_slice(batch, 1, look) {
                (rest, reached) = (rest.max(one.bound), reached.max(one.reached));
            }
        }
        rest.min(known)
    }
}
