//! A bicubic spline with bounds that take the same time over boxes of any size.

use crate::geom::{BicubicSpline, DVec2, DerivativeBounds, Rect};
use crate::num::{Interval, PlaneFn};
use std::sync::OnceLock;

/// Patches along the side of a block, whose bounds are made once.
const BLOCK: usize = 4;
/// Steps beyond the grid without a jump of second derivatives: what bounds of regions at the edge look at beside them is
/// no wider, and noise of the samples grows with half the square of it.
const STEPS: usize = 32;
/// How far evaluation may be off, as a share of the sizes that are summed up: it is good to far better.
const OFF: f64 = 1e-13;

/// A bicubic spline, linear beyond its grid, and bounds of its higher derivatives over blocks of its patches as they
/// are asked for.
#[derive(Debug)]
pub(super) struct BoundedSpline {
    spline: BicubicSpline,
    /// Where its second derivatives are continuous.
    smooth: Rect,
    /// Largest magnitude of its values at the knots.
    size: f64,
    /// Row by row.
    blocks: Vec<OnceLock<DerivativeBounds>>,
}

impl PartialEq for BoundedSpline {
    fn eq(&self, other: &Self) -> bool {
        self.spline == other.spline
    }
}

impl BoundedSpline {
    /// The spline on its grid and [`STEPS`] beyond, and linear from there on: over so many further `rings`.
    pub(super) fn new(on_grid: &BicubicSpline, rings: [usize; 2]) -> Self {
        let [x, y] = on_grid.knots().map(|axis| axis.widened(1 + STEPS));
        let smooth = Rect {
            min: DVec2::new(x.first_mm, y.first_mm),
            max: DVec2::new(x.last_mm(), y.last_mm()),
        };
        let spline = on_grid.with_ends(STEPS, rings);
        let [across, up] = spline.knots().map(|axis| (axis.count - 1).div_ceil(BLOCK));
        let size = spline.largest_value();
        Self { blocks: vec![OnceLock::new(); across * up], spline, smooth, size }
    }

    /// The rectangle of its knots, the rings included.
    pub(super) fn grid(&self) -> Rect {
        let [x, y] = self.spline.knots();
        Rect { min: DVec2::new(x.first_mm, y.first_mm), max: DVec2::new(x.last_mm(), y.last_mm()) }
    }

    /// Width of a patch, mm.
    pub(super) fn step_mm(&self) -> f64 {
        self.spline.knots()[0].step_mm
    }

    /// Bounds over the block of a column and a row of blocks.
    fn block(&self, i: usize, j: usize) -> DerivativeBounds {
        let [x, y] = self.spline.knots();
        let across = (x.count - 1).div_ceil(BLOCK);
        *self.blocks[j * across + i].get_or_init(|| {
            let end = |k: usize, count: usize| ((k + 1) * BLOCK).min(count - 1);
            let patches = (j * BLOCK..end(j, y.count)).flat_map(|row| {
                (i * BLOCK..end(i, x.count)).map(move |column| self.patch(column, row))
            });
            patches.reduce(DerivativeBounds::union).expect("a block has patches")
        })
    }

    /// Bounds over the patch of a column and a row.
    fn patch(&self, i: usize, j: usize) -> DerivativeBounds {
        let [x, y] = self.spline.knots();
        let half = 0.5 * DVec2::new(x.step_mm, y.step_mm);
        let middle = DVec2::new(x.at(i), y.at(j)) + half;
        let third = self.spline.third_of_patch(i, j);
        let hessian = self.second_near(middle, half, &third);
        let [f, along, up] = self.first_near(middle, half, &hessian);
        DerivativeBounds { f, slope: [along, up], hessian, third }
    }

    /// Ranges of the second derivatives up to `half` to all sides of `middle`, where those of the third are known and the
    /// second have no jump.
    fn second_near(&self, middle: DVec2, half: DVec2, third: &[Interval; 4]) -> [Interval; 3] {
        let [x, y] = [half.x, half.y].map(|half| Interval::around(0.0, half));
        let [per_x, per_y] = self.spline.knots().map(|axis| 1.0 / axis.step_mm);
        let slack = [per_x * per_x, per_x * per_y, per_y * per_y];
        let at = self.spline.second(middle);
        std::array::from_fn(|k| {
            let here = Interval::around(at[k], OFF * self.size * slack[k]);
            here + third[k] * x + third[k + 1] * y
        })
    }

    /// Ranges of value and first derivatives up to `half` to all sides of `middle`, where those of the second are known.
    fn first_near(&self, middle: DVec2, half: DVec2, second: &[Interval; 3]) -> [Interval; 3] {
        let [x, y] = [half.x, half.y].map(|half| Interval::around(0.0, half));
        let [per_x, per_y] = self.spline.knots().map(|axis| 1.0 / axis.step_mm);
        let [f, fx, fy] = self.first(middle.to_array());
        let here = |at: f64, per: f64| Interval::around(at, OFF * self.size * per);
        let [xx, xy, yy] = *second;
        let along = here(fx, per_x) + xx * x + xy * y;
        let up = here(fy, per_y) + xy * x + yy * y;
        [here(f, 1.0) + along * x + up * y, along, up]
    }

    /// Bounds over a box between the knots.
    fn derivatives(&self, lo: DVec2, hi: DVec2) -> DerivativeBounds {
        let axes = self.spline.knots();
        let touched =
            |k: usize| axes[k].interval(lo[k]).0 / BLOCK..=axes[k].interval(hi[k]).0 / BLOCK;
        let blocks = touched(1).flat_map(|j| touched(0).map(move |i| self.block(i, j)));
        blocks.reduce(DerivativeBounds::union).expect("a box touches a block")
    }
}

impl PlaneFn for BoundedSpline {
    #[inline]
    fn first(&self, at: [f64; 2]) -> [f64; 3] {
        let (f, slope) = self.spline.row(at[1]).value_and_slope(at[0]);
        [f, slope.x, slope.y]
    }

    #[inline]
    fn second(&self, at: [f64; 2]) -> [f64; 3] {
        self.spline.second(DVec2::from_array(at))
    }

    /// The whole line beyond the knots.
    fn over(&self, [x, y]: [[f64; 2]; 2]) -> [[f64; 2]; 6] {
        let (lo, hi) = (DVec2::new(x[0], y[0]), DVec2::new(x[1], y[1]));
        let grid = self.grid();
        if !(grid.contains(lo) && grid.contains(hi)) {
            return [[f64::NEG_INFINITY, f64::INFINITY]; 6];
        }
        let half = 0.5 * (hi - lo);
        let middle = (lo + half).clamp(lo, hi);
        // (Rounding of the middle may be to the one side.)
        let half = (middle - lo).max(hi - middle);
        let DerivativeBounds { f, slope: [along, up], hessian, third } = self.derivatives(lo, hi);
        let is_smooth = self.smooth.contains(lo) && self.smooth.contains(hi);
        let second = match is_smooth {
            true => common(hessian, self.second_near(middle, half, &third)),
            false => hessian,
        };
        let first = self.first_near(middle, half, &second);
        let [f, along, up] = common([f, along, up], first);
        let [xx, xy, yy] = second;
        [f, along, up, xx, xy, yy].map(|range| [range.lo, range.hi])
    }
}

/// What is in both of two ranges that hold the same.
fn common<const N: usize>(a: [Interval; N], b: [Interval; N]) -> [Interval; N] {
    std::array::from_fn(|k| {
        let (lo, hi) = (a[k].lo.max(b[k].lo), a[k].hi.min(b[k].hi));
        if lo <= hi { Interval::new(lo, hi) } else { a[k] }
    })
}
