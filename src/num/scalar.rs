//! One formula, many kinds of number: plain, with exact derivatives, or with rigorous bounds.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Arithmetic alone: what formulas without a choice between forms ask of a [`Scalar`], or of several
/// numbers side by side ([`Lanes`](super::Lanes)).
pub trait Arithmetic:
    Copy
    + Debug
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A number that depends on nothing.
    fn constant(x: f64) -> Self;
}

/// What the optics' formulas ask of a number. `f64` gives values, `Jet2` over `f64` values with
/// first and second derivatives, `Jet2` over `Interval` bounds of them all over a box.
pub trait Scalar: Arithmetic {
    /// A plain number near this one, to choose between forms of a formula by. (All forms hold
    /// everywhere; they differ in rounding.)
    fn mid(self) -> f64;
    /// x^2.
    #[must_use]
    fn square(self) -> Self;
    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Exponential.
    #[must_use]
    fn exp(self) -> Self;
    /// Natural logarithm.
    #[must_use]
    fn log(self) -> Self;
    /// Sine.
    #[must_use]
    fn sin(self) -> Self;
    /// Cosine.
    #[must_use]
    fn cos(self) -> Self;
    /// Tangent.
    #[must_use]
    fn tan(self) -> Self;
    /// Arc tangent.
    #[must_use]
    fn atan(self) -> Self;
    /// Angle of the point (x, self) from the positive x axis. Not defined on the negative x axis,
    /// where it jumps.
    #[must_use]
    fn atan2(self, x: Self) -> Self;
    /// (1 - exp(-x)) / x, 1 at x = 0.
    #[must_use]
    fn one_minus_exp_over_x(self) -> Self;
    /// log(1 + x) / x, 1 at x = 0.
    #[must_use]
    fn ln_1p_over_x(self) -> Self;
    /// tan(sqrt x) / sqrt x, 1 at x = 0, for 0 <= x < (pi/2)^2 (and a rounding error below 0).
    #[must_use]
    fn tan_over_root(self) -> Self;
    /// atan(sqrt x) / sqrt x, 1 at x = 0, for x >= 0 (and a rounding error below 0).
    #[must_use]
    fn atan_over_root(self) -> Self;
    /// The value of a smooth function at this number.
    #[must_use]
    fn map(self, curve: &impl SmoothFn) -> Self;
    /// The value of a smooth function of the plane at the point (`x`, `y`).
    #[must_use]
    fn of_plane(x: Self, y: Self, f: &impl PlaneFn) -> Self;
    /// The point of the plane near `near` at which the two functions of `map` have the values `value`, to rounding of
    /// lengths of `scale`; not finite where none is found. Of intervals: a box that surely holds the point of each
    /// value, and of each no other.
    #[must_use]
    fn invert_plane(
        map: &[impl PlaneFn; 2],
        scale: f64,
        value: [Self; 2],
        near: [f64; 2],
    ) -> [Self; 2];
}

/// A number that can carry derivatives: one for which a curve's slope and bend are known too.
pub trait Base: Scalar {
    /// (f, f', f'') of a smooth function at this number.
    #[must_use]
    fn curve(self, curve: &impl SmoothFn) -> [Self; 3];
    /// (f, f_x, f_y, f_xx, f_xy, f_yy) of a smooth function of the plane at the point (`x`, `y`).
    #[must_use]
    fn plane(x: Self, y: Self, f: &impl PlaneFn) -> [Self; 6];
}

/// A function of one variable with its first two derivatives.
pub trait SmoothFn {
    /// (f, f', f'') at `x`.
    fn at(&self, x: f64) -> [f64; 3];
    /// Ranges that hold f, f' and f'' over lo..=hi.
    fn over(&self, range: [f64; 2]) -> [[f64; 2]; 3];
}

/// A function of the plane with its first two derivatives.
pub trait PlaneFn {
    /// (f, f_x, f_y) at a point.
    fn first(&self, at: [f64; 2]) -> [f64; 3];
    /// (f_xx, f_xy, f_yy) at a point.
    fn second(&self, at: [f64; 2]) -> [f64; 3];
    /// Ranges that hold both, in that order, over the box of two ranges, x and y.
    fn over(&self, ranges: [[f64; 2]; 2]) -> [[f64; 2]; 6];
}
