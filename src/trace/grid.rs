//! A pyramid of grids over the (X, Y) plane that finds the facets near a ray.
//!
//! Mirrors are shallow and rays cross them from above, so two dimensions suffice: each cell lists
//! the facets over it and their range of Z, each coarser cell the range of its cells. A ray visits
//! the cells under it in order and passes by those whose range it does not enter. Facets larger
//! than a coarsest cell, of which a solid has few, are listed there.

use crate::geom::{DVec2, DVec3, Ray, TriMesh};
use rayon::prelude::*;

/// Lattices in the pyramid.
const LEVELS: usize = 3;
/// Cells of one level along the side of a cell of the next.
const STEP: usize = 6;
/// Facets per cell that the grid aims at.
const CROWD: f64 = 1.5;
/// Cells at most, whatever the number of facets.
const MOST_CELLS: f64 = 6.4e7;

/// Bands of rows that are filled side by side; fixed, whatever the number of threads.
const BANDS: usize = 8;
/// Share of a cell by which facets are taken to be larger than they are: rounding of positions is
/// far below it.
const MARGIN: f64 = 1e-6;

/// [least, largest] Z over a cell.
type Range = [f64; 2];

/// Facets by cell of a lattice, with the range of Z in each.
#[derive(Debug, Clone, Default)]
struct Layer {
    start: Vec<u32>,
    facets: Vec<u32>,
    ranges: Vec<Range>,
}

impl Layer {
    #[inline]
    fn of(&self, k: usize) -> &[u32] {
        &self.facets[self.start[k] as usize..self.start[k + 1] as usize]
    }
}

/// A pyramid of lattices over the plane, finest first.
#[derive(Debug, Clone)]
pub struct Grid {
    levels: [Lattice; LEVELS],
    /// Facets no larger than a coarsest cell, by finest cell.
    small: Layer,
    /// The others, by coarsest cell.
    large: Layer,
    /// Range of the small facets in each cell of the levels above the finest.
    ranges: [Vec<Range>; LEVELS],
}

const NOTHING: Range = [f64::INFINITY, f64::NEG_INFINITY];

impl Grid {
    /// A grid over `mesh`.
    pub fn new(mesh: &TriMesh) -> Self {
        let (lo, hi) = mesh.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
        let extent = Some((hi - lo).max_element()).filter(|&e| e > 0.0).unwrap_or(1.0);
        let size = (hi - lo).truncate().max(DVec2::splat(1e-6 * extent));
        let wanted = (mesh.triangles.len() as f64 / CROWD).clamp(1.0, MOST_CELLS);
        let cell = (size.x * size.y / wanted).sqrt();
        // A margin keeps every facet inside, and rays along the rim off the last edge.
        let origin = lo.truncate() - DVec2::splat(0.25 * cell);
        let count = [size.x, size.y].map(|s| ((s / cell).ceil() as usize + 1).max(1));
        let levels: [Lattice; LEVELS] = std::array::from_fn(|level| {
            let cells = STEP.pow(level as u32);
            Lattice { origin, cell: cell * cells as f64, count: count.map(|n| n.div_ceil(cells)) }
        });

        let (finest, coarsest) = (&levels[0], &levels[LEVELS - 1]);
        let most = STEP.pow(LEVELS as u32 - 1);
        let is_small: Vec<bool> = (0..mesh.triangles.len())
            .into_par_iter()
            .with_min_len(1 << 14)
            .map(|t| {
                let [first, last] = finest.span(mesh.corners(t));
                last[0] - first[0] < most && last[1] - first[1] < most
            })
            .collect();
        let choose = |small: bool| -> Vec<u32> {
            (0..mesh.triangles.len() as u32).filter(|&t| is_small[t as usize] == small).collect()
        };
        let (small, large) = rayon::join(
            || finest.layer(mesh, &choose(true)),
            || coarsest.layer(mesh, &choose(false)),
        );
        let mut ranges: [Vec<Range>; LEVELS] = Default::default();
        for level in 1..LEVELS {
            let below = if level == 1 { &small.ranges } else { &ranges[level - 1] };
            ranges[level] = levels[level].gather(&levels[level - 1], below);
        }
        Self { levels, small, large, ranges }
    }

    /// Visits, in the order of the ray, the facets that it may meet for parameters in `span`.
    /// `visit` gets the facets and returns the parameter beyond which nothing matters any more.
    #[inline]
    pub fn walk(&self, ray: &Ray, span: [f64; 2], mut visit: impl FnMut(&[u32]) -> f64) {
        let mut end = span[1];
        let top = LEVELS - 1;
        let lattice = &self.levels[top];
        lattice.walk(ray, span, [0, 0], lattice.count, |at, [enter, leave]| {
            self.enter(top, at, ray, [enter, leave], &mut end, &mut visit);
            let cell = lattice.index(at);
            if enter <= end && meets(ray, [enter, leave.min(end)], self.large.ranges[cell]) {
                end = end.min(visit(self.large.of(cell)));
            }
            enter <= end
        });
    }

    /// Visits the small facets in cell `at` of `level`, unless the ray passes by their range.
    #[inline]
    fn enter(
        &self,
        level: usize,
        at: [usize; 2],
        ray: &Ray,
        [enter, leave]: [f64; 2],
        end: &mut f64,
        visit: &mut impl FnMut(&[u32]) -> f64,
    ) {
        let cell = self.levels[level].index(at);
        let range = if level == 0 { self.small.ranges[cell] } else { self.ranges[level][cell] };
        if enter > *end || !meets(ray, [enter, leave], range) {
            return;
        }
        if level == 0 {
            *end = end.min(visit(self.small.of(cell)));
            return;
        }
        let finer = &self.levels[level - 1];
        let first = at.map(|k| k * STEP);
        let last = [0, 1].map(|axis| (first[axis] + STEP).min(finer.count[axis]));
        finer.walk(ray, [enter, leave], first, last, |at, span| {
            self.enter(level - 1, at, ray, span, end, visit);
            span[0] <= *end
        });
    }
}

fn z_range([a, b, c]: [DVec3; 3]) -> (f64, f64) {
    (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z))
}

/// Whether the ray's Z enters `range` for parameters in `span`, with a margin for rounding.
#[inline]
fn meets(ray: &Ray, [enter, leave]: [f64; 2], [least, largest]: Range) -> bool {
    let (a, b) = (ray.at(enter).z, ray.at(leave).z);
    let margin = 1e-9 * (a.abs() + b.abs() + largest.abs());
    a.min(b) <= largest + margin && a.max(b) >= least - margin
}

/// Square cells in the plane.
#[derive(Debug, Clone)]
struct Lattice {
    origin: DVec2,
    cell: f64,
    count: [usize; 2],
}

impl Lattice {
    /// First and last column and row of cells that the box around a triangle's shadow touches.
    #[inline]
    fn span(&self, corners: [DVec3; 3]) -> [[usize; 2]; 2] {
        let [a, b, c] = corners.map(|v| (v.truncate() - self.origin) / self.cell);
        let index =
            |p: DVec2| [0, 1].map(|axis| (p[axis].max(0.0) as usize).min(self.count[axis] - 1));
        let margin = DVec2::splat(MARGIN);
        [index(a.min(b).min(c) - margin), index(a.max(b).max(c) + margin)]
    }

    #[inline]
    fn index(&self, at: [usize; 2]) -> usize {
        at[1] * self.count[0] + at[0]
    }

    /// Range over each cell of the ranges over the cells of the next finer lattice.
    fn gather(&self, finer: &Self, ranges: &[Range]) -> Vec<Range> {
        let mut gathered = vec![NOTHING; self.count[0] * self.count[1]];
        for (k, [lo, hi]) in ranges.iter().enumerate() {
            let at = [k % finer.count[0] / STEP, k / finer.count[0] / STEP];
            let range = &mut gathered[self.index(at)];
            *range = [range[0].min(*lo), range[1].max(*hi)];
        }
        gathered
    }

    /// Sorts `facets` of `mesh` into the cells they lie over. Bands of rows are filled side by
    /// side; within a cell facets keep their order, so the result is the same for any number of
    /// threads.
    fn layer(&self, mesh: &TriMesh, facets: &[u32]) -> Layer {
        let height = self.count[1].div_ceil(BANDS).max(1);
        let rows_of = |&t: &u32| {
            let [first, last] = self.span(mesh.corners(t as usize));
            [first[1] as u32, last[1] as u32]
        };
        let rows: Vec<[u32; 2]> = facets.par_iter().with_min_len(1 << 14).map(rows_of).collect();
        let fill = |band: usize| -> Layer {
            let (low, high) = (band * height, ((band + 1) * height).min(self.count[1]));
            let cells = high.saturating_sub(low) * self.count[0];
            let mut layer =
                Layer { start: vec![0; cells + 1], facets: vec![], ranges: vec![NOTHING; cells] };
            let inside: Vec<u32> = facets
                .iter()
                .zip(&rows)
                .filter(|(_, [first, last])| (*first as usize) < high && *last as usize >= low)
                .map(|(&t, _)| t)
                .collect();
            for &t in &inside {
                let corners = mesh.corners(t as usize);
                let (lo, hi) = z_range(corners);
                self.cover(corners, low..high, |k| {
                    layer.start[k + 1] += 1;
                    let range = &mut layer.ranges[k];
                    *range = [range[0].min(lo), range[1].max(hi)];
                });
            }
            for k in 1..layer.start.len() {
                layer.start[k] += layer.start[k - 1];
            }
            let mut next = layer.start.clone();
            layer.facets = vec![0; layer.start[cells] as usize];
            for &t in &inside {
                self.cover(mesh.corners(t as usize), low..high, |k| {
                    layer.facets[next[k] as usize] = t;
                    next[k] += 1;
                });
            }
            layer
        };
        let bands: Vec<Layer> = (0..BANDS).into_par_iter().map(fill).collect();
        let mut whole = Layer { start: vec![0], ..Layer::default() };
        for band in bands {
            let before = whole.facets.len() as u32;
            whole.start.extend(band.start[1..].iter().map(|s| s + before));
            whole.facets.extend(band.facets);
            whole.ranges.extend(band.ranges);
        }
        whole
    }

    /// Calls `visit` for every cell in `rows` that the triangle's shadow touches (and, to be safe,
    /// some that it does not), once each, counted from the first row.
    #[inline]
    fn cover(
        &self,
        corners: [DVec3; 3],
        rows: std::ops::Range<usize>,
        mut visit: impl FnMut(usize),
    ) {
        let [first, last] = self.span(corners);
        let across = last[0] - first[0] + 1;
        let (low, high) = (first[1].max(rows.start), (last[1] + 1).min(rows.end));
        // For a few cells the box is cheaper than finding out which of them are touched.
        let few = across * (last[1] - first[1] + 1) <= 2;
        for j in low..high {
            let [left, right] = if few { [first[0], last[0]] } else { self.slice(corners, j) };
            for i in left..=right {
                visit((j - rows.start) * self.count[0] + i);
            }
        }
    }

    /// First and last cell of row `j` that a triangle reaching into the row touches.
    fn slice(&self, corners: [DVec3; 3], j: usize) -> [usize; 2] {
        let p = corners.map(|v| (v.truncate() - self.origin) / self.cell);
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
        [left - MARGIN, right + MARGIN].map(|x| (x.max(0.0) as usize).min(self.count[0] - 1))
    }

    /// Visits the cells from index `first` up to, not including, `last` along the ray, with the
    /// span of parameters in each, until `visit` returns false (Amanatides and Woo's traversal).
    #[inline]
    fn walk(
        &self,
        ray: &Ray,
        span: [f64; 2],
        first: [usize; 2],
        last: [usize; 2],
        mut visit: impl FnMut([usize; 2], [f64; 2]) -> bool,
    ) {
        debug_assert!(last[0] <= self.count[0] && last[1] <= self.count[1]);
        let [mut enter, mut leave] = span;
        let (mut step, mut next, mut delta) = ([0isize; 2], [f64::INFINITY; 2], [f64::INFINITY; 2]);
        let (origin, direction) = (ray.origin.truncate() - self.origin, ray.direction.truncate());
        for axis in 0..2 {
            let (o, d) = (origin[axis], direction[axis]);
            let (lo, hi) = (self.cell * first[axis] as f64, self.cell * last[axis] as f64);
            if d == 0.0 {
                if o < lo || o > hi {
                    return;
                }
                continue;
            }
            let (near, far) = if d > 0.0 { (lo, hi) } else { (hi, lo) };
            enter = enter.max((near - o) / d);
            leave = leave.min((far - o) / d);
            step[axis] = if d > 0.0 { 1 } else { -1 };
            delta[axis] = self.cell / d.abs();
        }
        if enter > leave {
            return;
        }
        let start = origin + direction * enter;
        let mut at = [0, 1].map(|axis| {
            let k = (start[axis] / self.cell).floor() as isize;
            k.clamp(first[axis] as isize, last[axis] as isize - 1)
        });
        for axis in 0..2 {
            if step[axis] != 0 {
                let edge = self.cell * (at[axis] + isize::from(step[axis] > 0)) as f64;
                next[axis] = (edge - origin[axis]) / direction[axis];
            }
        }
        loop {
            let axis = usize::from(next[1] < next[0]);
            let until = next[axis].min(leave).max(enter);
            if !visit(at.map(|k| k as usize), [enter, until]) || next[axis] >= leave {
                return;
            }
            at[axis] += step[axis];
            if at[axis] < first[axis] as isize || at[axis] >= last[axis] as isize {
                return;
            }
            enter = until;
            next[axis] += delta[axis];
        }
    }
}
