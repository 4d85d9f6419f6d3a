//! Triangles as a target: the first facet that a ray meets, as a plane.

use crate::geom::{DVec3, MeshSearch, Ray, TriMesh};
use crate::num::Scalar;
use std::fmt;
use std::sync::Arc;

/// A triangle mesh with the search for the facets that rays meet, from both sides.
#[derive(Clone)]
pub(super) struct TargetMesh(Arc<MeshSearch>);

impl PartialEq for TargetMesh {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0.mesh() == other.0.mesh()
    }
}

/// The triangles alone: what is searched with follows from them.
impl fmt::Debug for TargetMesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.mesh().fmt(f)
    }
}

impl TargetMesh {
    /// A mesh, ready for rays. It must not be called from work that is shared out among threads.
    pub(super) fn new(mesh: TriMesh) -> Self {
        let search = MeshSearch::new(mesh);
        search.prepare();
        Self(Arc::new(search))
    }

    /// Distance along the unit vector `u` from `start` to the first facet, with the derivatives of that facet's plane; NaN
    /// where none is met. The facet is that of the number nearest to the middle of a box.
    pub(super) fn distance<S: Scalar>(&self, start: [S; 3], u: [S; 3]) -> S {
        let middle = |v: [S; 3]| DVec3::from_array(v.map(S::mid));
        let ray = Ray { origin: middle(start), direction: middle(u) };
        if !(ray.origin.is_finite() && ray.direction.is_finite()) {
            return S::constant(f64::NAN);
        }
        let Some(hit) = self.0.nearest_hit(&ray, 0.0) else { return S::constant(f64::NAN) };
        let mesh = self.0.mesh();
        let normal = mesh.area_vector(hit.facet as usize).normalize();
        let [corner, ..] = mesh.corners(hit.facet as usize);
        let along = |v: [S; 3]| v[0] * normal.x + v[1] * normal.y + v[2] * normal.z;
        (-along(start) + normal.dot(corner)) / along(u)
    }

    /// Whether a facet lies between two places.
    pub(super) fn parts(&self, a: DVec3, b: DVec3) -> bool {
        let way = b - a;
        let length = way.length();
        let ray = Ray { origin: a, direction: way / length };
        length > 0.0 && self.0.nearest_hit(&ray, 0.0).is_some_and(|hit| hit.t < length)
    }
}
