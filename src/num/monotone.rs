//! The curve through rising or falling points that rises or falls with them, and its inverse.

use super::interval::Interval;
use super::knot_search::KnotSearch;
use super::lanes::Lanes;
use super::piecewise_cubic::{PiecewiseCubic, chords, cubic, fit_to_use, hulls};
use super::scalar::{Arithmetic, Scalar, SmoothFn};

/// A knot's slope is at most this many times either chord's. Up to 3 the piece is monotone; with
/// less, its least slope is above 0.
const STEEPEST: f64 = 2.5;

/// Share of a root that its last step may leave: a quarter of its last bit.
const LEFT: f64 = 0.25 * f64::EPSILON;

/// A once differentiable piecewise cubic through points that rise, or fall, and so does it: slopes
/// by the parabola through each knot and its neighbours, limited as Fritsch and Carlson showed.
/// Its second derivative jumps at knots. Outside the knots it is linear.
#[derive(Debug, Clone, PartialEq)]
pub struct MonotoneCubic {
    pub(super) pieces: PiecewiseCubic,
    /// Values at the knots, times `sense`, so that they rise.
    levels: KnotSearch,
    /// 1 if rising, -1 if falling.
    sense: f64,
    /// Of each piece between knots the slopes of the inverse at its ends, over that of the chord, less 1.
    bends: Vec<[f64; 2]>,
}

impl MonotoneCubic {
    /// The curve through `values`, strictly rising or strictly falling, at the strictly rising
    /// `knots`; None if they are not that, or fewer than two, or not finite.
    #[must_use]
    pub fn new(knots: &[f64], values: &[f64]) -> Option<Self> {
        if !fit_to_use(knots, values) {
            return None;
        }
        let sense = if values[0] < values[1] { 1.0 } else { -1.0 };
        let levels: Vec<f64> = values.iter().map(|y| sense * y).collect();
        let (h, chords) = chords(knots, values);
        // (Chords of values this close may round to 0, and no slope serves those.)
        if levels.windows(2).any(|y| y[0] >= y[1]) || chords.contains(&0.0) {
            return None;
        }
        let n = h.len();
        let slopes: Vec<f64> = (0..=n)
            .map(|k| match k {
                0 => end_slope(&h, &chords, 0, 1),
                k if k == n => end_slope(&h, &chords, n - 1, n.wrapping_sub(2)),
                k => {
                    let (p, q) = (chords[k - 1], chords[k]);
                    let slope = (p * h[k] + q * h[k - 1]) / (h[k - 1] + h[k]);
                    sense * slope.abs().min(STEEPEST * p.abs().min(q.abs()))
                }
            })
            .collect();
        let mut anchors = vec![knots[0]];
        anchors.extend(knots);
        let mut terms = vec![[values[0], slopes[0], 0.0, 0.0]];
        terms.extend((0..n).map(|k| {
            let [m, s, t] = [chords[k], slopes[k], slopes[k + 1]];
            [values[k], s, (3.0 * m - 2.0 * s - t) / h[k], (s + t - 2.0 * m) / (h[k] * h[k])]
        }));
        terms.push([values[n], slopes[n], 0.0, 0.0]);
        let bends =
            (0..n).map(|k| [slopes[k], slopes[k + 1]].map(|s| chords[k] / s - 1.0)).collect();
        let (borders, levels) = (KnotSearch::new(knots.to_vec()), KnotSearch::new(levels));
        Some(Self { pieces: PiecewiseCubic { borders, anchors, terms }, levels, sense, bends })
    }

    /// f at `x`.
    #[must_use]
    pub fn value(&self, x: f64) -> f64 {
        self.pieces.evaluate(x)[0]
    }

    /// The inverse function.
    #[must_use]
    pub fn inverse(&self) -> Inverse<'_> {
        Inverse(self)
    }
}

/// The slope at an end by the parabola through the nearest three points, kept above an eighth of
/// the end chord's, for an inverse that has a slope too.
fn end_slope(h: &[f64], chords: &[f64], end: usize, next: usize) -> f64 {
    let m = chords[end];
    if h.len() == 1 {
        return m;
    }
    let ratio = 1.0 + (1.0 - chords[next] / m) * (h[end] / (h[end] + h[next]));
    m * ratio.clamp(0.125, STEEPEST)
}

/// The root of a cubic in 0..=`width` by a few steps from `t`, if that is near enough.
#[inline]
fn steps(shape: [f64; 4], mut t: f64, width: f64) -> Option<f64> {
    for _ in 0..3 {
        let [f, slopes @ ..] = cubic(shape, t);
        let (step, [bent, twisted]) = chebyshev(f, slopes);
        t += step;
        if !(0.0 <= t && t <= width) {
            return None;
        }
        if step.abs().min(bent.abs() + twisted.abs()) <= LEFT * t {
            return Some(t);
        }
    }
    None
}

/// The root of a cubic that rises in 0..=`width`, by steps from `t` within the bracket that they narrow.
fn bracketed(shape: [f64; 4], mut t: f64, width: f64) -> f64 {
    let (mut lo, mut hi) = (0.0, width);
    for _ in 0..80 {
        let [f, slopes @ ..] = cubic(shape, t);
        if f > 0.0 {
            hi = t
        } else {
            lo = t
        }
        let (step, [bent, twisted]) = chebyshev(f, slopes);
        let next = t + step;
        if !(lo <= next && next <= hi) {
            t = 0.5 * (lo + hi);
            continue;
        }
        t = next;
        if step.abs().min(bent.abs() + twisted.abs()) <= LEFT * t {
            break;
        }
    }
    t
}

/// Chebyshev's step from a place where a function is `f` to where it is 0, Newton's and the second order that this
/// leaves; and the two parts of what it leaves itself, of third order.
#[inline(always)]
fn chebyshev<A: Arithmetic>(f: A, [d, dd, ddd]: [A; 3]) -> (A, [A; 2]) {
    let per = A::constant(1.0) / d;
    let newton = f * per;
    let bend = dd * 0.5 * per * newton;
    let square = newton * newton;
    (-(newton * (bend + 1.0)), [newton * (bend * bend * 2.0), newton * (ddd * per * square)])
}

impl SmoothFn for MonotoneCubic {
    fn at(&self, x: f64) -> [f64; 3] {
        let [f, d, dd, _] = self.pieces.evaluate(x);
        [f, d, dd]
    }

    fn over(&self, range: [f64; 2]) -> [[f64; 2]; 3] {
        hulls(self.pieces.parts(range).map(|(_, ranges)| ranges))
    }
}

/// The inverse x(y) of a [`MonotoneCubic`].
#[derive(Debug, Clone, Copy)]
pub struct Inverse<'a>(&'a MonotoneCubic);

impl Inverse<'_> {
    /// x with f(x) = `y`, but for the last bits.
    #[must_use]
    pub fn value(&self, y: f64) -> f64 {
        let (k, t) = self.place(y);
        self.0.pieces.anchors[k] + t
    }

    /// x(y + `dy`) but for the last bits, where `x` is x(y): in less time than [`Self::value`] takes. None where one is not
    /// near, or not in the piece of its `x`.
    #[inline]
    #[must_use]
    pub fn beside<const L: usize>(&self, x: Lanes<L>, dy: Lanes<L>) -> Option<Lanes<L>> {
        let PiecewiseCubic { borders, anchors, terms } = &self.0.pieces;
        // (Neighbours are mostly of one piece.)
        let mut piece = borders.up_to(x.0.first().copied()?);
        let pieces = x.0.map(|x| {
            piece = borders.up_to_near(x, piece);
            piece
        });
        if pieces.iter().any(|k| *k == 0 || *k == borders.knots().len()) {
            return None;
        }
        let anchor = Lanes(pieces.map(|k| anchors[k]));
        let width = Lanes(pieces.map(|k| borders.knots()[k])) - anchor;
        let [b, c, d] = [1, 2, 3].map(|power| Lanes(pieces.map(|k| terms[k][power])));
        let rise = |t: Lanes<L>| t * (b + t * (c + t * d));
        let mut t = x - anchor;
        // (From x, so that the value there need not be known.)
        let sought = rise(t) + dy;
        let mut is_found = [false; L];
        for _ in 0..2 {
            let slopes = [b + t * (c * 2.0 + t * (d * 3.0)), c * 2.0 + t * (d * 6.0), d * 6.0];
            let (step, [bent, twisted]) = chebyshev(rise(t) - sought, slopes);
            for (k, is_found) in is_found.iter_mut().enumerate() {
                // (What is found stays, so that no number depends on those beside it.)
                if !*is_found {
                    t.0[k] += step.0[k];
                    let left = bent.0[k].abs() + twisted.0[k].abs();
                    *is_found = left <= LEFT * t.0[k];
                }
            }
            if !(0..L).all(|k| 0.0 <= t.0[k] && t.0[k] <= width.0[k]) {
                return None;
            }
            if is_found.iter().all(|is_found| *is_found) {
                return Some(anchor + t);
            }
        }
        None
    }

    /// The piece in which f is `y`, and how far from its anchor.
    fn place(&self, y: f64) -> (usize, f64) {
        let Self(MonotoneCubic { pieces, levels, sense, bends }) = self;
        let k = levels.up_to(sense * y);
        let terms = pieces.terms[k];
        let rest = y - terms[0];
        let levels = levels.knots();
        if k == 0 || k == levels.len() {
            return (k, rest / terms[1]);
        }
        // t (b + t (c + t d)) = rest for t = x - anchor.
        let shape = [-rest, terms[1], terms[2], terms[3]];
        let width = pieces.borders.knots()[k] - pieces.anchors[k];
        // It begins where the inverse's own cubic through both ends is.
        let share = sense * rest / (levels[k] - levels[k - 1]);
        let [first, last] = bends[k - 1];
        let off = share * (1.0 - share) * (first * (1.0 - share) - last * share);
        let start = width * (share + off).clamp(0.0, 1.0);
        let t = steps(shape, start, width)
            .unwrap_or_else(|| bracketed(shape.map(|x| sense * x), start, width));
        (k, t)
    }

    /// x(`y`) moved by more than its error, down or up as `side` is -1 or 1.
    pub(super) fn bound(&self, y: f64, side: f64) -> f64 {
        let Self(MonotoneCubic { pieces, sense, .. }) = self;
        let x = self.value(y);
        let mut step = 4.0 * f64::EPSILON * x.abs() + f64::MIN_POSITIVE;
        while step.is_finite() {
            // Past x(y), f is surely past y.
            let end = x + side * step;
            let past = |f: &[Interval; 3]| {
                if side * sense > 0.0 { f[0].lo > y } else { f[0].hi < y }
            };
            if pieces.parts([end, end]).all(|(_, f)| past(&f)) {
                return end;
            }
            step *= 2.0;
        }
        side * f64::INFINITY
    }
}

impl SmoothFn for Inverse<'_> {
    fn at(&self, y: f64) -> [f64; 3] {
        let (k, t) = self.place(y);
        let pieces = &self.0.pieces;
        let x = pieces.anchors[k] + t;
        let [_, d, dd, _] = cubic(pieces.terms[k], t);
        [x, 1.0 / d, -dd / (d * d * d)]
    }

    fn over(&self, [lo, hi]: [f64; 2]) -> [[f64; 2]; 3] {
        let [first, last] = if self.0.sense > 0.0 { [lo, hi] } else { [hi, lo] };
        let xs = Interval::new(self.bound(first, -1.0), self.bound(last, 1.0));
        let parts = self.0.pieces.parts([xs.lo, xs.hi]).map(|(_, [_, d, dd])| {
            let slope = Interval::constant(1.0) / d;
            [xs, slope, -dd * slope * slope.square()]
        });
        hulls(parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::exp;
    use crate::num::piecewise_cubic::tests::{error, holds, knots};
    use crate::num::sample::Draws;

    #[test]
    fn monotone_curves_are_and_their_inverses_undo_them() {
        for mut r in (0..100).map(Draws::new) {
            let knots = knots(10, &mut r);
            let sense = if r.unit() < 0.5 { 1.0 } else { -1.0 };
            let mut values = vec![r.inside([-1.0, 1.0])];
            for k in 0..9 {
                values.push(values[k] + sense * exp(r.inside([-4.0, 0.0])));
            }
            let curve = MonotoneCubic::new(&knots, &values).unwrap();
            let inverse = curve.inverse();
            for (x, y) in knots.iter().zip(&values) {
                assert!((curve.value(*x) - y).abs() < 1e-14);
                assert!((inverse.value(*y) - x).abs() < 1e-14);
            }
            let ends = [-1.4, knots[9] + 0.4];
            for _ in 0..100 {
                let x = r.inside(ends);
                let [y, d, dd] = curve.at(x);
                assert!(sense * d > 0.0, "{x}");
                let found = inverse.at(y);
                // What a rounding of y does to x.
                let blur = f64::EPSILON * (4.0 + 16.0 / d.abs());
                assert!((found[0] - x).abs() < blur, "{x}: {:e}", found[0] - x);
                assert!((found[1] * d - 1.0).abs() < 1e-10 * (1.0 + dd.abs() / d.abs()));
                assert!((found[2] * d * d * d + dd).abs() < 1e-8 * (1.0 + dd.abs() / d.abs()));
            }
            holds(&curve, ends, &mut r);
            let mut levels = ends.map(|x| curve.value(x));
            levels.sort_by(f64::total_cmp);
            holds(&inverse, levels, &mut r);
        }
    }

    #[test]
    fn inverses_are_good_to_the_last_bits() {
        let knots: Vec<f64> = (0..=20).map(|k| f64::from(k) / 10.0).collect();
        let values: Vec<f64> = knots.iter().map(|&x| 2.0 - exp(0.4 * x)).collect();
        let curve = MonotoneCubic::new(&knots, &values).unwrap();
        let mut r = Draws::new(7);
        for _ in 0..2000 {
            let x = r.inside([-0.1, 2.1]);
            let y = curve.value(x);
            assert!((curve.inverse().value(y) - x).abs() < 2e-15);
            // Bounds of a point are as good.
            let [x0, slope, _] = curve.inverse().over([y, y]);
            assert!(x0[0] <= x && x <= x0[1] && x0[1] - x0[0] < 1e-13);
            assert!(slope[1] < 0.0);
        }
    }

    /// None across a knot and beyond the ends.
    #[test]
    fn places_beside_a_known_one_are_those_of_the_inverse() {
        let knots: Vec<f64> = (0..=20).map(|k| f64::from(k) / 10.0 - 1.0).collect();
        let values: Vec<f64> = knots.iter().map(|&x| 2.0 - exp(0.4 * x)).collect();
        let curve = MonotoneCubic::new(&knots, &values).unwrap();
        let mut r = Draws::new(8);
        let mut found = [0; 4];
        for k in 0..4000 {
            let x = r.inside([-1.1, 1.1]);
            let step = [1e-9, 1e-6, 1e-2, 0.3][k % 4] * r.inside([-1.0, 1.0]);
            let Some(Lanes([beside])) = curve.inverse().beside(Lanes([x]), Lanes([step])) else {
                continue;
            };
            found[k % 4] += 1;
            let both = curve.inverse().beside(Lanes([0.54, x]), Lanes([1e-3, step]));
            assert_eq!(both.map(|both| both.0[1]), Some(beside));
            let exact = curve.inverse().value(curve.value(x) + step);
            assert!((beside - exact).abs() < 3e-15, "{x} {step:e}: {:e}", beside - exact);
            assert_eq!((x * 10.0).floor(), (exact * 10.0).floor());
        }
        assert!(found[0] > 850 && found[1] > 850 && found[2] > 700 && found[3] < 300, "{found:?}");
    }

    #[test]
    fn monotone_curves_converge_at_third_order() {
        let [coarse, fine] = [20, 40].map(|n| error(n, MonotoneCubic::new));
        assert!((7.0..30.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }

    #[test]
    fn steps_stay_monotone_with_a_slope_everywhere() {
        let knots = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let curve = MonotoneCubic::new(&knots, &[0.0, 1e-3, 5.0, 5.001, 10.0, 10.1]).unwrap();
        for k in 0..=5000 {
            let x = f64::from(k) / 1000.0;
            assert!(curve.at(x)[1] > 1e-4, "{x}");
            assert!((curve.inverse().value(curve.value(x)) - x).abs() < 1e-10, "{x}");
        }
    }

    #[test]
    fn a_line_stays_one() {
        let curve = MonotoneCubic::new(&[0.0, 1.0, 3.0, 4.0], &[4.0, 2.0, -2.0, -4.0]).unwrap();
        assert_eq!(curve.at(2.5), [-1.0, -2.0, 0.0]);
        assert_eq!(curve.inverse().at(8.0), [-2.0, -0.5, 0.0]);
        let two = MonotoneCubic::new(&[0.0, 1.0], &[4.0, 2.0]).unwrap();
        assert_eq!(two.at(0.5), [3.0, -2.0, 0.0]);
    }

    #[test]
    fn points_out_of_order_are_refused() {
        assert!(MonotoneCubic::new(&[0.0, 1.0, 2.0], &[1.0, 2.0, 2.0]).is_none());
        assert!(MonotoneCubic::new(&[0.0, 1.0, 2.0], &[1.0, 0.0, 3.0]).is_none());
        assert!(MonotoneCubic::new(&[0.0, 1.0, 1.0], &[1.0, 2.0, 3.0]).is_none());
    }
}
