//! Walls between the meshed panels of a panelled mirror.
//!
//! A wall lies in the plane through the pinhole and a line between panels. Its outline is the rims of the panels on both
//! sides, with a step where one panel ends on a side and the next begins.

use super::{Mirror, Surface};
use crate::geom::{DVec2, DividingLine, FaceMesh, TriMesh, triangulate_loops};
use crate::num::sort_by_number;
use thiserror::Error;

/// How far rounding takes a vertex from the line between panels that it is on, as a share of the mirror's size: far less
/// than the next vertex is away from it.
const OFF: f64 = 1e-9;

/// A wall that cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the wall between panels near X {:.3} mm, Y {:.3} mm crosses itself: facets depart from the mirror by more than \
     the panels do from each other; give a smaller mesh.chord_um or mesh.facet_px",
    near.x, near.y
)]
pub struct WallFault {
    /// Where, in the chart.
    pub near: DVec2,
}

/// A vertex at the rim of a meshed panel.
#[derive(Debug, Clone, Copy)]
struct RimVertex {
    vertex: u32,
    /// Where it is in the chart, mm.
    q: DVec2,
    /// Its height in the chart, mm.
    f: f64,
}

impl Mirror {
    /// The mesh of all panels ([`Mirror::panels`]) with the walls between them, which a mirror without steps has none of.
    ///
    /// # Errors
    /// [`WallFault`] where the meshes of two panels come nearer to each other than they are to the mirror.
    pub fn with_walls(&self, mesh: TriMesh) -> Result<FaceMesh, WallFault> {
        let Surface::Panels(surface) = &self.surface else { return Ok(FaceMesh::smooth(mesh)) };
        let mut rims: Vec<Vec<RimVertex>> = vec![Vec::new(); surface.sheets.len()];
        for vertex in rim_vertices(&mesh) {
            let at = mesh.vertices[vertex as usize];
            let (q, f) = self.chart.coordinates(at);
            rims[self.panel_at(at)].push(RimVertex { vertex, q, f });
        }
        let mut walls = Vec::new();
        for line in surface.parts.dividing_lines() {
            walls.extend(self.wall(&mesh, &rims, &line)?);
        }
        Ok(FaceMesh::walled(mesh, &walls, self.chart))
    }

    /// The facets of one wall.
    fn wall(
        &self,
        mesh: &TriMesh,
        rims: &[Vec<RimVertex>],
        line: &DividingLine,
    ) -> Result<Vec<[u32; 3]>, WallFault> {
        let along = 1 - line.axis;
        let off = OFF * self.outline.bounds().size().max_element();
        let side = |panels: &[usize]| -> Vec<RimVertex> {
            let of_panel = |&k: &usize| {
                let on_line = |v: &&RimVertex| {
                    (v.q[line.axis] - line.at).abs() <= off
                        && (line.ends[0] - off..=line.ends[1] + off).contains(&v.q[along])
                };
                let mut chain: Vec<RimVertex> = rims[k].iter().filter(on_line).copied().collect();
                sort_by_number(&mut chain, |vertex| vertex.q[along]);
                chain
            };
            panels.iter().flat_map(of_panel).collect()
        };
        let sides = line.sides.each_ref().map(|panels| side(panels));
        // Both sides have a vertex where the line begins.
        let begins = |side: usize| sides[side].first().map_or(f64::NAN, |v| v.f);
        let lower = usize::from(begins(1) < begins(0));
        let outline: Vec<RimVertex> =
            sides[lower].iter().chain(sides[1 - lower].iter().rev()).copied().collect();
        // Plane coordinates in the wall, in which the lower side runs along +x.
        let place = |v: &RimVertex| {
            let at = mesh.vertices[v.vertex as usize];
            DVec2::new(at[along], at.z)
        };
        let points: Vec<DVec2> = outline.iter().map(place).collect();
        let triangles = triangulate_loops(&points, &[points.len()])
            .map_err(|fault| WallFault { near: outline[fault.near].q })?;
        // Seen along the line's coordinate, the wall's face turns to the lower panel.
        let turns = (lower == 1) != (line.axis == 0);
        let facet = |t: [u32; 3]| {
            let [a, b, c] = t.map(|k| outline[k as usize].vertex);
            if turns { [a, c, b] } else { [a, b, c] }
        };
        Ok(triangles.into_iter().map(facet).collect())
    }
}

/// The vertices of the edges that one facet alone has, by their rising numbers.
fn rim_vertices(mesh: &TriMesh) -> Vec<u32> {
    let mut vertices: Vec<u32> = mesh.open_edges().into_iter().map(|(from, _)| from).collect();
    vertices.sort_unstable();
    vertices
}
