//! Curves of edges: lines, ellipses and splines, with their inverse.

use super::b_spline::{Knots, SplineCurve, Weighted};
use crate::geom::DVec3;
use crate::num::{atan2, cos, sin};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_8, TAU};

/// A curve in space, of a parameter t.
#[derive(Debug, Clone)]
pub(super) enum Curve {
    /// `at + along t` of a unit vector `along`.
    Line { at: DVec3, along: DVec3 },
    /// `centre + axes[0] cos t + axes[1] sin t`: circles and ellipses.
    Ellipse { centre: DVec3, axes: [DVec3; 2] },
    /// A spline over its knots.
    Spline(SplineCurve),
}

/// Samples of each span of a spline among which the nearest to a point is searched.
const SAMPLES: usize = 8;
/// Steps of Newton's method from the nearest sample: quadratic convergence needs fewer than ten.
const STEPS: usize = 20;

impl Curve {
    /// Point and derivative at `t`; a closed spline goes round.
    pub(super) fn at(&self, t: f64) -> (DVec3, DVec3) {
        match self {
            Self::Line { at, along } => (*at + *along * t, *along),
            Self::Ellipse { centre, axes: [x, y] } => {
                let (c, s) = (cos(t), sin(t));
                (*centre + *x * c + *y * s, *y * c - *x * s)
            }
            Self::Spline(spline) => {
                let [lo, hi] = spline.knots.domain();
                let inside = if t > hi {
                    t - (hi - lo)
                } else if t < lo {
                    t + (hi - lo)
                } else {
                    t
                };
                spline.at(inside.clamp(lo, hi))
            }
        }
    }

    /// The parameter's increase once round, of a curve whose ends are within `gap` of each other.
    pub(super) fn period(&self, gap: f64) -> Option<f64> {
        match self {
            Self::Line { .. } => None,
            Self::Ellipse { .. } => Some(TAU),
            Self::Spline(spline) => {
                let [lo, hi] = spline.knots.domain();
                (spline.at(lo).0.distance(spline.at(hi).0) <= gap).then_some(hi - lo)
            }
        }
    }

    /// The parameter of the point of the curve nearest to `p`.
    pub(super) fn nearest(&self, p: DVec3) -> f64 {
        match self {
            Self::Line { at, along } => (p - *at).dot(*along),
            Self::Ellipse { centre, axes: [x, y] } => {
                let off = p - *centre;
                // Of a point on the ellipse this is the parameter, to rounding.
                atan2(off.dot(*y) / y.length_squared(), off.dot(*x) / x.length_squared())
            }
            Self::Spline(spline) => nearest_of_spline(spline, p),
        }
    }

    /// Places along it, of a line two of them; for checks of where it lies.
    pub(super) fn samples(&self) -> Vec<DVec3> {
        let range = match self {
            Self::Line { .. } => [0.0, 1.0],
            Self::Ellipse { .. } => [0.0, TAU],
            Self::Spline(spline) => spline.knots.domain(),
        };
        self.breaks(range).into_iter().map(|t| self.at(t).0).collect()
    }

    /// Points whose convex hull holds the curve between two parameters.
    pub(super) fn hull(&self, range: [f64; 2]) -> Vec<DVec3> {
        match self {
            Self::Line { .. } => range.map(|t| self.at(t).0).to_vec(),
            Self::Ellipse { centre, axes: [x, y] } => {
                let sides = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
                sides.map(|[a, b]| *centre + *x * a + *y * b).to_vec()
            }
            Self::Spline(spline) => spline.points.iter().map(|point| point.project()).collect(),
        }
    }

    /// The curve in other coordinates: of points, and of vectors.
    pub(super) fn mapped(
        &self,
        point: impl Fn(DVec3) -> DVec3,
        vector: impl Fn(DVec3) -> DVec3,
    ) -> Self {
        match self {
            Self::Line { at, along } => Self::Line { at: point(*at), along: vector(*along) },
            Self::Ellipse { centre, axes } => {
                Self::Ellipse { centre: point(*centre), axes: axes.map(vector) }
            }
            Self::Spline(SplineCurve { knots, points }) => {
                let moved = |p: &Weighted| Weighted::new(point(p.project()), p.w);
                let points = points.iter().map(moved).collect();
                Self::Spline(SplineCurve { knots: knots.clone(), points })
            }
        }
    }

    /// Control points and weights of pieces of the curve between two parameters, each in Bezier's form, with the
    /// range of its parameters.
    pub(super) fn pieces(&self, range: [f64; 2]) -> Vec<(Vec<Weighted>, [f64; 2])> {
        match self {
            Self::Line { .. } => {
                let points = range.map(|t| Weighted::new(self.at(t).0, 1.0));
                vec![(points.to_vec(), range)]
            }
            Self::Ellipse { centre, axes: [x, y] } => {
                let count = ((range[1] - range[0]) / FRAC_PI_2).ceil().max(1.0);
                let step = (range[1] - range[0]) / count;
                let arc = |k: usize| {
                    let ends = [0, 1].map(|end| range[0] + step * (k + end) as f64);
                    let (middle, weight) = (0.5 * (ends[0] + ends[1]), cos(0.5 * step));
                    // Where the tangents of both ends meet.
                    let corner = *centre + (*x * cos(middle) + *y * sin(middle)) / weight;
                    let [a, b] = ends.map(|t| Weighted::new(self.at(t).0, 1.0));
                    (vec![a, Weighted::new(corner, weight), b], ends)
                };
                (0..count as usize).map(arc).collect()
            }
            Self::Spline(SplineCurve { knots, points }) => {
                let breaks = knots.breaks();
                let piece = |ends: &[f64]| {
                    let span = knots.span(0.5 * (ends[0] + ends[1]));
                    let own = &points[span - knots.degree..];
                    let sum = |row: Vec<f64>| {
                        row.iter().zip(own).fold(Weighted::ZERO, |sum, (w, p)| sum + *p * *w)
                    };
                    (knots.bezier(span).into_iter().map(sum).collect(), [ends[0], ends[1]])
                };
                breaks.windows(2).map(piece).collect()
            }
        }
    }

    /// The whole of an ellipse as a spline of other parameters.
    pub(super) fn as_spline(&self) -> Result<SplineCurve, String> {
        let pieces = self.pieces([0.0, TAU]);
        let degree = pieces[0].0.len() - 1;
        let mut points = vec![pieces[0].0[0]];
        points.extend(pieces.iter().flat_map(|(points, _)| &points[1..]));
        let knots = Knots::even(degree, points.len(), degree, true)?;
        Ok(SplineCurve { knots, points })
    }

    /// Where a range of parameters is cut before it is sampled: knots, and eighths of a half turn.
    pub(super) fn breaks(&self, [from, to]: [f64; 2]) -> Vec<f64> {
        let (lo, hi) = (from.min(to), from.max(to));
        let mut inner: Vec<f64> = match self {
            Self::Line { .. } => Vec::new(),
            Self::Ellipse { .. } => {
                let count = ((hi - lo) / FRAC_PI_8).ceil().clamp(1.0, 64.0) as usize;
                (1..count).map(|k| lo + (hi - lo) * k as f64 / count as f64).collect()
            }
            Self::Spline(spline) => {
                let [first, last] = spline.knots.domain();
                let breaks = spline.knots.breaks();
                let turns = [0.0, last - first, first - last];
                turns.iter().flat_map(|turn| breaks.iter().map(move |knot| knot + turn)).collect()
            }
        };
        let margin = 1e-12 * (hi - lo);
        inner.retain(|&t| t > lo + margin && t < hi - margin);
        inner.sort_by(f64::total_cmp);
        inner.dedup();
        if from > to {
            inner.reverse();
        }
        std::iter::once(from).chain(inner).chain([to]).collect()
    }
}

fn nearest_of_spline(spline: &SplineCurve, p: DVec3) -> f64 {
    let [lo, hi] = spline.knots.domain();
    let off = |t: f64| spline.at(t).0.distance_squared(p);
    // An edge ends most often where its curve does.
    let scale = p.abs().max_element().max(1.0);
    for end in [lo, hi] {
        if off(end) <= (1e-10 * scale) * (1e-10 * scale) {
            return end;
        }
    }
    let mut best = (f64::INFINITY, lo);
    for ends in spline.knots.breaks().windows(2) {
        for k in 0..=SAMPLES {
            let t = ends[0] + (ends[1] - ends[0]) * k as f64 / SAMPLES as f64;
            let distance = off(t);
            if distance < best.0 {
                best = (distance, t);
            }
        }
    }
    let mut t = best.1;
    for _ in 0..STEPS {
        let (at, along) = spline.at(t);
        let step = (p - at).dot(along) / along.length_squared();
        if !step.is_finite() {
            break;
        }
        let next = (t + step).clamp(lo, hi);
        if next == t {
            break;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::super::b_spline::{Knots, Weighted};
    use super::*;

    #[test]
    fn the_inverse_finds_the_parameter() {
        let points = [(0.0, 0.0), (1.0, 2.0), (3.0, -1.0), (4.0, 1.0), (6.0, 0.5)];
        let points = points.map(|(x, z)| Weighted::new(DVec3::new(x, 1.0, z), 1.0)).to_vec();
        let spline =
            Curve::Spline(SplineCurve { knots: Knots::even(3, 5, 1, true).unwrap(), points });
        let line = Curve::Line { at: DVec3::ONE, along: DVec3::new(0.6, 0.0, 0.8) };
        let ellipse = Curve::Ellipse { centre: DVec3::Y, axes: [DVec3::X * 3.0, DVec3::Z * 2.0] };
        for (curve, ends) in [(spline, [0.0, 2.0]), (line, [-4.0, 7.0]), (ellipse, [-3.0, 3.0])] {
            for k in 0..=30 {
                let t = ends[0] + (ends[1] - ends[0]) * f64::from(k) / 30.0;
                assert!((curve.nearest(curve.at(t).0) - t).abs() < 1e-9, "{t}");
            }
        }
    }

    #[test]
    fn breaks_run_the_way_of_the_edge() {
        let circle = Curve::Ellipse { centre: DVec3::ZERO, axes: [DVec3::X, DVec3::Y] };
        let breaks = circle.breaks([TAU, 0.0]);
        assert_eq!((breaks[0], breaks[16], breaks.len()), (TAU, 0.0, 17));
        assert!(breaks.is_sorted_by(|a, b| a > b));
    }
}
