//! A body of curved faces among the obstacles around it, for camera rays.

use super::obstacles::Obstacles;
use super::occlusion::OcclusionProof;
use super::ray_end::{Outcome, RayEnd, obstruction, reflect_at_facet};
use super::scene::LeavingRay;
use crate::brep::Body;
use crate::geom::{DVec3, Ray};
use std::sync::{Arc, OnceLock};

/// Distance from where a ray leaves a face within which it meets nothing, mm: far above rounding, and far below what
/// a picture shows.
const CLEAR_MM: f64 = 1e-6;

/// A closed body of curved faces with what its rays need.
#[derive(Debug)]
pub struct BodyScene {
    body: Body,
    bounds: [DVec3; 2],
    /// Made when it is first needed: never from within a trace, whose threads would wait for it while it waits for
    /// them.
    occlusion_proof: OnceLock<Option<OcclusionProof>>,
    obstacles: Option<Arc<Obstacles>>,
}

impl BodyScene {
    /// A scene of `body` among `obstacles`.
    #[must_use]
    pub fn new(body: Body, obstacles: Option<Arc<Obstacles>>) -> Self {
        let bounds = body.bounds();
        Self { body, bounds, occlusion_proof: OnceLock::new(), obstacles }
    }

    /// The body.
    #[must_use]
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// The bodies beside it, if there are any.
    #[must_use]
    pub fn obstacles(&self) -> Option<&Obstacles> {
        self.obstacles.as_deref()
    }

    /// Smallest and largest coordinates, mm.
    #[must_use]
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let [lo, hi] = self.bounds;
        (lo, hi)
    }

    /// A height above everything in it, mm, for camera rays to start from.
    #[must_use]
    pub fn above_mm(&self) -> f64 {
        let [lo, hi] = self.bounds;
        let above = hi.z + (hi - lo).max_element();
        self.obstacles().map_or(above, |obstacles| above.max(obstacles.above_mm()))
    }

    pub(super) fn occlusion_proof(&self) -> Option<&OcclusionProof> {
        let proof = || OcclusionProof::of_closed(&self.body.pieces(), self.bounds);
        self.occlusion_proof.get_or_init(proof).as_ref()
    }

    /// End of a ray by its first reflection alone: occlusion of the reflected ray is not considered. The number of
    /// the facet is that of the face.
    #[must_use]
    pub fn trace_primary(&self, ray: &Ray) -> RayEnd {
        let Some(hit) = self.body.nearest_hit(ray, 0.0, f64::INFINITY) else {
            return RayEnd::MISSED;
        };
        let (outcome, direction) = reflect_at_facet(ray.direction, hit.normal);
        RayEnd { outcome, facet: hit.face, t: hit.t, direction }
    }

    /// The first face between two distances on a ray that leaves the body, mm.
    fn occluder(&self, ray: &Ray, [clear, most]: [f64; 2]) -> Option<u32> {
        self.body.nearest_hit(ray, clear.max(CLEAR_MM), most).map(|hit| hit.face)
    }

    /// Whether a reflected ray meets the body.
    pub(super) fn blocks(&self, LeavingRay { ray, clear, .. }: &LeavingRay) -> bool {
        self.occluder(ray, [*clear, f64::INFINITY]).is_some()
    }

    /// Outcome of a ray that ends as `end` where nothing is beside the body: obstructed, or the same.
    #[must_use]
    pub fn obstructed(&self, ray: &Ray, end: &RayEnd) -> Outcome {
        let Some(obstacles) = self.obstacles() else { return end.outcome };
        obstruction(obstacles, ray, end, |leaving, range| {
            self.occluder(&leaving.ray, range).is_some()
        })
    }

    /// Outcome of a ray that `end` says to be reflected: occluded by a face, or not.
    #[must_use]
    pub fn occlusion(&self, ray: &Ray, end: &RayEnd) -> Outcome {
        let LeavingRay { ray, clear, .. } = LeavingRay::new(ray, end);
        self.occluder(&ray, [clear, f64::INFINITY]).map_or(Outcome::Hit, Outcome::Shadowed)
    }
}
