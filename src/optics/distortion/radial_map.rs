//! The map of the plane that both models of distortion share: a radial ratio of polynomials, with
//! tangential and thin-prism terms.

use crate::num::Scalar;

/// w -> w N(u) / D(u) + tangential + prism with u = |w|^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RadialMap {
    /// N = 1 + n1 u + n2 u^2 + n3 u^3 + n4 u^4.
    pub numerator: [f64; 4],
    /// D = 1 + d1 u + d2 u^2 + d3 u^3.
    pub denominator: [f64; 3],
    /// p1 and p2.
    pub tangential: [f64; 2],
    /// s1 to s4.
    pub prism: [f64; 4],
}

/// 1 + c1 u + c2 u^2 + ...
fn polynomial<S: Scalar>(coefficients: &[f64], u: S) -> S {
    let mut sum = S::constant(0.0);
    for &c in coefficients.iter().rev() {
        sum = u * (sum + c);
    }
    sum + 1.0
}

/// Derivative of [`polynomial`] by u.
fn slope(coefficients: &[f64], u: f64) -> f64 {
    let terms = coefficients.iter().enumerate().rev();
    terms.fold(0.0, |sum, (k, c)| sum * u + (k + 1) as f64 * c)
}

impl RadialMap {
    /// Image of the point `w`.
    #[inline]
    pub(super) fn image<S: Scalar>(&self, [x, y]: [S; 2]) -> [S; 2] {
        let [p1, p2] = self.tangential;
        let [s1, s2, s3, s4] = self.prism;
        let (x2, y2) = (x.square(), y.square());
        let u = x2 + y2;
        let mut ratio = polynomial(&self.numerator, u);
        if self.denominator != [0.0; 3] {
            ratio = ratio / polynomial(&self.denominator, u);
        }
        let (xy, u2) = (x * y * 2.0, u.square());
        let x = x * ratio + xy * p1 + (u + x2 * 2.0) * p2 + u * s1 + u2 * s2;
        let y = y * ratio + (u + y2 * 2.0) * p1 + xy * p2 + u * s3 + u2 * s4;
        [x, y]
    }

    /// Derivatives of the image: `[[dx'/dx, dx'/dy], [dy'/dx, dy'/dy]]`.
    #[inline]
    pub(super) fn jacobian(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let [p1, p2] = self.tangential;
        let [s1, s2, s3, s4] = self.prism;
        let u = x * x + y * y;
        let denominator = polynomial(&self.denominator, u);
        let ratio = polynomial(&self.numerator, u) / denominator;
        // By u, twice.
        let rate =
            2.0 * (slope(&self.numerator, u) - ratio * slope(&self.denominator, u)) / denominator;
        let [along_x, along_y] = [2.0 * (s1 + 2.0 * s2 * u), 2.0 * (s3 + 2.0 * s4 * u)];
        let mixed = x * y * rate + 2.0 * (p1 * x + p2 * y);
        [
            [ratio + x * x * rate + 2.0 * p1 * y + 6.0 * p2 * x + x * along_x, mixed + y * along_x],
            [mixed + x * along_y, ratio + y * y * rate + 6.0 * p1 * y + 2.0 * p2 * x + y * along_y],
        ]
    }
}

/// Frobenius norm of a^-1 b - 1: how far `b` is from `a`, as a share of it.
pub(super) fn relative_change(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> f64 {
    let [[p, q], [r, s]] = [0, 1].map(|k| solved(a, [b[0][k], b[1][k]]));
    f64::sqrt((p - 1.0) * (p - 1.0) + q * q + r * r + (s - 1.0) * (s - 1.0))
}

/// Determinant of a matrix of 2 x 2.
pub(super) fn determinant(m: [[f64; 2]; 2]) -> f64 {
    m[0][0] * m[1][1] - m[0][1] * m[1][0]
}

/// x with m x = b, by Cramer's rule.
#[inline]
pub(super) fn solved(m: [[f64; 2]; 2], b: [f64; 2]) -> [f64; 2] {
    let d = determinant(m);
    [(b[0] * m[1][1] - m[0][1] * b[1]) / d, (m[0][0] * b[1] - b[0] * m[1][0]) / d]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Dual;

    const ALL: RadialMap = RadialMap {
        numerator: [-0.31, 0.12, -0.015, 0.002],
        denominator: [0.08, -0.02, 0.004],
        tangential: [0.0012, -0.0007],
        prism: [0.0004, -0.0003, -0.0006, 0.0002],
    };

    #[test]
    fn the_jacobian_is_that_of_dual_numbers() {
        for k in 0..400 {
            let w = [0.11 * f64::from(k % 20) - 1.0, 0.1 * f64::from(k / 20) - 0.95];
            let jacobian = ALL.jacobian(w);
            let image = ALL.image([Dual::<2>::variable(w[0], 0), Dual::variable(w[1], 1)]);
            for (row, dual) in jacobian.iter().zip(image) {
                for (found, exact) in row.iter().zip(dual.slope) {
                    assert!((found - exact).abs() < 1e-14 * (1.0 + exact.abs()), "{w:?}");
                }
            }
        }
    }

    #[test]
    fn a_solved_system_is_solved() {
        let m = [[2.0, -1.0], [0.5, 3.0]];
        let [x, y] = solved(m, [3.0, 4.0]);
        assert!((2.0 * x - y - 3.0).abs() < 1e-15 && (0.5 * x + 3.0 * y - 4.0).abs() < 1e-15);
        assert_eq!(determinant(m), 6.5);
    }
}
