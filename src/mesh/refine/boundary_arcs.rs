//! The arcs of a mirror's boundary, onto which vertices between two vertices of one arc go.

use crate::geom::{DVec2, Outline};
use crate::mirror::Mirror;
use crate::num::{atan, cos, sin};
use std::f64::consts::{FRAC_PI_2, PI};

/// Relative distance from an arc up to which a vertex counts as on it: rounding leaves less.
const ON_ARC: f64 = 1e-6;
/// Size of a direction's component that counts as 0: ends of arcs lie on an axis, exactly.
const ON_AXIS: f64 = 1e-12;
/// Share of what a chord may cut off that is used: rounding takes a little of it.
const CUT: f64 = 0.98;

/// The part of a circle about the axis that bounds the meshed part of a mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BoundaryArc {
    /// Radius, mm.
    pub radius: f64,
    /// Angles of its ends, radians.
    pub ends: [f64; 2],
    /// Whether it is the whole circle, and its ends one point.
    pub closed: bool,
}

impl BoundaryArc {
    /// The arcs of `mirror`, the outer one last; none of a rectangle.
    pub(crate) fn all(mirror: &Mirror) -> Vec<Self> {
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

    /// The largest angle (radians) that a chord may span.
    pub(crate) fn widest_chord() -> f64 {
        let cut = CUT * Outline::EDGE;
        // 1 - cos a = 2 sin^2 (a / 2) for half the chord's angle a.
        4.0 * atan((cut / (2.0 - cut)).sqrt())
    }

    /// The point at an angle (radians), mm.
    pub(crate) fn at(&self, angle: f64) -> DVec2 {
        let way = DVec2::new(cos(angle), sin(angle));
        let way = DVec2::select(way.abs().cmplt(DVec2::splat(ON_AXIS)), DVec2::ZERO, way);
        way * self.radius
    }

    /// The point of the circle that is nearest to `p`, mm.
    pub(crate) fn project(&self, p: DVec2) -> DVec2 {
        p.normalize() * self.radius
    }
}

/// The arcs of a boundary, and the boundary nodes on each.
#[derive(Debug, Clone)]
pub(crate) struct BoundaryArcs {
    /// The arcs, the outer one last.
    pub arcs: Vec<BoundaryArc>,
    /// For every boundary node 0, or 1 + the number of its arc.
    pub arc_of: Vec<u8>,
}

impl BoundaryArcs {
    /// The arc on which two neighbouring boundary nodes lie, if both do.
    pub(crate) fn between(&self, a: usize, b: usize) -> Option<&BoundaryArc> {
        let of = |v: usize| self.arc_of.get(v).copied().unwrap_or(0);
        (of(a) != 0 && of(a) == of(b)).then(|| &self.arcs[usize::from(of(a)) - 1])
    }

    /// The arc on which two points of the boundary lie, if both do.
    pub(crate) fn through(&self, a: DVec2, b: DVec2) -> Option<&BoundaryArc> {
        let on = |arc: &&BoundaryArc| {
            [a, b].into_iter().all(|p| (p.length() - arc.radius).abs() <= ON_ARC * arc.radius)
        };
        self.arcs.iter().find(on)
    }
}
