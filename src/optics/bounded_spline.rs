//! A bicubic spline with bounds over boxes, in a time that grows with the logarithms of their width and height.

use crate::geom::{BicubicSpline, DVec2, DerivativeBounds, Rect};
use crate::num::{Interval, PlaneFn};
use std::sync::OnceLock;

/// Patches along the side of the smallest blocks, whose bounds are made once.
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
    /// Blocks of [`BLOCK`] patches to a side and, from one to the next, of twice as many columns; in each of the outer list of
    /// twice as many rows.
    blocks: Vec<Vec<Blocks>>,
}

/// Blocks of one size.
#[derive(Debug)]
struct Blocks {
    /// Columns and rows.
    size: [usize; 2],
    /// Their bounds, row by row: boxed, since most are never asked for.
    bounds: Vec<OnceLock<Box<DerivativeBounds>>>,
}

impl Blocks {
    fn new(size: [usize; 2]) -> Self {
        Self { size, bounds: vec![OnceLock::new(); size[0] * size[1]] }
    }
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
        let [columns, rows] = spline.knots().map(|axis| {
            let coarser = |count: &usize| (*count > 1).then(|| count.div_ceil(2));
            std::iter::successors(Some((axis.count - 1).div_ceil(BLOCK)), coarser)
        });
        let of_height = |row| columns.clone().map(|column| Blocks::new([column, row])).collect();
        let blocks = rows.map(of_height).collect();
        let size = spline.largest_value();
        Self { blocks, spline, smooth, size }
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

    /// Bounds over a block of 2^a columns and 2^b rows of the smallest ones: of those `[a, b]` the one in a column and a row.
    fn block(&self, [a, b]: [usize; 2], [i, j]: [usize; 2]) -> &DerivativeBounds {
        let all = &self.blocks[b][a];
        all.bounds[j * all.size[0] + i].get_or_init(|| {
            let halves =
                |k: usize, finer: &Blocks, axis: usize| 2 * k..(2 * k + 2).min(finer.size[axis]);
            if a > 0 {
                let columns = halves(i, &self.blocks[b][a - 1], 0);
                return union(columns.map(|i| *self.block([a - 1, b], [i, j])));
            }
            if b > 0 {
                let rows = halves(j, &self.blocks[b - 1][a], 1);
                return union(rows.map(|j| *self.block([a, b - 1], [i, j])));
            }
            let patches = |k: usize, axis: usize| {
                k * BLOCK..((k + 1) * BLOCK).min(self.spline.knots()[axis].count - 1)
            };
            let (columns, rows) = (patches(i, 0), patches(j, 1));
            union(rows.flat_map(|j| columns.clone().map(move |i| self.patch(i, j))))
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
        let touched = [0, 1].map(|k: usize| [lo, hi].map(|at| axes[k].interval(at[k]).0 / BLOCK));
        let mut bounds = DerivativeBounds::EMPTY;
        for_each_span(touched[1], |b, j| {
            for_each_span(touched[0], |a, i| bounds = bounds.union(*self.block([a, b], [i, j])));
        });
        bounds
    }
}

fn union(all: impl Iterator<Item = DerivativeBounds>) -> Box<DerivativeBounds> {
    Box::new(all.fold(DerivativeBounds::EMPTY, DerivativeBounds::union))
}

/// Calls `visit` with as few spans as the numbers from the first to the last one are made of: each has 2^k numbers and begins at a
/// multiple of that, and is told by k and the number of such spans before it.
fn for_each_span([first, last]: [usize; 2], mut visit: impl FnMut(usize, usize)) {
    let (mut from, mut to, mut k) = (first, last + 1, 0);
    while from < to {
        if from % 2 == 1 {
            visit(k, from);
            from += 1;
        }
        if to % 2 == 1 {
            to -= 1;
            visit(k, to);
        }
        (from, to, k) = (from / 2, to / 2, k + 1);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::GridAxis;
    use crate::num::sample::Draws;
    use crate::num::sin;

    #[test]
    fn bounds_over_a_box_are_those_of_all_smallest_blocks_that_it_touches() {
        let axis = |count: usize| GridAxis { first_mm: -3.0, step_mm: 0.1, count };
        let (x, y) = (axis(67), axis(23));
        let value = |k: usize| sin(0.3 * x.at(k % x.count)) + y.at(k / x.count) * x.at(k % x.count);
        let values: Vec<f64> = (0..x.count * y.count).map(value).collect();
        let spline = BoundedSpline::new(&BicubicSpline::new(x, y, &values).unwrap(), [9, 14]);
        assert!(spline.blocks.len() > 3 && spline.blocks[0].len() > 4);
        let Rect { min, max } = spline.grid();
        for mut r in (0..300).map(Draws::new) {
            let ends = [0, 1].map(|k: usize| {
                let at = r.inside([min[k], max[k]]);
                let width = r.inside([0.0, 1.0]) * r.inside([0.0, 1.0]) * (max[k] - at);
                [at, at + width]
            });
            let [lo, hi] = [0, 1].map(|end: usize| DVec2::new(ends[0][end], ends[1][end]));
            let touched = |k: usize| {
                let axis = spline.spline.knots()[k];
                axis.interval(lo[k]).0 / BLOCK..=axis.interval(hi[k]).0 / BLOCK
            };
            let blocks = touched(1).flat_map(|j| touched(0).map(move |i| [i, j]));
            let all =
                blocks.map(|at| *spline.block([0, 0], at)).reduce(DerivativeBounds::union).unwrap();
            assert_eq!(spline.derivatives(lo, hi), all);
        }
    }
}
