//! Rising curves over a radius, in the form that is smooth at the centre.

use super::interval::Interval;
use super::monotone::MonotoneCubic;
use super::piecewise_cubic::hulls;
use super::scalar::{Arithmetic, Scalar, SmoothFn};

/// A strictly rising, once differentiable f(x) through points with x >= 0: a [`MonotoneCubic`], whose second
/// derivative jumps at knots. Where the first point is (0, 0) the curve is that through the points and their
/// opposites, which is odd: up to the second point it is a x + b x^3.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialCubic {
    curve: MonotoneCubic,
    centre: Option<CentrePiece>,
}

/// f(x) = a x + b x^3 about x = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CentrePiece {
    a: f64,
    b: f64,
    /// Where it ends.
    knot: f64,
    /// f there.
    level: f64,
}

impl RadialCubic {
    /// The curve through `values` at `radii`, both strictly rising and not negative; None if they are not that, or
    /// fewer than two, or not finite, or if the value at radius 0 is not 0.
    #[must_use]
    pub fn new(radii: &[f64], values: &[f64]) -> Option<Self> {
        let (&first, &level) = (radii.first()?, values.first()?);
        if !(first >= 0.0 && level >= 0.0 && level < *values.last()?) {
            return None;
        }
        if first > 0.0 {
            return Some(Self { curve: MonotoneCubic::new(radii, values)?, centre: None });
        }
        if level > 0.0 {
            return None;
        }
        let with_opposites = |points: &[f64]| -> Vec<f64> {
            let beyond = &points[1..];
            beyond.iter().rev().map(|x| -x).chain(beyond.iter().copied()).collect()
        };
        let curve = MonotoneCubic::new(&with_opposites(radii), &with_opposites(values))?;
        let (knot, level) = (radii[1], values[1]);
        // The odd cubic with this value and slope at its end. A slope of a monotone cubic is at most 2.5 times the
        // chord, so a is positive.
        let [_, slope, ..] = curve.pieces.evaluate(knot);
        let chord = level / knot;
        let (a, b) = (1.5 * chord - 0.5 * slope, 0.5 * (slope - chord) / (knot * knot));
        Some(Self { curve, centre: Some(CentrePiece { a, b, knot, level }) })
    }

    /// f(x) / x against x^2.
    #[must_use]
    pub fn quotient(&self) -> Quotient<'_> {
        Quotient(self)
    }

    /// x / f(x) against f(x)^2.
    #[must_use]
    pub fn inverse_quotient(&self) -> InverseQuotient<'_> {
        InverseQuotient(self)
    }
}

impl CentrePiece {
    /// (f / x, and its derivatives by x^2) at x^2 = `v`.
    fn quotient<S: Arithmetic>(&self, v: S) -> [S; 3] {
        [v * self.b + self.a, S::constant(self.b), S::constant(0.0)]
    }

    /// (x / f, and its derivatives by f^2) at x^2 = `v`: with q = x / f and D = df/dx, dq/d(f^2) = -b q^3 / D and
    /// dD/d(f^2) = 3 b q / D.
    fn inverse_quotient<S: Scalar>(&self, v: S) -> [S; 3] {
        let q = S::constant(1.0) / (v * self.b + self.a);
        let per_slope = S::constant(1.0) / (v * (3.0 * self.b) + self.a);
        let cube = q * q.square();
        let second = (q + per_slope) * (cube * q * per_slope.square());
        [q, cube * per_slope * -self.b, second * (3.0 * self.b * self.b)]
    }
}

/// (g, g', g'') with g(x^2) = f(x) / x, from (f, f', f'') at `x`.
fn quotient<S: Arithmetic>([f, d, dd]: [S; 3], x: S) -> [S; 3] {
    let g = f / x;
    let excess = (d - g) / x;
    [g, excess / x * 0.5, (dd - excess * 3.0) / (x * x * x) * 0.25]
}

/// The ends of a range of squares, and their roots moved outward; squares that rounding left below 0 are 0.
fn rooted(squares: [f64; 2]) -> (Interval, Interval) {
    let squares = Interval::new(squares[0].max(0.0), squares[1].max(0.0));
    (squares, squares.sqrt())
}

/// f(x) / x against x^2, see [`RadialCubic::quotient`].
#[derive(Debug, Clone, Copy)]
pub struct Quotient<'a>(&'a RadialCubic);

impl SmoothFn for Quotient<'_> {
    fn at(&self, v: f64) -> [f64; 3] {
        let Self(RadialCubic { curve, centre }) = self;
        let x = v.sqrt();
        match centre {
            Some(piece) if x < piece.knot => piece.quotient(v),
            _ => quotient(curve.at(x), x),
        }
    }

    fn over(&self, squares: [f64; 2]) -> [[f64; 2]; 3] {
        let Self(RadialCubic { curve, centre }) = self;
        let (v, x) = rooted(squares);
        let inner = centre.filter(|piece| x.lo < piece.knot);
        let inner = inner.map(|piece| {
            let end = Interval::point(piece.knot).square().hi;
            piece.quotient(Interval::new(v.lo, v.hi.min(end)))
        });
        let from = centre.map_or(x.lo, |piece| x.lo.max(piece.knot));
        let outer = (from <= x.hi).then(|| curve.pieces.parts([from, x.hi]));
        let outer = outer.into_iter().flatten().map(|(x, ranges)| quotient(ranges, x));
        hulls(inner.into_iter().chain(outer))
    }
}

/// x / f(x) against f(x)^2, see [`RadialCubic::inverse_quotient`].
#[derive(Debug, Clone, Copy)]
pub struct InverseQuotient<'a>(&'a RadialCubic);

impl InverseQuotient<'_> {
    /// Range of x where f is between `lo` and `hi`.
    fn reach(&self, [lo, hi]: [f64; 2]) -> [f64; 2] {
        let inverse = self.0.curve.inverse();
        [if lo > 0.0 { inverse.bound(lo, -1.0) } else { 0.0 }, inverse.bound(hi, 1.0)]
    }
}

impl SmoothFn for InverseQuotient<'_> {
    fn at(&self, w: f64) -> [f64; 3] {
        let Self(RadialCubic { curve, centre }) = self;
        let level = w.sqrt();
        match centre {
            Some(piece) if level < piece.level => {
                let x = curve.inverse().value(level);
                piece.inverse_quotient(x * x)
            }
            _ => quotient(curve.inverse().at(level), level),
        }
    }

    fn over(&self, squares: [f64; 2]) -> [[f64; 2]; 3] {
        let Self(RadialCubic { curve, centre }) = self;
        let (_, levels) = rooted(squares);
        let inner = centre.filter(|piece| levels.lo < piece.level).map(|piece| {
            let [from, to] = self.reach([levels.lo, levels.hi.min(piece.level)]);
            piece.inverse_quotient(Interval::new(from, to).square())
        });
        let from = centre.map_or(levels.lo, |piece| levels.lo.max(piece.level));
        let outer = (from <= levels.hi).then(|| {
            let reach = self.reach([from, levels.hi]);
            curve.pieces.parts(reach).map(move |(x, [f, d, dd])| {
                let slope = Interval::constant(1.0) / d;
                // What of the levels this piece has.
                let level = Interval::new(f.lo.max(from), f.hi.min(levels.hi));
                quotient([x, slope, -dd * slope * slope.square()], level)
            })
        });
        hulls(inner.into_iter().chain(outer.into_iter().flatten()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::piecewise_cubic::tests::holds;
    use crate::num::sample::Draws;
    use crate::num::{exp, sin, tan};

    const RADII: [f64; 6] = [0.0, 3.0, 11.0, 12.0, 21.0, 30.0];
    const VALUES: [f64; 6] = [0.0, 0.6, 0.9, 1.35, 1.5, 1.7];

    fn curves() -> [RadialCubic; 3] {
        let shifted = RADII.map(|x| x + 6.0);
        [
            RadialCubic::new(&RADII, &VALUES).unwrap(),
            RadialCubic::new(&[0.0, 30.0], &[0.0, 1.7]).unwrap(),
            RadialCubic::new(&shifted, &VALUES.map(|y| y + 0.2)).unwrap(),
        ]
    }

    #[test]
    fn points_are_met_and_the_way_back_is_found() {
        let curve = &curves()[0];
        for (x, y) in RADII.into_iter().zip(VALUES).skip(1) {
            assert!((curve.quotient().at(x * x)[0] * x / y - 1.0).abs() < 1e-14, "{x}");
        }
        for curve in curves() {
            for k in 1..=720 {
                let x = f64::from(k) / 20.0;
                let f = x * curve.quotient().at(x * x)[0];
                let back = f * curve.inverse_quotient().at(f * f)[0];
                assert!(!(f > 0.0) || (back / x - 1.0).abs() < 1e-13, "{x}: {back}");
            }
        }
    }

    #[test]
    fn the_centre_piece_is_odd_and_meets_the_next_with_its_slope() {
        let curve = &curves()[0];
        let CentrePiece { a, b, knot, level } = curve.centre.unwrap();
        assert!(a > 0.0 && (a * knot + b * knot * knot * knot - level).abs() < 1e-15);
        let [value, slope, ..] = curve.curve.pieces.evaluate(knot);
        assert!((value - level).abs() < 1e-15);
        assert!((a + 3.0 * b * knot * knot - slope).abs() < 1e-15);
        // Without the opposites' help: at the centre f / x is a, flat in x.
        assert_eq!(curve.quotient().at(0.0), [a, b, 0.0]);
        assert!((curve.inverse_quotient().at(0.0)[0] * a - 1.0).abs() < 1e-15);
        // Two points alone are a line through the centre.
        let [g, slope, _] = curves()[1].quotient().at(4.0);
        assert!((g * 30.0 / 1.7 - 1.0).abs() < 1e-15 && slope.abs() < 1e-18);
    }

    #[test]
    fn derivatives_are_those_of_the_quotients() {
        let check = |f: &dyn SmoothFn, v: f64| {
            let h = 1e-4 * v;
            let [below, at, above] = [v - h, v, v + h].map(|v| f.at(v));
            for k in 0..2 {
                let slope = (above[k] - below[k]) / (2.0 * h);
                let size = at[k + 1].abs() + 1e-4 * at[0].abs() / [v, v * v][k];
                assert!((slope - at[k + 1]).abs() < 1e-3 * size, "{v} {k}: {slope} {at:?}");
            }
        };
        for curve in curves() {
            for v in [1.0, 4.0, 60.0, 130.0, 300.0, 700.0] {
                let f = curve.quotient().at(v)[0];
                check(&curve.quotient(), v);
                check(&curve.inverse_quotient(), v * f * f);
            }
        }
    }

    #[test]
    fn ranges_hold_values_and_derivatives_both_ways() {
        let mut r = Draws::new(3);
        for curve in curves() {
            let ends = if curve.centre.is_some() { [0.0, 1100.0] } else { [36.0, 1500.0] };
            holds(&curve.quotient(), ends, &mut r);
            let levels = ends.map(|v| v * Scalar::square(curve.quotient().at(v)[0]));
            holds(&curve.inverse_quotient(), levels, &mut r);
        }
        // About the centre, and of a single point.
        let curve = &curves()[0];
        let over = curve.inverse_quotient().over([-1e-18, 1e-3]);
        let at = curve.inverse_quotient().at(1e-4);
        assert!((0..3).all(|k| over[k][0] <= at[k] && at[k] <= over[k][1]), "{over:?} {at:?}");
        // Of a point, hardly more than rounding; at a knot both second derivatives.
        let point = curve.quotient().over([144.0, 144.0]);
        assert!(point[0][1] - point[0][0] < 1e-14, "{point:?}");
        let sides = [143.999, 144.001].map(|v| curve.quotient().at(v)[2]);
        let jump = (sides[1] - sides[0]).abs();
        assert!((point[2][1] - point[2][0]) / jump > 0.99, "{point:?} {sides:?}");
    }

    /// Largest error of the curve through `n` + 1 even points of `f` over the radii 0 to 1 or 1 to 2.
    fn error(first: f64, n: u32, f: fn(f64) -> f64) -> f64 {
        let even = |n: u32| (0..=n).map(move |k| first + f64::from(k) / f64::from(n));
        let radii: Vec<f64> = even(n).collect();
        let values: Vec<f64> = radii.iter().map(|&x| f(x)).collect();
        let curve = RadialCubic::new(&radii, &values).unwrap();
        even(997).map(|x| (x * curve.quotient().at(x * x)[0] - f(x)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn odd_functions_are_met_to_third_order() {
        for f in [|x| sin(1.4 * x), |x| tan(0.9 * x)] {
            let [coarse, fine] = [24, 48].map(|n| error(0.0, n, f));
            assert!((6.5..12.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
        }
        let [coarse, fine] = [24, 48].map(|n| error(1.0, n, |x| 2.0 - exp(-x)));
        assert!((6.5..12.0).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    }

    #[test]
    fn points_without_a_rising_curve_are_refused() {
        let refused = |radii: &[f64], values: &[f64]| RadialCubic::new(radii, values).is_none();
        assert!(refused(&[0.0, 1.0], &[0.1, 1.0]));
        assert!(refused(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0]));
        assert!(refused(&[1.0, 2.0], &[2.0, 1.0]));
        assert!(refused(&[-1.0, 2.0], &[0.0, 1.0]));
        assert!(refused(&[1.0, 2.0], &[-1.0, 1.0]));
        assert!(refused(&[0.0], &[0.0]) && refused(&[], &[]));
        assert!(refused(&[0.0, 1.0], &[0.0, f64::NAN]));
    }
}
