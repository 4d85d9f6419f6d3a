//! Ranges of a Legendre series over the cells of a grid, by Bernstein coefficients.
//!
//! On a cell, a polynomial written in Bernstein form lies between its least and largest
//! coefficient, and those close in on the true range with the square of the cell's size.

use super::legendre::Series;

/// Rounding of the conversion and of an evaluation, as a share of the sum of the terms' sizes.
const ROUNDING: f64 = 1e-13;

/// [least, largest] of `series` over each cell of the grid with the given edges (ascending, in
/// [-1, 1] but for rounding), row by row in v.
#[must_use]
pub fn ranges(series: &Series, u_edges: &[f64], v_edges: &[f64]) -> Vec<[f64; 2]> {
    let series = series.trimmed();
    let (rows, columns) = series.shape();
    let along_u = conversions(rows, u_edges);
    let mut found = Vec::with_capacity(along_u.len() * v_edges.len());
    let mut both = vec![0.0; rows * columns];
    for to_v in conversions(columns, v_edges) {
        // half[i][b]: Bernstein in v, still Legendre in u.
        let mut half = vec![0.0; rows * columns];
        for (i, row) in half.chunks_exact_mut(columns).enumerate() {
            for j in 0..columns {
                add_scaled(row, &to_v[j * columns..(j + 1) * columns], series.coefficient(i, j));
            }
        }
        let size = |row: &[f64]| row.iter().fold(0.0f64, |most, c| most.max(c.abs()));
        let largest: Vec<f64> = half.chunks_exact(columns).map(size).collect();
        // Of an even function, and of an odd one, half of the degrees are missing.
        let present: Vec<usize> = (0..rows).filter(|&i| largest[i] != 0.0).collect();
        for to_u in &along_u {
            let mut terms = 0.0f64;
            both.fill(0.0);
            for &i in &present {
                let from = &half[i * columns..(i + 1) * columns];
                let shares = &to_u[i * rows..(i + 1) * rows];
                let most = shares.iter().fold(0.0f64, |most, share| most.max(share.abs()));
                terms = terms.max(most * largest[i]);
                if let [from] = *from {
                    add_scaled(&mut both, shares, from);
                } else {
                    let lines = both.chunks_exact_mut(columns).zip(shares);
                    lines.for_each(|(line, &share)| add_scaled(line, from, share));
                }
            }
            let none = [f64::INFINITY, f64::NEG_INFINITY];
            let range = both.iter().fold(none, |[lo, hi], &c| [lo.min(c), hi.max(c)]);
            let slack = ROUNDING * terms * rows as f64;
            found.push([range[0] - slack, range[1] + slack]);
        }
    }
    found
}

fn add_scaled(to: &mut [f64], from: &[f64], factor: f64) {
    for (t, f) in to.iter_mut().zip(from) {
        *t += factor * f;
    }
}

/// Cells that are converted side by side: the same steps for all, several in one instruction.
const LANES: usize = 8;

/// One number for each of these cells.
type Lanes = [f64; LANES];

/// Turns the `length` Bernstein coefficients at the head of `p` into those of one degree more.
fn elevate(p: &mut [Lanes], length: usize) {
    let share = 1.0 / length as f64;
    p[length] = p[length - 1];
    for i in (1..length).rev() {
        let left = i as f64 * share;
        let before = p[i - 1];
        for (p, before) in p[i].iter_mut().zip(before) {
            *p = (1.0 - left) * *p + left * before;
        }
    }
}

/// For each cell between neighbours of `edges` Bernstein coefficients, all of degree `count` - 1, of P_0 ...
/// P_{count-1}: entry [k * count + i] is the i-th coefficient of P_k.
fn conversions(count: usize, edges: &[f64]) -> Vec<Vec<f64>> {
    let cells: Vec<&[f64]> = edges.windows(2).collect();
    let mut found = Vec::with_capacity(cells.len());
    for some in cells.chunks(LANES) {
        let ends = |end: usize| std::array::from_fn(|lane| some[lane.min(some.len() - 1)][end]);
        let table = conversion(count, ends(0), ends(1));
        found.extend((0..some.len()).map(|lane| table.iter().map(|at| at[lane]).collect()));
    }
    found
}

/// The same for the cells from `lo` to `hi`. Every step is a convex combination but for the recurrence itself.
fn conversion(count: usize, lo: Lanes, hi: Lanes) -> Vec<Lanes> {
    let mut table = vec![[0.0; LANES]; count * count];
    table[0] = [1.0; LANES];
    let mut older = vec![[0.0; LANES]; count];
    for k in 1..count {
        let (done, now) = table.split_at_mut(k * count);
        if k > 1 {
            older.copy_from_slice(&done[(k - 2) * count..(k - 1) * count]);
            elevate(&mut older, k - 1);
            elevate(&mut older, k);
        }
        let last = &done[(k - 1) * count..];
        // x P_{k-1}, of one degree more.
        let (n, m, degree) = ((2 * k - 1) as f64, (k - 1) as f64, k as f64);
        for i in 0..=k {
            let at = i as f64;
            let (own, before) = (last[i], if i > 0 { last[i - 1] } else { [0.0; LANES] });
            for lane in 0..LANES {
                let left = if i < k { (degree - at) * lo[lane] * own[lane] } else { 0.0 };
                let right = if i > 0 { at * hi[lane] * before[lane] } else { 0.0 };
                now[i][lane] = (n * ((left + right) / degree) - m * older[i][lane]) / degree;
            }
        }
    }
    for (k, p) in table.chunks_exact_mut(count).enumerate() {
        (k + 1..count).for_each(|length| elevate(p, length));
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_every_sample_and_close_in_on_it() {
        let series = Series::from_fn(13, 10, |i, j| {
            ((7 * i + 3 * j) % 11) as f64 / 5.0 - 1.0 + if i + j == 0 { 3.0 } else { 0.0 }
        });
        let edges = |n: u32| -> Vec<f64> {
            (0..=n).map(|k| 2.0 * f64::from(k) / f64::from(n) - 1.0).collect()
        };
        let mut excess = Vec::new();
        for cells in [16, 64] {
            let (u, v) = (edges(cells), edges(cells));
            let found = ranges(&series, &u, &v);
            let n = cells as usize;
            let mut worst: f64 = 0.0;
            for (k, range) in found.iter().enumerate() {
                let (i, j) = (k % n, k / n);
                let mut sampled = [f64::INFINITY, f64::NEG_INFINITY];
                for a in 0..=8 {
                    for b in 0..=8 {
                        let at = |edge: &[f64], k: usize, t: i32| {
                            edge[k] + (edge[k + 1] - edge[k]) * f64::from(t) / 8.0
                        };
                        let f = series.row(at(&v, j, b)).gradient(at(&u, i, a)).f;
                        assert!(range[0] <= f && f <= range[1]);
                        sampled = [sampled[0].min(f), sampled[1].max(f)];
                    }
                }
                worst = worst.max(range[1] - sampled[1]).max(sampled[0] - range[0]);
            }
            excess.push(worst);
        }
        // Second order: a quarter of the size, a sixteenth of the excess (sampling spoils some).
        assert!(excess[1] < excess[0] / 8.0, "{excess:?}");
    }

    #[test]
    fn cells_side_by_side_get_what_each_gets_alone() {
        let edges: Vec<f64> = (0..12).map(|k| f64::from(k * k) / 60.0 - 1.0).collect();
        let all = conversions(7, &edges);
        let alone: Vec<Vec<f64>> = edges.windows(2).flat_map(|cell| conversions(7, cell)).collect();
        assert_eq!((all.len(), &all), (11, &alone));
        assert!(all[0] != all[1] && all[7] != all[8]);
    }
}
