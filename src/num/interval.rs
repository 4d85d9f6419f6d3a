//! Rigorous ranges: whatever the arguments in their intervals, the true result is in the result's.
//!
//! Sums, products, quotients and roots are correctly rounded, so a step outward of each end makes
//! up for it; `libm`'s functions are good to under two units in the last place, and their ends
//! move by more than that. What is not defined somewhere on its argument is the whole line.

use super::plane_inverse;
use super::scalar::{Arithmetic, Base, PlaneFn, Scalar, SmoothFn};
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// All numbers from `lo` to `hi`; an infinite end stands for no bound. Never NaN, and `lo` <= `hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Least.
    pub lo: f64,
    /// Largest.
    pub hi: f64,
}

/// Ends' step for one `libm` call, in units in the last place, and for a few operations.
const CALL: f64 = 2.0;
const CALLS: f64 = 8.0;

/// A little less than the square of pi/2, where `tan_over_root` has its pole.
const POLE: f64 = 2.467_401_100_272_339;

/// Strictly below `x` by `ulps` at least; 0 stays, for functions that are 0 exactly there alone.
#[inline]
fn below(x: f64, ulps: f64) -> f64 {
    if x == 0.0 {
        x
    } else if x.is_infinite() {
        x.next_down()
    } else {
        (x - ulps * f64::EPSILON * x.abs()).next_down()
    }
}

#[inline]
fn above(x: f64, ulps: f64) -> f64 {
    -below(-x, ulps)
}

/// Below `x` by one unit in the last place or two, for a result of one operation that is neither 0
/// nor positive infinity. (Quicker than `next_down`, which most of the time of proofs went to.)
#[inline]
fn down(x: f64) -> f64 {
    x - (x.abs() * f64::EPSILON + f64::MIN_POSITIVE)
}

/// Above `x` likewise, if it is neither 0 nor negative infinity.
#[inline]
fn up(x: f64) -> f64 {
    x + (x.abs() * f64::EPSILON + f64::MIN_POSITIVE)
}

impl Interval {
    /// All numbers: the answer where there is none.
    pub const WHOLE: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    const ZERO: Self = Self { lo: 0.0, hi: 0.0 };

    /// `lo` to `hi`; the whole line if they are out of order or not numbers.
    #[inline]
    #[must_use]
    pub fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi { Self { lo, hi } } else { Self::WHOLE }
    }

    /// `x` alone.
    #[inline]
    #[must_use]
    pub fn point(x: f64) -> Self {
        Self::new(x, x)
    }

    /// `x` give or take `slack` (and a rounding).
    #[must_use]
    pub fn around(x: f64, slack: f64) -> Self {
        Self::new((x - slack).next_down(), (x + slack).next_up())
    }

    /// `lo` to `hi` with ends moved outward by `ulps`.
    fn outward(lo: f64, hi: f64, ulps: f64) -> Self {
        Self::new(below(lo, ulps), above(hi, ulps))
    }

    /// Is `x` inside?
    #[inline]
    #[must_use]
    pub fn contains(self, x: f64) -> bool {
        self.lo <= x && x <= self.hi
    }

    /// Largest |x|.
    #[must_use]
    pub fn magnitude(self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// Least |x|.
    #[must_use]
    pub fn mignitude(self) -> f64 {
        self.lo.max(-self.hi).max(0.0)
    }

    /// Length, rounded up.
    #[must_use]
    pub fn width(self) -> f64 {
        if self.lo == self.hi { 0.0 } else { (self.hi - self.lo).next_up() }
    }

    /// The least interval that holds both.
    #[inline]
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Is it bounded?
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// From the results at the ends, `first` and `second` in their order; no bound where either
    /// is missing or overflowed.
    fn spanned(first: f64, second: f64, ulps: f64) -> Self {
        if first.is_finite() && second.is_finite() {
            Self::outward(first, second, ulps)
        } else {
            Self::WHOLE
        }
    }

    /// From the four products (or quotients) of the ends of `a` and `b`.
    #[inline(always)]
    fn from_products(p: [f64; 4], a: Self, b: Self) -> Self {
        let less = |a: f64, b: f64| if a < b { a } else { b };
        let more = |a: f64, b: f64| if a > b { a } else { b };
        let lo = less(less(p[0], p[1]), less(p[2], p[3]));
        let hi = more(more(p[0], p[1]), more(p[2], p[3]));
        // The sum is finite only if all are.
        if (lo != 0.0) & (hi != 0.0) & ((p[0] + p[1] + (p[2] + p[3])).abs() < f64::INFINITY) {
            Self { lo: down(lo), hi: up(hi) }
        } else if p == [0.0; 4] && (a == Self::ZERO || b == Self::ZERO) {
            // Zeros stay zeros: derivatives are full of them.
            Self::ZERO
        } else {
            Self::from_special_products(p, [lo, hi], a, b)
        }
    }

    /// The same where an end is zero or there is none. A zero end holds, whatever underflowed, if
    /// the factors' signs say so.
    #[cold]
    #[inline(never)]
    fn from_special_products(p: [f64; 4], [lo, hi]: [f64; 2], a: Self, b: Self) -> Self {
        if p.iter().any(|p| p.is_nan()) {
            return Self::WHOLE;
        }
        let (not_negative, not_positive) = a.signs(b);
        Self {
            lo: if lo == 0.0 && not_negative { 0.0 } else { lo.next_down() },
            hi: if hi == 0.0 && not_positive { 0.0 } else { hi.next_up() },
        }
    }

    /// Whether no product (or quotient) with another is negative, and whether none is positive.
    fn signs(self, other: Self) -> (bool, bool) {
        let (a, b) = (self, other);
        (
            (a.lo >= 0.0 && b.lo >= 0.0) || (a.hi <= 0.0 && b.hi <= 0.0),
            (a.lo >= 0.0 && b.hi <= 0.0) || (a.hi <= 0.0 && b.lo >= 0.0),
        )
    }

    /// Could offset + k * period be inside, for a whole k? Says yes when rounding hides it.
    fn meets(self, offset: f64, period: f64) -> bool {
        let [lo, hi] = [self.lo, self.hi].map(|x| (x - offset) / period);
        let slack = 4.0 * f64::EPSILON * (1.0 + lo.abs().max(hi.abs()));
        // Infinite ends make NaNs here, and those must mean yes.
        !((lo - slack).ceil() > hi + slack)
    }

    /// Sine or cosine, from its values at the ends and the place of a maximum.
    fn wave(self, first: f64, second: f64, top: f64) -> Self {
        let ends = Self::outward(first.min(second), first.max(second), CALL);
        Self {
            lo: if self.meets(top + PI, 2.0 * PI) { -1.0 } else { ends.lo.max(-1.0) },
            hi: if self.meets(top, 2.0 * PI) { 1.0 } else { ends.hi.min(1.0) },
        }
    }
}

impl Neg for Interval {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Add for Interval {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        // A sum that comes out 0 is exact.
        let (lo, hi) = (self.lo + other.lo, self.hi + other.hi);
        Self::new(if lo == 0.0 { lo } else { down(lo) }, if hi == 0.0 { hi } else { up(hi) })
    }
}

impl Sub for Interval {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (self, other);
        let products = [a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi];
        Self::from_products(products, a, b)
    }
}

impl Div for Interval {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let (a, b) = (self, other);
        if b.contains(0.0) {
            return Self::WHOLE;
        }
        if a == Self::ZERO {
            return Self::ZERO;
        }
        let quotients = [a.lo / b.lo, a.lo / b.hi, a.hi / b.lo, a.hi / b.hi];
        Self::from_products(quotients, a, b)
    }
}

macro_rules! with_plain {
    ($($of:ident $name:ident),*) => {
        $(impl $of<f64> for Interval {
            type Output = Self;
            #[inline]
            fn $name(self, other: f64) -> Self {
                self.$name(Self::point(other))
            }
        })*
    };
}
with_plain!(Add add, Sub sub, Div div);

impl Mul<f64> for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        let (p, q) = (self.lo * factor, self.hi * factor);
        let (lo, hi) = if p < q { (p, q) } else { (q, p) };
        let is_plain = lo.is_finite() && hi.is_finite() && lo != 0.0 && hi != 0.0;
        if is_plain { Self { lo: down(lo), hi: up(hi) } } else { self * Self::point(factor) }
    }
}

/// Most boxes that are tried: each is the one before, enlarged by what its own derivatives ask for.
const MOST_BOXES: usize = 6;
/// Enlargement of a box over what the derivatives of the last one ask for.
const ROOM: f64 = 1.25;

impl Arithmetic for Interval {
    fn constant(x: f64) -> Self {
        Self::point(x)
    }
}

impl Scalar for Interval {
    fn mid(self) -> f64 {
        let (lo, hi) = (self.lo.max(f64::MIN), self.hi.min(f64::MAX));
        (0.5 * lo + 0.5 * hi).clamp(lo.min(hi), hi.max(lo)).clamp(f64::MIN, f64::MAX)
    }
    #[inline]
    fn square(self) -> Self {
        let (least, most) = (self.mignitude(), self.magnitude());
        if most == 0.0 {
            return Self::ZERO;
        }
        Self { lo: below(least * least, 0.0).max(0.0), hi: (most * most).next_up() }
    }
    fn sqrt(self) -> Self {
        // (An end below 0 is NaN, which is the whole line.)
        Self::outward(f64::sqrt(self.lo), f64::sqrt(self.hi), 0.0)
    }
    fn exp(self) -> Self {
        let found = Self::outward(Scalar::exp(self.lo), Scalar::exp(self.hi), CALL);
        Self { lo: found.lo.clamp(0.0, f64::MAX), hi: found.hi.max(f64::MIN_POSITIVE) }
    }
    fn log(self) -> Self {
        if self.lo > 0.0 {
            Self::outward(Scalar::log(self.lo), Scalar::log(self.hi), CALL)
        } else {
            Self::WHOLE
        }
    }
    fn sin(self) -> Self {
        self.wave(Scalar::sin(self.lo), Scalar::sin(self.hi), FRAC_PI_2)
    }
    fn cos(self) -> Self {
        self.wave(Scalar::cos(self.lo), Scalar::cos(self.hi), 0.0)
    }
    fn tan(self) -> Self {
        if self.meets(FRAC_PI_2, PI) {
            Self::WHOLE
        } else {
            Self::outward(Scalar::tan(self.lo), Scalar::tan(self.hi), CALL)
        }
    }
    fn atan(self) -> Self {
        Self::outward(Scalar::atan(self.lo), Scalar::atan(self.hi), CALL)
    }
    fn atan2(self, x: Self) -> Self {
        if x.lo <= 0.0 && self.contains(0.0) {
            return Self::WHOLE;
        }
        if self == Self::ZERO {
            return Self::ZERO;
        }
        // Along each side the angle is monotone.
        let corner = |y: f64, x: f64| {
            let angle = Scalar::atan2(y, x);
            Self { lo: below(angle, CALLS).next_down(), hi: above(angle, CALLS).next_up() }
        };
        let side = |y: f64| corner(y, x.lo).hull(corner(y, x.hi));
        side(self.lo).hull(side(self.hi))
    }
    fn one_minus_exp_over_x(self) -> Self {
        Self::spanned(self.hi.one_minus_exp_over_x(), self.lo.one_minus_exp_over_x(), CALLS)
    }
    fn ln_1p_over_x(self) -> Self {
        Self::spanned(self.hi.ln_1p_over_x(), self.lo.ln_1p_over_x(), CALLS)
    }
    fn tan_over_root(self) -> Self {
        if !(self.hi < POLE) {
            return Self::WHOLE;
        }
        // Near the pole the root's rounding grows, and must be followed.
        let end = |x: f64| {
            if x < 0.5 {
                Self::spanned(x.tan_over_root(), x.tan_over_root(), CALLS)
            } else {
                let root = Self::point(x).sqrt();
                root.tan() / root
            }
        };
        let (first, last) = (end(self.lo), end(self.hi));
        if first.is_finite() && last.is_finite() { first.hull(last) } else { Self::WHOLE }
    }
    fn atan_over_root(self) -> Self {
        Self::spanned(self.hi.atan_over_root(), self.lo.atan_over_root(), CALLS)
    }
    fn map(self, curve: &impl SmoothFn) -> Self {
        self.curve(curve)[0]
    }
    fn of_plane(x: Self, y: Self, f: &impl PlaneFn) -> Self {
        Self::plane(x, y, f)[0]
    }
    /// The interval Newton method; the whole plane where that does not prove it.
    fn invert_plane(
        map: &[impl PlaneFn; 2],
        scale: f64,
        value: [Self; 2],
        near: [f64; 2],
    ) -> [Self; 2] {
        let whole = [Self::WHOLE; 2];
        let middle = plane_inverse::at(map, scale, value.map(Scalar::mid), near);
        if !middle.into_iter().all(f64::is_finite) {
            return whole;
        }
        let on = middle.map(Self::point);
        let off = [0, 1].map(|k: usize| Self::of_plane(on[0], on[1], &map[k]) - value[k]);
        // What is to be taken from the middle, by some Jacobians.
        let steps = |jacobian: [[Self; 2]; 2]| {
            plane_inverse::inverse(jacobian).map(|[a, b]| (a * off[0] + b * off[1]).magnitude())
        };
        let here = [0, 1].map(|k: usize| map[k].first(middle));
        let mut reach = steps(here.map(|[_, x, y]| [Self::point(x), Self::point(y)]));
        for _ in 0..MOST_BOXES {
            let tried = [0, 1].map(|k: usize| {
                let room = plane_inverse::ROUNDING * (middle[k].abs() + scale);
                Self::around(middle[k], ROOM * reach[k] + room)
            });
            let over = [0, 1].map(|k: usize| Self::plane(tried[0], tried[1], &map[k]));
            let asked = steps(over.map(|[_, x, y, ..]| [x, y]));
            if !asked.into_iter().all(f64::is_finite) {
                return whole;
            }
            let found = [0, 1].map(|k: usize| Self::around(middle[k], asked[k]));
            let is_inside = |k: usize| tried[k].lo < found[k].lo && found[k].hi < tried[k].hi;
            if is_inside(0) && is_inside(1) {
                return found;
            }
            reach = asked;
        }
        whole
    }
}

impl Base for Interval {
    fn curve(self, curve: &impl SmoothFn) -> [Self; 3] {
        curve.over([self.lo, self.hi]).map(|[lo, hi]| Self::new(lo.next_down(), hi.next_up()))
    }
    fn plane(x: Self, y: Self, f: &impl PlaneFn) -> [Self; 6] {
        f.over([x, y].map(|range| [range.lo, range.hi])).map(|[lo, hi]| Self::new(lo, hi))
    }
}

#[cfg(test)]
mod tests;
