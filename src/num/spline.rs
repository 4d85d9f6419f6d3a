//! The smooth curve through given points: twice differentiable piecewise cubics.

use super::interval::Interval;
use super::scalar::Curve;

/// Rounding of an evaluation, as a share of the sum of the terms' sizes.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Cubics side by side. Piece k lies between `borders` k and k + 1 (the outermost are infinite)
/// and has the coefficients `terms[k]` of the powers of x - `anchors[k]`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pieces {
    pub(super) borders: Vec<f64>,
    pub(super) anchors: Vec<f64>,
    pub(super) terms: Vec<[f64; 4]>,
}

/// f and its first three derivatives at `t`.
#[inline]
pub(super) fn cubic([a, b, c, d]: [f64; 4], t: f64) -> [f64; 4] {
    [
        a + t * (b + t * (c + t * d)),
        b + t * (2.0 * c + t * (3.0 * d)),
        2.0 * c + t * (6.0 * d),
        6.0 * d,
    ]
}

/// Ranges of f, f' and f'' over `from`..=`to`.
fn cubic_over(terms: [f64; 4], from: f64, to: f64) -> [Interval; 3] {
    let [_, b, c, d] = terms;
    // Where f' is 0 (in the form that does not cancel), and f''.
    let spread = f64::sqrt(c * c - 3.0 * b * d);
    let q = -(c + spread.copysign(c));
    let flat = [q / (3.0 * d), b / q];
    let bend = [-c / (3.0 * d)];
    let sizes = cubic(terms.map(f64::abs), from.abs().max(to.abs()));
    let range = |order: usize, inner: &[f64]| {
        let inside = |t: &f64| from < *t && *t < to;
        [from, to]
            .into_iter()
            .chain(inner.iter().copied().filter(inside))
            .map(|t| Interval::around(cubic(terms, t)[order], ROUNDING * sizes[order]))
            .reduce(Interval::hull)
            .unwrap_or(Interval::WHOLE)
    };
    [range(0, &flat), range(1, &bend), range(2, &[])]
}

impl Pieces {
    /// The piece that `x` is in: at a border, the one that begins there.
    #[inline]
    fn find(&self, x: f64) -> usize {
        let inner = &self.borders[1..self.terms.len()];
        inner.partition_point(|&border| border <= x)
    }

    #[inline]
    pub(super) fn evaluate(&self, x: f64) -> [f64; 4] {
        let k = self.find(x);
        cubic(self.terms[k], x - self.anchors[k])
    }

    /// Ranges of f, f' and f'' on each piece's share of the range; both sides of a border count.
    pub(super) fn parts(&self, [lo, hi]: [f64; 2]) -> impl Iterator<Item = [Interval; 3]> {
        let inner = &self.borders[1..self.terms.len()];
        let first = inner.partition_point(|&border| border < lo);
        let last = inner.partition_point(|&border| border <= hi).max(first);
        (first..=last).map(move |k| {
            let from = lo.max(self.borders[k]) - self.anchors[k];
            let to = hi.min(self.borders[k + 1]) - self.anchors[k];
            cubic_over(self.terms[k], from, to)
        })
    }
}

pub(super) fn hulls(parts: impl Iterator<Item = [Interval; 3]>) -> [[f64; 2]; 3] {
    parts
        .reduce(|a, b| std::array::from_fn(|k| a[k].hull(b[k])))
        .unwrap_or([Interval::WHOLE; 3])
        .map(|range| [range.lo, range.hi])
}

/// Knots (strictly rising), values at them, and both finite, in equal numbers of at least two?
pub(super) fn fit_to_use(knots: &[f64], values: &[f64]) -> bool {
    knots.len() >= 2
        && knots.len() == values.len()
        && knots.iter().chain(values).all(|x| x.is_finite())
        && knots.windows(2).all(|k| k[0] < k[1])
}

/// Lengths of the pieces and slopes of the chords.
pub(super) fn chords(knots: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let h: Vec<f64> = knots.windows(2).map(|k| k[1] - k[0]).collect();
    let slopes = values.windows(2).zip(&h).map(|(y, h)| (y[1] - y[0]) / h).collect();
    (h, slopes)
}

/// The twice differentiable piecewise cubic through given points, "not a knot" at the ends (the
/// two pieces at each end are one cubic): three points give their parabola, two their line.
/// Outside the knots the end pieces go on.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicSpline(Pieces);

impl CubicSpline {
    /// The spline through `values` at the strictly rising `knots`; None if they are not that, or
    /// fewer than two, or not finite.
    #[must_use]
    pub fn new(knots: &[f64], values: &[f64]) -> Option<Self> {
        if !fit_to_use(knots, values) {
            return None;
        }
        let (h, slopes) = chords(knots, values);
        let bends = bends(&h, &slopes);
        let n = h.len();
        let terms = (0..n)
            .map(|k| {
                let [from, to] = [bends[k], bends[k + 1]];
                [
                    values[k],
                    slopes[k] - h[k] * (2.0 * from + to) / 6.0,
                    from / 2.0,
                    (to - from) / (6.0 * h[k]),
                ]
            })
            .collect();
        let mut borders = knots.to_vec();
        (borders[0], borders[n]) = (f64::NEG_INFINITY, f64::INFINITY);
        Some(Self(Pieces { borders, anchors: knots[..n].to_vec(), terms }))
    }

    /// f, f', f'' and f''' at `x` (f''' jumps at knots).
    #[must_use]
    pub fn derivatives(&self, x: f64) -> [f64; 4] {
        self.0.evaluate(x)
    }

    /// f at `x`.
    #[must_use]
    pub fn value(&self, x: f64) -> f64 {
        self.0.evaluate(x)[0]
    }
}

/// Second derivatives at the knots of the spline with pieces `h` long and chords of `slopes`.
fn bends(h: &[f64], slopes: &[f64]) -> Vec<f64> {
    let n = h.len();
    if n < 3 {
        let bend = if n < 2 { 0.0 } else { 2.0 * (slopes[1] - slopes[0]) / (h[0] + h[1]) };
        return vec![bend; n + 1];
    }
    // A third derivative that does not jump at the second knot makes the first bend
    // M_0 = M_1 + (M_1 - M_2) h_0 / h_1, and likewise at the other end. With those put in, the
    // rows of the inner knots stay diagonally dominant: no pivoting.
    let mut m = vec![0.0; n + 1];
    let mut above = vec![0.0; n];
    for k in 1..n {
        let (p, q) = (h[k - 1], h[k]);
        let (mut left, mut middle, mut right) = (p, 2.0 * (p + q), q);
        if k == 1 {
            middle += p * (1.0 + p / q);
            right -= p * p / q;
            left = 0.0;
        }
        if k == n - 1 {
            middle += q * (1.0 + q / p);
            left -= q * q / p;
            right = 0.0;
        }
        let pivot = middle - left * above[k - 1];
        above[k] = right / pivot;
        m[k] = (6.0 * (slopes[k] - slopes[k - 1]) - left * m[k - 1]) / pivot;
    }
    for k in (1..n - 1).rev() {
        m[k] -= above[k] * m[k + 1];
    }
    m[0] = m[1] + (m[1] - m[2]) * (h[0] / h[1]);
    m[n] = m[n - 1] + (m[n - 1] - m[n - 2]) * (h[n - 1] / h[n - 2]);
    m
}

impl Curve for CubicSpline {
    fn at(&self, x: f64) -> [f64; 3] {
        let [f, d, dd, _] = self.0.evaluate(x);
        [f, d, dd]
    }

    fn over(&self, range: [f64; 2]) -> [[f64; 2]; 3] {
        hulls(self.0.parts(range))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::num::sample::Draws;
    use crate::num::sin;

    /// Knots from -1 up, unevenly spaced.
    pub fn knots(count: u64, r: &mut Draws) -> Vec<f64> {
        let grow = |x: &mut f64, _| {
            *x += r.inside([0.05, 0.5]);
            Some(*x)
        };
        (0..count).scan(-1.0, grow).collect()
    }

    /// Do the ranges over parts of [lo, hi] hold what is at points inside?
    pub fn holds(curve: &impl Curve, [lo, hi]: [f64; 2], r: &mut Draws) {
        for _ in 0..100 {
            let range = r.range([lo, hi]);
            let over = curve.over(range);
            for _ in 0..8 {
                let x = r.inside(range);
                for (k, (over, at)) in over.iter().zip(curve.at(x)).enumerate() {
                    assert!(over[0] <= at && at <= over[1], "order {k} at {x}: {at} {over:?}");
                }
            }
        }
    }

    /// Largest distance from sin(1.5 x) on [-1, 1] of the curve through `n` + 1 even points of it.
    pub fn error<C: Curve>(n: u32, through: impl Fn(&[f64], &[f64]) -> Option<C>) -> f64 {
        let f = |x: f64| sin(1.5 * x);
        let even = |n: u32| (0..=n).map(move |k| 2.0 * f64::from(k) / f64::from(n) - 1.0);
        let knots: Vec<f64> = even(n).collect();
        let values: Vec<f64> = knots.iter().map(|&x| f(x)).collect();
        let curve = through(&knots, &values).unwrap();
        even(999).map(|x| (curve.at(x)[0] - f(x)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn splines_give_back_cubics() {
        let mut r = Draws::new(1);
        for count in 2..12 {
            let knots = knots(count, &mut r);
            // As high a degree as the points tell.
            let terms: [f64; 4] =
                std::array::from_fn(
                    |k| {
                        if (k as u64) < count { r.inside([-1.0, 1.0]) } else { 0.0 }
                    },
                );
            let values: Vec<f64> = knots.iter().map(|&x| cubic(terms, x)[0]).collect();
            let spline = CubicSpline::new(&knots, &values).unwrap();
            for _ in 0..100 {
                let x = r.inside([-1.5, 2.0]);
                let (found, exact) = (spline.derivatives(x), cubic(terms, x));
                for (k, tolerance) in [1e-12, 1e-11, 1e-10, 1e-9].into_iter().enumerate() {
                    assert!((found[k] - exact[k]).abs() < tolerance, "{count}, order {k}");
                }
            }
        }
    }

    #[test]
    fn splines_are_smooth_and_keep_to_their_ranges() {
        for mut r in (0..50).map(Draws::new) {
            let knots = knots(9, &mut r);
            let values: Vec<f64> = knots.iter().map(|_| r.inside([-1.0, 1.0])).collect();
            let spline = CubicSpline::new(&knots, &values).unwrap();
            for (&knot, &value) in knots.iter().zip(&values) {
                assert!((spline.value(knot) - value).abs() < 1e-14);
                let [before, after] =
                    [knot.next_down(), knot.next_up()].map(|x| spline.derivatives(x));
                let size = before[2].abs() + before[3].abs() + after[3].abs() + 1.0;
                for k in 0..3 {
                    assert!((before[k] - after[k]).abs() < 1e-13 * size, "order {k} at {knot}");
                }
            }
            // Not a knot: the third derivative is the same on the outer two pieces.
            let third = |k: usize| spline.derivatives(0.5 * (knots[k] + knots[k + 1]))[3];
            for (a, b) in [(third(0), third(1)), (third(6), third(7))] {
                assert!((a - b).abs() < 1e-10 * (1.0 + a.abs()));
            }
            holds(&spline, [-1.3, knots[8] + 0.3], &mut r);
        }
    }

    #[test]
    fn splines_converge_at_fourth_order() {
        let [coarse, fine] = [20, 40].map(|n| error(n, CubicSpline::new));
        assert!((11.0..30.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }

    #[test]
    fn points_that_will_not_do_are_refused() {
        assert!(CubicSpline::new(&[0.0], &[1.0]).is_none());
        assert!(CubicSpline::new(&[0.0, 1.0, 1.0], &[1.0, 2.0, 3.0]).is_none());
        assert!(CubicSpline::new(&[0.0, 1.0], &[1.0, f64::NAN]).is_none());
        assert!(CubicSpline::new(&[0.0, 1.0], &[1.0, 2.0, 3.0]).is_none());
    }
}
