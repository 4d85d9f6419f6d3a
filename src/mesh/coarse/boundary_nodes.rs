//! Nodes on the boundary of the meshed part of a mirror: its straight sides and its arcs.

use super::tuning::TUNING;
use crate::geom::{DVec2, Outline, Rect, turn};
use crate::mesh::refine::boundary_arcs::{BoundaryArc, BoundaryArcs};
use crate::mesh::sizing::frame_field::{FrameField, cell_extent};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use glam::DMat2;
use std::collections::HashMap;

/// Part of a step by which a number of steps may exceed a whole one by rounding.
const WHOLE: f64 = 1e-6;

/// The boundary of a meshed part, and its nodes.
#[derive(Debug, Clone)]
pub(crate) struct BoundaryNodes {
    domain: Rect,
    outline: Outline,
    /// The arcs, and the nodes on each.
    pub arcs: BoundaryArcs,
    /// Positions of the nodes in the chart, all of them different, mm.
    pub points: Vec<DVec2>,
    /// The number of each, by the bits of its position.
    known: HashMap<[u64; 2], usize>,
    /// Edges between neighbours on arcs.
    pub edges: Vec<[usize; 2]>,
}

impl BoundaryNodes {
    /// Nodes one cell apart on the boundary of the part `domain` of `mirror`.
    ///
    /// # Errors
    /// The beginning of a side along which cells are too small for that.
    pub(crate) fn new(mirror: &Mirror, domain: Rect, frames: &FrameField) -> Result<Self, DVec2> {
        let mut nodes = Self {
            domain,
            outline: mirror.outline,
            arcs: BoundaryArcs { arcs: BoundaryArc::all(mirror), arc_of: Vec::new() },
            points: Vec::new(),
            known: HashMap::new(),
            edges: Vec::new(),
        };
        for [a, b] in nodes.straight_sides(mirror) {
            let step = |share: f64| frames.boundary_step(a + (b - a) * share, b - a);
            for share in steps(0.0, 1.0, step).ok_or(a)? {
                nodes.push(if share == 1.0 { b } else { a + (b - a) * share }, 0);
            }
        }
        for (k, arc) in nodes.arcs.arcs.clone().into_iter().enumerate() {
            let points = arc_points(&arc, frames).ok_or(arc.at(arc.ends[0]))?;
            let on: Vec<usize> = points.into_iter().map(|q| nodes.push(q, k as u8 + 1)).collect();
            nodes.edges.extend(on.windows(2).map(|w| [w[0], w[1]]));
            if arc.closed {
                nodes.edges.push([on[on.len() - 1], on[0]]);
            }
        }
        Ok(nodes)
    }

    /// The ends of the straight sides, mm.
    fn straight_sides(&self, mirror: &Mirror) -> Vec<[DVec2; 2]> {
        let Rect { min, max } = self.domain;
        match self.outline {
            Outline::Rect(_) => {
                let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
                (0..4).map(|k| [corners[k], corners[(k + 1) % 4]]).collect()
            }
            Outline::Ring { inner, outer } => {
                let mut sides = Vec::new();
                for (axis, way) in [(1, DVec2::X), (0, DVec2::Y)] {
                    if !mirror.mirror_symmetric[axis] {
                        continue;
                    }
                    // The half of the axis that is a side, or both halves of it.
                    let both = !mirror.mirror_symmetric[1 - axis];
                    if both && inner == 0.0 {
                        sides.push([way * -outer, way * outer]);
                    } else {
                        sides.push([way * inner, way * outer]);
                        if both {
                            sides.push([way * -inner, way * -outer]);
                        }
                    }
                }
                sides
            }
        }
    }

    /// Adds a node, unless it is there; its number.
    fn push(&mut self, q: DVec2, arc: u8) -> usize {
        let key = q.to_array().map(|x| (x + 0.0).to_bits());
        let index = *self.known.entry(key).or_insert(self.points.len());
        let arc_of = &mut self.arcs.arc_of;
        if index == self.points.len() {
            self.points.push(q);
            arc_of.push(0);
        }
        arc_of[index] = arc_of[index].max(arc);
        index
    }

    /// Distance of `q` from the boundary, in cells; positive inside.
    pub(crate) fn depth(&self, q: DVec2, cell: &DMat2) -> f64 {
        let reach = cell_extent(cell);
        let Outline::Ring { inner, outer } = self.outline else {
            return ((q - self.domain.min).min(self.domain.max - q) / reach).min_element();
        };
        let r = q.length();
        let across = (cell.transpose() * q).length() / r;
        let from_hole = if inner == 0.0 { f64::INFINITY } else { r - inner };
        // Where the domain ends on an axis there is a side; elsewhere the arc ends it.
        let from_axis = |at: f64, end: f64| if end == 0.0 { at } else { f64::INFINITY };
        let from_axes =
            DVec2::new(from_axis(q.x, self.domain.min.x), from_axis(q.y, self.domain.min.y));
        (from_hole.min(outer - r) / across).min((from_axes / reach).min_element())
    }

    /// Whether `q` lies inside by the clearance of the lattice.
    pub(crate) fn is_clear(&self, q: DVec2, cell: &DMat2) -> bool {
        self.depth(q, cell) >= TUNING.clearance
    }

    /// Whether a triangle of the convex hull of all points is inside: it is not when its corners are all on the rim of
    /// the hole, nor when it fills the dent that rounding made of three nodes on the outer rim.
    pub(crate) fn keeps(&self, triangle: [usize; 3]) -> bool {
        let [a, b, c] = triangle;
        let arc = self.arcs.between(a, b).filter(|_| self.arcs.between(b, c).is_some());
        let Some(arc) = arc else { return true };
        let is_outer = self.arcs.arcs.last() == Some(arc);
        let [a, b, c] = triangle.map(|v| self.points[v].normalize());
        is_outer && turn(a, b, c) > 0.0
    }
}

/// The nodes on an arc, mm. None where cells are too small.
fn arc_points(arc: &BoundaryArc, frames: &FrameField) -> Option<Vec<DVec2>> {
    let [from, to] = arc.ends;
    let step = |share: f64| {
        let angle = from + (to - from) * share;
        let (s, c) = (sin(angle), cos(angle));
        let chord = frames.boundary_step(DVec2::new(c, s) * arc.radius, DVec2::new(-s, c));
        (chord / arc.radius).min(BoundaryArc::widest_chord() * frames.parts as f64)
    };
    let mut angles = steps(from, to, step)?;
    if arc.closed {
        angles.pop();
    }
    Some(angles.into_iter().map(|angle| arc.at(angle)).collect())
}

/// Positions from `lo` to `hi`, both included, a whole number of `step`s (which depend on the share of the way) apart.
/// None where these are too small.
fn steps(lo: f64, hi: f64, step: impl Fn(f64) -> f64) -> Option<Vec<f64>> {
    let samples = TUNING.boundary_samples;
    let width = 1.0 / samples as f64;
    let rates: Vec<f64> =
        (0..samples).map(|k| width * (hi - lo) / step((k as f64 + 0.5) * width)).collect();
    let total: f64 = rates.iter().sum();
    if !(total <= TUNING.most_points as f64) {
        return None;
    }
    let whole = (total - WHOLE).ceil().max(1.0);
    let (mut positions, mut reached, mut next) = (vec![lo], 0.0, 1.0);
    for (k, rate) in rates.iter().map(|rate| rate * whole / total).enumerate() {
        while next < reached + rate && next < whole - 0.5 {
            positions.push(lo + (hi - lo) * width * (k as f64 + (next - reached) / rate));
            next += 1.0;
        }
        reached += rate;
    }
    positions.push(hi);
    Some(positions)
}
