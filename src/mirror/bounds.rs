//! Bounds of a sheet's slope, curvature and third derivatives over cells of its panel.
//!
//! Derivatives up to third order are evaluated at the cell's centre and carried over the cell by
//! Taylor's theorem; the fourth order is bounded once, by the sum of its Legendre coefficients.

use super::Sheet;
use crate::geom::{DVec2, Rect};
use crate::num::legendre::Series;

/// Cells per side: fine enough that the fourth-order term adds a few per cent to the third.
const CELLS: usize = 48;

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

impl CellBounds {
    fn union(self, other: Self) -> Self {
        Self {
            slope_min: self.slope_min.min(other.slope_min),
            slope_max: self.slope_max.max(other.slope_max),
            curvature: self.curvature.max(other.curvature),
            third: self.third.max(other.third),
        }
    }
}

/// Bounds over a grid of cells of one panel.
#[derive(Debug, Clone)]
pub struct SheetBounds {
    panel: Rect,
    cell: DVec2,
    cells: Vec<CellBounds>,
}

impl SheetBounds {
    /// Bounds of `sheet` over `panel`, which lies inside the sheet's own rectangle.
    #[must_use]
    pub fn new(sheet: &Sheet, panel: Rect) -> Self {
        let cell = panel.size() / CELLS as f64;
        let radius = 0.5 * cell.length();
        let third = derivatives::<4>(sheet);
        let fourth = norm(&derivatives::<5>(sheet).map(|(series, unit)| series.bound() * unit));
        let mut cells = Vec::with_capacity(CELLS * CELLS);
        for j in 0..CELLS {
            let y = panel.min.y + cell.y * (j as f64 + 0.5);
            let v = (y - sheet.centre.y) / sheet.half.y;
            let rows: Vec<_> = third
                .iter()
                .map(|(series, unit)| (series.row(v), unit))
                .collect();
            for i in 0..CELLS {
                let centre = DVec2::new(panel.min.x + cell.x * (i as f64 + 0.5), y);
                let u = (centre.x - sheet.centre.x) / sheet.half.x;
                let at: Vec<f64> = rows
                    .iter()
                    .map(|(row, unit)| row.gradient(u).f * *unit)
                    .collect();
                let third = norm(&at) + fourth * radius;
                let curvature = sheet.curvature(centre).norm() + third * radius;
                let slope = sheet.at(centre).slope.length();
                let reach = curvature * radius;
                cells.push(CellBounds {
                    slope_min: (slope - reach).max(0.0),
                    slope_max: slope + reach,
                    curvature,
                    third,
                });
            }
        }
        Self { panel, cell, cells }
    }

    /// Bounds over the cells that the box `lo`..`hi` touches.
    #[inline]
    #[must_use]
    pub fn over(&self, lo: DVec2, hi: DVec2) -> CellBounds {
        let index = |q: DVec2| {
            let k = ((q - self.panel.min) / self.cell).floor();
            let clamp = |t: f64| (t.max(0.0) as usize).min(CELLS - 1);
            (clamp(k.x), clamp(k.y))
        };
        let ((i0, j0), (i1, j1)) = (index(lo), index(hi));
        let mut bounds = self.cells[j0 * CELLS + i0];
        for j in j0..=j1 {
            for i in i0..=i1 {
                bounds = bounds.union(self.cells[j * CELLS + i]);
            }
        }
        bounds
    }
}

/// The `N - 1`-th derivatives of the sag, X-most first, each as a series and the factor that turns
/// it into part units.
fn derivatives<const N: usize>(sheet: &Sheet) -> [(Series, f64); N] {
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
        (series, unit)
    })
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

    /// A wavy sheet of mixed degrees.
    fn sheet() -> Sheet {
        let series = Series::from_fn(7, 6, |i, j| {
            (1.0 + (3 * i + 5 * j) as f64 % 7.0 - 3.0) / (1 + i * i + j * j) as f64
        });
        let (centre, half) = (DVec2::new(1.0, -2.0), DVec2::new(30.0, 12.0));
        Sheet {
            series,
            centre,
            half,
            scale_mm: 4.0,
            lift_mm: 9.0,
        }
    }

    #[test]
    fn bounds_hold_at_every_sample_and_are_not_idle() {
        let panel = Rect {
            min: DVec2::new(-20.0, -14.0),
            max: DVec2::new(31.0, 9.0),
        };
        let bounds = SheetBounds::new(&sheet(), panel);
        let step = 1e-3;
        let mut tightest: f64 = 0.0;
        for (q, _) in panel.grid(37, 29) {
            let held = bounds.over(q, q);
            let slope = sheet().at(q).slope.length();
            let curvature = sheet().curvature(q).norm();
            assert!(held.slope_min <= slope && slope <= held.slope_max);
            assert!(curvature <= held.curvature);
            let along = |d: DVec2| {
                let (a, b) = (
                    sheet().curvature(q + d * step),
                    sheet().curvature(q - d * step),
                );
                let xx = (a.xx - b.xx) * d.x * d.x + 2.0 * (a.xy - b.xy) * d.x * d.y;
                (xx + (a.yy - b.yy) * d.y * d.y) / (2.0 * step)
            };
            for d in [
                DVec2::X,
                DVec2::Y,
                DVec2::new(0.6, 0.8),
                DVec2::new(0.6, -0.8),
            ] {
                assert!(along(d).abs() <= held.third * (1.0 + 1e-6));
                tightest = tightest.max(along(d).abs() / held.third);
            }
        }
        assert!(tightest > 0.5, "{tightest}");
    }

    #[test]
    fn a_box_over_many_cells_takes_the_worst_of_them() {
        let panel = Rect {
            min: DVec2::new(-20.0, -14.0),
            max: DVec2::new(31.0, 9.0),
        };
        let bounds = SheetBounds::new(&sheet(), panel);
        let whole = bounds.over(panel.min, panel.max);
        for (q, _) in panel.grid(9, 9) {
            let here = bounds.over(q, q);
            assert!(here.curvature <= whole.curvature && here.third <= whole.third);
            assert!(here.slope_max <= whole.slope_max && here.slope_min >= whole.slope_min);
        }
    }
}
