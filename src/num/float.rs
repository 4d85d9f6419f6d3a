//! `f64` as a [`Scalar`]: plain values.

use super::elementary as f;
use super::plane_inverse;
use super::scalar::{Arithmetic, Base, PlaneFn, Scalar, SmoothFn};
use super::special::{AtanOverRoot, TanOverRoot};

impl Arithmetic for f64 {
    #[inline]
    fn constant(x: f64) -> Self {
        x
    }
}

impl Scalar for f64 {
    #[inline]
    fn mid(self) -> f64 {
        self
    }
    #[inline]
    fn square(self) -> Self {
        self * self
    }
    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline]
    fn exp(self) -> Self {
        f::exp(self)
    }
    #[inline]
    fn log(self) -> Self {
        f::log(self)
    }
    #[inline]
    fn sin(self) -> Self {
        f::sin(self)
    }
    #[inline]
    fn cos(self) -> Self {
        f::cos(self)
    }
    #[inline]
    fn tan(self) -> Self {
        f::tan(self)
    }
    #[inline]
    fn atan(self) -> Self {
        f::atan(self)
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        f::atan2(self, x)
    }
    #[inline]
    fn one_minus_exp_over_x(self) -> Self {
        if self == 0.0 { 1.0 } else { -f::expm1(-self) / self }
    }
    #[inline]
    fn ln_1p_over_x(self) -> Self {
        if self == 0.0 { 1.0 } else { f::log1p(self) / self }
    }
    #[inline]
    fn tan_over_root(self) -> Self {
        if self.abs() < 1e-8 {
            1.0 + self / 3.0
        } else if self < 0.0 {
            TanOverRoot.at(self)[0]
        } else {
            let root = f64::sqrt(self);
            f::tan(root) / root
        }
    }
    #[inline]
    fn atan_over_root(self) -> Self {
        if self.abs() < 1e-8 {
            1.0 - self / 3.0
        } else if self < 0.0 {
            AtanOverRoot.at(self)[0]
        } else {
            let root = f64::sqrt(self);
            f::atan(root) / root
        }
    }
    #[inline]
    fn map(self, curve: &impl SmoothFn) -> Self {
        curve.at(self)[0]
    }
    #[inline]
    fn of_plane(x: Self, y: Self, f: &impl PlaneFn) -> Self {
        f.first([x, y])[0]
    }
    fn invert_plane(
        map: &[impl PlaneFn; 2],
        scale: f64,
        value: [Self; 2],
        near: [f64; 2],
    ) -> [Self; 2] {
        plane_inverse::at(map, scale, value, near)
    }
}

impl Base for f64 {
    #[inline]
    fn curve(self, curve: &impl SmoothFn) -> [Self; 3] {
        curve.at(self)
    }
    #[inline]
    fn plane(x: Self, y: Self, f: &impl PlaneFn) -> [Self; 6] {
        let ([f0, fx, fy], [fxx, fxy, fyy]) = (f.first([x, y]), f.second([x, y]));
        [f0, fx, fy, fxx, fxy, fyy]
    }
}
