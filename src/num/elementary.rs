//! Elementary functions with the same bits on every machine.

macro_rules! unary {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {
        $($(#[$doc])* #[inline] #[must_use] pub fn $name(x: f64) -> f64 { libm::$name(x) })*
    };
}

unary! {
    /// Sine of an angle in radians.
    sin,
    /// Cosine of an angle in radians.
    cos,
    /// Tangent of an angle in radians.
    tan,
    /// Arc sine, in radians.
    asin,
    /// Arc cosine, in radians.
    acos,
    /// Bessel function of the first kind of order 1.
    j1,
    /// Arc tangent, in radians.
    atan,
    /// Exponential.
    exp,
    /// exp(x) - 1 without cancellation.
    expm1,
    /// Natural logarithm.
    log,
    /// log(1 + x) without cancellation.
    log1p,
    /// Hyperbolic sine.
    sinh,
    /// Hyperbolic cosine.
    cosh,
    /// Hyperbolic tangent.
    tanh,
    /// Inverse hyperbolic sine.
    asinh,
}

/// Angle of the point (x, y) from the positive x axis, in (-pi, pi].
#[inline]
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Length of (x, y) without overflow or underflow on the way.
#[inline]
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// The angle in radians of `degrees`; exact multiples of 90 give the nearest double.
#[inline]
#[must_use]
pub fn radians(degrees: f64) -> f64 {
    degrees / 180.0 * std::f64::consts::PI
}

/// The angle in degrees of `radians`.
#[inline]
#[must_use]
pub fn degrees(radians: f64) -> f64 {
    radians / std::f64::consts::PI * 180.0
}

/// `angle` (radians) shifted by whole turns into [-pi, pi].
#[inline]
#[must_use]
pub fn wrap_turn(angle: f64) -> f64 {
    const TURN: f64 = 2.0 * std::f64::consts::PI;
    if angle.abs() <= std::f64::consts::PI { angle } else { angle - TURN * (angle / TURN).round() }
}
