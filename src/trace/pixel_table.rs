//! Where the rays of pixels cross the reference plane behind a lens that bends lines, and which pixels a part of that
//! plane has.
//!
//! A facet is a triangle on the plane as the pinhole sees it, whatever the lens; its picture has bent sides. The pixels
//! that it may cover are therefore looked up where it is straight: in square cells of the plane, each of which knows
//! the block of pixels whose rays cross it, and in cells of twice, four times ... the size for larger facets.

use super::camera_rays::CameraRays;
use super::fragment::PixelSpan;
use crate::geom::{DVec2, Ray};
use crate::parallel;
use std::ops::Range;

/// Most cells to a pixel; fewer where the lens shows the plane's rim much coarser than its middle.
const CELLS_PER_PIXEL: f64 = 2.0;
/// Most cells to a side: a [`PixelSpan`] holds them as 16-bit integers.
const MOST_CELLS: f64 = 16_384.0;
/// Most cells of a level that a block is looked up in, along each side.
const LOOKUPS: usize = 4;

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
        for (k, block) in self.blocks.iter().enumerate() {
            let [x, y] = [k % self.size[0], k / self.size[0]];
            let above = &mut blocks[y / 2 * size[0] + x / 2];
            *above = union(*above, *block);
        }
        Self { size, blocks }
    }
}

/// The pixels of some rows by where their rays cross the reference plane.
#[derive(Debug)]
pub(super) struct PixelTable {
    columns: usize,
    first_row: usize,
    /// Chart coordinates of the rays through the pixel centres, row by row, mm.
    charted: Vec<DVec2>,
    /// The corner of the first cell, mm.
    corner: DVec2,
    /// Cells to a mm.
    per_mm: f64,
    levels: Vec<Level>,
}

impl PixelTable {
    /// The table of the pixels of `rows`.
    pub(super) fn new(rays: &CameraRays, rows: Range<usize>) -> Self {
        let columns = rays.camera.pixels[0] as usize;
        let first_row = rows.start;
        let line = |row: usize| {
            let at = move |column| rays.camera.picture.chart_point(rays.image_point(column, row));
            (0..columns).map(at)
        };
        let charted: Vec<DVec2> = parallel::gather(rows.len(), 1, |piece| {
            piece.flat_map(|row| line(first_row + row)).collect()
        });
        let finite = || charted.iter().filter(|q| q.is_finite());
        let lo = finite().copied().fold(DVec2::INFINITY, DVec2::min);
        let hi = finite().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let extent = (hi - lo).max(DVec2::splat(rays.camera.pixel_mm));
        let cells = CELLS_PER_PIXEL * charted.len() as f64;
        let per_mm = f64::sqrt(cells / (extent.x * extent.y))
            .min(1.0 / rays.camera.pixel_mm)
            .min(MOST_CELLS / extent.max_element());
        let size = (extent * per_mm).to_array().map(|n| n as usize + 1);
        let mut finest = Level { size, blocks: vec![NONE; size[0] * size[1]] };
        for (k, q) in charted.iter().enumerate().filter(|(_, q)| q.is_finite()) {
            let [x, y] = ((*q - lo) * per_mm).to_array().map(|n| n as usize);
            let [column, row] = [k % columns, first_row + k / columns].map(|n| n as u16);
            let block = &mut finest.blocks[y * size[0] + x];
            *block = union(*block, [column, row, column + 1, row + 1]);
        }
        let mut levels = vec![finest];
        while let Some(last) = levels.last().filter(|last| last.size.iter().any(|&n| n > 1)) {
            levels.push(last.halved());
        }
        Self { columns, first_row, charted, corner: lo, per_mm, levels }
    }

    /// The ray of a pixel of `rays`.
    #[inline]
    pub(super) fn ray(&self, rays: &CameraRays, column: usize, row: usize) -> Ray {
        let q = self.charted[(row - self.first_row) * self.columns + column];
        rays.camera.chart.ray(q, rays.top_mm)
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
        while (0..2).any(|k| last[k] - first[k] >= LOOKUPS) {
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
}
