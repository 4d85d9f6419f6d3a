//! Branch and bound: a facet is divided, for the proof alone, until its bound is near the error that it attains.
//!
//! The errors are known at the corners of a part, and what its interior may add shrinks by 8 (chord error) or 4 (facet
//! error) with each halving of its edges. The part of the largest bound is divided first.

use super::error_bound::{ErrorBound, ErrorKind, Limits};
use super::error_bounder::ErrorBounder;
use super::facet_parts::{FacetParts, FacetPoint};
use super::tuning::TUNING;
use super::vertex::SurfaceVertex;
use crate::num::max_or_nan;

/// Errors that rounding of the proof itself may cause, as a share of the mirror's size: they count as none.
pub(crate) const NEGLIGIBLE: f64 = 1e-12;

/// A part of a facet.
#[derive(Debug, Clone, Copy)]
struct FacetPart {
    corners: [FacetPoint; 3],
    /// Upper bound of its error, mm.
    bound: f64,
}

/// The largest error of one kind on a facet, from both sides, mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Enclosure {
    /// Upper bound of the error.
    pub bound: f64,
    /// An error that the facet has somewhere.
    pub attained: f64,
}

impl ErrorBounder<'_> {
    /// Bounds over a facet whose quick bounds, `bound`, exceed `limits`: it is divided until they are proven to hold or
    /// seen to be broken.
    #[must_use]
    pub(crate) fn bound_until_decided(
        &self,
        t: [&SurfaceVertex; 3],
        mut bound: ErrorBound,
        limits: &Limits,
    ) -> ErrorBound {
        if bound == ErrorBound::INFINITE {
            return bound;
        }
        for kind in ErrorKind::ALL {
            let Some(limit) = kind.limit(limits) else { continue };
            let quick = kind.of(&bound);
            let decidable =
                if self.table.is_axial() { f64::INFINITY } else { TUNING.decidable_ratio * limit };
            if quick > limit && quick <= decidable {
                let slow = kind == ErrorKind::Facet && !self.direction_only;
                let mut left = if slow {
                    TUNING.most_slow_divisions_to_decide
                } else {
                    TUNING.most_divisions_to_decide
                };
                let found = self.branch_and_bound(t, kind, quick, |found| {
                    left -= 1;
                    left == 0 || found.bound <= limit || found.attained > limit
                });
                kind.set(&mut bound, found.bound);
            }
        }
        bound
    }

    /// Bounds that are near the errors that the facet attains, as far as division can bring them there.
    #[must_use]
    pub fn bound_tightly(&self, t: [&SurfaceVertex; 3]) -> ErrorBound {
        let mut bound = self.bound(t);
        if bound == ErrorBound::INFINITE {
            return bound;
        }
        for kind in ErrorKind::ALL {
            let is_tight = |found: &Enclosure| self.is_tight(found);
            let found = self.branch_and_bound(t, kind, kind.of(&bound), is_tight);
            kind.set(&mut bound, found.bound);
        }
        bound
    }

    /// Bounds that a few divisions bring near those errors which have limits, or well below these.
    pub(crate) fn bound_roughly(&self, t: [&SurfaceVertex; 3], limits: &Limits) -> ErrorBound {
        let (mut bound, attained) = self.enclose(t);
        if bound == ErrorBound::INFINITE {
            return bound;
        }
        for kind in ErrorKind::ALL {
            let Some(limit) = kind.limit(limits) else { continue };
            let low = TUNING.well_below_limit * limit;
            let quick = Enclosure { bound: kind.of(&bound), attained: kind.of_both(attained) };
            if !(quick.bound <= low || self.is_tight(&quick)) {
                let mut left = TUNING.most_rough_divisions;
                let found = self.branch_and_bound(t, kind, quick.bound, |found| {
                    left -= 1;
                    left == 0 || found.bound <= low || self.is_tight(found)
                });
                kind.set(&mut bound, found.bound);
            }
        }
        bound
    }

    /// Whether a bound is as near to the attained error as it need be.
    pub(crate) fn is_tight(&self, found: &Enclosure) -> bool {
        let least = NEGLIGIBLE * self.mirror().outline.bounds().size().max_element();
        found.bound <= ((1.0 + TUNING.tightness) * found.attained).max(least)
    }

    /// Whether the facet, which has no bound of the facet error, lies where the mirror may look along its axis, so that
    /// there is no image point.
    #[must_use]
    pub(crate) fn may_be_on_axis(&self, t: &[SurfaceVertex; 3]) -> bool {
        let frame = self.table.frame(t.each_ref().map(|v| v.q));
        self.table.region(&self.problem, &frame, frame.triangle.diameter, 0.0).may_be_on_axis
            && !self.has_facet_bound(t.each_ref())
    }

    /// Whether the facet error has a finite bound.
    fn has_facet_bound(&self, t: [&SurfaceVertex; 3]) -> bool {
        let is_finite = |found: &Enclosure| found.bound < f64::INFINITY;
        let quick = self.bound(t);
        quick != ErrorBound::INFINITE
            && is_finite(&self.branch_and_bound(t, ErrorKind::Facet, quick.facet_mm, is_finite))
    }

    /// Encloses one error of the facet `t`, of which `quick` is a bound (mm), until `enough` is known.
    pub(crate) fn branch_and_bound(
        &self,
        t: [&SurfaceVertex; 3],
        kind: ErrorKind,
        quick: f64,
        mut enough: impl FnMut(&Enclosure) -> bool,
    ) -> Enclosure {
        let facet = FacetParts::new(self, t, kind);
        let quick = if quick.is_nan() { f64::INFINITY } else { quick };
        let mut attained = 0.0f64;
        // The part with the given corners, of which `known` is a bound.
        let part = |corners: [FacetPoint; 3], known: f64, attained: &mut f64| {
            let found = facet.bound(&corners, attained);
            FacetPart { corners, bound: if found < known { found } else { known } }
        };
        let weights = |i: usize| std::array::from_fn(|k| if k == i { 1.0 } else { 0.0 });
        let corners = [0, 1, 2].map(|i| facet.corner(weights(i), t[i]));
        let mut parts = vec![part(corners, quick, &mut attained)];
        for division in 0..TUNING.most_divisions {
            // Parts that cannot be worse than what is attained are not kept.
            let worst =
                (0..parts.len()).reduce(|a, b| if parts[b].bound > parts[a].bound { b } else { a });
            let Some(k) = worst else { break };
            let FacetPart { corners: [a, b, c], bound } = parts[k];
            let found = Enclosure { bound: max_or_nan(bound, attained), attained };
            let unbounded = division >= TUNING.most_divisions_unbounded && !(bound < f64::INFINITY);
            if enough(&found) || unbounded {
                return found;
            }
            parts.swap_remove(k);
            let [ab, bc, ca] =
                [facet.midpoint(&a, &b), facet.midpoint(&b, &c), facet.midpoint(&c, &a)];
            for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
                let part = part(corners, bound, &mut attained);
                if !(part.bound <= attained) {
                    parts.push(part);
                }
            }
        }
        let bound = parts.iter().map(|part| part.bound).fold(attained, max_or_nan);
        Enclosure { bound, attained }
    }
}
