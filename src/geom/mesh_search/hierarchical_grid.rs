//! A hierarchical grid over the (X, Y) plane that finds the facets near a ray.
//!
//! Mirrors are shallow and rays cross them from above, so two dimensions suffice: each cell lists
//! the facets over it and their range of Z, each coarser cell the range of its cells. A ray visits
//! the cells under it in order and skips those whose range it does not enter. Facets larger
//! than a coarsest cell, of which a solid has few, are listed there.

use super::uniform_grid::{CellLists, GridRay, UniformGrid, ZRange};
use crate::geom::{DVec2, DVec3, Ray, TriMesh};
use crate::parallel;

/// Levels of the hierarchy.
const LEVELS: usize = 3;
/// Cells of one level along the side of a cell of the next.
const STEP: usize = 6;
/// Facets per finest cell that the grid aims at.
const FACETS_PER_CELL: f64 = 1.5;
/// Largest number of finest cells: a bound of memory, whatever the number of facets.
const MOST_CELLS: f64 = 6.4e7;

/// Uniform grids over the plane, finest first.
#[derive(Debug, Clone)]
pub(crate) struct HierarchicalGrid {
    origin: DVec2,
    levels: [UniformGrid; LEVELS],
    /// Facets no larger than a coarsest cell, by finest cell.
    small: CellLists,
    /// The others, by coarsest cell.
    large: CellLists,
    /// Range of Z of the small facets in each cell of the levels above the finest.
    ranges: [Vec<ZRange>; LEVELS],
}

impl HierarchicalGrid {
    /// The grids over `mesh`.
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let (lo, hi) = mesh.bounds().unwrap_or((DVec3::ZERO, DVec3::ZERO));
        let extent = Some((hi - lo).max_element()).filter(|&e| e > 0.0).unwrap_or(1.0);
        let size = (hi - lo).truncate().max(DVec2::splat(1e-6 * extent));
        let wanted = (mesh.triangles.len() as f64 / FACETS_PER_CELL).clamp(1.0, MOST_CELLS);
        let cell = (size.x * size.y / wanted).sqrt();
        // A margin keeps every facet inside, and rays along the rim off the last edge.
        let origin = lo.truncate() - DVec2::splat(0.25 * cell);
        let count = [size.x, size.y].map(|s| ((s / cell).ceil() as usize + 1).max(1));
        let levels: [UniformGrid; LEVELS] = std::array::from_fn(|level| {
            let cells = STEP.pow(level as u32);
            UniformGrid::new(cell * cells as f64, count.map(|n| n.div_ceil(cells)))
        });

        let (finest, coarsest) = (&levels[0], &levels[LEVELS - 1]);
        let corners = |t: u32| mesh.corners(t as usize).map(|v| v - origin.extend(0.0));
        let spans =
            parallel::map(mesh.triangles.len(), 1 << 14, |t| finest.span(corners(t as u32)));
        let most = STEP.pow(LEVELS as u32 - 1) as u32;
        let (small, large): (Vec<_>, Vec<_>) = (0..)
            .zip(&spans)
            .map(|(t, &span)| (t, span))
            .partition(|(_, [first, last])| last[0] - first[0] < most && last[1] - first[1] < most);
        let large: Vec<_> = large
            .into_iter()
            .map(|(t, span)| (t, span.map(|corner| corner.map(|k| k / most))))
            .collect();
        let (small, large) = parallel::join(
            || finest.cell_lists(&small, corners),
            || coarsest.cell_lists(&large, corners),
        );
        let mut ranges: [Vec<ZRange>; LEVELS] = Default::default();
        for level in 1..LEVELS {
            let below = if level == 1 { &small.ranges } else { &ranges[level - 1] };
            ranges[level] = levels[level].gather(&levels[level - 1], STEP, below);
        }
        Self { origin, levels, small, large, ranges }
    }

    /// X of the borders between the columns of cells of every level.
    #[cfg(test)]
    pub(crate) fn borders(&self) -> Vec<f64> {
        let columns = |grid: &UniformGrid| {
            (0..=grid.count[0]).map(|k| grid.border(k) + self.origin.x).collect::<Vec<_>>()
        };
        self.levels.iter().flat_map(columns).collect()
    }

    /// Visits, in the order of the ray, the facets that it may meet ahead of its origin. `visit`
    /// gets the facets and returns the distance beyond which nothing matters any more.
    #[inline]
    pub(crate) fn walk(&self, ray: &Ray, mut visit: impl FnMut(&[u32]) -> f64) {
        let ray = GridRay::new(ray, self.origin);
        let mut end = f64::INFINITY;
        let top = LEVELS - 1;
        let grid = &self.levels[top];
        grid.walk(&ray, [0.0, end], [0, 0], grid.count, |at, [enter, leave]| {
            self.enter(top, at, &ray, [enter, leave], &mut end, &mut visit);
            let cell = grid.index(at);
            if enter <= end && ray.meets([enter, leave.min(end)], self.large.ranges[cell]) {
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
        ray: &GridRay,
        [enter, leave]: [f64; 2],
        end: &mut f64,
        visit: &mut impl FnMut(&[u32]) -> f64,
    ) {
        let cell = self.levels[level].index(at);
        let range = if level == 0 { self.small.ranges[cell] } else { self.ranges[level][cell] };
        if enter > *end || !ray.meets([enter, leave], range) {
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
