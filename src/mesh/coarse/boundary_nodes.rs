//! The rim of the meshed part of a mirror: straight sides, arcs, and the points on them.

use super::point_placement::extent;
use crate::geom::{DVec2, Outline, Rect, turn};
use crate::mesh::CROWDED;
use crate::mesh::sizing::frame_field::FrameField;
use crate::mirror::Mirror;
use crate::num::{atan, cos, sin};
use glam::DMat2;
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// Places per side where cells are turned into steps.
const PLACES: usize = 128;

/// The part of a circle about the axis that bounds the meshed part of a mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arc {
    /// mm.
    pub radius: f64,
    /// Angles of its ends.
    ends: [f64; 2],
    /// Whether it is the whole circle, and its ends one point.
    closed: bool,
}

impl Arc {
    /// The arcs of `mirror`, the outer one last; none of a rectangle.
    fn all(mirror: &Mirror) -> Vec<Self> {
        let Outline::Ring { inner, outer } = mirror.outline else { return Vec::new() };
        let ends = match mirror.mirror_symmetric {
            [true, true] => [0.0, FRAC_PI_2],
            [true, false] => [-FRAC_PI_2, FRAC_PI_2],
            [false, true] => [0.0, PI],
            [false, false] => [-PI, PI],
        };
        let closed = mirror.mirror_symmetric == [false; 2];
        let radii = [inner, outer].into_iter().filter(|&radius| radius > 0.0);
        radii.map(|radius| Self { radius, ends, closed }).collect()
    }

    /// The largest angle that a chord may span.
    fn widest() -> f64 {
        // Rounding takes a little of what a chord may cut off.
        let cut = 0.98 * Outline::EDGE;
        // 1 - cos a = 2 sin^2 (a / 2) for half the chord's angle a.
        4.0 * atan((cut / (2.0 - cut)).sqrt())
    }

    /// The point at an angle.
    fn at(&self, angle: f64) -> DVec2 {
        let way = DVec2::new(cos(angle), sin(angle));
        // Ends lie on an axis, exactly.
        let way = DVec2::select(way.abs().cmplt(DVec2::splat(1e-12)), DVec2::ZERO, way);
        way * self.radius
    }

    /// The point nearest to `p`.
    pub fn onto(&self, p: DVec2) -> DVec2 {
        p.normalize() * self.radius
    }

    fn points(&self, cells: &FrameField) -> Option<Vec<DVec2>> {
        let [from, to] = self.ends;
        let step = |share: f64| {
            let angle = from + (to - from) * share;
            let (s, c) = (sin(angle), cos(angle));
            let chord = cells.step(DVec2::new(c, s) * self.radius, DVec2::new(-s, c));
            (chord / self.radius).min(Self::widest() * cells.parts as f64)
        };
        let mut angles = steps(from, to, step)?;
        if self.closed {
            angles.pop();
        }
        Some(angles.into_iter().map(|angle| self.at(angle)).collect())
    }
}

/// The rim and its points.
#[derive(Debug, Clone)]
pub struct BoundaryNodes {
    domain: Rect,
    outline: Outline,
    /// Its arcs, the outer one last.
    pub arcs: Vec<Arc>,
    /// Points, all of them different.
    pub points: Vec<DVec2>,
    /// The number of each.
    known: HashMap<[u64; 2], usize>,
    /// For every point 0, or 1 + the number of its arc.
    arc_of: Vec<u8>,
    /// Neighbours on arcs.
    pub edges: Vec<[usize; 2]>,
}

impl BoundaryNodes {
    /// The rim of the part `domain` of `mirror`, with points one cell apart; where a side begins along
    /// which cells are too small for that.
    pub fn new(mirror: &Mirror, domain: Rect, cells: &FrameField) -> Result<Self, DVec2> {
        let mut rim = Self {
            domain,
            outline: mirror.outline,
            arcs: Arc::all(mirror),
            points: Vec::new(),
            known: HashMap::new(),
            arc_of: Vec::new(),
            edges: Vec::new(),
        };
        for [a, b] in rim.lines(mirror) {
            let step = |share: f64| cells.step(a + (b - a) * share, b - a);
            for share in steps(0.0, 1.0, step).ok_or(a)? {
                rim.push(if share == 1.0 { b } else { a + (b - a) * share }, 0);
            }
        }
        for (k, arc) in rim.arcs.clone().into_iter().enumerate() {
            let points = arc.points(cells).ok_or(arc.at(arc.ends[0]))?;
            let on: Vec<usize> = points.into_iter().map(|q| rim.push(q, k as u8 + 1)).collect();
            rim.edges.extend(on.windows(2).map(|w| [w[0], w[1]]));
            if arc.closed {
                rim.edges.push([on[on.len() - 1], on[0]]);
            }
        }
        Ok(rim)
    }

    /// The straight sides.
    fn lines(&self, mirror: &Mirror) -> Vec<[DVec2; 2]> {
        let Rect { min, max } = self.domain;
        match self.outline {
            Outline::Rect(_) => {
                let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
                (0..4).map(|k| [corners[k], corners[(k + 1) % 4]]).collect()
            }
            Outline::Ring { inner, outer } => {
                let mut lines = Vec::new();
                for (axis, way) in [(1, DVec2::X), (0, DVec2::Y)] {
                    if !mirror.mirror_symmetric[axis] {
                        continue;
                    }
                    // The half of the axis that is an edge, or both halves of it.
                    let both = !mirror.mirror_symmetric[1 - axis];
                    if both && inner == 0.0 {
                        lines.push([way * -outer, way * outer]);
                    } else {
                        lines.push([way * inner, way * outer]);
                        if both {
                            lines.push([way * -inner, way * -outer]);
                        }
                    }
                }
                lines
            }
        }
    }

    /// Adds a point unless it is there.
    fn push(&mut self, q: DVec2, arc: u8) -> usize {
        let key = q.to_array().map(|x| (x + 0.0).to_bits());
        let index = *self.known.entry(key).or_insert(self.points.len());
        if index == self.points.len() {
            self.points.push(q);
            self.arc_of.push(0);
        }
        self.arc_of[index] = self.arc_of[index].max(arc);
        index
    }

    /// How many cells `q` lies inside.
    pub fn depth(&self, q: DVec2, cell: &DMat2) -> f64 {
        let reach = extent(cell);
        let Outline::Ring { inner, outer } = self.outline else {
            return ((q - self.domain.min).min(self.domain.max - q) / reach).min_element();
        };
        let r = q.length();
        let across = (cell.transpose() * q).length() / r;
        let from_hole = if inner == 0.0 { f64::INFINITY } else { r - inner };
        // Where the domain ends on an axis that is a side; elsewhere the arc ends it.
        let from_axis = |at: f64, end: f64| if end == 0.0 { at } else { f64::INFINITY };
        let from_axes =
            DVec2::new(from_axis(q.x, self.domain.min.x), from_axis(q.y, self.domain.min.y));
        (from_hole.min(outer - r) / across).min((from_axes / reach).min_element())
    }

    /// Whether `q` lies at least `clearance` cells inside.
    pub fn is_clear(&self, q: DVec2, cell: &DMat2, clearance: f64) -> bool {
        self.depth(q, cell) >= clearance
    }

    /// The arc that two neighbours on the rim lie on.
    pub fn arc(&self, a: usize, b: usize) -> Option<&Arc> {
        let of = |v: usize| self.arc_of.get(v).copied().unwrap_or(0);
        (of(a) != 0 && of(a) == of(b)).then(|| &self.arcs[usize::from(of(a)) - 1])
    }

    /// The arc that two points on the rim lie on, if they do.
    pub fn arc_through(&self, a: DVec2, b: DVec2) -> Option<&Arc> {
        const NEAR: f64 = 1e-6;
        let on = |arc: &&Arc| {
            [a, b].into_iter().all(|p| (p.length() - arc.radius).abs() <= NEAR * arc.radius)
        };
        self.arcs.iter().find(on)
    }

    /// Whether a triangle of the points' convex hull is inside: it is not when all its corners are
    /// on the rim of the hole, nor when it fills the dent that rounding made of three points on the
    /// outer rim.
    pub fn keeps(&self, triangle: [usize; 3]) -> bool {
        let [a, b, c] = triangle;
        let Some(arc) = self.arc(a, b).filter(|_| self.arc(b, c).is_some()) else { return true };
        let is_outer = self.arcs.last() == Some(arc);
        let [a, b, c] = triangle.map(|v| self.points[v].normalize());
        is_outer && turn(a, b, c) > 0.0
    }
}

/// Places from `lo` to `hi`, both included, a whole number of `step`s (which depend on the share of
/// the way) apart. None where these are too small.
fn steps(lo: f64, hi: f64, step: impl Fn(f64) -> f64) -> Option<Vec<f64>> {
    let width = 1.0 / PLACES as f64;
    let rates: Vec<f64> =
        (0..PLACES).map(|k| width * (hi - lo) / step((k as f64 + 0.5) * width)).collect();
    let total: f64 = rates.iter().sum();
    if !(total <= CROWDED as f64) {
        return None;
    }
    // What is a whole number but for rounding is one.
    let whole = (total - 1e-6).ceil().max(1.0);
    let (mut places, mut reached, mut next) = (vec![lo], 0.0, 1.0);
    for (k, rate) in rates.iter().map(|rate| rate * whole / total).enumerate() {
        while next < reached + rate && next < whole - 0.5 {
            places.push(lo + (hi - lo) * width * (k as f64 + (next - reached) / rate));
            next += 1.0;
        }
        reached += rate;
    }
    places.push(hi);
    Some(places)
}
