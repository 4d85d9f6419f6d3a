//! A smooth surface near one place, as a polynomial.
//!
//! The surface is interpolated at Chebyshev's points of a small square, and terms beyond the total
//! degree are dropped; what that leaves is measured, and where it is not negligible a higher degree
//! is taken, or the caller evaluates the surface itself.

use crate::num::{Arithmetic, Scalar, cos};
use std::f64::consts::PI;

/// Number of terms u^i v^j with i + j up to `degree`.
#[must_use]
pub(super) const fn terms(degree: usize) -> usize {
    (degree + 1) * (degree + 2) / 2
}

/// Number of the first of them with this `i`.
#[must_use]
pub(super) const fn start(degree: usize, i: usize) -> usize {
    i * (degree + 1) - i * i.saturating_sub(1) / 2
}

/// The square that a polynomial holds on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ExpansionSquare {
    /// Its middle, mm.
    pub centre: [f64; 2],
    /// Half its side, mm.
    pub half: f64,
}

impl ExpansionSquare {
    /// (u, v) of a place: within [-1, 1] inside the square.
    #[inline]
    pub(super) fn unit<S: Arithmetic>(&self, [x, y]: [S; 2]) -> [S; 2] {
        [(x - self.centre[0]) / self.half, (y - self.centre[1]) / self.half]
    }

    /// Whether a place lies inside.
    #[inline]
    pub(super) fn holds<S: Scalar>(&self, at: [S; 2]) -> bool {
        let within = |k: usize| (at[k].mid() - self.centre[k]).abs() <= self.half;
        within(0) && within(1)
    }
}

/// Value and derivatives by u and v of the polynomial with the coefficients `c` of u^i v^j in the order
/// (0, 0), (0, 1) ... (0, degree), (1, 0) ...
#[inline]
pub(super) fn value<S: Arithmetic>(degree: usize, c: &[S], [u, v]: [S; 2]) -> [S; 3] {
    let zero = S::constant(0.0);
    let (mut f, mut f_u, mut f_v) = (zero, zero, zero);
    let mut end = terms(degree);
    for i in (0..=degree).rev() {
        let start = end - (degree + 1 - i);
        let (mut row, mut row_v) = (zero, zero);
        for &c in c[start..end].iter().rev() {
            row_v = row_v * v + row;
            row = row * v + c;
        }
        f_u = f_u * u + f;
        f = f * u + row;
        f_v = f_v * u + row_v;
        end = start;
    }
    [f, f_u, f_v]
}

/// Values alone, of several polynomials at once.
#[inline]
pub(super) fn values<S: Arithmetic, const N: usize>(
    degree: usize,
    c: &[[f64; N]],
    square: &ExpansionSquare,
    at: [S; 2],
) -> [S; N] {
    let [u, v] = square.unit(at);
    let mut sum = [S::constant(0.0); N];
    let mut end = terms(degree);
    for i in (0..=degree).rev() {
        let start = end - (degree + 1 - i);
        let mut row = [S::constant(0.0); N];
        for c in c[start..end].iter().rev() {
            row = std::array::from_fn(|k| row[k] * v + c[k]);
        }
        sum = std::array::from_fn(|k| sum[k] * u + row[k]);
        end = start;
    }
    sum
}

/// Makes polynomials of one degree from values.
#[derive(Debug, Clone)]
pub(super) struct Fitter {
    degree: usize,
    nodes: Vec<f64>,
    /// Chebyshev coefficients from values.
    transform: Vec<Vec<f64>>,
    /// Monomial coefficients of Chebyshev's polynomials.
    monomials: Vec<Vec<f64>>,
}

impl Fitter {
    /// For polynomials of total degree `degree`.
    #[must_use]
    pub(super) fn new(degree: usize) -> Self {
        let points = degree + 2;
        let angle = |k: usize| PI * (k as f64 + 0.5) / points as f64;
        let nodes = (0..points).map(|k| cos(angle(k))).collect();
        let row = |n: usize| -> Vec<f64> {
            let scale = if n == 0 { 1.0 } else { 2.0 } / points as f64;
            (0..points).map(|k| scale * cos(n as f64 * angle(k))).collect()
        };
        let mut monomials = vec![vec![1.0], vec![0.0, 1.0]];
        for n in 2..=degree {
            let mut next: Vec<f64> = (0..=n).map(|_| 0.0).collect();
            for (k, c) in monomials[n - 1].iter().enumerate() {
                next[k + 1] = 2.0 * c;
            }
            for (k, c) in monomials[n - 2].iter().enumerate() {
                next[k] -= c;
            }
            monomials.push(next);
        }
        Self { degree, nodes, transform: (0..=degree).map(row).collect(), monomials }
    }

    /// Total degree of the polynomials.
    #[must_use]
    pub(super) fn degree(&self) -> usize {
        self.degree
    }

    /// The polynomials of the functions `f` on `square`.
    #[must_use]
    pub(super) fn fit<const N: usize>(
        &self,
        square: &ExpansionSquare,
        f: impl Fn([f64; 2]) -> [f64; N],
    ) -> Vec<[f64; N]> {
        let places = |axis: usize| -> Vec<f64> {
            self.nodes.iter().map(|node| square.centre[axis] + square.half * node).collect()
        };
        let (xs, ys) = (places(0), places(1));
        let mut values = vec![vec![[0.0; N]; ys.len()]; xs.len()];
        // In lines of equal y.
        for (j, y) in ys.iter().enumerate() {
            for (i, x) in xs.iter().enumerate() {
                values[i][j] = f([*x, *y]);
            }
        }
        let product = |a: &[f64], b: &[[f64; N]]| -> [f64; N] {
            a.iter().zip(b).fold([0.0; N], |sum, (a, b)| std::array::from_fn(|k| sum[k] + a * b[k]))
        };
        let degree = self.degree;
        // Along v, then along u.
        let rows: Vec<Vec<[f64; N]>> = self
            .transform
            .iter()
            .map(|line| values.iter().map(|values| product(line, values)).collect())
            .collect();
        let mut c = vec![[0.0; N]; terms(degree)];
        for (m, line) in self.transform.iter().enumerate() {
            for (n, row) in rows.iter().enumerate().take(degree - m + 1) {
                let size = product(line, row);
                for (i, a) in self.monomials[m].iter().enumerate() {
                    let out = &mut c[start(degree, i)..];
                    for (out, b) in out.iter_mut().zip(&self.monomials[n]) {
                        out.iter_mut().zip(size).for_each(|(out, size)| *out += size * a * b);
                    }
                }
            }
        }
        c
    }
}

/// Largest difference in height, mm, or slope of `found` from `exact`, at places in the square between the
/// points that polynomials are made of.
pub(super) fn largest_difference(
    square: &ExpansionSquare,
    found: impl Fn([f64; 2]) -> [f64; 3],
    exact: impl Fn([f64; 2]) -> [f64; 3],
) -> f64 {
    const PLACES: [[f64; 2]; 9] = [
        [1.0, 1.0],
        [-1.0, 1.0],
        [1.0, -1.0],
        [-1.0, -1.0],
        [0.0, 1.0],
        [-1.0, 0.0],
        [0.13, -0.62],
        [-0.71, 0.07],
        [0.41, 0.35],
    ];
    let miss = |[u, v]: [f64; 2]| {
        let at = [square.centre[0] + square.half * u, square.centre[1] + square.half * v];
        let (found, exact) = (found(at), exact(at));
        (0..3).map(|k| (found[k] - exact[k]).abs()).fold(0.0, crate::num::max_or_nan)
    };
    PLACES.into_iter().map(miss).fold(0.0, crate::num::max_or_nan)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{Dual, exp};

    /// Value and slopes, per mm, on a square.
    fn height(degree: usize, c: &[f64], square: &ExpansionSquare, at: [f64; 2]) -> [f64; 3] {
        let [f, f_u, f_v] = value(degree, c, square.unit(at));
        [f, f_u / square.half, f_v / square.half]
    }

    #[test]
    fn polynomials_are_met_and_smooth_functions_nearly() {
        let square = ExpansionSquare { centre: [3.0, -7.0], half: 0.4 };
        let sextic = |[x, y]: [f64; 2]| {
            let (a, b) = (x * y * (x - y) * x * y, 0.3 * y * y * y * y * y * y);
            let a_x = 3.0 * x * x * y * y - 2.0 * x * y * y * y;
            let a_y = 2.0 * x * x * x * y - 3.0 * x * x * y * y;
            [2.0 + a + b, a_x, a_y + 1.8 * y * y * y * y * y]
        };
        let wave = |a: f64| {
            move |[x, y]: [f64; 2]| {
                let (e, c, s) = (exp(a * (y + 7.0)), cos(a * x), crate::num::sin(a * x));
                [e * c, -a * e * s, a * e * c]
            }
        };
        // About 4 * (0.4 a)^n / (n + 1)!, a times n^2 for slopes.
        for (degree, most) in [(7, 0.5), (10, 5e-3), (16, 5e-7)] {
            let fitter = Fitter::new(degree);
            let missed = |f: &dyn Fn([f64; 2]) -> [f64; 3]| {
                let c = fitter.fit(&square, |at| [f(at)[0]]).concat();
                let by_height =
                    largest_difference(&square, |at| height(degree, &c, &square, at), f);
                let c = fitter.fit(&square, f);
                let by_all = largest_difference(&square, |at| values(degree, &c, &square, at), f);
                assert!(by_all <= by_height);
                by_height
            };
            // Rounding, times n^2 and per half side for slopes.
            let off = missed(&sextic);
            assert!(off < 5e-12 * sextic(square.centre)[0].abs(), "{degree}: {off:e}");
            let off = missed(&wave(0.1));
            assert!(off < 1e-12, "{degree}: {off:e}");
            let off = missed(&wave(4.0));
            assert!(off < most && off > 1e-4 * most, "{degree}: {off:e}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_polynomial() {
        let square = ExpansionSquare { centre: [1.0, 2.0], half: 0.5 };
        let c = Fitter::new(5).fit(&square, |[x, y]| [x * x * y + y * y * y * y]).concat();
        let (x, y) = (1.3, 1.7);
        let [f, f_x, f_y] = height(5, &c, &square, [x, y]);
        assert!((f - x * x * y - y * y * y * y).abs() < 1e-13);
        assert!((f_x - 2.0 * x * y).abs() < 1e-12);
        assert!((f_y - x * x - 4.0 * y * y * y).abs() < 1e-12);
        let at = square.unit([Dual::<1>::constant(x), Dual::variable(y, 0)]);
        let dual = value(5, &c.iter().map(|&c| Dual::constant(c)).collect::<Vec<_>>(), at);
        assert!((dual[0].slope[0] - f_y).abs() < 1e-13);
        assert!((dual[1].slope[0] / square.half - 2.0 * x).abs() < 1e-12);
        assert!(
            square.holds([x, y]) && !square.holds([1.6, 2.0]) && !square.holds([1.0, f64::NAN])
        );
    }
}
