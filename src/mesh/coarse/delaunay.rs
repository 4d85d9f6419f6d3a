//! The coarse mesh: the packing triangulated, and improved by the errors that the quadratic model
//! foresees.

use super::boundary_nodes::BoundaryNodes;
use super::point_placement::{PointPlacement, extent};
use crate::geom::DVec2;
use crate::mesh::MeshError;
use crate::mesh::refine::independent_sets::{IndependentSets, flip_all};
use crate::mesh::refine::triangulation::EditableTriangulation;
use crate::mesh::sizing::frame_field::FrameField;
use crate::num::{exp, log};
use glam::DMat2;
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};
use std::collections::HashSet;

/// Rounds of flips and moves.
const ROUNDS: usize = 8;
/// Excess, in shares of what is aimed at, from which on corners are moved.
const UNEASY: f64 = 1.04;

/// Triangulates a packing inside its rim, which the first points are.
pub fn triangulate<'a>(
    packing: PointPlacement,
    rim: &BoundaryNodes,
    cells: &FrameField<'a>,
) -> Result<EditableTriangulation<'a>, MeshError> {
    let stretch = stretch(&packing.cells);
    // Of points in one place spade would keep one, and number all after it anew.
    let mut met = HashSet::new();
    let mut is_new = |q: DVec2| met.insert((q * stretch + 0.0).to_array().map(f64::to_bits));
    let both = packing.points.into_iter().zip(packing.cells);
    let (points, frames): (Vec<_>, Vec<_>) = both.filter(|(q, _)| is_new(*q)).unzip();
    let scaled = points.iter().map(|&q| q * stretch);
    let scaled = scaled.map(|q| Point2::new(q.x, q.y)).collect();
    let refuse = |reason: InsertionError| MeshError::PointRejected {
        x: f64::NAN,
        y: f64::NAN,
        reason: reason.to_string(),
    };
    let plane: ConstrainedDelaunayTriangulation<Point2<f64>> =
        ConstrainedDelaunayTriangulation::bulk_load_cdt(scaled, rim.edges.clone())
            .map_err(refuse)?;
    let triangles: Vec<[u32; 3]> = plane
        .inner_faces()
        .map(|f| f.vertices().map(|v| v.index()))
        .filter(|&triangle| rim.keeps(triangle))
        .map(|triangle| triangle.map(|v| v as u32))
        .collect();
    let net = EditableTriangulation::new(cells.needs, cells.parts as f64, points, triangles);
    Ok(improve(net, cells, &frames))
}

fn improve<'a>(
    mut net: EditableTriangulation<'a>,
    cells: &FrameField,
    frames: &[DMat2],
) -> EditableTriangulation<'a> {
    let easy = UNEASY * cells.aim() * cells.aim();
    let mut edges: Vec<[u32; 2]> = net
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|[a, b]| a < b)
        .collect();
    let mut active: Vec<u32> = (0..net.points.len() as u32).collect();
    let mut crowd = IndependentSets::default();
    // What has changed since it was last looked at.
    let mut loose = vec![false; net.points.len()];
    let mut stale = vec![false; net.triangles.len()];
    for _ in 0..ROUNDS {
        let mut touched = Vec::new();
        flip_all(&mut net, std::mem::take(&mut edges), |t| touched.push(t));
        for t in touched {
            for v in net.triangles[t as usize] {
                if !std::mem::replace(&mut loose[v as usize], true) {
                    active.push(v);
                }
            }
        }
        active.iter().for_each(|&v| loose[v as usize] = false);
        let better = |net: &EditableTriangulation, v: u32| {
            net.better_place(v, easy, |_| frames[v as usize], |q| q)
        };
        crowd.move_all(&mut net, std::mem::take(&mut active), better, |net, v| {
            net.around(v).for_each(|t| stale[t as usize] = true);
        });
        for (t, stale) in stale.iter_mut().enumerate() {
            if std::mem::take(stale) {
                let [a, b, c] = net.triangles[t];
                edges.extend([[a, b], [b, c], [c, a]].into_iter().filter(|[a, b]| a < b));
                for v in [a, b, c] {
                    if !std::mem::replace(&mut loose[v as usize], true) {
                        active.push(v);
                    }
                }
            }
        }
        if active.is_empty() {
            break;
        }
    }
    flip_all(&mut net, edges, |_| {});
    net
}

/// Scales of the axes that make the cells about as long as wide.
fn stretch(cells: &[DMat2]) -> DVec2 {
    let logs = |cell: &DMat2| {
        let e = extent(cell);
        DVec2::new(log(e.x), log(e.y))
    };
    let mean = cells.iter().map(logs).sum::<DVec2>() / cells.len() as f64;
    DVec2::new(1.0, exp(mean.x - mean.y))
}
