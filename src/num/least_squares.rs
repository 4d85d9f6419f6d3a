//! Linear least squares by Householder QR.

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

/// The minimiser of |A x - b|.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The unknowns x.
    pub x: Vec<f64>,
    /// |A x - b|^2, from the part of b outside the range of A: no cancellation.
    pub residual_squared: f64,
}

/// The columns of A are dependent to working precision.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("least squares: unknown {column} is not determined (pivot {pivot:e} of {largest:e})")]
pub struct RankDeficient {
    /// Index of the first undetermined unknown.
    pub column: usize,
    /// Its diagonal entry in R.
    pub pivot: f64,
    /// The largest diagonal entry in R.
    pub largest: f64,
}

/// Minimises |A x - b| for a tall A by QR; the normal equations, which square the condition
/// number, are never formed.
///
/// # Errors
/// [`RankDeficient`] when a pivot falls below 1e-13 of the largest.
pub fn solve(a: DMatrix<f64>, b: DVector<f64>) -> Result<Solution, RankDeficient> {
    let unknowns = a.ncols();
    let qr = a.qr();
    let mut projected = b;
    qr.q_tr_mul(&mut projected);
    let r = qr.unpack_r();
    let largest = (0..unknowns).map(|k| r[(k, k)].abs()).fold(0.0, f64::max);
    if let Some(column) = (0..unknowns).find(|&k| r[(k, k)].abs() <= 1e-13 * largest) {
        return Err(RankDeficient { column, pivot: r[(column, column)], largest });
    }
    let mut x = vec![0.0; unknowns];
    for row in (0..unknowns).rev() {
        let known: f64 = (row + 1..unknowns).map(|k| r[(row, k)] * x[k]).sum();
        x[row] = (projected[row] - known) / r[(row, row)];
    }
    let residual_squared = projected.iter().skip(unknowns).map(|t| t * t).sum();
    Ok(Solution { x, residual_squared })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_a_line_and_reports_what_is_left() {
        // y = 1 + 2 t + alternating 1: residual 4 for an orthogonal disturbance.
        let t = [-1.5, -0.5, 0.5, 1.5];
        let disturbance = [1.0, -1.0, -1.0, 1.0];
        let a = DMatrix::from_fn(4, 2, |i, j| if j == 0 { 1.0 } else { t[i] });
        let b = DVector::from_fn(4, |i, _| 1.0 + 2.0 * t[i] + disturbance[i]);
        let solution = solve(a, b).unwrap();
        assert!((solution.x[0] - 1.0).abs() < 1e-15);
        assert!((solution.x[1] - 2.0).abs() < 1e-15);
        assert!((solution.residual_squared - 4.0).abs() < 1e-14);
    }

    #[test]
    fn names_a_dependent_column() {
        let a = DMatrix::from_fn(5, 3, |i, j| [1.0, i as f64, 2.0 * i as f64][j]);
        assert_eq!(solve(a, DVector::zeros(5)).unwrap_err().column, 2);
    }
}
