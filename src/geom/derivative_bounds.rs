//! Bounds of a function over the plane and of its first three derivatives.

use crate::num::Interval;

/// What holds at every point of a region: ranges of f, (f_x, f_y), (f_xx, f_xy, f_yy) and
/// (f_xxx, f_xxy, f_xyy, f_yyy), in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DerivativeBounds {
    /// f.
    pub f: Interval,
    /// First derivatives.
    pub slope: [Interval; 2],
    /// Second derivatives.
    pub hessian: [Interval; 3],
    /// Third derivatives.
    pub third: [Interval; 4],
}

impl DerivativeBounds {
    /// What holds of no point.
    pub const EMPTY: Self = {
        let none = Interval { lo: f64::INFINITY, hi: f64::NEG_INFINITY };
        Self { f: none, slope: [none; 2], hessian: [none; 3], third: [none; 4] }
    };

    /// What holds in both of two regions.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        fn both<const N: usize>(a: [Interval; N], b: [Interval; N]) -> [Interval; N] {
            std::array::from_fn(|k| a[k].hull(b[k]))
        }
        Self {
            f: self.f.hull(other.f),
            slope: both(self.slope, other.slope),
            hessian: both(self.hessian, other.hessian),
            third: both(self.third, other.third),
        }
    }

    /// What holds of the sum of two functions.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        fn sums<const N: usize>(a: [Interval; N], b: [Interval; N]) -> [Interval; N] {
            std::array::from_fn(|k| a[k] + b[k])
        }
        Self {
            f: self.f + other.f,
            slope: sums(self.slope, other.slope),
            hessian: sums(self.hessian, other.hessian),
            third: sums(self.third, other.third),
        }
    }
}
