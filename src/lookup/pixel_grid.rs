//! The nodes of a table over a frame.

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
