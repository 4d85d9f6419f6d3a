//! Bounds of a sheet's slope, curvature and third derivatives over cells of its panel.
//!
//! Each partial derivative is a polynomial, bounded over a cell by its Bernstein coefficients.

use super::Sheet;
use crate::geom::{DVec2, Rect};
use crate::num::bernstein;

/// Cells per side: fine enough that the bounds are within a few per cent of the local values.
const CELLS: usize = 32;

/// What holds at every point of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellBounds {
    /// Least |slope|.
    pub slope_min: f64,
    /// Largest |slope|.
    pub slope_max: f64,
    /// Largest Hessian norm, 1/mm.
    pub curvature: f64,
    /// Largest norm of the third derivative, 1/mm^2.
    pub third: f64,
}

/// A bound that holds for two regions together.
pub trait Union: Copy {
    /// What holds in both.
    #[must_use]
    fn union(self, other: Self) -> Self;
}

impl Union for CellBounds {
    fn union(self, other: Self) -> Self {
        Self {
            slope_min: self.slope_min.min(other.slope_min),
            slope_max: self.slope_max.max(other.slope_max),
            curvature: self.curvature.max(other.curvature),
            third: self.third.max(other.third),
        }
    }
}

/// One bound for each cell of a panel.
#[derive(Debug, Clone)]
pub struct Cells<T> {
    panel: Rect,
    cell: DVec2,
    values: Vec<T>,
}

impl Cells<CellBounds> {
    /// Bounds of `sheet` over `panel`, which lies inside the sheet's own rectangle.
    #[must_use]
    pub fn new(sheet: &Sheet, panel: Rect) -> Self {
        let cell = panel.size() / CELLS as f64;
        let (lo, step) = ((panel.min - sheet.centre) / sheet.half, cell / sheet.half);
        let edges = |lo: f64, step: f64| -> Vec<f64> {
            (0..=CELLS).map(|k| lo + step * k as f64).collect()
        };
        let (u, v) = (edges(lo.x, step.x), edges(lo.y, step.y));
        let (third, (second, first)) = rayon::join(
            || derivative_ranges::<4>(sheet, &u, &v),
            || {
                rayon::join(
                    || derivative_ranges::<3>(sheet, &u, &v),
                    || derivative_ranges::<2>(sheet, &u, &v),
                )
            },
        );
        let values = (0..CELLS * CELLS)
            .map(|k| CellBounds {
                slope_min: norm(&first.each_ref().map(|entry| least(entry[k]))),
                slope_max: norm(&first.each_ref().map(|entry| largest(entry[k]))),
                curvature: norm(&second.each_ref().map(|entry| largest(entry[k]))),
                third: norm(&third.each_ref().map(|entry| largest(entry[k]))),
            })
            .collect();
        Self { panel, cell, values }
    }
}

impl<T: Union> Cells<T> {
    /// A bound derived from each cell's bound.
    #[must_use]
    pub fn map<U: Union>(&self, derive: impl FnMut(&T) -> U) -> Cells<U> {
        Cells {
            panel: self.panel,
            cell: self.cell,
            values: self.values.iter().map(derive).collect(),
        }
    }

    /// Bounds over the cells that the box `lo`..`hi` touches.
    #[inline]
    #[must_use]
    pub fn over(&self, lo: DVec2, hi: DVec2) -> T {
        let index = |q: DVec2| {
            let k = (q - self.panel.min) / self.cell;
            let clamp = |t: f64| (t.max(0.0) as usize).min(CELLS - 1);
            (clamp(k.x), clamp(k.y))
        };
        let ((i0, j0), (i1, j1)) = (index(lo), index(hi));
        let mut bound = self.values[j0 * CELLS + i0];
        for j in j0..=j1 {
            for i in i0..=i1 {
                bound = bound.union(self.values[j * CELLS + i]);
            }
        }
        bound
    }
}

/// Ranges over every cell of the `N - 1`-th derivatives of the sag in part units, X-most first.
fn derivative_ranges<const N: usize>(sheet: &Sheet, u: &[f64], v: &[f64]) -> [Vec<[f64; 2]>; N] {
    std::array::from_fn(|by_y| {
        let mut series = sheet.series.clone();
        let mut unit = sheet.scale_mm;
        for step in 0..N - 1 {
            if step < by_y {
                series = series.derivative_v();
                unit /= sheet.half.y;
            } else {
                series = series.derivative_u();
                unit /= sheet.half.x;
            }
        }
        let mut ranges = bernstein::ranges(&series, u, v);
        ranges.iter_mut().flatten().for_each(|end| *end *= unit);
        ranges
    })
}

/// Least |x| over a range.
fn least([lo, hi]: [f64; 2]) -> f64 {
    lo.max(-hi).max(0.0)
}

/// Largest |x| over a range.
fn largest([lo, hi]: [f64; 2]) -> f64 {
    lo.abs().max(hi.abs())
}

/// Frobenius norm of the symmetric tensor with the given distinct entries: an upper bound of the
/// operator norm. The k-th entry occurs binomial(n, k) times.
fn norm(entries: &[f64]) -> f64 {
    let order = entries.len() - 1;
    let mut times = 1.0;
    let mut sum = 0.0;
    for (k, entry) in entries.iter().enumerate() {
        sum += times * entry * entry;
        times *= (order - k) as f64 / (k + 1) as f64;
    }
    sum.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::legendre::Series;

    const PANEL: Rect = Rect { min: DVec2::new(-20.0, -14.0), max: DVec2::new(31.0, 9.0) };

    /// A wavy sheet of mixed degrees.
    fn sheet() -> Sheet {
        let series = Series::from_fn(7, 6, |i, j| {
            (1.0 + ((3 * i + 5 * j) % 7) as f64 - 3.0) / (1 + i * i + j * j) as f64
        });
        let (centre, half) = (DVec2::new(1.0, -2.0), DVec2::new(30.0, 12.0));
        Sheet { series, centre, half, scale_mm: 4.0, lift_mm: 9.0 }
    }

    #[test]
    fn bounds_hold_at_every_sample_and_are_not_idle() {
        let bounds = Cells::new(&sheet(), PANEL);
        let step = 1e-3;
        let mut tightest: f64 = 0.0;
        for (q, _) in PANEL.grid(37, 29) {
            let held = bounds.over(q, q);
            let slope = sheet().at(q).slope.length();
            let curvature = sheet().curvature(q).norm();
            assert!(held.slope_min <= slope && slope <= held.slope_max);
            assert!(curvature <= held.curvature);
            let along = |d: DVec2| {
                let (a, b) = (sheet().curvature(q + d * step), sheet().curvature(q - d * step));
                let xx = (a.xx - b.xx) * d.x * d.x + 2.0 * (a.xy - b.xy) * d.x * d.y;
                (xx + (a.yy - b.yy) * d.y * d.y) / (2.0 * step)
            };
            for d in [DVec2::X, DVec2::Y, DVec2::new(0.6, 0.8), DVec2::new(0.6, -0.8)] {
                assert!(along(d).abs() <= held.third * (1.0 + 1e-6));
                tightest = tightest.max(along(d).abs() / held.third);
            }
        }
        assert!(tightest > 0.8, "{tightest}");
    }

    #[test]
    fn a_box_over_many_cells_takes_the_worst_of_them() {
        let panel = Rect { min: DVec2::new(-20.0, -14.0), max: DVec2::new(31.0, 9.0) };
        let bounds = Cells::new(&sheet(), panel);
        let whole = bounds.over(panel.min, panel.max);
        for (q, _) in panel.grid(9, 9) {
            let here = bounds.over(q, q);
            assert!(here.curvature <= whole.curvature && here.third <= whole.third);
            assert!(here.slope_max <= whole.slope_max && here.slope_min >= whole.slope_min);
        }
    }
}
