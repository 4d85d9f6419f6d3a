//! What camera rays are traced at: a mesh, or a body of curved faces.

use super::body_scene::BodyScene;
use super::obstacles::Obstacles;
use super::occlusion::OcclusionProof;
use super::ray_end::{Outcome, RayEnd};
use super::scene::{LeavingRay, Scene};
use crate::geom::{DVec3, Ray};

/// A part with what finds the places where rays meet it.
#[derive(Debug, Clone, Copy)]
pub enum TracedPart<'a> {
    /// Of facets.
    Mesh(&'a Scene),
    /// Of curved faces.
    Body(&'a BodyScene),
}

impl<'a> From<&'a Scene> for TracedPart<'a> {
    fn from(scene: &'a Scene) -> Self {
        Self::Mesh(scene)
    }
}

impl<'a> From<&'a BodyScene> for TracedPart<'a> {
    fn from(scene: &'a BodyScene) -> Self {
        Self::Body(scene)
    }
}

impl<'a> TracedPart<'a> {
    /// Smallest and largest coordinates; `None` of an empty mesh.
    pub(super) fn bounds(self) -> Option<(DVec3, DVec3)> {
        match self {
            Self::Mesh(scene) => scene.bounds(),
            Self::Body(scene) => Some(scene.bounds()),
        }
    }

    /// The bodies beside the part, if there are any.
    pub(super) fn obstacles(self) -> Option<&'a Obstacles> {
        match self {
            Self::Mesh(scene) => scene.obstacles(),
            Self::Body(scene) => scene.obstacles(),
        }
    }

    /// Proof that reflected rays are unoccluded, where there is one.
    pub(super) fn occlusion_proof(self) -> Option<&'a OcclusionProof> {
        match self {
            Self::Mesh(scene) => scene.occlusion_proof(),
            Self::Body(scene) => scene.occlusion_proof(),
        }
    }

    /// Makes what searches for single rays, unless it is there.
    pub(super) fn prepare_search(self) {
        match self {
            Self::Mesh(scene) => scene.prepare_search(),
            // Faces have their hierarchy from the start.
            Self::Body(_) => {}
        }
    }

    /// Whether single rays are searched for quickly.
    pub(super) fn has_search(self) -> bool {
        match self {
            Self::Mesh(scene) => scene.has_search(),
            Self::Body(_) => true,
        }
    }

    /// Whether the part blocks any of `rays`.
    pub(super) fn blocks_any(self, rays: &[LeavingRay]) -> bool {
        match self {
            Self::Mesh(scene) => scene.blocks_any(rays),
            Self::Body(scene) => rays.iter().any(|leaving| scene.blocks(leaving)),
        }
    }

    /// End of a ray by its first reflection alone.
    pub(super) fn trace_primary(self, ray: &Ray) -> RayEnd {
        match self {
            Self::Mesh(scene) => scene.trace_primary(ray),
            Self::Body(scene) => scene.trace_primary(ray),
        }
    }

    /// Outcome of a ray that ends as `end` where nothing is beside the part.
    pub(super) fn obstructed(self, ray: &Ray, end: &RayEnd) -> Outcome {
        match self {
            Self::Mesh(scene) => scene.obstructed(ray, end),
            Self::Body(scene) => scene.obstructed(ray, end),
        }
    }

    /// Outcome of a ray that `end` says to be reflected: occluded by the part, or not.
    pub(super) fn occlusion(self, ray: &Ray, end: &RayEnd) -> Outcome {
        match self {
            Self::Mesh(scene) => scene.occlusion(ray, end),
            Self::Body(scene) => scene.occlusion(ray, end),
        }
    }
}
