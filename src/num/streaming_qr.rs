//! Householder QR of a tall matrix that arrives a block of rows at a time: least squares in the
//! memory of the triangle, with the same bits for any number of threads.

use super::least_squares::RankDeficient;
use crate::parallel;

/// Reflections made before they are applied to the columns to their right.
const PANEL: usize = 16;
/// Below this many entries to update the threads cost more than they bring.
const WORTH_THREADS: usize = 1 << 16;

/// Triangle R of the rows so far, the projected right side, and the norm of the residual.
#[derive(Debug, Clone)]
pub struct StreamingQr {
    unknowns: usize,
    /// Columns 0 ..= unknowns (the last is the right side), each of `unknowns` entries.
    r: Vec<f64>,
    left: f64,
}

/// Rows of A and b, stored by columns; the last column is b.
#[derive(Debug, Clone)]
pub struct RowBlock {
    count: usize,
    entries: Vec<f64>,
}

impl RowBlock {
    /// `count` rows of zeros for `unknowns` unknowns.
    #[must_use]
    pub fn zeros(count: usize, unknowns: usize) -> Self {
        Self { count, entries: vec![0.0; count * (unknowns + 1)] }
    }

    /// Sets a row of A and its right side.
    pub fn set(&mut self, row: usize, a: impl Iterator<Item = f64>, b: f64) {
        let last = self.entries.len() - self.count;
        for (place, value) in self.entries[row..last].iter_mut().step_by(self.count).zip(a) {
            *place = value;
        }
        self.entries[last + row] = b;
    }
}

impl StreamingQr {
    /// No rows yet.
    #[must_use]
    pub fn new(unknowns: usize) -> Self {
        Self { unknowns, r: vec![0.0; unknowns * (unknowns + 1)], left: 0.0 }
    }

    /// Takes the rows in.
    pub fn absorb(&mut self, rows: RowBlock) {
        let (n, count, mut a) = (self.unknowns, rows.count, rows.entries);
        for first in (0..n).step_by(PANEL) {
            let last = (first + PANEL).min(n);
            let mut scale = [0.0; PANEL];
            for k in first..last {
                let (head, tail) = a.split_at_mut((k + 1) * count);
                let v = &mut head[k * count..];
                let pivot = &mut self.r[k * n + k];
                let squares = dot(v, v);
                if squares == 0.0 {
                    continue;
                }
                let length = f64::sqrt(*pivot * *pivot + squares);
                let target = if *pivot > 0.0 { -length } else { length };
                // Reflector (1, v): v over the head's own entry, which stays 1.
                let lead = *pivot - target;
                scale[k - first] = -lead / target;
                v.iter_mut().for_each(|x| *x /= lead);
                *pivot = target;
                for (j, column) in tail.chunks_exact_mut(count).enumerate().take(last - k - 1) {
                    reflect(v, scale[k - first], &mut self.r[(k + 1 + j) * n + k], column);
                }
            }
            let (head, tail) = a.split_at_mut(last * count);
            let panel = &head[first * count..];
            let update = |_, (column, r): &mut (&mut [f64], &mut [f64])| {
                for (k, v) in panel.chunks_exact(count).enumerate() {
                    if scale[k] != 0.0 {
                        reflect(v, scale[k], &mut r[first + k], column);
                    }
                }
            };
            let triangle = &mut self.r[last * n..];
            let mut columns: Vec<_> =
                tail.chunks_exact_mut(count).zip(triangle.chunks_exact_mut(n)).collect();
            let few = columns.len() * count * PANEL <= WORTH_THREADS * 4;
            parallel::for_each_mut(&mut columns, if few { usize::MAX } else { 8 }, update);
        }
        let b = &a[n * count..];
        self.left += dot(b, b);
    }

    /// Sum of the squares of A x - b at its least.
    #[must_use]
    pub fn residual_squared(&self) -> f64 {
        self.left
    }

    /// Column `k` of R down to its diagonal.
    #[must_use]
    pub fn column(&self, k: usize) -> &[f64] {
        &self.r[k * self.unknowns..k * self.unknowns + k + 1]
    }

    /// The minimiser of |A x - b|.
    ///
    /// # Errors
    /// [`RankDeficient`] when a column has less than 1e-13 of its length off the span of those
    /// before it.
    pub fn solve(&self) -> Result<Vec<f64>, RankDeficient> {
        let n = self.unknowns;
        for k in 0..n {
            let column = self.column(k);
            let (pivot, largest) = (column[k].abs(), f64::sqrt(dot(column, column)));
            if !(pivot > 1e-13 * largest) {
                return Err(RankDeficient { column: k, pivot, largest });
            }
        }
        let mut x = self.r[n * n..].to_vec();
        self.back(&mut x);
        Ok(x)
    }

    /// Number of unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// x <- R x.
    pub fn times(&self, x: &mut [f64]) {
        for k in 0..self.unknowns {
            let (column, by) = (self.column(k), x[k]);
            x[k] = 0.0;
            x.iter_mut().zip(column).for_each(|(x, r)| *x += r * by);
        }
    }

    /// x <- R^T x.
    pub fn times_transposed(&self, x: &mut [f64]) {
        for k in (0..self.unknowns).rev() {
            x[k] = dot(self.column(k), &x[..=k]);
        }
    }

    /// x <- R^-1 x.
    pub fn back(&self, x: &mut [f64]) {
        for k in (0..self.unknowns).rev() {
            let (column, pivot) = (&self.column(k)[..k], self.column(k)[k]);
            x[k] /= pivot;
            let (head, tail) = x.split_at_mut(k);
            head.iter_mut().zip(column).for_each(|(x, r)| *x -= r * tail[0]);
        }
    }

    /// x <- R^-T x.
    pub fn forward(&self, x: &mut [f64]) {
        for k in 0..self.unknowns {
            let column = self.column(k);
            x[k] = (x[k] - dot(&column[..k], &x[..k])) / column[k];
        }
    }
}

/// Applies I - scale (1, v)(1, v)^T to (head, column).
#[inline]
fn reflect(v: &[f64], scale: f64, head: &mut f64, column: &mut [f64]) {
    let w = scale * (*head + dot(v, column));
    *head -= w;
    column.iter_mut().zip(v).for_each(|(c, v)| *c -= w * v);
}

/// Inner product in a fixed order that the compiler can spread over lanes.
#[inline]
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_parts, b_parts) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_parts.remainder().iter().zip(b_parts.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_parts.zip(b_parts) {
        for k in 0..8 {
            lanes[k] += a[k] * b[k];
        }
    }
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + e) + (b + f)) + ((c + g) + (d + h)) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::least_squares;
    use crate::num::sin;
    use nalgebra::{DMatrix, DVector};

    fn entry(i: usize, j: usize) -> f64 {
        sin((1 + 7 * i + 13 * j + i * j) as f64)
    }

    fn taken(rows: usize, unknowns: usize, block: usize) -> StreamingQr {
        let mut qr = StreamingQr::new(unknowns);
        for start in (0..rows).step_by(block) {
            let count = block.min(rows - start);
            let mut part = RowBlock::zeros(count, unknowns);
            for i in 0..count {
                part.set(i, (0..unknowns).map(|j| entry(start + i, j)), entry(start + i, 99));
            }
            qr.absorb(part);
        }
        qr
    }

    #[test]
    fn agrees_with_the_whole_matrix_at_once() {
        for (rows, unknowns) in [(90, 37), (40, 40), (300, 5)] {
            let whole = least_squares::solve(
                DMatrix::from_fn(rows, unknowns, entry),
                DVector::from_fn(rows, |i, _| entry(i, 99)),
            )
            .unwrap();
            for block in [1, 7, 64, 1000] {
                let qr = taken(rows, unknowns, block);
                let x = qr.solve().unwrap();
                for (a, b) in x.iter().zip(&whole.x) {
                    assert!((a - b).abs() < 1e-10 * (1.0 + b.abs()), "{rows} x {unknowns}");
                }
                assert!((qr.residual_squared() - whole.residual_squared).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn triangle_solves_both_ways() {
        let qr = taken(60, 20, 16);
        let mut x: Vec<f64> = (0..20).map(|k| entry(k, 3)).collect();
        let before = x.clone();
        qr.back(&mut x);
        let again: Vec<f64> =
            (0..20).map(|i| (i..20).map(|j| qr.column(j)[i] * x[j]).sum::<f64>()).collect();
        qr.times(&mut x);
        let mut y = before.clone();
        qr.forward(&mut y);
        qr.times_transposed(&mut y);
        for k in 0..20 {
            for found in [again[k], x[k], y[k]] {
                assert!((found - before[k]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn names_a_dependent_column_whatever_its_scale() {
        let mut qr = StreamingQr::new(3);
        let mut rows = RowBlock::zeros(5, 3);
        for i in 0..5 {
            let t = i as f64;
            rows.set(i, [1e9, 1e-9 * t, 2.0 * t].into_iter(), 1.0);
        }
        qr.absorb(rows);
        assert_eq!(qr.solve().unwrap_err().column, 2);
    }
}
