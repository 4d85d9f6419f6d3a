//! The one door to mathematics.
//!
//! Platform `sin`, `exp` and their kin differ in the last bit between machines, and "same input,
//! same bytes" would break with them; the functions here are `libm`'s software versions, equal
//! everywhere. `sqrt`, `abs` and rounding are exact in IEEE 754 and may be called directly.

pub mod bernstein;
pub mod condition;
mod dual;
mod elementary;
mod float;
pub mod interval;
pub mod jet;
mod knot_search;
mod lanes;
pub mod least_bending;
pub mod least_squares;
pub mod legendre;
pub mod monotone;
mod piecewise_cubic;
mod plane_inverse;
pub mod quadrature;
mod radial_cubic;
pub mod random;
pub mod rounding;
mod scalar;
mod sorting;
pub mod special;
pub mod stats;
pub mod streaming_qr;
pub mod units;

pub use dual::Dual;
pub use elementary::*;
pub use interval::Interval;
pub use jet::Jet2;
pub use lanes::Lanes;
pub use monotone::{Inverse, MonotoneCubic};
pub use radial_cubic::RadialCubic;
pub use scalar::{Arithmetic, Base, PlaneFn, Scalar, SmoothFn};
pub use sorting::sort_by_number;

/// The larger of two errors; one that is no number is larger than all.
#[inline]
#[must_use]
pub fn max_or_nan(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() { a } else { b }
}

/// Arguments to test with, the same every time.
#[cfg(test)]
pub(crate) mod sample {
    /// A series of pseudo-random numbers.
    pub struct Draws(u64);

    impl Draws {
        /// The series numbered `seed`.
        pub fn new(seed: u64) -> Self {
            Self(seed.wrapping_mul(1_000_003))
        }

        /// Uniform in [0, 1).
        pub fn unit(&mut self) -> f64 {
            self.0 += 1;
            let mut z = self.0.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        }

        /// A number in the range.
        pub fn inside(&mut self, [lo, hi]: [f64; 2]) -> f64 {
            (lo + (hi - lo) * self.unit()).clamp(lo, hi)
        }

        /// A part of the range, often a small one.
        pub fn range(&mut self, domain: [f64; 2]) -> [f64; 2] {
            let a = self.inside(domain);
            let size = crate::num::exp(-30.0 * self.unit()) * (domain[1] - domain[0]);
            [a, (a + size).min(domain[1])]
        }
    }
}
