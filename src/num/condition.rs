//! Condition numbers of least-squares problems, from their triangle R.

use super::sin;
use super::streaming_qr::{StreamingQr, dot};
use nalgebra::{DMatrix, DVector};

/// Unknowns up to which all singular values are computed.
const SMALL: usize = 200;

/// Lengths of the matrix' columns.
#[must_use]
pub fn column_norms(qr: &StreamingQr) -> Vec<f64> {
    (0..qr.unknowns()).map(|k| f64::sqrt(dot(qr.column(k), qr.column(k)))).collect()
}

/// Condition number (2-norm) of R with its columns scaled to unit length.
#[must_use]
pub fn condition_number(qr: &StreamingQr) -> f64 {
    if qr.unknowns() > SMALL {
        return condition_by_powers(qr);
    }
    let columns: Vec<DVector<f64>> = (0..qr.unknowns())
        .map(|k| DVector::from_column_slice(qr.column(k)).normalize())
        .map(|c| c.resize_vertically(qr.unknowns(), 0.0))
        .collect();
    let singular = DMatrix::from_columns(&columns).singular_values();
    singular.max() / singular.min()
}

/// The same by powers of R^T R and of its inverse, R scaled: to a few per mille.
fn condition_by_powers(qr: &StreamingQr) -> f64 {
    let lengths = column_norms(qr);
    let divide = |x: &mut [f64]| x.iter_mut().zip(&lengths).for_each(|(x, l)| *x /= l);
    let multiply = |x: &mut [f64]| x.iter_mut().zip(&lengths).for_each(|(x, l)| *x *= l);
    let largest = dominant(qr.unknowns(), |x| {
        divide(x);
        qr.times(x);
        qr.times_transposed(x);
        divide(x);
    });
    let inverse = dominant(qr.unknowns(), |x| {
        multiply(x);
        qr.forward(x);
        qr.back(x);
        multiply(x);
    });
    f64::sqrt(largest * inverse)
}

/// The largest eigenvalue of a positive operator, by the power method: to a few per mille.
fn dominant(n: usize, mut operator: impl FnMut(&mut [f64])) -> f64 {
    let mut x: Vec<f64> = (0..n).map(|k| 1.0 + 0.3 * sin(k as f64)).collect();
    let mut value = 0.0;
    for _ in 0..200 {
        let length = f64::sqrt(dot(&x, &x));
        x.iter_mut().for_each(|x| *x /= length);
        operator(&mut x);
        let next = f64::sqrt(dot(&x, &x));
        if (next - value).abs() <= 1e-5 * next {
            return next;
        }
        value = next;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::super::streaming_qr::RowBlock;
    use super::*;

    #[test]
    fn both_ways_agree_with_the_hilbert_matrix() {
        // Columns 1/(i + j + 1), scaled to unit length; by numpy's SVD.
        let mut rows = RowBlock::zeros(5, 5);
        for i in 0..5 {
            rows.set(i, (0..5).map(|j| 1.0 / (i + j + 1) as f64), 0.0);
        }
        let mut qr = StreamingQr::new(5);
        qr.absorb(rows);
        let exact = 292433.24305300246;
        assert!((condition_number(&qr) / exact - 1.0).abs() < 1e-9, "{}", condition_number(&qr));
        assert!((condition_by_powers(&qr) / exact - 1.0).abs() < 0.01);
    }
}
