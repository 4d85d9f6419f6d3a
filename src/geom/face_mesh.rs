//! A meshed mirror before it is closed: its facets, its walls between panels, and the rays along which its skirt falls.

use super::{Chart, TriMesh};
use std::collections::HashSet;
use std::ops::Deref;

/// Facets of a mirror's panels, mm, and after them those of the walls between the panels. Walls and skirt lie along the
/// rays of one chart: the camera's where there are steps between panels, vertical ones where there are none.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMesh {
    mesh: TriMesh,
    /// Number of facets of walls, the last ones.
    walls: usize,
    rays: Chart,
}

impl FaceMesh {
    /// A face without walls, whose skirt is vertical.
    #[must_use]
    pub fn smooth(mesh: TriMesh) -> Self {
        Self { mesh, walls: 0, rays: Chart::on_axis(0.0, 0.0) }
    }

    /// The panels of `mesh` with the facets `walls` between them, all along `rays`.
    #[must_use]
    pub fn walled(mut mesh: TriMesh, walls: &[[u32; 3]], rays: Chart) -> Self {
        mesh.triangles.extend_from_slice(walls);
        Self { mesh, walls: walls.len(), rays }
    }

    /// Number of facets of the panels, the first ones.
    #[must_use]
    pub fn optical(&self) -> usize {
        self.mesh.triangles.len() - self.walls
    }

    /// The chart along whose rays walls and skirt lie.
    #[must_use]
    pub fn rays(&self) -> &Chart {
        &self.rays
    }

    /// The panels alone.
    #[must_use]
    pub fn into_panels(mut self) -> TriMesh {
        self.mesh.triangles.truncate(self.optical());
        self.mesh
    }

    /// The edges of walls, each as the wall's facet runs along it.
    #[must_use]
    pub fn wall_edges(&self) -> HashSet<(u32, u32)> {
        let walls = self.mesh.triangles[self.optical()..].iter();
        walls.flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect()
    }

    /// The same facets with vertices that `change` moves.
    #[must_use]
    pub fn moved(mut self, change: impl FnOnce(TriMesh) -> TriMesh) -> Self {
        self.mesh = change(self.mesh);
        self
    }
}

impl Deref for FaceMesh {
    type Target = TriMesh;

    fn deref(&self) -> &TriMesh {
        &self.mesh
    }
}

impl From<TriMesh> for FaceMesh {
    fn from(mesh: TriMesh) -> Self {
        Self::smooth(mesh)
    }
}
