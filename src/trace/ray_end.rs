//! One ray's end: its nearest facet, the reflection there, and occlusion by the mesh itself.

use super::obstacles::Obstacles;
use super::scene::{LeavingRay, Scene};
use crate::geom::{DVec3, Ray};
use crate::optics::reflect;

/// End of a camera ray after at most one reflection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// It is reflected and leaves into the world.
    Hit,
    /// It meets no facet.
    Missed,
    /// It is reflected and then meets this facet.
    Shadowed(u32),
    /// Its nearest facet shows it the back.
    BackFace,
    /// It meets the obstacle of this number before the mesh, or after it is reflected and before it meets the mesh
    /// again or the target.
    Obstructed(u32),
}

/// Outcome of a camera ray with the facet, the distance and the reflected direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayEnd {
    /// Its end.
    pub outcome: Outcome,
    /// The nearest facet, or [`RayEnd::NO_FACET`].
    pub facet: u32,
    /// Distance along the ray to that facet, mm; infinite for a ray that meets none.
    pub t: f64,
    /// Unit direction of the reflected ray, or the zero vector.
    pub direction: DVec3,
}

impl RayEnd {
    /// Facet number of a ray that meets none: an `Option` would enlarge the entry of every pixel.
    pub const NO_FACET: u32 = u32::MAX;
    /// End of a ray that meets no facet.
    pub const MISSED: Self = Self {
        outcome: Outcome::Missed,
        facet: Self::NO_FACET,
        t: f64::INFINITY,
        direction: DVec3::ZERO,
    };

    /// Point where `ray`, which ends so, meets its nearest facet, mm; the zero vector without one.
    #[must_use]
    pub fn hit_point(&self, ray: &Ray) -> DVec3 {
        if self.facet == Self::NO_FACET { DVec3::ZERO } else { ray.at(self.t) }
    }
}

impl Scene {
    /// End of a ray by its first reflection alone: occlusion of the reflected ray is not considered.
    #[must_use]
    pub fn trace_primary(&self, ray: &Ray) -> RayEnd {
        let Some(hit) = self.nearest_hit(ray) else { return RayEnd::MISSED };
        let normal = self.mesh().area_vector(hit.facet as usize);
        let (outcome, direction) = reflect_at_facet(ray.direction, normal);
        RayEnd { outcome, facet: hit.facet, t: hit.t, direction }
    }

    /// End of a ray: [`Scene::trace_primary`], then obstacles in its way, then occlusion of the reflected ray by the
    /// mesh.
    #[must_use]
    pub fn trace(&self, ray: &Ray) -> RayEnd {
        let mut end = self.trace_primary(ray);
        end.outcome = self.obstructed(ray, &end);
        if end.outcome == Outcome::Hit {
            end.outcome = self.occlusion(ray, &end);
        }
        end
    }

    /// Outcome of a ray of which `end` says what it meets of the mesh first: obstructed where an obstacle is before
    /// that, or before anything else that the reflected ray meets; otherwise as before.
    #[must_use]
    pub fn obstructed(&self, ray: &Ray, end: &RayEnd) -> Outcome {
        let Some(obstacles) = self.obstacles() else { return end.outcome };
        obstruction(obstacles, ray, end, |leaving, range| {
            self.occluder_before(&leaving.ray, leaving.from, range).is_some()
        })
    }

    /// Outcome of a ray that `end` says to be reflected: occluded by a facet, or not.
    pub(super) fn occlusion(&self, ray: &Ray, end: &RayEnd) -> Outcome {
        let LeavingRay { ray, from, clear } = LeavingRay::new(ray, end);
        self.occluder(&ray, from, clear).map_or(Outcome::Hit, Outcome::Shadowed)
    }
}

/// Outcome of a ray of which `end` says what it meets of the part first; `is_met` tells whether the part is met by a
/// reflected ray between two distances, mm.
pub(super) fn obstruction(
    obstacles: &Obstacles,
    ray: &Ray,
    end: &RayEnd,
    is_met: impl FnOnce(&LeavingRay, [f64; 2]) -> bool,
) -> Outcome {
    if let Some((number, _)) = obstacles.between(ray, [Obstacles::clear(ray), end.t]) {
        return Outcome::Obstructed(number);
    }
    if end.outcome != Outcome::Hit {
        return end.outcome;
    }
    let leaving = LeavingRay::new(ray, end);
    match obstacles.before_target(&leaving.ray, leaving.clear) {
        Some((number, t)) if !is_met(&leaving, [leaving.clear, t]) => Outcome::Obstructed(number),
        _ => Outcome::Hit,
    }
}

impl LeavingRay {
    /// The reflected ray of `ray`, which ends as `end`.
    pub(super) fn new(ray: &Ray, end: &RayEnd) -> Self {
        let leaving = Ray { origin: ray.at(end.t), direction: end.direction };
        // The origin is rounded: neighbours of the facet may seem to lie a few ulps ahead of it.
        let clear = 1e-12 * (leaving.origin.abs().max_element() + end.t);
        Self { ray: leaving, from: end.facet, clear }
    }
}

/// Outcome of a ray at a facet with a normal of any length, and its reflected direction; occlusion is
/// not considered.
#[inline(always)]
pub(super) fn reflect_at_facet(direction: DVec3, normal: DVec3) -> (Outcome, DVec3) {
    if normal.dot(direction) < 0.0 {
        (Outcome::Hit, reflect(direction, normal))
    } else {
        (Outcome::BackFace, DVec3::ZERO)
    }
}
