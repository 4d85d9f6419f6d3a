//! Triangulation of the placed points, and its smoothing by the errors that the quadratic model foresees.

use super::boundary_nodes::BoundaryNodes;
use super::point_placement::PointPlacement;
use super::tuning::TUNING;
use crate::geom::DVec2;
use crate::mesh::error::MeshError;
use crate::mesh::refine::independent_sets::{IndependentSets, flip_all};
use crate::mesh::refine::triangulation::EditableTriangulation;
use crate::mesh::sizing::frame_field::{FrameField, cell_extent};
use crate::num::{exp, log};
use glam::DMat2;
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};
use std::collections::HashSet;

/// Constrained Delaunay triangulation of the placed points inside their boundary, smoothed.
///
/// # Errors
/// [`MeshError::PointRejected`] where spade refuses a point.
pub(crate) fn triangulate(
    placed: PointPlacement,
    boundary: &BoundaryNodes,
    frames: &FrameField,
) -> Result<EditableTriangulation, MeshError> {
    let scale = isotropic_scale(&placed.cells);
    // spade would keep one of several points in one place, and number all after it anew.
    let mut met = HashSet::new();
    let mut is_new = |q: DVec2| met.insert((q * scale + 0.0).to_array().map(f64::to_bits));
    let both = placed.points.into_iter().zip(placed.cells);
    let (points, cells): (Vec<_>, Vec<_>) = both.filter(|(q, _)| is_new(*q)).unzip();
    let scaled = points.iter().map(|&q| q * scale);
    let scaled = scaled.map(|q| Point2::new(q.x, q.y)).collect();
    let refuse = |reason: InsertionError| MeshError::PointRejected {
        x: f64::NAN,
        y: f64::NAN,
        reason: reason.to_string(),
    };
    let delaunay: ConstrainedDelaunayTriangulation<Point2<f64>> =
        ConstrainedDelaunayTriangulation::bulk_load_cdt(scaled, boundary.edges.clone())
            .map_err(refuse)?;
    let triangles: Vec<[u32; 3]> = delaunay
        .inner_faces()
        .map(|f| f.vertices().map(|v| v.index()))
        .filter(|&triangle| boundary.keeps(triangle))
        .map(|triangle| triangle.map(|v| v as u32))
        .collect();
    let net = EditableTriangulation::new(&frames.sizing, frames.parts as f64, points, triangles);
    let threshold = TUNING.movable_oversize * frames.relative_size() * frames.relative_size();
    Ok(Smoothing::new(net, &cells, threshold).run())
}

/// Rounds of flips and moves, each over what the one before has changed.
struct Smoothing<'c> {
    net: EditableTriangulation,
    /// The cell at each vertex, in which moves are measured.
    cells: &'c [DMat2],
    /// Oversize over which vertices are moved.
    threshold: f64,
    /// Edges that may gain by a flip.
    edges: Vec<[u32; 2]>,
    /// Vertices that may gain by a move, and whether each is among them.
    vertices: Vec<u32>,
    is_listed: Vec<bool>,
}

impl<'c> Smoothing<'c> {
    fn new(net: EditableTriangulation, cells: &'c [DMat2], threshold: f64) -> Self {
        let edges = net.triangles.iter().flat_map(|&t| edges_once(t)).collect();
        let vertices = (0..net.vertices.len() as u32).collect();
        let is_listed = vec![false; net.vertices.len()];
        Self { net, cells, threshold, edges, vertices, is_listed }
    }

    /// The smoothed triangulation.
    fn run(mut self) -> EditableTriangulation {
        let mut sets = IndependentSets::default();
        let mut is_stale = vec![false; self.net.triangles.len()];
        for _ in 0..TUNING.smoothing_rounds {
            let mut flipped = Vec::new();
            flip_all(&mut self.net, std::mem::take(&mut self.edges), |t| flipped.push(t));
            for t in flipped {
                self.list_vertices(t);
            }
            self.vertices.iter().for_each(|&v| self.is_listed[v as usize] = false);
            let (cells, threshold) = (self.cells, self.threshold);
            let better = |net: &EditableTriangulation, v: u32| {
                net.better_position(v, threshold, |_| cells[v as usize], |q| q)
            };
            let vertices = std::mem::take(&mut self.vertices);
            sets.move_all(&mut self.net, vertices, better, |net, v| {
                net.around(v).for_each(|t| is_stale[t as usize] = true);
            });
            for (t, is_stale) in is_stale.iter_mut().enumerate() {
                if std::mem::take(is_stale) {
                    self.edges.extend(edges_once(self.net.triangles[t]));
                    self.list_vertices(t as u32);
                }
            }
            if self.vertices.is_empty() {
                break;
            }
        }
        flip_all(&mut self.net, self.edges, |_| {});
        self.net
    }

    /// Lists the vertices of triangle `t` that are not listed yet.
    fn list_vertices(&mut self, t: u32) {
        for v in self.net.triangles[t as usize] {
            if !std::mem::replace(&mut self.is_listed[v as usize], true) {
                self.vertices.push(v);
            }
        }
    }
}

/// The edges of a triangle that run from the lesser number: of two triangles beside an edge, one has it.
fn edges_once([a, b, c]: [u32; 3]) -> impl Iterator<Item = [u32; 2]> {
    [[a, b], [b, c], [c, a]].into_iter().filter(|[a, b]| a < b)
}

/// Scales of the axes that make the cells about as long as wide.
fn isotropic_scale(cells: &[DMat2]) -> DVec2 {
    let logs = |cell: &DMat2| {
        let e = cell_extent(cell);
        DVec2::new(log(e.x), log(e.y))
    };
    let mean = cells.iter().map(logs).sum::<DVec2>() / cells.len() as f64;
    DVec2::new(1.0, exp(mean.x - mean.y))
}
