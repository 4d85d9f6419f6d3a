//! A meshed mirror before it is closed: its facets, its walls between panels, and where its skirt ends.

use super::{Chart, DVec2, DVec3, TriMesh};
use std::collections::HashSet;
use std::ops::Deref;

/// Facets of a mirror's panels, mm, and after them those of the walls between the panels.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMesh {
    mesh: TriMesh,
    /// Number of facets of walls, the last ones.
    walls: usize,
    skirt: Skirt,
}

/// Shape of the walls from a face's edge down to a plane.
#[derive(Debug, Clone, PartialEq)]
enum Skirt {
    /// They lie along the rays of one chart, with the walls between panels: the camera's where there are steps, vertical
    /// ones where there are none.
    AlongRays(Chart),
    /// They lead to these places of the plane, one for each vertex.
    Drafted(Vec<DVec2>),
}

impl FaceMesh {
    /// A face without walls, whose skirt is vertical.
    #[must_use]
    pub fn smooth(mesh: TriMesh) -> Self {
        Self { mesh, walls: 0, skirt: Skirt::AlongRays(Chart::on_axis(0.0, 0.0)) }
    }

    /// The panels of `mesh` with the facets `walls` between them, all along `rays`.
    #[must_use]
    pub fn walled(mut mesh: TriMesh, walls: &[[u32; 3]], rays: Chart) -> Self {
        mesh.triangles.extend_from_slice(walls);
        Self { mesh, walls: walls.len(), skirt: Skirt::AlongRays(rays) }
    }

    /// A face without walls, whose skirt leads from each vertex of its edge to that vertex' place of `feet`, X and Y.
    #[must_use]
    pub fn drafted(mesh: TriMesh, feet: Vec<DVec2>) -> Self {
        Self { mesh, walls: 0, skirt: Skirt::Drafted(feet) }
    }

    /// Number of facets of the panels, the first ones.
    #[must_use]
    pub fn optical(&self) -> usize {
        self.mesh.triangles.len() - self.walls
    }

    /// The place in the plane at height `z_mm` where the skirt from a vertex ends, mm.
    #[must_use]
    pub fn foot(&self, vertex: u32, z_mm: f64) -> DVec3 {
        let foot = match &self.skirt {
            Skirt::AlongRays(rays) => rays.passing(self.mesh.vertices[vertex as usize], z_mm),
            Skirt::Drafted(feet) => feet[vertex as usize],
        };
        foot.extend(z_mm)
    }

    /// Whether the skirt leads upwards from a face below the plane where it ends, as that of a mould may.
    #[must_use]
    pub fn may_be_sunk(&self) -> bool {
        matches!(self.skirt, Skirt::Drafted(_))
    }

    /// The panels alone.
    #[must_use]
    pub fn into_panels(mut self) -> TriMesh {
        self.mesh.triangles.truncate(self.optical());
        self.mesh
    }

    /// The facets: panels, and the walls between them.
    #[must_use]
    pub fn into_mesh(self) -> TriMesh {
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
