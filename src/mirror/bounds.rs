//! Bounds of a surface's height and its first three derivatives over cells of its outline.
//!
//! Partial derivatives of a tensor series, or of a spline's patch, are polynomials, bounded over a
//! cell by their Bernstein coefficients.

use super::{Surface, TensorLegendre};
use crate::geom::{DVec2, Rect};
use crate::num::{Interval, bernstein};
use crate::parallel;

/// Cells per side: fine enough that the bounds are within a few per cent of the local values.
const CELLS: usize = 32;

/// How far evaluation may be off, as a share of the largest value: it is good to far better.
pub(super) const OFF: f64 = 1e-11;

/// What holds at every point of a region: ranges of f, (f_x, f_y), (f_xx, f_xy, f_yy) and
/// (f_xxx, f_xxy, f_xyy, f_yyy), in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DerivativeBounds {
    /// f.
    pub f: Interval,
    /// First derivatives.
    pub slope: [Interval; 2],
    /// Second derivatives.
    pub hessian: [Interval; 3],
    /// Third derivatives.
    pub third: [Interval; 4],
}

/// A bound that holds for two regions together.
pub trait UnionBound: Copy {
    /// What holds in both.
    #[must_use]
    fn union(self, other: Self) -> Self;
}

impl UnionBound for DerivativeBounds {
    fn union(self, other: Self) -> Self {
        fn both<const N: usize>(a: [Interval; N], b: [Interval; N]) -> [Interval; N] {
            std::array::from_fn(|k| a[k].hull(b[k]))
        }
        Self {
            f: self.f.hull(other.f),
            slope: both(self.slope, other.slope),
            hessian: both(self.hessian, other.hessian),
            third: both(self.third, other.third),
        }
    }
}

/// One bound for each cell of a rectangle.
#[derive(Debug, Clone)]
pub struct BoundGrid<T> {
    rect: Rect,
    /// Cells per side.
    count: usize,
    cell: DVec2,
    values: Vec<T>,
}

impl BoundGrid<DerivativeBounds> {
    /// Bounds of `surface` over `rect`, as far as the surface reaches.
    #[must_use]
    pub fn new(surface: &Surface, rect: Rect) -> Self {
        let cell = rect.size() / CELLS as f64;
        let mut cells = Self { rect, count: CELLS, cell, values: Vec::new() };
        cells.values = match surface {
            Surface::Tensor(sheet) => tensor(sheet, &cells),
            Surface::Round(round) => cells.each(|a, b| round.bounds(a, b)),
            Surface::Sum(round, sheet) => {
                let rest = tensor(sheet, &cells);
                let round = cells.each(|a, b| round.bounds(a, b));
                round.iter().zip(&rest).map(|(a, b)| a.plus(b)).collect()
            }
            Surface::Patches(patches) => cells.each(|a, b| patches.bounds(a, b)),
        };
        cells
    }

    /// A bound for each cell's corners.
    fn each(
        &self,
        bounds: impl Fn(DVec2, DVec2) -> DerivativeBounds + Sync,
    ) -> Vec<DerivativeBounds> {
        let cell = |k| {
            let [lo, hi] = self.corners(k);
            bounds(lo, hi)
        };
        parallel::map(CELLS * CELLS, 1, cell)
    }
}

impl DerivativeBounds {
    /// What holds of the sum of two functions.
    fn plus(&self, other: &Self) -> Self {
        fn sums<const N: usize>(a: [Interval; N], b: [Interval; N]) -> [Interval; N] {
            std::array::from_fn(|k| a[k] + b[k])
        }
        Self {
            f: self.f + other.f,
            slope: sums(self.slope, other.slope),
            hessian: sums(self.hessian, other.hessian),
            third: sums(self.third, other.third),
        }
    }
}

impl<T> BoundGrid<T> {
    /// Opposite corners of a cell.
    fn corners(&self, k: usize) -> [DVec2; 2] {
        let (i, j) = (k % self.count, k / self.count);
        let lo = self.rect.min + self.cell * DVec2::new(i as f64, j as f64);
        [lo, lo + self.cell]
    }

    /// Bounds of `parts` by `parts` parts of each cell, derived from the part's corners and the
    /// cell's bound.
    #[must_use]
    pub fn map<U: Send + Sync>(
        &self,
        parts: usize,
        derive: impl Fn([DVec2; 2], &T) -> U + Sync,
    ) -> BoundGrid<U>
    where
        T: Sync,
    {
        let count = parts * self.count;
        let mut cells = BoundGrid {
            rect: self.rect,
            count,
            cell: self.cell / parts as f64,
            values: Vec::new(),
        };
        let value = |k: usize| {
            let (i, j) = (k % count / parts, k / count / parts);
            derive(cells.corners(k), &self.values[j * self.count + i])
        };
        cells.values = parallel::map(count * count, 1, value);
        cells
    }
}

impl<T: UnionBound> BoundGrid<T> {
    /// Bounds over the cells that the box `lo`..`hi` touches.
    #[inline]
    #[must_use]
    pub fn over(&self, lo: DVec2, hi: DVec2) -> T {
        let index = |q: DVec2| {
            let k = (q - self.rect.min) / self.cell;
            let clamp = |t: f64| (t.max(0.0) as usize).min(self.count - 1);
            (clamp(k.x), clamp(k.y))
        };
        let ((i0, j0), (i1, j1)) = (index(lo), index(hi));
        let mut bound = self.values[j0 * self.count + i0];
        if (i0, j0) == (i1, j1) {
            return bound;
        }
        for j in j0..=j1 {
            for i in i0..=i1 {
                bound = bound.union(self.values[j * self.count + i]);
            }
        }
        bound
    }
}

/// Third derivatives by their Bernstein coefficients, the others by Taylor's theorem about the middle
/// of each cell.
fn tensor(sheet: &TensorLegendre, cells: &BoundGrid<DerivativeBounds>) -> Vec<DerivativeBounds> {
    let (lo, step) = ((cells.rect.min - sheet.centre) / sheet.half, cells.cell / sheet.half);
    let edges =
        |lo: f64, step: f64| -> Vec<f64> { (0..=CELLS).map(|k| lo + step * k as f64).collect() };
    let (u, v) = (edges(lo.x, step.x), edges(lo.y, step.y));
    let middle = |k: usize| {
        let [lo, hi] = cells.corners(k);
        let (point, c) = (sheet.at(0.5 * (lo + hi)), sheet.hessian(0.5 * (lo + hi)));
        [point.f, point.slope.x, point.slope.y, c.xx, c.xy, c.yy]
    };
    let (third, middles): (_, Vec<[f64; 6]>) = parallel::join(
        || third_derivatives(sheet, &u, &v),
        || parallel::map(CELLS * CELLS, 1, middle),
    );
    let off: [f64; 6] =
        std::array::from_fn(|i| OFF * middles.iter().map(|m| m[i].abs()).fold(0.0, f64::max));
    let half = 0.5 * cells.cell;
    let [x, y] = [half.x, half.y].map(|half| Interval::around(0.0, half));
    let bounds = |(k, middle): (usize, &[f64; 6])| {
        let third = third.each_ref().map(|range| range[k]);
        let [xxx, xxy, xyy, yyy] = third;
        let about = |i: usize, by_x: Interval, by_y: Interval| {
            Interval::around(middle[i], off[i]) + by_x * x + by_y * y
        };
        let hessian @ [xx, xy, yy] = [about(3, xxx, xxy), about(4, xxy, xyy), about(5, xyy, yyy)];
        let slope @ [by_x, by_y] = [about(1, xx, xy), about(2, xy, yy)];
        DerivativeBounds { f: about(0, by_x, by_y), slope, hessian, third }
    };
    middles.iter().enumerate().map(bounds).collect()
}

/// Ranges over every cell of the third derivatives of the height, x-most first.
fn third_derivatives(sheet: &TensorLegendre, u: &[f64], v: &[f64]) -> [Vec<Interval>; 4] {
    let ranges = |by_y: usize| {
        let mut series = sheet.series.clone();
        let mut unit = sheet.scale_mm;
        for step in 0..3 {
            if step < by_y {
                series = series.derivative_v();
                unit /= sheet.half.y;
            } else {
                series = series.derivative_u();
                unit /= sheet.half.x;
            }
        }
        let ranges = bernstein::ranges(&series, u, v);
        ranges.into_iter().map(|[lo, hi]| Interval::new(lo, hi) * unit).collect()
    };
    let ((a, b), (c, d)) = parallel::join(
        || parallel::join(|| ranges(0), || ranges(1)),
        || parallel::join(|| ranges(2), || ranges(3)),
    );
    [a, b, c, d]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::legendre::Series;

    const PANEL: Rect = Rect { min: DVec2::new(-20.0, -14.0), max: DVec2::new(31.0, 9.0) };

    /// A wavy sheet of mixed degrees.
    fn sheet() -> TensorLegendre {
        let series = Series::from_fn(7, 6, |i, j| {
            (1.0 + ((3 * i + 5 * j) % 7) as f64 - 3.0) / (1 + i * i + j * j) as f64
        });
        let (centre, half) = (DVec2::new(1.0, -2.0), DVec2::new(30.0, 12.0));
        TensorLegendre { series, centre, half, scale_mm: 4.0 }
    }

    #[test]
    fn bounds_hold_at_every_sample_and_are_not_idle() {
        let bounds = BoundGrid::new(&Surface::Tensor(sheet()), PANEL);
        let step = 1e-3;
        let (mut found, mut allowed) = (0.0f64, 0.0f64);
        for (q, _) in PANEL.grid(37, 29) {
            let held = bounds.over(q, q);
            let (point, c) = (sheet().at(q), sheet().hessian(q));
            assert!(held.f.contains(point.f));
            assert!(held.slope[0].contains(point.slope.x) && held.slope[1].contains(point.slope.y));
            for (range, x) in held.hessian.iter().zip([c.xx, c.xy, c.yy]) {
                assert!(range.contains(x));
            }
            let d = |e: DVec2| {
                let (a, b) = (sheet().hessian(q + e * step), sheet().hessian(q - e * step));
                [a.xx - b.xx, a.xy - b.xy, a.yy - b.yy].map(|x| x / (2.0 * step))
            };
            let (dx, dy) = (d(DVec2::X), d(DVec2::Y));
            for (range, x) in held.third.iter().zip([dx[0], dx[1], dx[2], dy[2]]) {
                let slack = 1e-6 * (1.0 + x.abs());
                assert!(range.lo - slack <= x && x <= range.hi + slack, "{range:?} {x}");
                found = found.max(x.abs());
                allowed = allowed.max(range.magnitude());
            }
        }
        assert!(found > 0.8 * allowed, "{found} of {allowed}");
    }

    #[test]
    fn a_box_over_many_cells_takes_the_worst_of_them() {
        let bounds = BoundGrid::new(&Surface::Tensor(sheet()), PANEL);
        let whole = bounds.over(PANEL.min, PANEL.max);
        for (q, _) in PANEL.grid(9, 9) {
            let here = bounds.over(q, q);
            assert_eq!(whole.union(here), whole);
        }
    }
}
