//! The surfaces of a cavity: its roof, upright walls and a floor with drains.

use super::border_facets::{HoleLoops, triangulate_between};
use super::skirt::Feet;
use super::{BoundaryLoops, Rim, SolidError, boundary_loops, check, fan};
use crate::geom::{CavityFloor, FaceMesh, Precision, TriMesh};

/// The cavity of a hollow body.
#[derive(Debug, Clone, Copy)]
pub struct HollowSpace<'a> {
    /// Facets of its roof, counter-clockwise from above, as those of a mirror above it.
    pub roof: &'a FaceMesh,
    /// Its floor.
    pub floor: &'a CavityFloor,
}

impl HollowSpace<'_> {
    /// How many facets it adds to a solid body, without the drains.
    ///
    /// # Errors
    /// [`SolidError::BoundaryLoops`] when the roof's rim is not of one loop or two.
    pub fn facets(&self) -> Result<usize, SolidError> {
        let Rim { edges, hole_edges, .. } = super::rim(self.roof)?;
        let mouths: usize = self.floor.meridians().map(|drain| drain.corners() + 2).sum();
        // A polygon of n corners in all and h holes takes n + 2 h - 2 triangles.
        Ok(self.roof.triangles.len() + hole_edges + 2 * edges + edges + mouths - 2)
    }

    /// Adds its facets to a body whose drains end in `drains`.
    ///
    /// # Errors
    /// [`SolidError`] when the roof's rim is not of one loop or two, or drains touch what is around them.
    pub(super) fn add(
        &self,
        mesh: &mut TriMesh,
        drains: &[HoleLoops],
        precision: Precision,
    ) -> Result<(), SolidError> {
        let BoundaryLoops { outer, hole } =
            boundary_loops(self.roof, check::open_edges(self.roof))?;
        let mut room: TriMesh = TriMesh::clone(self.roof);
        if let Some(hole) = hole {
            fan(&mut room, &hole);
        }
        let feet = Feet::of(self.roof, &outer, self.floor.z_mm).skirt(&mut room, &outer);
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(room.vertices);
        // Seen from the room its surfaces are turned round.
        mesh.triangles.extend(room.triangles.iter().map(|t| [t[0], t[2], t[1]].map(|v| v + first)));
        let feet: Vec<u32> = feet.into_iter().map(|foot| foot + first).collect();
        let mouths: Vec<&[u32]> = drains.iter().map(HoleLoops::upper).collect();
        let floor = triangulate_between(mesh, &feet, &mouths, precision)?;
        mesh.triangles.extend(floor);
        Ok(())
    }
}
