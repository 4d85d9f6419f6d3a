//! Heights of some rows of a grid, with the highest of each tile of its columns.

use crate::geom::DVec2;
use std::ops::Range;

/// Columns of a tile; it has all rows.
const TILE: usize = 16;

/// Z over each place of some rows of a grid, mm, and an upper bound of those of each tile.
pub(super) struct BandHeights {
    columns: usize,
    /// Number of the first row in the grid.
    from: usize,
    /// X and Y of the grid's first place, mm.
    first: DVec2,
    /// Distance of the places, mm.
    pitch_mm: f64,
    heights: Vec<f64>,
    /// Bounds of the tiles, and whether a tile has been lowered since its own was found.
    tiles: Vec<(f64, bool)>,
    /// Highest of all bounds when they were looked at last.
    highest: f64,
}

impl BandHeights {
    /// Rows of `columns` places each, from row `from` on, of a grid with a first place and a distance.
    pub(super) fn new(
        heights: Vec<f64>,
        (columns, from): (usize, usize),
        (first, pitch_mm): (DVec2, f64),
    ) -> Self {
        let tiles = vec![(f64::INFINITY, true); columns.div_ceil(TILE)];
        Self { columns, from, first, pitch_mm, heights, tiles, highest: f64::INFINITY }
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    fn rows(&self) -> usize {
        self.heights.len() / self.columns
    }

    /// The place of a row and a column.
    pub(super) fn place(&self, row: usize, column: usize) -> DVec2 {
        self.first + self.pitch_mm * DVec2::new(column as f64, (self.from + row) as f64)
    }

    pub(super) fn height(&self, k: usize) -> f64 {
        self.heights[k]
    }

    pub(super) fn lower(&mut self, k: usize, z: f64) {
        self.heights[k] = z;
        self.tiles[k % self.columns / TILE].1 = true;
    }

    pub(super) fn into_heights(self) -> Vec<f64> {
        self.heights
    }

    /// Rows and columns of the places that a rectangle may hold, which is given by two opposite corners.
    pub(super) fn within(&self, corners: [DVec2; 2], reach_mm: f64) -> [Range<usize>; 2] {
        let [a, b] = corners.map(|corner| (corner - self.first) / self.pitch_mm);
        let reach = reach_mm / self.pitch_mm;
        let range = |a: f64, b: f64, count: usize| {
            let from = (a.min(b) - reach).ceil().max(0.0);
            let to = (a.max(b) + reach).floor().min(count as f64 - 1.0);
            if to < from { 0..0 } else { from as usize..to as usize + 1 }
        };
        let down = self.from as f64;
        [range(a.y - down, b.y - down, self.rows()), range(a.x, b.x, self.columns)]
    }

    /// Calls `found` for the places of some rows and columns that may be above what it says, which is `least` at first.
    pub(super) fn each_above(
        &mut self,
        [rows, columns]: [Range<usize>; 2],
        mut least: f64,
        mut found: impl FnMut(DVec2, f64) -> f64,
    ) {
        if rows.is_empty() || columns.is_empty() || self.highest <= least {
            return;
        }
        for tile in columns.start / TILE..columns.end.div_ceil(TILE) {
            if self.bound(tile, least) <= least {
                continue;
            }
            let here = columns.start.max(tile * TILE)..columns.end.min((tile + 1) * TILE);
            for row in rows.clone() {
                for column in here.clone() {
                    let z = self.heights[row * self.columns + column];
                    if z > least {
                        least = found(self.place(row, column), z);
                    }
                }
            }
        }
        self.highest = self.tiles.iter().map(|tile| tile.0).fold(f64::NEG_INFINITY, f64::max);
    }

    /// An upper bound of a tile's heights: the highest, if the one that is known is above `least`.
    fn bound(&mut self, tile: usize, least: f64) -> f64 {
        if self.tiles[tile].1 && self.tiles[tile].0 > least {
            let columns = tile * TILE..self.columns.min((tile + 1) * TILE);
            let rows = self.heights.chunks_exact(self.columns);
            let all = rows.flat_map(|row| &row[columns.clone()]).copied();
            self.tiles[tile] = (all.fold(f64::NEG_INFINITY, f64::max), false);
        }
        self.tiles[tile].0
    }
}
