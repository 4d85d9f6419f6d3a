//! Rim curves: closed splines on a B-spline surface, over a circle.

use super::FitError;
use super::b_spline::{BSplineSurface, KnotVector};
use super::knots::written_digits;
use crate::geom::{DVec2, DVec3};
use crate::num::{atan2, cos, sin};
use std::f64::consts::PI;

/// The largest distance of a rim from its spline, mm.
const LIMIT_MM: f64 = 4e-8;
/// Spans of a rim at least, and rounds of dividing them.
const LEAST_SPANS: usize = 64;
const ROUNDS: usize = 6;
/// Angles closer than this are one.
const CLOSE: f64 = 1e-4;
/// Places in every span where the distance is measured.
const PARTS: usize = 5;

/// A closed cubic spline over the angle from the X axis, 0 to 2 pi.
#[derive(Debug, Clone)]
pub(super) struct RimCurve {
    /// Its knots.
    pub angles: KnotVector,
    /// Its control points; the last is the first.
    pub points: Vec<DVec3>,
}

impl RimCurve {
    /// The direction at `angle` from the X axis.
    pub(super) fn direction(angle: f64) -> DVec2 {
        DVec2::new(cos(angle), sin(angle))
    }

    /// The curve on `net`, whose parameters are X and Y, over the circle of radius `rho`.
    pub(super) fn new(net: &BSplineSurface, rho: f64) -> Result<Self, FitError> {
        let at = |angle: f64| net.at(Self::direction(angle) * rho);
        let mut breaks = crossings(net, rho);
        let start = at(0.0);
        let mut worst = f64::NAN;
        for _ in 0..ROUNDS {
            let angles = KnotVector::new(&breaks);
            let samples: Vec<f64> =
                angles.sites().iter().flat_map(|&angle| at(angle).to_array()).collect();
            let found = angles.fit(3, &samples);
            let mut points: Vec<DVec3> =
                found.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect();
            let last = points.len() - 1;
            (points[0], points[last]) = (start, start);
            points
                .iter_mut()
                .for_each(|p| *p = DVec3::from_array(p.to_array().map(written_digits)));
            let rim = Self { angles, points };
            let off = |&angle: &f64| (rim.at(angle) - at(angle)).length();
            let offs: Vec<f64> = rim.angles.interior_points(PARTS).iter().map(off).collect();
            let offs: Vec<f64> =
                offs.chunks(PARTS).map(|offs| offs.iter().copied().fold(0.0, f64::max)).collect();
            worst = offs.iter().copied().fold(0.0, f64::max);
            if worst <= LIMIT_MM {
                return Ok(rim);
            }
            let parts = |off: f64| (1.1 * (off / LIMIT_MM).sqrt().sqrt()).ceil().clamp(1.0, 8.0);
            breaks = subdivide(&breaks, |k| parts(offs[k]) as usize);
        }
        Err(FitError::Rim { off_mm: worst })
    }

    /// The point at `angle`.
    pub(super) fn at(&self, angle: f64) -> DVec3 {
        let (first, b) = self.angles.basis(angle);
        (0..4).map(|k| self.points[first + k] * b[k]).sum()
    }
}

/// The angles at which the circle crosses knots, so that the spline over it is smooth between.
fn crossings(net: &BSplineSurface, rho: f64) -> Vec<f64> {
    let other = |x: f64| (rho * rho - x * x).sqrt();
    let [u, v] = net.axes.each_ref().map(|axis| axis.breaks().iter().filter(|x| x.abs() < rho));
    let on_u = u.flat_map(|&x| [DVec2::new(x, other(x)), DVec2::new(x, -other(x))]);
    let on_v = v.flat_map(|&y| [DVec2::new(other(y), y), DVec2::new(-other(y), y)]);
    let turn = |q: DVec2| {
        let angle = atan2(q.y, q.x);
        if angle < 0.0 { angle + 2.0 * PI } else { angle }
    };
    let mut angles: Vec<f64> = on_u.chain(on_v).map(turn).collect();
    angles.sort_by(f64::total_cmp);
    let mut breaks = vec![0.0];
    for angle in angles {
        if angle - breaks[breaks.len() - 1] > CLOSE && angle < 2.0 * PI - CLOSE {
            breaks.push(angle);
        }
    }
    breaks.push(2.0 * PI);
    let most = 2.0 * PI / LEAST_SPANS as f64;
    let lengths: Vec<f64> = breaks.windows(2).map(|ends| ends[1] - ends[0]).collect();
    subdivide(&breaks, |k| (lengths[k] / most).ceil() as usize)
}

/// `breaks` with every span divided into so many equal parts.
fn subdivide(breaks: &[f64], parts: impl Fn(usize) -> usize) -> Vec<f64> {
    let mut all = Vec::new();
    for (k, ends) in breaks.windows(2).enumerate() {
        let n = parts(k);
        all.extend((0..n).map(|i| ends[0] + (ends[1] - ends[0]) * (i as f64 / n as f64)));
    }
    all.push(breaks[breaks.len() - 1]);
    // The digits that are written.
    all.iter().map(|angle| (angle * 1e13).round() / 1e13).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rim_lies_on_a_rough_surface_and_on_its_cylinder() {
        let breaks: Vec<f64> = (0..=14).map(|k| f64::from(k) * 1.5 - 10.5).collect();
        let axis = KnotVector::new(&breaks);
        let (across, count) = (axis.greville(), axis.count());
        let points = (0..count * count)
            .map(|k| {
                let bump = if k % 7 == 3 { 1e-3 } else { 0.0 };
                DVec2::new(across[k / count], across[k % count]).extend(5.0 + bump)
            })
            .collect();
        let net = BSplineSurface { axes: [axis.clone(), axis], points };
        let rim = RimCurve::new(&net, 10.0).unwrap();
        assert_eq!(rim.points[0], rim.points[rim.points.len() - 1]);
        for k in 0..=5000 {
            let p = rim.at(2.0 * PI * f64::from(k) / 5000.0);
            assert!((p.truncate().length() - 10.0).abs() < 5e-8);
            assert!((net.at(p.truncate()) - p).length() < 6e-8, "{k}");
        }
    }
}
