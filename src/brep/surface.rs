//! Surfaces of faces: planes, surfaces of revolution and splines, with their inverse.

use super::b_spline::SplineSurface;
use super::curve::Curve;
use crate::geom::DVec3;
use crate::num::{atan2, cos, sin};
use std::f64::consts::{FRAC_PI_8, TAU};

/// A place with three unit vectors at right angles, right-handed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub at: DVec3,
    pub x: DVec3,
    pub y: DVec3,
    pub z: DVec3,
}

impl Frame {
    /// The frame whose Z is `z` and whose X is the part of `x` across it; `None` where there is none.
    pub(super) fn new(at: DVec3, z: DVec3, x: DVec3) -> Option<Self> {
        let z = z.try_normalize()?;
        let x = (x - z * x.dot(z)).try_normalize()?;
        Some(Self { at, x, y: z.cross(x), z })
    }

    /// Components of a vector along the frame's axes.
    pub(super) fn components(&self, v: DVec3) -> DVec3 {
        DVec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }
}

/// A surface of two parameters u and v, whose normal is that of its derivatives along u and along v.
#[derive(Debug, Clone)]
pub(super) enum FaceSurface {
    /// `at + x u + y v`.
    Plane(Frame),
    /// The meridian, in X >= 0 and Y = 0 of the frame, turned about its Z by the angle u; v is the meridian's.
    Revolved { frame: Frame, meridian: Curve },
    /// A spline over its knots.
    Spline(SplineSurface),
}

/// Point and derivatives along u and v.
pub(super) type SurfaceJet = [DVec3; 3];

/// Steps of Newton's method: quadratic convergence needs fewer than ten.
const STEPS: usize = 24;
/// Last step of Newton's method, as a share of the range: what is left after it is its square.
const LAST_STEP: f64 = 1e-10;

impl FaceSurface {
    pub(super) fn at(&self, [u, v]: [f64; 2]) -> SurfaceJet {
        match self {
            Self::Plane(frame) => [frame.at + frame.x * u + frame.y * v, frame.x, frame.y],
            Self::Revolved { frame, meridian } => {
                let (c, s) = (cos(u), sin(u));
                let (p, d) = meridian.at(v);
                let (out, round) = (frame.x * c + frame.y * s, frame.y * c - frame.x * s);
                let at = frame.at + out * p.x + frame.z * p.z;
                [at, round * p.x, out * d.x + frame.z * d.z]
            }
            Self::Spline(spline) => spline.at(u, v),
        }
    }

    /// Increase of u and of v once round, where the surface closes.
    pub(super) fn periods(&self) -> [Option<f64>; 2] {
        match self {
            Self::Plane(_) => [None; 2],
            Self::Revolved { meridian, .. } => {
                let [lo, hi] = self.range_v();
                let is_closed = match meridian {
                    Curve::Line { .. } => false,
                    Curve::Ellipse { .. } => hi - lo >= TAU,
                    Curve::Spline(_) => meridian.period(GAP).is_some(),
                };
                [Some(TAU), is_closed.then_some(hi - lo)]
            }
            Self::Spline(spline) => [0, 1].map(|axis| {
                let [lo, hi] = spline.knots[axis].domain();
                spline.closed[axis].then_some(hi - lo)
            }),
        }
    }

    /// Length of the range of u; 1 where the surface has no end.
    pub(super) fn length_u(&self) -> f64 {
        match self {
            Self::Plane(_) => 1.0,
            Self::Revolved { .. } => TAU,
            Self::Spline(spline) => {
                let [lo, hi] = spline.knots[0].domain();
                hi - lo
            }
        }
    }

    /// Where a range of u, which may fall, is cut before it is integrated: knots, or eighths of a half turn.
    pub(super) fn breaks_u(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        let (lo, hi) = (from.min(to), from.max(to));
        let mut inner: Vec<f64> = match self {
            Self::Plane(_) => Vec::new(),
            Self::Revolved { .. } => {
                let count = ((hi - lo) / FRAC_PI_8).ceil().clamp(1.0, 64.0) as usize;
                (1..count).map(|k| lo + (hi - lo) * k as f64 / count as f64).collect()
            }
            Self::Spline(spline) => spline.knots[0].breaks(),
        };
        inner.retain(|&u| u > lo && u < hi);
        if from > to {
            inner.reverse();
        }
        std::iter::once(from).chain(inner).chain([to]).collect()
    }

    /// Least and largest v; infinite where the surface has no end.
    pub(super) fn range_v(&self) -> [f64; 2] {
        match self {
            Self::Plane(_) => [f64::NEG_INFINITY, f64::INFINITY],
            Self::Spline(spline) => spline.knots[1].domain(),
            Self::Revolved { meridian, .. } => meridian_range(meridian),
        }
    }

    /// Parameters of the surface's point nearest to `p`: of a spline by Newton's method from the parameters `near`,
    /// or from the nearest of many places.
    pub(super) fn inverse(&self, p: DVec3, near: Option<[f64; 2]>) -> [f64; 2] {
        match self {
            Self::Plane(frame) => [(p - frame.at).dot(frame.x), (p - frame.at).dot(frame.y)],
            Self::Revolved { frame, meridian } => {
                let at = frame.components(p - frame.at);
                let radius = (at.x * at.x + at.y * at.y).sqrt();
                let v = meridian.nearest(DVec3::new(radius, 0.0, at.z));
                [atan2(at.y, at.x), within(v, meridian_range(meridian), meridian)]
            }
            Self::Spline(spline) => {
                let near = near.map(|near| nearest(spline, p, near));
                let is_on = |q: &[f64; 2]| spline.at(q[0], q[1])[0].distance(p) <= FAR;
                near.filter(is_on).unwrap_or_else(|| nearest(spline, p, coarse(spline, p)))
            }
        }
    }

    /// The spline that has u for v and v for u, whose normal is the opposite; other surfaces stay.
    pub(super) fn transposed(self) -> Self {
        let Self::Spline(SplineSurface { knots: [u, v], points, closed }) = self else {
            return self;
        };
        let (rows, columns) = (u.count(), v.count());
        let at = |k: usize| points[k % rows * columns + k / rows];
        let points = (0..rows * columns).map(at).collect();
        Self::Spline(SplineSurface { knots: [v, u], points, closed: [closed[1], closed[0]] })
    }
}

/// Distance between the ends of a meridian that closes, mm.
const GAP: f64 = 1e-7;
/// Distance from a surface beyond which Newton's method has gone astray, mm.
const FAR: f64 = 1e-3;

/// Where a meridian is on its own side of the axis.
fn meridian_range(meridian: &Curve) -> [f64; 2] {
    let all = [f64::NEG_INFINITY, f64::INFINITY];
    match meridian {
        Curve::Line { at, along } => match along.x {
            0.0 => all,
            rising if rising > 0.0 => [-at.x / along.x, all[1]],
            _ => [all[0], -at.x / along.x],
        },
        Curve::Ellipse { centre, axes: [x, y] } => {
            let reach = (x.x * x.x + y.x * y.x).sqrt();
            let middle = atan2(y.x, x.x);
            if centre.x >= reach {
                return [middle - 0.5 * TAU, middle + 0.5 * TAU];
            }
            let share = (-centre.x / reach).clamp(-1.0, 1.0);
            let half = atan2((1.0 - share * share).sqrt(), share);
            [middle - half, middle + half]
        }
        Curve::Spline(spline) => spline.knots.domain(),
    }
}

/// The angle `v` of an ellipse with as many whole turns as bring it into a range, or nearest to it.
fn within(v: f64, [lo, hi]: [f64; 2], meridian: &Curve) -> f64 {
    let Curve::Ellipse { .. } = meridian else { return v.clamp(lo, hi) };
    let middle = 0.5 * (lo + hi);
    let turned = v - TAU * ((v - middle) / TAU).round();
    turned.clamp(lo, hi)
}

/// Parts of each span in whose middles the nearest point of a spline is looked for: at its ends it may have poles, from
/// where no step leads away.
const COARSE: usize = 2;

/// Parameters of the nearest of a spline's points on a grid.
fn coarse(spline: &SplineSurface, p: DVec3) -> [f64; 2] {
    let [us, vs] = [0, 1].map(|axis| {
        let breaks = spline.knots[axis].breaks();
        let span = |ends: &[f64]| {
            let [from, to] = [ends[0], ends[1]];
            (0..COARSE).map(move |k| from + (to - from) * (k as f64 + 0.5) / COARSE as f64)
        };
        breaks.windows(2).flat_map(span).collect::<Vec<f64>>()
    });
    let mut best = (f64::INFINITY, [us[0], vs[0]]);
    for &u in &us {
        for &v in &vs {
            let distance = spline.at(u, v)[0].distance_squared(p);
            if distance < best.0 {
                best = (distance, [u, v]);
            }
        }
    }
    best.1
}

/// Parameters of the nearest point by Gauss and Newton's method; a closed axis goes round.
fn nearest(spline: &SplineSurface, p: DVec3, mut q: [f64; 2]) -> [f64; 2] {
    for _ in 0..STEPS {
        let [at, along_u, along_v] = spline.at(q[0], q[1]);
        let step = solve([along_u, along_v], p - at);
        let (mut next, mut is_last) = (q, true);
        for axis in 0..2 {
            let [lo, hi] = spline.knots[axis].domain();
            let to = q[axis] + step[axis];
            is_last &= step[axis].abs() <= LAST_STEP * (hi - lo);
            next[axis] = if spline.closed[axis] {
                lo + (to - lo).rem_euclid(hi - lo)
            } else {
                to.clamp(lo, hi)
            };
        }
        if !(next[0].is_finite() && next[1].is_finite()) || next == q {
            break;
        }
        q = next;
        if is_last {
            break;
        }
    }
    q
}

/// Coefficients a and b for which `a u + b v` is nearest to `d`.
pub(super) fn solve([u, v]: [DVec3; 2], d: DVec3) -> [f64; 2] {
    let normal = u.cross(v);
    let square = normal.length_squared();
    [d.cross(v).dot(normal) / square, u.cross(d).dot(normal) / square]
}
