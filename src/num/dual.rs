//! A number with its exact first derivatives with respect to `N` variables (forward
//! differentiation).

use super::elementary as m;
use super::{Arithmetic, PlaneFn, Scalar, SmoothFn, plane_inverse};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// Derivatives with respect to the variables.
    pub slope: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// Variable number `index` at `value`.
    #[inline]
    #[must_use]
    pub fn variable(value: f64, index: usize) -> Self {
        let mut slope = [0.0; N];
        slope[index] = 1.0;
        Self { value, slope }
    }

    /// g(self), from g and g' at the value.
    #[inline]
    fn chain(self, value: f64, derivative: f64) -> Self {
        Self { value, slope: self.slope.map(|d| derivative * d) }
    }

    /// The number with derivatives a * self' + b * other'.
    #[inline]
    fn mix(self, other: Self, value: f64, a: f64, b: f64) -> Self {
        Self { value, slope: std::array::from_fn(|k| a * self.slope[k] + b * other.slope[k]) }
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        self.mix(other, self.value + other.value, 1.0, 1.0)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self.mix(other, self.value - other.value, 1.0, -1.0)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        self.mix(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let (value, per) = (self.value / other.value, 1.0 / other.value);
        self.mix(other, value, per, -value * per)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, ..self }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

impl<const N: usize> Div<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn div(self, other: f64) -> Self {
        self.chain(self.value / other, 1.0 / other)
    }
}

/// Horner's rule for sum of c_k x^k.
#[inline]
fn polynomial(c: &[f64], x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// Derivative of (1 - exp(-x)) / x, whose value is `g`.
fn fade_slope(x: f64, g: f64) -> f64 {
    if x.abs() > 0.5 {
        return (m::exp(-x) - g) / x;
    }
    // Sum of (-1)^k k x^(k-1) / (k+1)!.
    let (mut power, mut sum) = (0.5, 0.0);
    for k in 1..16 {
        sum -= f64::from(k) * power;
        power *= -x / f64::from(k + 2);
    }
    sum
}

/// Derivative of log(1 + x) / x, whose value is `g`.
fn log_over_slope(x: f64, g: f64) -> f64 {
    if x.abs() > 0.1 {
        return (1.0 / (1.0 + x) - g) / x;
    }
    // Sum of (-1)^k k x^(k-1) / (k+1).
    let mut sum = 0.0;
    for k in (1..18).rev() {
        sum = f64::from(k) / f64::from(k + 1) - x * sum;
    }
    -sum
}

/// Derivative of tan(sqrt x) / sqrt x, whose value is `g`.
fn tan_over_root_slope(x: f64, g: f64) -> f64 {
    if x.abs() > 0.05 {
        return (1.0 + x * g * g - g) / (2.0 * x);
    }
    // The Maclaurin series of the tangent, term by term.
    const C: [f64; 9] = [
        1.0 / 3.0,
        2.0 * 2.0 / 15.0,
        3.0 * 17.0 / 315.0,
        4.0 * 62.0 / 2835.0,
        5.0 * 1382.0 / 155_925.0,
        6.0 * 21844.0 / 6_081_075.0,
        7.0 * 929_569.0 / 638_512_875.0,
        8.0 * 6_404_582.0 / 10_854_718_875.0,
        9.0 * 443_861_162.0 / 1_856_156_927_625.0,
    ];
    polynomial(&C, x)
}

/// Derivative of atan(sqrt x) / sqrt x, whose value is `g`.
fn atan_over_root_slope(x: f64, g: f64) -> f64 {
    if x.abs() > 0.1 {
        return (1.0 / (1.0 + x) - g) / (2.0 * x);
    }
    // Sum of (-1)^k k x^(k-1) / (2k+1).
    let mut sum = 0.0;
    for k in (1..18).rev() {
        sum = f64::from(k) / f64::from(2 * k + 1) - x * sum;
    }
    -sum
}

impl<const N: usize> Arithmetic for Dual<N> {
    #[inline]
    fn constant(x: f64) -> Self {
        Self { value: x, slope: [0.0; N] }
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline]
    fn mid(self) -> f64 {
        self.value
    }
    #[inline]
    fn square(self) -> Self {
        self.chain(self.value * self.value, 2.0 * self.value)
    }
    #[inline]
    fn sqrt(self) -> Self {
        let root = f64::sqrt(self.value);
        self.chain(root, 0.5 / root)
    }
    #[inline]
    fn exp(self) -> Self {
        let value = m::exp(self.value);
        self.chain(value, value)
    }
    #[inline]
    fn log(self) -> Self {
        self.chain(m::log(self.value), 1.0 / self.value)
    }
    #[inline]
    fn sin(self) -> Self {
        self.chain(m::sin(self.value), m::cos(self.value))
    }
    #[inline]
    fn cos(self) -> Self {
        self.chain(m::cos(self.value), -m::sin(self.value))
    }
    #[inline]
    fn tan(self) -> Self {
        let value = m::tan(self.value);
        self.chain(value, 1.0 + value * value)
    }
    #[inline]
    fn atan(self) -> Self {
        self.chain(m::atan(self.value), 1.0 / (1.0 + self.value * self.value))
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let square = self.value * self.value + x.value * x.value;
        self.mix(x, m::atan2(self.value, x.value), x.value / square, -self.value / square)
    }
    #[inline]
    fn one_minus_exp_over_x(self) -> Self {
        let value = self.value.one_minus_exp_over_x();
        self.chain(value, fade_slope(self.value, value))
    }
    #[inline]
    fn ln_1p_over_x(self) -> Self {
        let value = self.value.ln_1p_over_x();
        self.chain(value, log_over_slope(self.value, value))
    }
    #[inline]
    fn tan_over_root(self) -> Self {
        let value = self.value.tan_over_root();
        self.chain(value, tan_over_root_slope(self.value, value))
    }
    #[inline]
    fn atan_over_root(self) -> Self {
        let value = self.value.atan_over_root();
        self.chain(value, atan_over_root_slope(self.value, value))
    }
    #[inline]
    fn map(self, curve: &impl SmoothFn) -> Self {
        let [value, slope, _] = curve.at(self.value);
        self.chain(value, slope)
    }
    #[inline]
    fn of_plane(x: Self, y: Self, f: &impl PlaneFn) -> Self {
        let [value, along_x, along_y] = f.first([x.value, y.value]);
        x.mix(y, value, along_x, along_y)
    }
    fn invert_plane(
        map: &[impl PlaneFn; 2],
        scale: f64,
        value: [Self; 2],
        near: [f64; 2],
    ) -> [Self; 2] {
        let at = plane_inverse::at(map, scale, value.map(|v| v.value), near);
        let [[_, p, q], [_, r, s]] = [0, 1].map(|k: usize| map[k].first(at));
        let inverse = plane_inverse::inverse([[p, q], [r, s]]);
        let [a, b] = value;
        [0, 1].map(|k: usize| a.mix(b, at[k], inverse[k][0], inverse[k][1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: Dual<2>, value: f64, slope: [f64; 2], what: &str) {
        let close = |a: f64, b: f64| (a - b).abs() <= 2e-14 * (1.0 + b.abs());
        assert!(close(found.value, value), "{what}: value {} for {value}", found.value);
        for (a, b) in found.slope.iter().zip(slope) {
            assert!(close(*a, b), "{what}: slope {a} for {b}");
        }
    }

    #[test]
    fn arithmetic_follows_the_rules() {
        let (x, y) = (Dual::<2>::variable(1.5, 0), Dual::<2>::variable(-0.4, 1));
        near(x * y + x, 0.9, [0.6, 1.5], "xy + x");
        near(x / y - y, -3.35, [-2.5, -1.5 / 0.16 - 1.0], "x/y - y");
        near(-(x * 3.0 - 1.0) / 2.0 + 5.0, 3.25, [-1.5, 0.0], "affine");
        near(x.square() * y.square(), 0.36, [0.48, -1.8], "x^2 y^2");
        near(Dual::constant(7.0), 7.0, [0.0; 2], "constant");
    }

    #[test]
    fn elementary_functions_have_their_derivatives() {
        for v in [0.3, 0.77, 1.2] {
            // x + 2 y at y = 0: every slope comes doubled in the second variable.
            let x = Dual::<2> { value: v, slope: [1.0, 2.0] };
            let both = |d: f64| [d, 2.0 * d];
            near(x.sqrt(), v.sqrt(), both(0.5 / v.sqrt()), "sqrt");
            near(x.exp(), m::exp(v), both(m::exp(v)), "exp");
            near(x.log(), m::log(v), both(1.0 / v), "log");
            near(x.sin(), m::sin(v), both(m::cos(v)), "sin");
            near(x.cos(), m::cos(v), both(-m::sin(v)), "cos");
            near(x.tan(), m::tan(v), both(1.0 / (m::cos(v) * m::cos(v))), "tan");
            near(x.atan(), m::atan(v), both(1.0 / (1.0 + v * v)), "atan");
            let (y, x) = (Dual::<2>::variable(v, 0), Dual::<2>::variable(-0.5, 1));
            let square = v * v + 0.25;
            near(y.atan2(x), m::atan2(v, -0.5), [-0.5 / square, -v / square], "atan2");
        }
    }

    #[test]
    fn removable_quotients_are_exact_through_zero_and_past_the_switch() {
        // Against the quotient's own rule away from zero, and known values at zero.
        let at = |v: f64| Dual::<2> { value: v, slope: [1.0, 0.0] };
        near(at(0.0).one_minus_exp_over_x(), 1.0, [-0.5, 0.0], "fade");
        near(at(0.0).ln_1p_over_x(), 1.0, [-0.5, 0.0], "log_over");
        near(at(0.0).tan_over_root(), 1.0, [1.0 / 3.0, 0.0], "tan_over_root");
        near(at(0.0).atan_over_root(), 1.0, [-1.0 / 3.0, 0.0], "atan_over_root");
        for v in [0.04, 0.051, 0.09, 0.11, 0.45, 0.55, 1.9] {
            let x = at(v);
            let quotient = (-(-x).exp() + 1.0) / x;
            let root = x.sqrt();
            for (found, rule, what) in [
                (x.one_minus_exp_over_x(), quotient, "fade"),
                (x.ln_1p_over_x(), (x + 1.0).log() / x, "log_over"),
                (x.tan_over_root(), root.tan() / root, "tan_over_root"),
                (x.atan_over_root(), root.atan() / root, "atan_over_root"),
            ] {
                let gap = (found.slope[0] - rule.slope[0]).abs();
                // The rule cancels: its error is an ulp over x^2.
                assert!(gap < 1e-15 / (v * v) + 1e-14, "{what} at {v}: {gap:e}");
            }
        }
    }

    struct Cubic;
    impl SmoothFn for Cubic {
        fn at(&self, x: f64) -> [f64; 3] {
            [x * x * x, 3.0 * x * x, 6.0 * x]
        }
        fn over(&self, range: [f64; 2]) -> [[f64; 2]; 3] {
            [range; 3]
        }
    }

    #[test]
    fn goes_through_a_curve_by_the_chain_rule() {
        let x = Dual::<2> { value: 2.0, slope: [0.5, -1.0] };
        near(x.map(&Cubic), 8.0, [6.0, -12.0], "through");
    }
}
