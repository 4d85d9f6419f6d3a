//! Values on a grid where some are missing: those of least bending through the given ones.
//!
//! The sum of the squared second differences along the rows, down the columns and, twice, across both is least:
//! the thin plate's energy with free edges, so that what is missing goes on with the slope of what is given. It is
//! found value by value (Gauss and Seidel) from coarse grids to fine ones.

/// Values along the shorter side of the coarsest grid, at the least.
const COARSEST: usize = 8;
/// Sweeps over the coarsest grid, from nothing known.
const FIRST_SWEEPS: usize = 5000;
/// Sweeps over each finer one: they mend what the coarser one could not have.
const SWEEPS: usize = 60;

/// Second differences that value 0 has a part in: offsets along and across with their factors, value 0 last, and the
/// weight of the square.
type Difference = (&'static [(isize, isize, f64)], f64, f64);

const DIFFERENCES: [Difference; 10] = [
    (&[(1, 0, -2.0), (2, 0, 1.0)], 1.0, 1.0),
    (&[(-1, 0, 1.0), (1, 0, 1.0)], -2.0, 1.0),
    (&[(-2, 0, 1.0), (-1, 0, -2.0)], 1.0, 1.0),
    (&[(0, 1, -2.0), (0, 2, 1.0)], 1.0, 1.0),
    (&[(0, -1, 1.0), (0, 1, 1.0)], -2.0, 1.0),
    (&[(0, -2, 1.0), (0, -1, -2.0)], 1.0, 1.0),
    (&[(1, 0, -1.0), (0, 1, -1.0), (1, 1, 1.0)], 1.0, 2.0),
    (&[(-1, 0, -1.0), (0, 1, -1.0), (-1, 1, 1.0)], 1.0, 2.0),
    (&[(1, 0, -1.0), (0, -1, -1.0), (1, -1, 1.0)], 1.0, 2.0),
    (&[(-1, 0, -1.0), (0, -1, -1.0), (-1, -1, 1.0)], 1.0, 2.0),
];

/// Fills the missing ones (not a number) of `values`, row after row of so many `columns`; all stay missing where none
/// is given.
pub fn fill(values: &mut [f64], columns: usize) {
    let missing: Vec<bool> = values.iter().map(|v| v.is_nan()).collect();
    if !missing.contains(&true) || !missing.contains(&false) {
        return;
    }
    let rows = values.len() / columns;
    let coarsest = columns.min(rows) < 2 * COARSEST;
    if coarsest {
        start_with_mean(values);
    } else {
        let (mut coarse, width) = halved(values, columns);
        fill(&mut coarse, width);
        let at = |k: usize| between(&coarse, width, k % columns, k / columns);
        for k in (0..values.len()).filter(|&k| missing[k]) {
            values[k] = at(k);
        }
        // (Of every second value none may be given.)
        start_with_mean(values);
    }
    let unknown: Vec<usize> = (0..values.len()).filter(|&k| missing[k]).collect();
    for _ in 0..if coarsest { FIRST_SWEEPS } else { SWEEPS } {
        for &k in &unknown {
            values[k] = relaxed(values, [columns, rows], k);
        }
    }
}

/// Puts the mean of the given values where they are missing.
fn start_with_mean(values: &mut [f64]) {
    let given = values.iter().filter(|v| !v.is_nan());
    let (sum, count) = given.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    values.iter_mut().filter(|v| v.is_nan()).for_each(|value| *value = sum / count);
}

/// The value that bends least between its neighbours as they are.
fn relaxed(values: &[f64], [columns, rows]: [usize; 2], k: usize) -> f64 {
    let (i, j) = ((k % columns) as isize, (k / columns) as isize);
    let (mut pull, mut stiffness) = (0.0, 0.0);
    'differences: for (others, own, weight) in DIFFERENCES {
        let mut rest = 0.0;
        for &(along, across, factor) in others {
            let (i, j) = (i + along, j + across);
            if i < 0 || j < 0 || i >= columns as isize || j >= rows as isize {
                continue 'differences;
            }
            rest += factor * values[j as usize * columns + i as usize];
        }
        pull += weight * own * rest;
        stiffness += weight * own * own;
    }
    -pull / stiffness
}

/// Every second value along and across, and their number of columns.
fn halved(values: &[f64], columns: usize) -> (Vec<f64>, usize) {
    let rows = values.len() / columns;
    let (width, height) = (columns.div_ceil(2), rows.div_ceil(2));
    let value = |k: usize| values[2 * (k / width) * columns + 2 * (k % width)];
    ((0..width * height).map(value).collect(), width)
}

/// The bilinear value between every second one at a place of the whole grid.
fn between(coarse: &[f64], width: usize, i: usize, j: usize) -> f64 {
    let height = coarse.len() / width;
    let place = |k: usize, count: usize| {
        let first = (k / 2).min(count - 2);
        (first, 0.5 * k as f64 - first as f64)
    };
    let ((i, s), (j, t)) = (place(i, width), place(j, height));
    let row = |j: usize| {
        let [a, b] = [coarse[j * width + i], coarse[j * width + i + 1]];
        a + s * (b - a)
    };
    row(j) + t * (row(j + 1) - row(j))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holes(columns: usize, rows: usize, f: impl Fn(f64, f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let place = |k: usize| {
            [(k % columns) as f64 / columns as f64, (k / columns) as f64 / columns as f64]
        };
        let all: Vec<f64> = (0..columns * rows)
            .map(|k| {
                let [x, y] = place(k);
                f(x, y)
            })
            .collect();
        let mut values = all.clone();
        for (k, value) in values.iter_mut().enumerate() {
            let [x, y] = place(k);
            let in_hole = crate::num::hypot(x - 0.4, y - 0.3) < 0.12;
            if in_hole || x + y < 0.2 || x > 0.95 {
                *value = f64::NAN;
            }
        }
        (values, all)
    }

    #[test]
    fn planes_are_given_back() {
        for [columns, rows] in [[9, 11], [64, 48], [101, 77]] {
            let (mut values, all) = holes(columns, rows, |x, y| 2.0 - 3.0 * x + 0.7 * y);
            fill(&mut values, columns);
            let off = values.iter().zip(&all).fold(0.0f64, |off, (a, b)| off.max((a - b).abs()));
            assert!(off < 2e-3, "{columns} x {rows}: {off}");
        }
    }

    /// The slope goes on: what is filled in leaves the given values by less than a bent picture asks.
    #[test]
    fn what_is_filled_in_joins_smoothly() {
        let bent = |x: f64, y: f64| (x - 0.3) * (x - 0.3) - 0.5 * x * y + y * y;
        let (mut values, all) = holes(160, 120, bent);
        let given: Vec<bool> = values.iter().map(|v| !v.is_nan()).collect();
        fill(&mut values, 160);
        for k in 0..values.len() {
            assert!(!given[k] || values[k] == all[k]);
            let (i, j) = (k % 160, k / 160);
            if i == 0 || i == 159 || j == 0 || j == 119 {
                continue;
            }
            let second = |step: usize| values[k - step] - 2.0 * values[k] + values[k + step];
            // Of the function they are 8e-5.
            assert!(second(1).abs() < 4e-4 && second(160).abs() < 4e-4, "{i} {j}");
        }
    }

    #[test]
    fn nothing_comes_of_nothing() {
        let mut values = vec![f64::NAN; 30];
        fill(&mut values, 6);
        assert!(values.iter().all(|v| v.is_nan()));
    }
}
