//! A two-level grid over the (X, Y) plane that finds the facets near a ray.
//!
//! Mirrors are shallow and rays cross them from above, so two dimensions suffice: each cell lists
//! the facets over it and their range of Z, each block of cells the range of its cells. A ray
//! visits the blocks and cells under it in order and passes by those whose range it does not
//! enter.

use crate::geom::{DVec2, DVec3, Ray, TriMesh};

/// Cells per block and side.
const BLOCK: usize = 16;
/// Facets per cell that the grid aims at.
const CROWD: f64 = 1.5;
/// Cells at most, whatever the number of facets.
const MOST_CELLS: f64 = 6.4e7;

/// [least, largest] Z over a cell or block.
type Range = [f64; 2];

#[derive(Debug, Clone)]
pub struct Grid {
    origin: DVec2,
    cell: f64,
    count: [usize; 2],
    blocks: [usize; 2],
    start: Vec<u32>,
    facets: Vec<u32>,
    cell_range: Vec<Range>,
    block_range: Vec<Range>,
}

impl Grid {
    /// A grid over `mesh`.
    pub fn new(mesh: &TriMesh) -> Self {
        let (lo, hi) = mesh.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
        let extent = Some((hi - lo).max_element())
            .filter(|&e| e > 0.0)
            .unwrap_or(1.0);
        let size = (hi - lo).truncate().max(DVec2::splat(1e-6 * extent));
        let cells = (mesh.triangles.len() as f64 / CROWD).clamp(1.0, MOST_CELLS);
        let cell = (size.x * size.y / cells).sqrt();
        // A margin keeps every facet inside, and rays along the rim off the last edge.
        let origin = lo.truncate() - DVec2::splat(0.25 * cell);
        let count = [size.x, size.y].map(|s| ((s / cell).ceil() as usize + 1).max(1));
        let blocks = count.map(|n| n.div_ceil(BLOCK));
        let mut grid = Self {
            origin,
            cell,
            count,
            blocks,
            start: vec![0; count[0] * count[1] + 1],
            facets: Vec::new(),
            cell_range: vec![[f64::INFINITY, f64::NEG_INFINITY]; count[0] * count[1]],
            block_range: vec![[f64::INFINITY, f64::NEG_INFINITY]; blocks[0] * blocks[1]],
        };
        grid.fill(mesh);
        grid
    }

    fn fill(&mut self, mesh: &TriMesh) {
        for t in 0..mesh.triangles.len() {
            let corners = mesh.corners(t);
            let (lo, hi) = z_range(corners);
            self.cover(corners, |grid, k| {
                grid.start[k + 1] += 1;
                let [least, largest] = &mut grid.cell_range[k];
                (*least, *largest) = (least.min(lo), largest.max(hi));
            });
        }
        for k in 1..self.start.len() {
            self.start[k] += self.start[k - 1];
        }
        let mut next = self.start.clone();
        self.facets = vec![0; self.start[self.start.len() - 1] as usize];
        for t in 0..mesh.triangles.len() {
            self.cover(mesh.corners(t), |grid, k| {
                grid.facets[next[k] as usize] = t as u32;
                next[k] += 1;
            });
        }
        for j in 0..self.count[1] {
            for i in 0..self.count[0] {
                let [lo, hi] = self.cell_range[j * self.count[0] + i];
                let block = &mut self.block_range[j / BLOCK * self.blocks[0] + i / BLOCK];
                *block = [block[0].min(lo), block[1].max(hi)];
            }
        }
    }

    /// Calls `visit` for every cell that the triangle's shadow touches (and, to be safe, a few
    /// that it only nearly touches), once each.
    fn cover(&mut self, corners: [DVec3; 3], mut visit: impl FnMut(&mut Self, usize)) {
        let p = corners.map(|c| (c.truncate() - self.origin) / self.cell);
        // Rounding of positions is far below this share of a cell.
        const MARGIN: f64 = 1e-6;
        let clamp = |t: f64, n: usize| (t.max(0.0) as usize).min(n - 1);
        let lo_y = p[0].y.min(p[1].y).min(p[2].y) - MARGIN;
        let hi_y = p[0].y.max(p[1].y).max(p[2].y) + MARGIN;
        for j in clamp(lo_y, self.count[1])..=clamp(hi_y, self.count[1]) {
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
                let (x0, x1) = if a.y == b.y {
                    (a.x, b.x)
                } else {
                    (at(below), at(above))
                };
                left = left.min(x0).min(x1);
                right = right.max(x0).max(x1);
            }
            if left > right {
                continue;
            }
            let row = j * self.count[0];
            for i in clamp(left - MARGIN, self.count[0])..=clamp(right + MARGIN, self.count[0]) {
                visit(self, row + i);
            }
        }
    }

    /// Visits, in the order of the ray, the facets of every cell that the ray may meet for
    /// parameters in `span`. `visit` gets the facets and returns the parameter beyond which
    /// nothing matters any more.
    #[inline]
    pub fn walk(&self, ray: &Ray, span: [f64; 2], mut visit: impl FnMut(&[u32]) -> f64) {
        let mut end = span[1];
        let blocks = Lattice {
            origin: self.origin,
            cell: self.cell * BLOCK as f64,
            count: self.blocks,
        };
        let cells = Lattice {
            origin: self.origin,
            cell: self.cell,
            count: self.count,
        };
        blocks.walk(
            ray,
            [span[0], end],
            [0, 0],
            self.blocks,
            |b, [enter, leave]| {
                if enter > end {
                    return false;
                }
                if !meets(
                    ray,
                    [enter, leave],
                    self.block_range[b[1] * self.blocks[0] + b[0]],
                ) {
                    return true;
                }
                let first = b.map(|k| k * BLOCK);
                let last = [0, 1].map(|axis| (first[axis] + BLOCK).min(self.count[axis]));
                cells.walk(ray, [enter, leave], first, last, |c, [enter, leave]| {
                    if enter > end {
                        return false;
                    }
                    let k = c[1] * self.count[0] + c[0];
                    if meets(ray, [enter, leave], self.cell_range[k]) {
                        let facets =
                            &self.facets[self.start[k] as usize..self.start[k + 1] as usize];
                        end = end.min(visit(facets));
                    }
                    true
                });
                true
            },
        );
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
struct Lattice {
    origin: DVec2,
    cell: f64,
    count: [usize; 2],
}

impl Lattice {
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
        let (origin, direction) = (
            ray.origin.truncate() - self.origin,
            ray.direction.truncate(),
        );
        for axis in 0..2 {
            let (o, d) = (origin[axis], direction[axis]);
            let (lo, hi) = (
                self.cell * first[axis] as f64,
                self.cell * last[axis] as f64,
            );
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
