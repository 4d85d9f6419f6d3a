//! The coarse mesh: the packing triangulated, and improved by the errors that the quadratic model
//! foresees.

use super::MeshError;
use super::cell::Cells;
use super::net::Net;
use super::pack::{Packing, extent};
use super::rim::Rim;
use crate::geom::DVec2;
use crate::num::{exp, log};
use glam::DMat2;
use rayon::prelude::*;
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};

/// Rounds of flips and moves.
const ROUNDS: usize = 8;
/// Excess, in shares of what is aimed at, from which on corners are moved.
const UNEASY: f64 = 1.04;
/// Corners or edges a thread looks at at a time, at least.
const CHUNK: usize = 32;

/// Triangulates a packing inside its rim, which the first points are.
pub fn triangulate<'a>(
    packing: Packing,
    rim: &Rim,
    cells: &Cells<'a>,
) -> Result<Net<'a>, MeshError> {
    let stretch = stretch(&packing.cells);
    let scaled = packing.points.iter().map(|&q| q * stretch);
    let scaled = scaled.map(|q| Point2::new(q.x, q.y)).collect();
    let refuse = |reason: InsertionError| MeshError::Point {
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
    let net = Net::new(cells.needs, cells.parts as f64, packing.points, triangles);
    Ok(improve(net, cells, &packing.cells))
}

fn improve<'a>(mut net: Net<'a>, cells: &Cells, frames: &[DMat2]) -> Net<'a> {
    let easy = UNEASY * cells.aim() * cells.aim();
    let mut edges: Vec<[u32; 2]> = net
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|[a, b]| a < b)
        .collect();
    let mut active: Vec<u32> = (0..net.points.len() as u32).collect();
    let mut crowd = Crowd { near: vec![0; net.points.len()], passes: 0 };
    // What has changed since it was last looked at.
    let mut loose = vec![false; net.points.len()];
    let mut stale = vec![false; net.triangles.len()];
    for _ in 0..ROUNDS {
        let mut touched = Vec::new();
        flip(&mut net, std::mem::take(&mut edges), |t| touched.push(t));
        for t in touched {
            for v in net.triangles[t as usize] {
                if !std::mem::replace(&mut loose[v as usize], true) {
                    active.push(v);
                }
            }
        }
        active.iter().for_each(|&v| loose[v as usize] = false);
        while !active.is_empty() {
            let apart = crowd.split(&net, &mut active);
            let place = |&v: &u32| net.better_place(v, easy, |_| frames[v as usize], |q| q);
            let places: Vec<_> = apart.par_iter().with_min_len(CHUNK).map(place).collect();
            for (v, place) in apart.into_iter().zip(places) {
                let Some(place) = place else { continue };
                net.points[v as usize] = place;
                for t in net.around(v) {
                    stale[t as usize] = true;
                }
            }
        }
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
    flip(&mut net, edges, |_| {});
    net
}

/// Flips those of the edges that gain, and what is then to flip around them.
fn flip(net: &mut Net, edges: Vec<[u32; 2]>, changed: impl FnMut(u32)) {
    let gains = |edge: &[u32; 2]| net.gains_by_flipping(*edge);
    let edges = edges.into_par_iter().with_min_len(CHUNK).filter(gains).collect();
    net.flip_all(edges, changed);
}

/// Picks corners that are no neighbours, so that each can be moved without the others.
struct Crowd {
    /// The last pass in which a neighbour of the corner was picked.
    near: Vec<u32>,
    passes: u32,
}

impl Crowd {
    /// Takes such corners out of `corners`.
    fn split(&mut self, net: &Net, corners: &mut Vec<u32>) -> Vec<u32> {
        self.passes += 1;
        let mut apart = Vec::with_capacity(corners.len() / 2);
        corners.retain(|&v| {
            if self.near[v as usize] == self.passes {
                return true;
            }
            for t in net.around(v) {
                for w in net.triangles[t as usize] {
                    self.near[w as usize] = self.passes;
                }
            }
            apart.push(v);
            false
        });
        apart
    }
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
