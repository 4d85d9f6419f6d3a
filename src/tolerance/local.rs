//! A smooth surface near one place, as a polynomial.
//!
//! The surface is interpolated at Chebyshev's points of a small square, and terms beyond the total
//! degree are dropped; what that leaves is measured, and where it is not negligible the caller
//! evaluates the surface itself.

use crate::num::{Scalar, cos};
use std::f64::consts::PI;

/// Total degree.
pub const DEGREE: usize = 7;
/// Number of terms u^i v^j with i + j up to [`DEGREE`].
pub const TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;
/// Points along each axis.
const POINTS: usize = DEGREE + 2;

/// Coefficients of u^i v^j in the order (0, 0), (0, 1) ... (0, 7), (1, 0) ...
pub type Terms<S> = [S; TERMS];

/// The square that a polynomial holds on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Its middle, mm.
    pub centre: [f64; 2],
    /// Half its side, mm.
    pub half: f64,
}

impl Square {
    /// (u, v) of a place: within [-1, 1] inside the square.
    #[inline]
    pub fn unit<S: Scalar>(&self, [x, y]: [S; 2]) -> [S; 2] {
        [(x - self.centre[0]) / self.half, (y - self.centre[1]) / self.half]
    }

    /// Whether a place lies inside.
    #[inline]
    pub fn holds<S: Scalar>(&self, at: [S; 2]) -> bool {
        let within = |k: usize| (at[k].centre() - self.centre[k]).abs() <= self.half;
        within(0) && within(1)
    }
}

/// Value and derivatives by x and y, per mm.
#[inline]
pub fn value<S: Scalar>(terms: &Terms<S>, square: &Square, at: [S; 2]) -> [S; 3] {
    let [u, v] = square.unit(at);
    let zero = S::constant(0.0);
    let (mut f, mut f_u, mut f_v) = (zero, zero, zero);
    let mut end = TERMS;
    for i in (0..=DEGREE).rev() {
        let start = end - (DEGREE + 1 - i);
        let (mut row, mut row_v) = (zero, zero);
        for &c in terms[start..end].iter().rev() {
            row_v = row_v * v + row;
            row = row * v + c;
        }
        f_u = f_u * u + f;
        f = f * u + row;
        f_v = f_v * u + row_v;
        end = start;
    }
    [f, f_u / square.half, f_v / square.half]
}

/// Makes polynomials from values.
#[derive(Debug, Clone)]
pub struct Fitter {
    nodes: [f64; POINTS],
    /// Chebyshev coefficients from values.
    transform: [[f64; POINTS]; POINTS],
    /// Monomial coefficients of Chebyshev's polynomials.
    monomials: [[f64; DEGREE + 1]; DEGREE + 1],
}

impl Default for Fitter {
    fn default() -> Self {
        let angle = |k: usize| PI * (k as f64 + 0.5) / POINTS as f64;
        let nodes = std::array::from_fn(|k| cos(angle(k)));
        let transform = std::array::from_fn(|n| {
            let scale = if n == 0 { 1.0 } else { 2.0 } / POINTS as f64;
            std::array::from_fn(|k| scale * cos(n as f64 * angle(k)))
        });
        let mut monomials = [[0.0; DEGREE + 1]; DEGREE + 1];
        monomials[0][0] = 1.0;
        monomials[1][1] = 1.0;
        for n in 2..=DEGREE {
            for k in 0..=DEGREE {
                let up = if k == 0 { 0.0 } else { 2.0 * monomials[n - 1][k - 1] };
                monomials[n][k] = up - monomials[n - 2][k];
            }
        }
        Self { nodes, transform, monomials }
    }
}

impl Fitter {
    /// The polynomial of `f` on `square`.
    #[must_use]
    pub fn fit(&self, square: &Square, f: impl Fn([f64; 2]) -> f64) -> Terms<f64> {
        let place = |k: usize, axis: usize| square.centre[axis] + square.half * self.nodes[k];
        let values: [[f64; POINTS]; POINTS] =
            std::array::from_fn(|a| std::array::from_fn(|b| f([place(a, 0), place(b, 1)])));
        // Along v, then along u.
        let product = |a: &[f64; POINTS], b: &[f64; POINTS]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a * b).sum()
        };
        let rows: [[f64; POINTS]; POINTS] = std::array::from_fn(|n| {
            std::array::from_fn(|a| product(&self.transform[n], &values[a]))
        });
        let mut terms = [0.0; TERMS];
        for m in 0..=DEGREE {
            for (n, row) in rows.iter().enumerate().take(DEGREE - m + 1) {
                let c = product(&self.transform[m], row);
                let mut k = 0;
                for i in 0..=DEGREE {
                    for j in 0..=DEGREE - i {
                        terms[k] += c * self.monomials[m][i] * self.monomials[n][j];
                        k += 1;
                    }
                }
            }
        }
        terms
    }

    /// How far the polynomial is from `f` at places between the points that made it.
    pub fn off(&self, terms: &Terms<f64>, square: &Square, f: impl Fn([f64; 2]) -> f64) -> f64 {
        const PLACES: [[f64; 2]; 7] = [
            [1.0, 1.0],
            [-1.0, 1.0],
            [1.0, -1.0],
            [-1.0, -1.0],
            [0.13, -0.62],
            [-0.71, 0.07],
            [0.41, 0.35],
        ];
        let miss = |[u, v]: [f64; 2]| {
            let at = [square.centre[0] + square.half * u, square.centre[1] + square.half * v];
            (value(terms, square, at)[0] - f(at)).abs()
        };
        PLACES.into_iter().map(miss).fold(0.0, crate::num::larger)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{Dual, exp};

    #[test]
    fn polynomials_are_met_and_smooth_functions_nearly() {
        let fitter = Fitter::default();
        let square = Square { centre: [3.0, -7.0], half: 0.4 };
        let sextic = |[x, y]: [f64; 2]| 2.0 + x * y * (x - y) * x * y + 0.3 * y * y * y * y * y * y;
        let terms = fitter.fit(&square, sextic);
        let size = sextic([3.0, -7.0]).abs();
        assert!(fitter.off(&terms, &square, sextic) < 1e-14 * size);
        let wave = |[x, y]: [f64; 2]| exp(0.1 * y) * cos(0.1 * x);
        let terms = fitter.fit(&square, wave);
        // (0.04)^8 / 8! / 2^7, and rounding.
        assert!(fitter.off(&terms, &square, wave) < 1e-14);
        let steep = |[x, y]: [f64; 2]| exp(4.0 * (y + 7.0)) * cos(4.0 * x);
        assert!(fitter.off(&fitter.fit(&square, steep), &square, steep) > 1e-6);
    }

    #[test]
    fn slopes_are_those_of_the_polynomial() {
        let fitter = Fitter::default();
        let square = Square { centre: [1.0, 2.0], half: 0.5 };
        let terms = fitter.fit(&square, |[x, y]| x * x * y + y * y * y * y);
        let (x, y) = (1.3, 1.7);
        let [f, f_x, f_y] = value(&terms, &square, [x, y]);
        assert!((f - x * x * y - y * y * y * y).abs() < 1e-13);
        assert!((f_x - 2.0 * x * y).abs() < 1e-12);
        assert!((f_y - x * x - 4.0 * y * y * y).abs() < 1e-12);
        let dual = value(
            &terms.map(Dual::<1>::constant),
            &square,
            [Dual::constant(x), Dual::variable(y, 0)],
        );
        assert!((dual[0].slope[0] - f_y).abs() < 1e-13);
        assert!((dual[1].slope[0] - 2.0 * x).abs() < 1e-12);
        assert!(
            square.holds([x, y]) && !square.holds([1.6, 2.0]) && !square.holds([1.0, f64::NAN])
        );
    }
}
