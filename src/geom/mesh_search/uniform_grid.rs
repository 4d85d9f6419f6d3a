//! A uniform grid of square cells: sorting facets into it, and traversing it along a ray.

use crate::geom::{DVec2, DVec3, Ray};
use crate::parallel;

/// Bands of rows that are filled side by side, whatever the number of threads.
const BANDS: usize = 8;
/// Share of a cell by which facets are enlarged: rounding of positions is far below it.
const MARGIN: f64 = 1e-6;

/// Least and largest Z over a cell, mm.
pub(super) type ZRange = [f64; 2];
/// First and last column and row that a facet's box touches.
pub(super) type CellSpan = [[u32; 2]; 2];

/// Range of no facet.
const NO_RANGE: ZRange = [f64::INFINITY, f64::NEG_INFINITY];

/// Square cells in the plane, from its origin on.
#[derive(Debug, Clone)]
pub(super) struct UniformGrid {
    /// Side of a cell, mm.
    cell: f64,
    per_mm: f64,
    /// Columns and rows.
    pub count: [usize; 2],
}

/// Lists of the facets over each cell of a grid, with their ranges of Z.
#[derive(Debug, Clone, Default)]
pub(super) struct CellLists {
    /// Index of each cell's first facet, and the number of all.
    start: Vec<u32>,
    facets: Vec<u32>,
    /// Range of Z of each cell's facets.
    pub ranges: Vec<ZRange>,
}

impl CellLists {
    /// The facets over cell `k`.
    #[inline]
    pub(super) fn of(&self, k: usize) -> &[u32] {
        &self.facets[self.start[k] as usize..self.start[k + 1] as usize]
    }
}

impl UniformGrid {
    /// `count` columns and rows of cells of side `cell` mm.
    pub(super) fn new(cell: f64, count: [usize; 2]) -> Self {
        Self { cell, per_mm: 1.0 / cell, count }
    }

    /// Number of the cell in column and row `at`.
    #[inline]
    pub(super) fn index(&self, at: [usize; 2]) -> usize {
        at[1] * self.count[0] + at[0]
    }

    /// Lower border of column or row `k`, mm.
    #[cfg(test)]
    pub fn border(&self, k: usize) -> f64 {
        self.cell * k as f64
    }

    /// The cells that the box around a triangle touches.
    #[inline]
    pub(super) fn span(&self, corners: [DVec3; 3]) -> CellSpan {
        let [a, b, c] = corners.map(|v| v.truncate() * self.per_mm);
        let index = |p: DVec2| [0, 1].map(|axis| self.clamp(p[axis], axis));
        let margin = DVec2::splat(MARGIN);
        [index(a.min(b).min(c) - margin), index(a.max(b).max(c) + margin)]
    }

    #[inline]
    fn clamp(&self, x: f64, axis: usize) -> u32 {
        (x.max(0.0) as u32).min(self.count[axis] as u32 - 1)
    }

    /// Ranges of the cells, from the `ranges` of a grid `step` times finer.
    pub(super) fn gather(&self, finer: &Self, step: usize, ranges: &[ZRange]) -> Vec<ZRange> {
        let mut gathered = vec![NO_RANGE; self.count[0] * self.count[1]];
        for (j, row) in ranges.chunks_exact(finer.count[0]).enumerate() {
            for (i, [lo, hi]) in row.iter().enumerate() {
                let range = &mut gathered[self.index([i / step, j / step])];
                *range = [range[0].min(*lo), range[1].max(*hi)];
            }
        }
        gathered
    }

    /// Sorts facets, each with its span, into the cells they lie over. Bands of rows are filled
    /// side by side; within a cell facets keep their order, so the result is the same for any
    /// number of threads.
    pub(super) fn cell_lists(
        &self,
        facets: &[(u32, CellSpan)],
        corners: impl Fn(u32) -> [DVec3; 3] + Sync,
    ) -> CellLists {
        let height = self.count[1].div_ceil(BANDS).max(1);
        let fill = |band: usize| -> CellLists {
            let low = (band * height).min(self.count[1]);
            let high = (low + height).min(self.count[1]);
            let cells = (high - low) * self.count[0];
            let mut lists = CellLists {
                start: vec![0; cells + 1],
                facets: vec![],
                ranges: vec![NO_RANGE; cells],
            };
            let mut covered: Vec<(u32, u32)> = Vec::with_capacity(facets.len() / BANDS * 5);
            for &(t, span @ [first, last]) in facets {
                if first[1] as usize >= high || (last[1] as usize) < low {
                    continue;
                }
                let corners = corners(t);
                let [a, b, c] = corners.map(|v| v.z);
                let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
                self.cover(span, corners, low..high, |k| {
                    covered.push((k as u32, t));
                    lists.start[k + 1] += 1;
                    let range = &mut lists.ranges[k];
                    *range = [range[0].min(lo), range[1].max(hi)];
                });
            }
            for k in 1..lists.start.len() {
                lists.start[k] += lists.start[k - 1];
            }
            let mut next = lists.start.clone();
            lists.facets = vec![0; covered.len()];
            for (k, t) in covered {
                let next = &mut next[k as usize];
                lists.facets[*next as usize] = t;
                *next += 1;
            }
            lists
        };
        let bands: Vec<CellLists> = parallel::map(BANDS, 1, fill);
        let mut whole = CellLists { start: vec![0], ..CellLists::default() };
        for band in bands {
            let before = whole.facets.len() as u32;
            whole.start.extend(band.start[1..].iter().map(|s| s + before));
            whole.facets.extend(band.facets);
            whole.ranges.extend(band.ranges);
        }
        whole
    }

    /// Calls `visit` for every cell in `rows` that a triangle touches (and, to be safe, some that
    /// it does not), once each, counted from the first row.
    #[inline]
    fn cover(
        &self,
        [first, last]: CellSpan,
        corners: [DVec3; 3],
        rows: std::ops::Range<usize>,
        mut visit: impl FnMut(usize),
    ) {
        let [first, last] = [first, last].map(|k| k.map(|k| k as usize));
        let (low, high) = (first[1].max(rows.start), (last[1] + 1).min(rows.end));
        // For a few cells the box is cheaper than finding out which of them are touched.
        let few = (last[0] - first[0] + 1) * (last[1] - first[1] + 1) <= 4;
        for j in low..high {
            let [left, right] = if few { [first[0], last[0]] } else { self.slice(corners, j) };
            for i in left..=right {
                visit((j - rows.start) * self.count[0] + i);
            }
        }
    }

    /// First and last cell of row `j` that a triangle reaching into the row touches.
    fn slice(&self, corners: [DVec3; 3], j: usize) -> [usize; 2] {
        let p = corners.map(|v| v.truncate() * self.per_mm);
        let (below, above) = (j as f64 - MARGIN, (j + 1) as f64 + MARGIN);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (a, b) = (p[k], p[(k + 1) % 3]);
            if a.y.max(b.y) < below || a.y.min(b.y) > above {
                continue;
            }
            // The part of the edge within the row.
            let at = |y: f64| {
                let share = (y.clamp(a.y.min(b.y), a.y.max(b.y)) - a.y) / (b.y - a.y);
                a.x + (b.x - a.x) * share
            };
            let (x0, x1) = if a.y == b.y { (a.x, b.x) } else { (at(below), at(above)) };
            left = left.min(x0).min(x1);
            right = right.max(x0).max(x1);
        }
        [left - MARGIN, right + MARGIN].map(|x| self.clamp(x, 0) as usize)
    }

    /// Visits the cells from index `first` up to, not including, `last` along the ray, with the
    /// span of distances in each, until `visit` returns false (Amanatides and Woo's traversal).
    #[inline]
    pub(super) fn walk(
        &self,
        ray: &GridRay,
        [mut enter, mut leave]: [f64; 2],
        first: [usize; 2],
        last: [usize; 2],
        mut visit: impl FnMut([usize; 2], [f64; 2]) -> bool,
    ) {
        for axis in 0..2 {
            // As wide as facets are taken to be: a ray a rounding error beside the border of the
            // coarser cell that it comes from must not be lost.
            let margin = MARGIN * self.cell;
            let lo = self.cell * first[axis] as f64 - margin;
            let hi = self.cell * last[axis] as f64 + margin;
            if ray.step[axis] == 0 {
                if ray.origin[axis] < lo || ray.origin[axis] > hi {
                    return;
                }
                continue;
            }
            let (near, far) = if ray.step[axis] > 0 { (lo, hi) } else { (hi, lo) };
            enter = enter.max((near - ray.origin[axis]) * ray.inverse[axis]);
            leave = leave.min((far - ray.origin[axis]) * ray.inverse[axis]);
        }
        if enter > leave {
            return;
        }
        let start = (ray.origin + ray.direction * enter) * self.per_mm;
        let (mut at, mut next, mut delta) = ([0isize; 2], [f64::INFINITY; 2], [f64::INFINITY; 2]);
        for axis in 0..2 {
            at[axis] = (start[axis] as isize).clamp(first[axis] as isize, last[axis] as isize - 1);
            if ray.step[axis] != 0 {
                let edge = self.cell * (at[axis] + isize::from(ray.step[axis] > 0)) as f64;
                next[axis] = (edge - ray.origin[axis]) * ray.inverse[axis];
                delta[axis] = self.cell * ray.inverse[axis].abs();
            }
        }
        loop {
            let axis = usize::from(next[1] < next[0]);
            let until = next[axis].min(leave).max(enter);
            if !visit(at.map(|k| k as usize), [enter, until]) || next[axis] >= leave {
                return;
            }
            at[axis] += ray.step[axis];
            if at[axis] < first[axis] as isize || at[axis] >= last[axis] as isize {
                return;
            }
            enter = until;
            next[axis] += delta[axis];
        }
    }
}

/// A ray over the plane, in the grid's own frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct GridRay {
    origin: DVec2,
    direction: DVec2,
    inverse: DVec2,
    step: [isize; 2],
    z: f64,
    climb: f64,
}

impl GridRay {
    /// `ray` with the grid's origin at `origin`.
    #[inline]
    pub(super) fn new(ray: &Ray, origin: DVec2) -> Self {
        let direction = ray.direction.truncate();
        let sign = |d: f64| isize::from(d > 0.0) - isize::from(d < 0.0);
        Self {
            origin: ray.origin.truncate() - origin,
            direction,
            inverse: direction.recip(),
            step: [sign(direction.x), sign(direction.y)],
            z: ray.origin.z,
            climb: ray.direction.z,
        }
    }

    /// Whether the ray's Z enters `range` within a span of distances, with a margin for rounding.
    #[inline]
    pub(super) fn meets(&self, [enter, leave]: [f64; 2], [least, largest]: ZRange) -> bool {
        let (a, b) = (self.z + self.climb * enter, self.z + self.climb * leave);
        let margin = 1e-9 * (a.abs() + b.abs() + largest.abs());
        a.min(b) <= largest + margin && a.max(b) >= least - margin
    }
}
