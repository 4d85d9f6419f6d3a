//! Whether splitting a facet that is too large does any good, found out before the work: what is
//! proven of it as it shrinks.

use crate::geom::{DVec2, Precision};
use crate::mesh::bound::error_bounder::{ErrorBound, ErrorBounder, SurfaceVertex};
use crate::mesh::bound::region::ImagingProblem;
use crate::mesh::{Limits, MeshError};
use crate::num::{asin, degrees};
use crate::optics::{Target, stereographic};
use thiserror::Error;

/// Halvings that are tried.
const HALVINGS: u32 = 5;
/// Excess up to which it falls as the facet shrinks.
const LINEAR: f64 = 2.0;
/// Excess over which no corner that rounds well helps.
const BEYOND_LUCK: f64 = 1.5;

/// Where one direction is as far from the horizon as from the pole, degrees.
const HALF_WAY_DEG: f64 = 45.0;

/// Directions near which a small turn of the mirror moves its image far.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ImageSingularity {
    /// Directions along the target plane.
    #[error(
        "the mirror shows elevation {elevation_deg:.2} degrees there: keep the picture further from the \
         horizon, where no direction meets the target plane"
    )]
    Horizon {
        /// The elevation that the mirror shows, degrees.
        elevation_deg: f64,
    },
    /// Directions along the axis.
    #[error(
        "the mirror shows elevation {elevation_deg:.2} degrees there: keep the picture further from \
         +-90 degrees of elevation"
    )]
    Pole {
        /// The elevation that the mirror shows, degrees.
        elevation_deg: f64,
    },
}

/// Proofs of shrinking facets by some limits.
pub struct RefinementProbe<'a> {
    prover: &'a ErrorBounder<'a>,
    limits: Limits,
}

/// What becomes of a facet that shrinks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProbeOutcome {
    /// It keeps the limits, about so many times as small in area.
    Converges(f64),
    /// It errs the more the smaller it is: rounding tilts it.
    Diverges,
    /// Neither is seen.
    Unknown,
}

impl<'a> RefinementProbe<'a> {
    pub fn new(prover: &'a ErrorBounder<'a>, limits: Limits) -> Self {
        Self { prover, limits }
    }

    /// By how much a facet, shrunk `by` a factor towards its middle, is larger than it may be.
    pub fn excess(&self, facet: [DVec2; 3], by: f64) -> f64 {
        let bound = self.bound(facet, by);
        let limits = &self.limits;
        let chord = limits.chord_mm.map_or(0.0, |limit| (bound.chord_mm / limit).sqrt());
        chord.max(limits.facet_mm.map_or(0.0, |limit| bound.facet_mm / limit))
    }

    /// By how much a facet must shrink to keep the limits, and what became of it when that was tried.
    pub fn oversize(&self, facet: [DVec2; 3]) -> (f64, Option<ProbeOutcome>) {
        let excess = self.excess(facet, 1.0);
        if excess <= 1.0 {
            return (excess, Some(ProbeOutcome::Converges(1.0)));
        }
        if excess <= LINEAR {
            return (excess, None);
        }
        // Bounds of facets that are far too large may be anything.
        let shrunk = self.shrink(facet);
        let by = match shrunk {
            ProbeOutcome::Converges(parts) => parts.sqrt(),
            ProbeOutcome::Diverges | ProbeOutcome::Unknown => excess.min(f64::from(1 << HALVINGS)),
        };
        (by, Some(shrunk))
    }

    /// The corners of a facet shrunk `by` a factor towards its middle.
    fn shrunk(&self, facet: [DVec2; 3], by: f64) -> [SurfaceVertex; 3] {
        let middle = middle(facet);
        facet.map(|p| self.prover.corner(middle + (p - middle) * by))
    }

    fn bound(&self, facet: [DVec2; 3], by: f64) -> ErrorBound {
        self.prover.bound_roughly(self.shrunk(facet, by).each_ref(), &self.limits)
    }

    /// Whether the proof, taken as far as it goes, finds that a facet so shrunk keeps the limits.
    fn settles(&self, facet: [DVec2; 3], by: f64) -> bool {
        let vertices = self.shrunk(facet, by);
        let t = vertices.each_ref();
        let (bound, reached) = self.prover.estimate(t);
        self.limits.allow(reached) && self.limits.hold(&self.prover.settle(t, bound, &self.limits))
    }

    /// What becomes of a facet as it is halved again and again.
    pub fn shrink(&self, facet: [DVec2; 3]) -> ProbeOutcome {
        let (mut least, mut growths) = (f64::INFINITY, 0);
        for halvings in 0..=HALVINGS {
            let parts = f64::from(1 << halvings);
            let mut excess = self.excess(facet, 1.0 / parts);
            if excess > 1.0 && self.settles(facet, 1.0 / parts) {
                excess = 1.0;
            }
            if excess <= 1.0 {
                let parts = parts * excess;
                return ProbeOutcome::Converges((parts * parts).max(1.0));
            }
            growths = if excess >= least && excess < f64::INFINITY { growths + 1 } else { 0 };
            // Once may be chance.
            if growths >= 2 && least > BEYOND_LUCK {
                return ProbeOutcome::Diverges;
            }
            least = least.min(excess);
        }
        ProbeOutcome::Unknown
    }

    /// Whether the facet, which splitting does not help, would hold in double precision.
    fn wants_digits(&self, facet: [DVec2; 3]) -> bool {
        if self.limits.precision == Precision::Double || self.holds(facet) {
            return false;
        }
        let prover = ErrorBounder { precision: Precision::Double, ..self.prover.clone() };
        let limits = Limits { precision: Precision::Double, ..self.limits };
        RefinementProbe::new(&prover, limits).holds(facet)
    }

    fn holds(&self, facet: [DVec2; 3]) -> bool {
        matches!(self.shrink(facet), ProbeOutcome::Converges(_))
    }

    /// Why a facet that was to be split is not.
    pub fn floor(&self, facet: [DVec2; 3]) -> MeshError {
        let [a, b, c] = facet;
        // A longer look may show that the facet itself was good enough.
        let mut bound = self.bound(facet, 1.0);
        if self.limits.hold(&bound) {
            let vertex = |q: DVec2| self.prover.vertex(q, self.prover.mirror().surface.at(q));
            bound = self.prover.bound(facet.map(vertex).each_ref());
        }
        MeshError::NotRefinable {
            at: middle(facet),
            size_mm: a.distance(b).max(b.distance(c)).max(c.distance(a)),
            bound,
            holds_in_double: self.wants_digits(facet),
            singularity: self.near(middle(facet)),
        }
    }

    /// What makes errors of the image large at `q`.
    fn near(&self, q: DVec2) -> Option<ImageSingularity> {
        self.limits.facet_mm?;
        let ImagingProblem { mirror, camera, view } = self.prover.sight;
        let target = view?.target;
        let point = mirror.surface.at(q);
        let towards =
            stereographic::towards_camera(camera.view(mirror.position(q, &point).to_array()));
        let seen = stereographic::reflect(towards, mirror.slope(q, &point).to_array());
        let elevation_deg = degrees(asin(stereographic::direction(seen).z.clamp(-1.0, 1.0)));
        if elevation_deg.abs() > HALF_WAY_DEG {
            return Some(ImageSingularity::Pole { elevation_deg });
        }
        let is_plane = matches!(target, Target::Plane { .. });
        is_plane.then_some(ImageSingularity::Horizon { elevation_deg })
    }
}

fn middle([a, b, c]: [DVec2; 3]) -> DVec2 {
    (a + b + c) / 3.0
}
