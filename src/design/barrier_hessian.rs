//! Linear algebra of the minimax search: the curvature of its barrier, in blocks of four columns.

use super::basis::LocalValues;
use crate::num::streaming_qr::dot;
use crate::parallel;

/// Columns of a block.
const LANES: usize = 4;

/// Derivatives of F, dF/dx and dF/dy at some places by the unknowns, four unknowns to a block:
/// block -> place -> (f, x, y) -> unknown.
#[derive(Debug, Clone)]
pub(super) struct ColumnBlocks {
    unknowns: usize,
    blocks: Vec<Vec<[[f64; LANES]; 3]>>,
}

/// A symmetric 3 x 3 curvature in (f, x, y) at one place, as the lower triangle L of L L^T.
pub(super) type CholeskyRoot = [[f64; 3]; 3];

impl ColumnBlocks {
    /// No places yet.
    pub(super) fn new(unknowns: usize) -> Self {
        Self { unknowns, blocks: vec![Vec::new(); unknowns.div_ceil(LANES)] }
    }

    /// Adds places, each by its three rows.
    pub(super) fn extend(&mut self, places: &[[Vec<f64>; 3]]) {
        parallel::for_each_mut(&mut self.blocks, 1, |p, block| {
            let entry = |row: &[f64], k: usize| row.get(p * LANES + k).copied().unwrap_or(0.0);
            block.extend(places.iter().map(|rows| -> [[f64; LANES]; 3] {
                std::array::from_fn(|c| std::array::from_fn(|k| entry(&rows[c], k)))
            }));
        });
    }

    /// Change of the local values at every place for a change of the unknowns.
    pub(super) fn apply(&self, x: &[f64]) -> Vec<LocalValues> {
        let mut locals = vec![[0.0; 3]; self.blocks[0].len()];
        for (block, x) in self.blocks.iter().zip(x.chunks(LANES)) {
            let mut by = [0.0; LANES];
            by[..x.len()].copy_from_slice(x);
            for (local, rows) in locals.iter_mut().zip(block) {
                for (l, row) in local.iter_mut().zip(rows) {
                    *l += (row[0] * by[0] + row[2] * by[2]) + (row[1] * by[1] + row[3] * by[3]);
                }
            }
        }
        locals
    }

    /// Sum over the places of a slope in (f, x, y), carried back to the unknowns.
    pub(super) fn gather(&self, slopes: &[LocalValues]) -> Vec<f64> {
        let sums = parallel::map_slice(&self.blocks, 1, |block| {
            let mut lanes = [0.0; LANES];
            for (rows, slope) in block.iter().zip(slopes) {
                for (k, lane) in lanes.iter_mut().enumerate() {
                    *lane += rows[0][k] * slope[0] + rows[1][k] * slope[1] + rows[2][k] * slope[2];
                }
            }
            lanes
        });
        let mut sum = sums.concat();
        sum.truncate(self.unknowns);
        sum
    }

    /// Sum over the places of the curvatures, carried back to the unknowns: a matrix, of which
    /// the lower triangle is set.
    pub(super) fn curvature(&self, roots: &[CholeskyRoot]) -> Vec<Vec<f64>> {
        // Where nothing depends on F itself two rows a place suffice.
        let first = usize::from(roots.iter().all(|l| l.iter().all(|row| row[0] == 0.0)));
        let weighted = parallel::map_slice(&self.blocks, 1, |block| {
            let mut rows = Vec::with_capacity(block.len() * (3 - first));
            for (d, l) in block.iter().zip(roots) {
                rows.extend((first..3).map(|q| -> [f64; LANES] {
                    std::array::from_fn(|k| {
                        l[0][q] * d[0][k] + l[1][q] * d[1][k] + l[2][q] * d[2][k]
                    })
                }));
            }
            rows
        });
        let mut matrix: Vec<Vec<f64>> = (0..self.unknowns).map(|i| vec![0.0; i + 1]).collect();
        parallel::map_chunks_mut(&mut matrix, LANES, |p, block| {
            for q in 0..=p {
                let tile = product(&weighted[p], &weighted[q]);
                for (row, tile) in block.iter_mut().zip(tile) {
                    let here = &mut row[q * LANES..];
                    let count = here.len().min(LANES);
                    here[..count].copy_from_slice(&tile[..count]);
                }
            }
        });
        matrix
    }
}

/// A^T B of two blocks.
fn product(a: &[[f64; LANES]], b: &[[f64; LANES]]) -> [[f64; LANES]; LANES] {
    let mut tile = [[0.0; LANES]; LANES];
    for (a, b) in a.iter().zip(b) {
        for i in 0..LANES {
            for j in 0..LANES {
                tile[i][j] += a[i] * b[j];
            }
        }
    }
    tile
}

/// The Cholesky factor of a matrix given by its lower triangle; directions without curvature (to
/// rounding) are held still.
#[derive(Debug, Clone)]
pub(super) struct Cholesky(Vec<Vec<f64>>);

impl Cholesky {
    /// Factors the matrix.
    pub(super) fn new(mut l: Vec<Vec<f64>>) -> Self {
        for i in 0..l.len() {
            let (above, rest) = l.split_at_mut(i);
            let row = &mut rest[0];
            for (j, other) in above.iter().enumerate() {
                row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
            }
            let own = row[i];
            let pivot = own - dot(&row[..i], &row[..i]);
            row[i] = if pivot > 1e-15 * own { f64::sqrt(pivot) } else { f64::INFINITY };
        }
        Self(l)
    }

    /// x <- A^-1 x.
    pub(super) fn solve(&self, x: &mut [f64]) {
        let l = &self.0;
        for i in 0..x.len() {
            x[i] = (x[i] - dot(&l[i][..i], &x[..i])) / l[i][i];
        }
        for i in (0..x.len()).rev() {
            x[i] /= l[i][i];
            let (head, tail) = x.split_at_mut(i);
            head.iter_mut().zip(&l[i]).for_each(|(x, l)| *x -= l * tail[0]);
        }
    }
}

/// L of a 3 x 3 semidefinite matrix; rows without curvature are zero.
pub(super) fn root(m: [[f64; 3]; 3]) -> CholeskyRoot {
    let mut l = [[0.0; 3]; 3];
    for j in 0..3 {
        let pivot = m[j][j] - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
        if !(pivot > 1e-15 * m[j][j]) {
            continue;
        }
        l[j][j] = f64::sqrt(pivot);
        for i in j + 1..3 {
            l[i][j] = (m[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>()) / l[j][j];
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sin;

    #[test]
    fn panels_agree_with_plain_sums() {
        let n = 6;
        let entry =
            |place: usize, c: usize, k: usize| sin(((place * 31 + c * 7 + 1) * (k + 2)) as f64);
        let mut blocks = ColumnBlocks::new(n);
        let rows =
            |place: usize| std::array::from_fn(|c| (0..n).map(|k| entry(place, c, k)).collect());
        blocks.extend(&(0..9).map(rows).collect::<Vec<_>>());
        let m = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 2.0]];
        let roots = vec![root(m); 9];
        let curvature = blocks.curvature(&roots);
        for (i, row) in curvature.iter().enumerate() {
            for (j, found) in row.iter().enumerate() {
                let mut exact = 0.0;
                for place in 0..9 {
                    for (c, row) in m.iter().enumerate() {
                        for (d, m) in row.iter().enumerate() {
                            exact += entry(place, c, i) * m * entry(place, d, j);
                        }
                    }
                }
                assert!((found - exact).abs() < 1e-12);
            }
        }
        let x: Vec<f64> = (0..n).map(|k| entry(k, 5, 2)).collect();
        let slopes: Vec<LocalValues> =
            (0..9).map(|k| [entry(k, 1, 9), 0.5, entry(2, k, 1)]).collect();
        let there: f64 = blocks.apply(&x).iter().zip(&slopes).map(|(a, b)| dot(a, b)).sum();
        let back = dot(&blocks.gather(&slopes), &x);
        assert!((there - back).abs() < 1e-12);

        let entry = |i: usize, j: usize| curvature[i.max(j)][i.min(j)];
        let mut y: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(i, j) * x[j]).sum()).collect();
        Cholesky::new(curvature).solve(&mut y);
        for (y, x) in y.iter().zip(&x) {
            assert!((y - x).abs() < 1e-10);
        }
    }
}
