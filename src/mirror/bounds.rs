//! Bounds of a surface's height and its first three derivatives over the cells of a rectangle.

use crate::geom::{DVec2, DerivativeBounds, Rect};
use crate::parallel;

/// Cells per side: fine enough that the bounds are within a few per cent of the local values.
const CELLS: usize = 32;

/// How far evaluation may be off, as a share of the largest value: it is good to far better.
pub(super) const OFF: f64 = 1e-11;

/// A bound that holds for two regions together.
pub trait UnionBound: Copy {
    /// What holds in both.
    #[must_use]
    fn union(self, other: Self) -> Self;
}

impl UnionBound for DerivativeBounds {
    fn union(self, other: Self) -> Self {
        self.union(other)
    }
}

/// Even cells of a rectangle, row by row.
#[derive(Debug, Clone, Copy)]
pub struct BoundCells {
    /// The rectangle.
    pub rect: Rect,
    /// Cells per side.
    pub count: usize,
    /// Width and height of a cell.
    pub size: DVec2,
}

impl BoundCells {
    /// Opposite corners of a cell.
    #[must_use]
    pub fn corners(&self, k: usize) -> [DVec2; 2] {
        let (i, j) = (k % self.count, k / self.count);
        let lo = self.rect.min + self.size * DVec2::new(i as f64, j as f64);
        [lo, lo + self.size]
    }

    /// The cell that `q` is in, as column and row; for a point outside, the nearest.
    #[inline]
    fn find(&self, q: DVec2) -> (usize, usize) {
        let k = (q - self.rect.min) / self.size;
        let clamp = |t: f64| (t.max(0.0) as usize).min(self.count - 1);
        (clamp(k.x), clamp(k.y))
    }

    /// A bound for each cell, from its corners.
    pub fn each(
        &self,
        bounds: impl Fn(DVec2, DVec2) -> DerivativeBounds + Sync,
    ) -> Vec<DerivativeBounds> {
        let cell = |k| {
            let [lo, hi] = self.corners(k);
            bounds(lo, hi)
        };
        parallel::map(self.count * self.count, 1, cell)
    }
}

/// One bound for each cell of a rectangle.
#[derive(Debug, Clone)]
pub struct BoundGrid<T> {
    cells: BoundCells,
    values: Vec<T>,
}

impl BoundGrid<DerivativeBounds> {
    /// The bounds that `bounds` finds of the cells of `rect`.
    pub(super) fn new(
        rect: Rect,
        bounds: impl FnOnce(&BoundCells) -> Vec<DerivativeBounds>,
    ) -> Self {
        let cells = BoundCells { rect, count: CELLS, size: rect.size() / CELLS as f64 };
        Self { values: bounds(&cells), cells }
    }
}

impl<T> BoundGrid<T> {
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
        let BoundCells { rect, count: coarse, size } = self.cells;
        let count = parts * coarse;
        let cells = BoundCells { rect, count, size: size / parts as f64 };
        let value = |k: usize| {
            let (i, j) = (k % count / parts, k / count / parts);
            derive(cells.corners(k), &self.values[j * coarse + i])
        };
        BoundGrid { cells, values: parallel::map(count * count, 1, value) }
    }
}

impl<T: UnionBound> BoundGrid<T> {
    /// Bounds over the cells that the box `lo`..`hi` touches.
    #[inline]
    #[must_use]
    pub fn over(&self, lo: DVec2, hi: DVec2) -> T {
        let count = self.cells.count;
        let ((i0, j0), (i1, j1)) = (self.cells.find(lo), self.cells.find(hi));
        let mut bound = self.values[j0 * count + i0];
        if (i0, j0) == (i1, j1) {
            return bound;
        }
        for j in j0..=j1 {
            for i in i0..=i1 {
                bound = bound.union(self.values[j * count + i]);
            }
        }
        bound
    }
}
