//! A bicubic spline with bounds that take the same time over boxes of any size.

use crate::geom::{BicubicSpline, DVec2, DerivativeBounds, Rect};
use crate::num::{Interval, PlaneFn, Scalar};
use std::sync::OnceLock;

/// Patches along a block's side: bounds of larger boxes are those of blocks.
const BLOCK: usize = 8;
/// Most patches along each side of a box that are bounded one by one.
const FEW: usize = 3;
/// How far evaluation may be off, as a share of the largest value: it is good to far better.
const OFF: f64 = 1e-13;

/// A bicubic spline, and bounds over blocks of its patches as they are asked for.
#[derive(Debug)]
pub(super) struct BoundedSpline {
    spline: BicubicSpline,
    /// Where its second derivatives are continuous.
    smooth: Rect,
    /// Row by row.
    blocks: Vec<OnceLock<DerivativeBounds>>,
}

impl PartialEq for BoundedSpline {
    fn eq(&self, other: &Self) -> bool {
        self.spline == other.spline
    }
}

impl BoundedSpline {
    /// The spline on its grid, and linear beyond: over so many `rings` and on.
    pub(super) fn new(on_grid: &BicubicSpline, rings: [usize; 2]) -> Self {
        let [x, y] = on_grid.knots().map(|axis| axis.widened(1));
        let smooth = Rect {
            min: DVec2::new(x.first_mm, y.first_mm),
            max: DVec2::new(x.last_mm(), y.last_mm()),
        };
        let spline = on_grid.with_linear_ends(rings);
        let [across, up] = spline.knots().map(|axis| (axis.count - 1).div_ceil(BLOCK));
        Self { blocks: vec![OnceLock::new(); across * up], spline, smooth }
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
            // (A patch's bounds hold to its edges.)
            let patches = (j * BLOCK..end(j, y.count)).flat_map(|row| {
                (i * BLOCK..end(i, x.count))
                    .map(move |column| self.spline.bounds_of_patch(column, row))
            });
            patches.reduce(DerivativeBounds::union).expect("a block has patches")
        })
    }

    /// Bounds over a box; none where many patches would have to go on beyond the knots.
    fn bounds(&self, lo: DVec2, hi: DVec2) -> Option<DerivativeBounds> {
        let axes = self.spline.knots();
        let touched = [0, 1].map(|k: usize| {
            let (first, last) = (axes[k].interval(lo[k]).0, axes[k].interval(hi[k]).0);
            [first, last]
        });
        let [[i0, i1], [j0, j1]] = touched;
        let is_inside = |k: usize| axes[k].first_mm <= lo[k] && hi[k] <= axes[k].last_mm();
        let few = i1 - i0 < FEW && j1 - j0 < FEW;
        if few {
            return Some(self.spline.bounds(lo, hi));
        }
        if !(is_inside(0) && is_inside(1)) {
            return None;
        }
        let rows = j0 / BLOCK..=j1 / BLOCK;
        let blocks = rows.flat_map(|j| (i0 / BLOCK..=i1 / BLOCK).map(move |i| self.block(i, j)));
        blocks.reduce(DerivativeBounds::union)
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

    /// The bounds of the patches, narrowed by those of the next derivatives about the middle of the box.
    fn over(&self, [x, y]: [Interval; 2]) -> [Interval; 6] {
        if !(x.is_finite() && y.is_finite()) {
            return [Interval::WHOLE; 6];
        }
        let (lo, hi) = (DVec2::new(x.lo, y.lo), DVec2::new(x.hi, y.hi));
        let Some(all) = self.bounds(lo, hi) else { return [Interval::WHOLE; 6] };
        let middle = [x.mid(), y.mid()];
        let aside = [x - Interval::point(middle[0]), y - Interval::point(middle[1])];
        let near = |at: f64, rates: [Interval; 2], known: Interval| {
            let slack = OFF * (known.magnitude() + known.width());
            let here = Interval::around(at, slack) + rates[0] * aside[0] + rates[1] * aside[1];
            let (lo, hi) = (here.lo.max(known.lo), here.hi.min(known.hi));
            if lo <= hi { Interval::new(lo, hi) } else { known }
        };
        let ([f, fx, fy], [fxx, fxy, fyy]) = (self.first(middle), self.second(middle));
        let [xxx, xxy, xyy, yyy] = all.third;
        let [xx, xy, yy] = if self.smooth.contains(lo) && self.smooth.contains(hi) {
            let [xx, xy, yy] = all.hessian;
            [near(fxx, [xxx, xxy], xx), near(fxy, [xxy, xyy], xy), near(fyy, [xyy, yyy], yy)]
        } else {
            all.hessian
        };
        let along = near(fx, [xx, xy], all.slope[0]);
        let up = near(fy, [xy, yy], all.slope[1]);
        [near(f, [along, up], all.f), along, up, xx, xy, yy]
    }
}
