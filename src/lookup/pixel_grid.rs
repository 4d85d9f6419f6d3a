//! The nodes of a table over a frame.

/// Corners of pixels of a frame from which on some are left out, where nodes are farther apart than pixels.
const MANY: f64 = 1e6;

/// Nodes in the middles of the blocks of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelGrid {
    /// Pixels of the frame, across and down.
    pub frame: [usize; 2],
    /// Pixels along each side of a block; blocks at the right and at the lower edge may reach beyond the frame.
    pub every: usize,
}

impl PixelGrid {
    /// Nodes across and down.
    #[must_use]
    pub fn nodes(&self) -> [usize; 2] {
        self.frame.map(|pixels| pixels.div_ceil(self.every))
    }

    /// Number of the nodes.
    #[must_use]
    pub fn count(&self) -> usize {
        let [columns, rows] = self.nodes();
        columns * rows
    }

    /// Cells across and down.
    #[must_use]
    pub fn cells(&self) -> [usize; 2] {
        self.nodes().map(|nodes| nodes.saturating_sub(1))
    }

    /// Place of node `k`, row by row, in pixels from the frame's upper left corner, to the right and down.
    #[must_use]
    pub fn node(&self, k: usize) -> [f64; 2] {
        let [columns, _] = self.nodes();
        [k % columns, k / columns].map(|index| (index as f64 + 0.5) * self.every as f64)
    }

    /// Places at which a table is held against what is known: corners of pixels, all of a frame that is not large, and the middle of each
    /// cell at least.
    #[must_use]
    pub fn places_between(&self) -> Vec<[f64; 2]> {
        let [width, height] = self.frame;
        let apart = ((width * height) as f64 / MANY).sqrt().ceil() as usize;
        // (Middles of cells are at multiples of what nodes are apart.)
        let step = (1..=self.every)
            .rev()
            .find(|k| self.every.is_multiple_of(*k) && *k <= apart)
            .unwrap_or(1);
        let across = move |y: usize| (step..width).step_by(step).map(move |x| [x, y]);
        let all = (step..height).step_by(step).flat_map(across);
        all.map(|corner| corner.map(|x| x as f64)).collect()
    }

    /// The cell that is read at a place, and where in it that is: from 0 to 1 in the cell, beyond that beside the outermost nodes.
    #[must_use]
    pub fn cell(&self, place: [f64; 2]) -> ([usize; 2], [f64; 2]) {
        let cells = self.cells();
        let on = place.map(|x| x / self.every as f64 - 0.5);
        let cell: [usize; 2] = std::array::from_fn(|axis| {
            (on[axis].floor().max(0.0) as usize).min(cells[axis].saturating_sub(1))
        });
        (cell, std::array::from_fn(|axis| on[axis] - cell[axis] as f64))
    }

    /// Numbers of the nodes of a cell: upper left, upper right, lower left, lower right.
    #[must_use]
    pub fn corners(&self, [column, row]: [usize; 2]) -> [usize; 4] {
        let [columns, _] = self.nodes();
        let first = row * columns + column;
        [first, first + 1, first + columns, first + columns + 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames with more corners of pixels than are taken, too: a cell without a place would tell nothing.
    #[test]
    fn every_cell_has_a_place_in_its_middle() {
        for (frame, every) in [
            ([1280, 960], 1),
            ([2028, 1520], 2),
            ([2028, 1520], 3),
            ([4056, 3040], 4),
            ([33, 20], 5),
        ] {
            let grid = PixelGrid { frame, every };
            let [columns, rows] = grid.cells();
            let mut has_middle = vec![false; columns * rows];
            for place in grid.places_between() {
                let ([column, row], share) = grid.cell(place);
                has_middle[row * columns + column] |= share == [0.5; 2];
            }
            assert!(has_middle.into_iter().all(|has| has), "{frame:?} {every}");
        }
    }
}
