//! Where the rays of pixels cross the reference plane behind a lens that bends lines, and which pixels a part of that
//! plane has.
//!
//! A facet is a triangle on the plane as the pinhole sees it, whatever the lens; its picture has bent sides. The pixels
//! that it may cover are therefore looked up where it is straight: in square cells of the plane, each of which knows
//! the block of pixels whose rays cross it, and in cells of twice, four times ... the size for larger facets.

use super::camera_rays::ChartedRows;
use super::fragment::PixelSpan;
use crate::geom::DVec2;
use crate::optics::Camera;
use crate::parallel;

/// Most cells to a pixel; fewer where the lens shows the plane's rim much coarser than its middle.
const CELLS_PER_PIXEL: f64 = 2.0;
/// Most cells to a side: a [`PixelSpan`] holds them as 16-bit integers.
const MOST_CELLS: f64 = 16_384.0;
/// Most cells of a level that a block is looked up in.
const LOOKUPS: usize = 64;
/// Pixels of a row that are held together against a large facet.
const STRETCH: usize = 16;

/// Block of pixels: first column and row, and those after the last.
type PixelBlock = [u16; 4];

/// The block of no pixels.
const NONE: PixelBlock = [u16::MAX, u16::MAX, 0, 0];

fn union(a: PixelBlock, b: PixelBlock) -> PixelBlock {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

/// Cells of one size.
#[derive(Debug)]
struct Level {
    /// Columns and rows.
    size: [usize; 2],
    blocks: Vec<PixelBlock>,
}

impl Level {
    /// Cells of twice the size.
    fn halved(&self) -> Self {
        let size = self.size.map(|n| n.div_ceil(2));
        let mut blocks = vec![NONE; size[0] * size[1]];
        for (y, row) in self.blocks.chunks(self.size[0]).enumerate() {
            let above = &mut blocks[y / 2 * size[0]..][..size[0]];
            for (above, pair) in above.iter_mut().zip(row.chunks(2)) {
                *above = pair.iter().fold(*above, |all, block| union(all, *block));
            }
        }
        Self { size, blocks }
    }
}

/// The pixels of some rows by where their rays cross the reference plane.
#[derive(Debug)]
pub(super) struct PixelTable {
    /// The corner of the first cell, mm.
    corner: DVec2,
    /// Cells to a mm.
    per_mm: f64,
    levels: Vec<Level>,
    columns: usize,
    first_row: usize,
    /// Least and largest chart coordinates of each stretch of pixels, row by row, mm.
    stretches: Vec<[DVec2; 2]>,
}

impl PixelTable {
    /// The table of charted rows of `camera`.
    pub(super) fn new(camera: &Camera, rows: &ChartedRows) -> Self {
        let columns = camera.pixels[0] as usize;
        let of_row = columns.div_ceil(STRETCH);
        let stretch = |k: usize| {
            let row = &rows.points[k / of_row * columns..][..columns];
            bounds(&row[k % of_row * STRETCH..columns.min((k % of_row + 1) * STRETCH)])
        };
        let stretches = parallel::map(rows.points.len() / columns * of_row, of_row, stretch);
        let [lo, hi] = bounds(stretches.as_flattened());
        let extent = (hi - lo).max(DVec2::splat(camera.pixel_mm));
        let cells = CELLS_PER_PIXEL * rows.points.len() as f64;
        let per_mm = f64::sqrt(cells / (extent.x * extent.y))
            .min(1.0 / camera.pixel_mm)
            .min(MOST_CELLS / extent.max_element());
        let size = (extent * per_mm).to_array().map(|n| n as usize + 1);
        let mut finest = Level { size, blocks: vec![NONE; size[0] * size[1]] };
        for (row, points) in (rows.first..).zip(rows.points.chunks(columns)) {
            for (column, q) in points.iter().enumerate().filter(|(_, q)| q.is_finite()) {
                let [x, y] = ((*q - lo) * per_mm).to_array().map(|n| n as usize);
                let [column, row] = [column, row].map(|n| n as u16);
                let block = &mut finest.blocks[y * size[0] + x];
                *block = union(*block, [column, row, column + 1, row + 1]);
            }
        }
        let mut levels = vec![finest];
        while let Some(last) = levels.last().filter(|last| last.size.iter().any(|&n| n > 1)) {
            levels.push(last.halved());
        }
        Self { corner: lo, per_mm, levels, columns, first_row: rows.first, stretches }
    }

    /// The span, in cells, of chart coordinates with an uncertainty of `margin_mm`.
    #[inline]
    pub(super) fn span(&self, q: DVec2, margin_mm: f64) -> PixelSpan {
        let cell = |at: DVec2, after: f64| {
            let at = (at - self.corner) * self.per_mm;
            let within = |x: f64, n: usize| (x.floor() + after).clamp(0.0, n as f64) as i16;
            let [columns, rows] = self.levels[0].size;
            [within(at.x, columns), within(at.y, rows)]
        };
        let [left, lower] = cell(q - margin_mm, 0.0);
        let [right, upper] = cell(q + margin_mm, 1.0);
        [left, lower, -right, -upper]
    }

    /// The span of the pixels whose rays cross the cells of a span.
    pub(super) fn pixels(&self, [left, lower, right, upper]: PixelSpan) -> PixelSpan {
        if left >= -right || lower >= -upper {
            return [0; 4];
        }
        let [mut first, mut last] =
            [[left, lower], [-right - 1, -upper - 1]].map(|cell| cell.map(|n| n as usize));
        let mut level = 0;
        while (last[0] - first[0] + 1) * (last[1] - first[1] + 1) > LOOKUPS {
            (first, last, level) = (first.map(|n| n / 2), last.map(|n| n / 2), level + 1);
        }
        let Level { size, blocks } = &self.levels[level];
        let mut found = NONE;
        for y in first[1]..=last[1] {
            for x in first[0]..=last[0] {
                found = union(found, blocks[y * size[0] + x]);
            }
        }
        if found == NONE {
            return [0; 4];
        }
        let [left, upper, right, lower] = found.map(|n| n as i16);
        [left, upper, -right, -lower]
    }

    /// The stretches of a row's `columns`, each with the one after its last, whose pixels a triangle of these chart
    /// coordinates may cover, which are uncertain by `margin_mm`.
    pub(super) fn stretches(
        &self,
        triangle: [DVec2; 3],
        margin_mm: f64,
        row: usize,
        [left, right]: [usize; 2],
    ) -> impl Iterator<Item = [usize; 2]> {
        let first = (row - self.first_row) * self.columns.div_ceil(STRETCH);
        (left / STRETCH..right.div_ceil(STRETCH))
            .filter(move |k| may_meet(triangle, self.stretches[first + k], margin_mm))
            .map(move |k| [left.max(k * STRETCH), right.min((k + 1) * STRETCH)])
    }
}

/// Least and largest coordinates of the points that are finite.
fn bounds(points: &[DVec2]) -> [DVec2; 2] {
    let finite = || points.iter().filter(|q| q.is_finite());
    let lo = finite().fold(DVec2::INFINITY, |lo, q| lo.min(*q));
    let hi = finite().fold(DVec2::NEG_INFINITY, |hi, q| hi.max(*q));
    [lo, hi]
}

/// Whether no side of a triangle parts it from a box that is wider by `margin` all around; boxes without points are
/// parted.
fn may_meet(triangle: [DVec2; 3], [lo, hi]: [DVec2; 2], margin: f64) -> bool {
    let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo) + margin);
    lo.x <= hi.x
        && (0..3).all(|k| {
            let [a, b, c] = [0, 1, 2].map(|step| triangle[(k + step) % 3]);
            let across = (b - a).perp();
            let reach = half.dot(across.abs());
            let [of_box, of_corner] = [middle, c].map(|q| across.dot(q - a));
            // (A triangle without area parts nothing.)
            if of_corner >= 0.0 { of_box >= -reach } else { of_box <= reach }
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_part_boxes_beyond_them() {
        let triangle = [DVec2::ZERO, DVec2::new(4.0, 0.0), DVec2::new(0.0, 4.0)];
        let around = |x: f64, y: f64| [DVec2::new(x, y) - 0.5, DVec2::new(x, y) + 0.5];
        for [a, b, c] in [[0, 1, 2], [2, 1, 0]] {
            let triangle = [a, b, c].map(|k: usize| triangle[k]);
            for (x, y, meets) in [
                (1.0, 1.0, true),
                (-0.4, 2.0, true),
                (-0.6, 2.0, false),
                (2.4, 2.4, true),
                (2.6, 2.6, false),
                (2.0, -0.6, false),
            ] {
                assert_eq!(may_meet(triangle, around(x, y), 0.0), meets, "{x} {y}");
            }
            assert!(may_meet(triangle, around(-0.6, 2.0), 0.2));
            assert!(!may_meet(triangle, bounds(&[DVec2::NAN]), 1.0));
        }
    }
}
