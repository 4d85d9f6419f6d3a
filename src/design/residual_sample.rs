//! Residuals of a mirror, point by point, and their linear least squares.

use super::basis::{Basis, LocalValues, variables};
use crate::geom::DVec2;
use crate::num::Scalar;
use crate::num::streaming_qr::{RowBlock, StreamingQr};
use crate::parallel;

/// Places whose rows enter the QR together.
const BLOCK: usize = 96;

/// Difference of a mirror F(q) from what is wanted, at one image point.
pub(super) trait PointwiseResidual<const N: usize>: Sync {
    /// The residual at `q` (mm) of a mirror that has there the value `f` (mm) and the slopes dF/dx
    /// and dF/dy.
    fn at<S: Scalar>(&self, q: DVec2, f: S, slope: [S; 2]) -> [S; N];
}

/// Residual at one place, linearised: with its derivatives by F, dF/dx and dF/dy.
#[derive(Debug, Clone, Copy)]
pub(super) struct ResidualSample<const N: usize> {
    /// r.
    pub r: [f64; N],
    /// Derivatives of each component.
    pub by: [LocalValues; N],
}

impl<const N: usize> ResidualSample<N> {
    /// The residual of a mirror with the given local values at `q`.
    pub(super) fn new(residual: &impl PointwiseResidual<N>, q: DVec2, local: LocalValues) -> Self {
        let (f, slope) = variables(local);
        let r = residual.at(q, f, slope);
        Self { r: r.map(|r| r.value), by: r.map(|r| r.slope) }
    }

    /// The residual at every place.
    pub(super) fn all(
        basis: &Basis,
        residual: &impl PointwiseResidual<N>,
        locals: &[LocalValues],
    ) -> Vec<Self> {
        let at = |k: usize| Self::new(residual, basis.at(k), locals[k]);
        parallel::map(locals.len(), BLOCK, at)
    }

    /// |r|^2.
    pub(super) fn square(&self) -> f64 {
        self.r.iter().map(|r| r * r).sum()
    }

    /// The residual after a change of the local values, were it linear in them.
    pub(super) fn after(&self, change: &LocalValues) -> [f64; N] {
        std::array::from_fn(|k| {
            let [f, x, y] = self.by[k];
            self.r[k] + f * change[0] + x * change[1] + y * change[2]
        })
    }

    /// At most three rows (derivatives; right side) with the same least squares.
    fn rows(&self) -> ([[f64; 4]; N], usize) {
        let mut rows: [[f64; 4]; N] = std::array::from_fn(|k| {
            let [f, x, y] = self.by[k];
            [f, x, y, -self.r[k]]
        });
        if N <= 2 {
            return (rows, N);
        }
        let mut used = 0;
        for column in 0..3 {
            for k in used + 1..N {
                let (a, b) = (rows[used][column], rows[k][column]);
                if b != 0.0 {
                    let length = f64::sqrt(a * a + b * b);
                    let (cos, sin) = (a / length, b / length);
                    let (upper, lower) = rows.split_at_mut(k);
                    for (a, b) in upper[used].iter_mut().zip(&mut lower[0]) {
                        (*a, *b) = (cos * *a + sin * *b, cos * *b - sin * *a);
                    }
                    rows[k][column] = 0.0;
                }
            }
            if used < N && rows[used][column] != 0.0 {
                used += 1;
            }
        }
        (rows, used)
    }
}

/// Largest magnitude of the terms that cancel in the residual: its rounding error is in proportion.
pub(super) fn magnitude_of_terms<const N: usize>(
    samples: &[ResidualSample<N>],
    locals: &[LocalValues],
) -> f64 {
    let term = |(s, l): (&ResidualSample<N>, &LocalValues)| {
        s.by.iter().flat_map(|by| by.iter().zip(l)).map(|(b, l)| (b * l).abs()).sum::<f64>()
    };
    samples.iter().zip(locals).map(term).fold(0.0, f64::max)
}

/// Whether the residual changed as its derivatives foretold, to rounding: then the problem is linear.
pub(super) fn is_linear<const N: usize>(
    before: &[ResidualSample<N>],
    change: &[LocalValues],
    after: &[ResidualSample<N>],
) -> bool {
    let (mut gap, mut went) = (0.0f64, 0.0f64);
    for ((s, d), then) in before.iter().zip(change).zip(after) {
        for ((expected, was), is) in s.after(d).iter().zip(s.r).zip(then.r) {
            gap = gap.max((expected - is).abs());
            went = went.max((expected - was).abs());
        }
    }
    gap <= 1e-13 * went
}

/// Minus the gradient of half the integral of |r|^2 over the coefficients: A^T b of the rows of [`linearised`].
pub(super) fn descent<const N: usize>(basis: &Basis, samples: &[ResidualSample<N>]) -> Vec<f64> {
    let part = |samples: &[(usize, &ResidualSample<N>)]| {
        let mut sum = vec![0.0; basis.unknowns()];
        for &(place, sample) in samples {
            let weight = basis.weight(place);
            let mut by = [0.0; 3];
            for (of, r) in sample.by.iter().zip(sample.r) {
                by.iter_mut().zip(of).for_each(|(by, of)| *by -= weight * r * of);
            }
            let [f, x, y] = by;
            for (sum, [b, b_x, b_y]) in sum.iter_mut().zip(basis.row(place)) {
                *sum += f * b + x * b_x + y * b_y;
            }
        }
        sum
    };
    let numbered: Vec<_> = samples.iter().enumerate().collect();
    let mut sums = parallel::map_chunks(&numbered, BLOCK, part).into_iter();
    let first = sums.next().unwrap_or_else(|| vec![0.0; basis.unknowns()]);
    sums.fold(first, |mut all, part| {
        all.iter_mut().zip(part).for_each(|(all, part)| *all += part);
        all
    })
}

/// The triangle of the linearised problem of the samples, each of (place, weight, residual).
pub(super) fn linearised<const N: usize>(
    basis: &Basis,
    samples: &[(usize, f64, ResidualSample<N>)],
) -> StreamingQr {
    let mut qr = StreamingQr::new(basis.unknowns());
    for part in samples.chunks(BLOCK) {
        let condensed: Vec<_> = part.iter().map(|s| s.2.rows()).collect();
        let mut rows = RowBlock::zeros(condensed.iter().map(|c| c.1).sum(), basis.unknowns());
        let mut row = 0;
        for (&(place, weight, _), (local, used)) in part.iter().zip(&condensed) {
            let root = f64::sqrt(weight);
            for &[f, x, y, b] in &local[..*used] {
                let [f, x, y] = [root * f, root * x, root * y];
                let a = basis.row(place).map(|[b, b_x, b_y]| f * b + x * b_x + y * b_y);
                rows.set(row, a, root * b);
                row += 1;
            }
        }
        qr.absorb(rows);
    }
    qr
}
