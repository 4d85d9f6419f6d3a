//! The refinement probe: whether refining a facet that is too large helps, found out before the work by bounding copies
//! of it that shrink towards its middle.

use super::tuning::TUNING;
use crate::geom::{DVec2, Precision};
use crate::mesh::bound::error_bound::{ErrorBound, Limits};
use crate::mesh::bound::error_bounder::ErrorBounder;
use crate::mesh::bound::imaging_problem::ImagingProblem;
use crate::mesh::bound::vertex::SurfaceVertex;
use crate::mesh::error::{ImageSingularity, MeshError};
use crate::num::{asin, degrees};
use crate::optics::{Target, stereographic};

/// Elevation (degrees) that is as far from the horizon as from the pole: the nearer one is named in an error.
const HALF_WAY_DEG: f64 = 45.0;

/// A probe of facets with a bounder and limits.
pub(crate) struct RefinementProbe<'a> {
    bounder: &'a ErrorBounder<'a>,
    limits: Limits,
}

/// The outcome of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ProbeOutcome {
    /// Refinement meets the limits, with about this many facets in place of the one.
    Converges(f64),
    /// Errors grow as the facet shrinks, because rounding tilts it.
    Diverges,
    /// Neither is seen.
    Unknown,
}

impl<'a> RefinementProbe<'a> {
    /// A probe with the given bounder and limits.
    pub(crate) fn new(bounder: &'a ErrorBounder<'a>, limits: Limits) -> Self {
        Self { bounder, limits }
    }

    /// Oversize, as a ratio of lengths, of a facet that is shrunk by the factor `by` towards its middle.
    pub(crate) fn oversize(&self, facet: [DVec2; 3], by: f64) -> f64 {
        let bound = self.bound(facet, by);
        let limits = &self.limits;
        let chord = limits.chord_mm.map_or(0.0, |limit| (bound.chord_mm / limit).sqrt());
        chord.max(limits.facet_mm.map_or(0.0, |limit| bound.facet_mm / limit))
    }

    /// Factor by which a facet must shrink to keep the limits, and the outcome of the probe where one was needed.
    pub(crate) fn required_shrinkage(&self, facet: [DVec2; 3]) -> (f64, Option<ProbeOutcome>) {
        let oversize = self.oversize(facet, 1.0);
        if oversize <= 1.0 {
            return (oversize, Some(ProbeOutcome::Converges(1.0)));
        }
        if oversize <= TUNING.linear_oversize {
            return (oversize, None);
        }
        // Bounds of facets that are far too large may be anything.
        let outcome = self.probe_from(facet, oversize);
        let by = match outcome {
            ProbeOutcome::Converges(facets) => facets.sqrt(),
            ProbeOutcome::Diverges | ProbeOutcome::Unknown => {
                oversize.min(f64::from(1 << TUNING.probe_halvings))
            }
        };
        (by, Some(outcome))
    }

    /// The vertices of a facet that is shrunk by the factor `by` towards its middle.
    fn shrunk(&self, facet: [DVec2; 3], by: f64) -> [SurfaceVertex; 3] {
        let middle = middle(facet);
        facet.map(|p| self.bounder.snapped_vertex(middle + (p - middle) * by))
    }

    fn bound(&self, facet: [DVec2; 3], by: f64) -> ErrorBound {
        self.bounder.bound_roughly(self.shrunk(facet, by).each_ref(), &self.limits)
    }

    /// Whether branch and bound proves that a facet so shrunk keeps the limits.
    fn is_proven(&self, facet: [DVec2; 3], by: f64) -> bool {
        let vertices = self.shrunk(facet, by);
        let t = vertices.each_ref();
        let (bound, attained) = self.bounder.enclose(t);
        self.limits.may_hold(attained)
            && self.limits.hold(&self.bounder.bound_until_decided(t, bound, &self.limits))
    }

    /// Bounds a facet as it is halved again and again.
    pub(crate) fn probe(&self, facet: [DVec2; 3]) -> ProbeOutcome {
        self.probe_from(facet, self.oversize(facet, 1.0))
    }

    /// The same where the oversize of the whole facet is known.
    fn probe_from(&self, facet: [DVec2; 3], whole: f64) -> ProbeOutcome {
        let (mut least, mut rises) = (f64::INFINITY, 0);
        for halvings in 0..=TUNING.probe_halvings {
            let parts = f64::from(1 << halvings);
            let mut oversize =
                if halvings == 0 { whole } else { self.oversize(facet, 1.0 / parts) };
            if oversize > 1.0 && self.is_proven(facet, 1.0 / parts) {
                oversize = 1.0;
            }
            if oversize <= 1.0 {
                let parts = parts * oversize;
                return ProbeOutcome::Converges((parts * parts).max(1.0));
            }
            rises = if oversize >= least && oversize < f64::INFINITY { rises + 1 } else { 0 };
            // One rise may be chance.
            if rises >= 2 && least > TUNING.beyond_snapping {
                return ProbeOutcome::Diverges;
            }
            least = least.min(oversize);
        }
        ProbeOutcome::Unknown
    }

    /// Whether refinement of the facet fails in single precision and succeeds in double precision.
    fn holds_in_double(&self, facet: [DVec2; 3]) -> bool {
        if self.limits.precision == Precision::Double || self.converges(facet) {
            return false;
        }
        let bounder = ErrorBounder { precision: Precision::Double, ..self.bounder.clone() };
        let limits = Limits { precision: Precision::Double, ..self.limits };
        RefinementProbe::new(&bounder, limits).converges(facet)
    }

    fn converges(&self, facet: [DVec2; 3]) -> bool {
        matches!(self.probe(facet), ProbeOutcome::Converges(_))
    }

    /// The error that says why a facet is not refined.
    pub(crate) fn not_refinable(&self, facet: [DVec2; 3]) -> MeshError {
        let [a, b, c] = facet;
        // A closer bound may show that the facet itself is good enough.
        let mut bound = self.bound(facet, 1.0);
        if self.limits.hold(&bound) {
            bound = self.bounder.bound(facet.map(|q| self.bounder.vertex_at(q)).each_ref());
        }
        MeshError::NotRefinable {
            at: middle(facet),
            size_mm: a.distance(b).max(b.distance(c)).max(c.distance(a)),
            bound,
            holds_in_double: self.holds_in_double(facet),
            singularity: self.nearest_singularity(middle(facet)),
        }
    }

    /// The singularity of the image that is nearest to `q`.
    fn nearest_singularity(&self, q: DVec2) -> Option<ImageSingularity> {
        self.limits.facet_mm?;
        let ImagingProblem { mirror, camera, view } = self.bounder.problem;
        let target = &view?.target;
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
