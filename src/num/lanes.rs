//! Several numbers side by side, for work that is the same for all of them: the processor then handles two or
//! more at a time. Each gets the bits that it would get alone.
//!
//! Operations are loops that are always inlined: as calls of closures they take many times as long.

use super::scalar::Arithmetic;
use std::f64::consts::FRAC_2_PI;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// `L` numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes<const L: usize>(pub [f64; L]);

macro_rules! lanewise {
    ($($operator:ident $name:ident $sign:tt),* $(,)?) => {$(
        impl<const L: usize> $operator for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $name(mut self, b: Self) -> Self {
                for (a, b) in self.0.iter_mut().zip(b.0) {
                    *a $sign b;
                }
                self
            }
        }
        impl<const L: usize> $operator<f64> for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $name(mut self, b: f64) -> Self {
                for a in &mut self.0 {
                    *a $sign b;
                }
                self
            }
        }
    )*};
}

lanewise!(Add add +=, Sub sub -=, Mul mul *=, Div div /=);

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for a in &mut self.0 {
            *a = -*a;
        }
        self
    }
}

impl<const L: usize> Arithmetic for Lanes<L> {
    #[inline]
    fn constant(x: f64) -> Self {
        Self([x; L])
    }
}

/// 1.5 * 2^52: a number smaller than 2^51 that is added to it is rounded to a whole one, whose lowest bits
/// are those of the sum.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// Upper 33 bits of half of pi, so that its multiples up to 2^20 are exact, and the rest.
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];
/// Coefficients of x^3, x^5 ... of the sine up to an eighth of a turn, to rounding: those of Sun's fdlibm,
/// which `libm` has too.
const SINE: [f64; 6] = [
    -0.166_666_666_666_666_32,
    8.333_333_333_322_49e-3,
    -1.984_126_982_985_795e-4,
    2.755_731_370_707_006_8e-6,
    -2.505_076_025_340_686_3e-8,
    1.589_690_995_211_55e-10,
];
/// Coefficients of x^4, x^6 ... of the cosine, likewise.
const COSINE: [f64; 6] = [
    4.166_666_666_666_66e-2,
    -1.388_888_888_887_411e-3,
    2.480_158_728_947_673e-5,
    -2.755_731_435_139_066_3e-7,
    2.087_572_321_298_175e-9,
    -1.135_964_755_778_819_5e-11,
];

impl<const L: usize> Lanes<L> {
    /// The coordinates of points, axis by axis.
    #[inline(always)]
    #[must_use]
    pub fn of_points(points: [[f64; 2]; L]) -> [Self; 2] {
        [Self(points.map(|[x, _]| x)), Self(points.map(|[_, y]| y))]
    }

    /// Sines and cosines of angles, in radians, within a million; the last two bits may be off.
    #[inline]
    #[must_use]
    pub fn sin_cos(self) -> [Self; 2] {
        let shifted = self * FRAC_2_PI + WHOLE;
        let quarters = shifted - WHOLE;
        let x = self - quarters * HALF_PI[0] - quarters * HALF_PI[1];
        let square = x * x;
        let series = |c: &[f64; 6]| {
            let last = square * c[5] + c[4];
            c[..4].iter().rev().fold(last, |sum, c| sum * square + *c)
        };
        let [mut sine, mut cosine] = [
            x + x * square * series(&SINE),
            square * square * series(&COSINE) + (square * -0.5 + 1.0),
        ];
        for (k, shifted) in shifted.0.iter().enumerate() {
            // Odd numbers of quarter turns swap the two, every second pair of them changes a sign.
            let turned = shifted.to_bits();
            let (s, c) = (sine.0[k].to_bits(), cosine.0[k].to_bits());
            let swapped = (s ^ c) & (turned & 1).wrapping_neg();
            sine.0[k] = f64::from_bits(s ^ swapped ^ ((turned & 2) << 62));
            cosine.0[k] = f64::from_bits(c ^ swapped ^ ((turned.wrapping_add(1) & 2) << 62));
        }
        [sine, cosine]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, sin};

    #[test]
    fn sines_and_cosines_are_those_of_single_numbers_wherever_they_stand() {
        for k in -40_000..40_000 {
            let x = 0.021_7 * f64::from(k);
            let other = 1e-3 * f64::from(k % 977);
            let [s, c] = Lanes([x, other, -x, 0.5]).sin_cos();
            assert!((s.0[0] - sin(x)).abs() < 4e-16 && (c.0[0] - cos(x)).abs() < 4e-16, "{x}");
            assert!(s.0[2] == -s.0[0] && c.0[2] == c.0[0], "{x}");
            let [alone, across] = Lanes([x]).sin_cos();
            assert_eq!(
                [alone.0[0], across.0[0]].map(f64::to_bits),
                [s, c].map(|y| y.0[0].to_bits())
            );
        }
        for x in [1e5, -9e5, f64::NAN] {
            let [[s], [c]] = Lanes([x]).sin_cos().map(|y| y.0);
            assert!(!((s - sin(x)).abs() > 1e-15 || (c - cos(x)).abs() > 1e-15), "{x}");
            assert_eq!(s.is_nan(), x.is_nan());
        }
    }

    #[test]
    fn arithmetic_is_that_of_each_number() {
        let (a, b) = (Lanes([1.5, -2.0, 0.1]), Lanes([0.3, 7.0, -1e9]));
        for k in 0..3 {
            let (x, y) = (a.0[k], b.0[k]);
            let found = [a + b, a - b, a * b, a / b, -a, a * 3.0, a - 0.7];
            let exact = [x + y, x - y, x * y, x / y, -x, x * 3.0, x - 0.7];
            assert_eq!(found.map(|found| found.0[k].to_bits()), exact.map(f64::to_bits));
        }
        assert_eq!(Lanes::constant(2.0), Lanes([2.0; 3]));
    }
}
