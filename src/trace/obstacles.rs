//! Bodies beside the mesh that stand in the way of rays: between camera and mirror, or between mirror and target.

use super::closed_mesh::is_closed;
use crate::geom::{Cuboid, Cylinder, DVec3, MeshSearch, Obstacle, ObstacleShape, Ray, Tube};
use crate::optics::ImagingTask;

/// Obstacles in the frame of a scene, ready for rays.
#[derive(Debug, Clone)]
pub struct Obstacles {
    bodies: Vec<Body>,
    /// What has the target, beyond which nothing hides it; without one the world is far away.
    task: Option<ImagingTask>,
    top_mm: f64,
}

/// A body with what finds the places where rays meet it.
#[derive(Debug, Clone)]
enum Body {
    Cuboid(Cuboid),
    Cylinder(Cylinder),
    Tube(Tube),
    Mesh {
        search: Box<MeshSearch>,
        /// Whether normals tell inside from outside: 1 where they point outwards, -1 of a mesh turned inside out, 0 of
        /// one that is not closed and has no inside.
        sense: f64,
    },
}

impl Body {
    fn new(shape: &ObstacleShape) -> Self {
        match shape {
            ObstacleShape::Cuboid(cuboid) => Self::Cuboid(*cuboid),
            ObstacleShape::Cylinder(cylinder) => Self::Cylinder(*cylinder),
            ObstacleShape::Tube(tube) => Self::Tube(*tube),
            ObstacleShape::Mesh(mesh) => {
                let volume = |t: usize| mesh.corners(t)[0].dot(mesh.area_vector(t));
                let volume: f64 = (0..mesh.triangles.len()).map(volume).sum();
                let sense = if is_closed(mesh) { volume.signum() } else { 0.0 };
                let search = MeshSearch::new((**mesh).clone());
                search.prepare();
                Self::Mesh { search: Box::new(search), sense }
            }
        }
    }

    /// Distance along the ray, more than `after`, at which it first meets the surface, mm.
    fn meeting(&self, ray: &Ray, after: f64) -> Option<f64> {
        match self {
            Self::Cuboid(cuboid) => cuboid.meeting(ray, after),
            Self::Cylinder(cylinder) => cylinder.meeting(ray, after),
            Self::Tube(tube) => tube.meeting(ray, after),
            Self::Mesh { search, .. } => search.nearest_hit(ray, after).map(|hit| hit.t),
        }
    }

    /// Whether a place is inside its material.
    fn contains(&self, at: DVec3) -> bool {
        match self {
            Self::Cuboid(cuboid) => cuboid.contains(at),
            Self::Cylinder(cylinder) => cylinder.contains(at),
            Self::Tube(tube) => tube.contains(at),
            Self::Mesh { search, sense } => {
                // From inside, the first facet in any direction shows its back.
                let ray = Ray { origin: at, direction: DVec3::new(0.48, 0.6, 0.64) };
                search.nearest_hit(&ray, 0.0).is_some_and(|hit| {
                    let normal = search.mesh().area_vector(hit.facet as usize);
                    sense * normal.dot(ray.direction) > 0.0
                })
            }
        }
    }
}

impl Obstacles {
    /// The obstacles `list`, before the target of `task`; none where the list is empty.
    #[must_use]
    pub fn new(list: &[Obstacle], task: Option<&ImagingTask>) -> Option<Self> {
        let bodies: Vec<Body> = list.iter().map(|obstacle| Body::new(&obstacle.shape)).collect();
        let top_mm = list.iter().map(|obstacle| obstacle.shape.top_mm()).reduce(f64::max)?;
        Some(Self { bodies, task: task.cloned(), top_mm })
    }

    /// A height above all of them, mm.
    #[must_use]
    pub fn above_mm(&self) -> f64 {
        self.top_mm + self.top_mm.abs().max(1.0)
    }

    /// Distance from a camera ray's origin within which nothing counts, mm: the front of the camera's body goes
    /// through it, and the origin is rounded.
    pub(super) fn clear(ray: &Ray) -> f64 {
        1e-12 * ray.origin.abs().max_element()
    }

    /// Number and distance of the obstacle that a ray meets first between two distances from its origin, mm; of two at
    /// the same distance the lower number.
    pub(super) fn between(&self, ray: &Ray, [clear, end]: [f64; 2]) -> Option<(u32, f64)> {
        let met = (0..).zip(&self.bodies).filter_map(|(number, body)| {
            let t = body.meeting(ray, clear)?;
            (t < end).then_some((number, t))
        });
        met.min_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// The same of a ray that leaves the mirror, up to the target.
    pub(super) fn before_target(&self, ray: &Ray, clear: f64) -> Option<(u32, f64)> {
        let target = |task: &ImagingTask| task.distance_to_target(ray.origin, ray.direction);
        self.between(ray, [clear, self.task.as_ref().map_or(f64::INFINITY, target)])
    }

    /// Number of an obstacle on the way of a camera ray, which is reflected as `leaving` or meets no mirror: for a
    /// mirror that has no mesh.
    #[must_use]
    pub fn on_the_way(&self, ray: &Ray, leaving: Option<&Ray>) -> Option<u32> {
        let mirror_mm =
            leaving.map_or(f64::INFINITY, |leaving| (leaving.origin - ray.origin).length());
        let before = self.between(ray, [Self::clear(ray), mirror_mm]);
        let met = before.or_else(|| {
            let leaving = leaving?;
            self.before_target(leaving, 1e-12 * (leaving.origin.abs().max_element() + mirror_mm))
        });
        met.map(|(number, _)| number)
    }

    /// Number of an obstacle inside which a place is.
    #[must_use]
    pub fn containing(&self, at: DVec3) -> Option<u32> {
        (0..).zip(&self.bodies).find(|(_, body)| body.contains(at)).map(|(number, _)| number)
    }
}
