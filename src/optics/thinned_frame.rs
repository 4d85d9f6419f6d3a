//! A frame thinned for maps: every pixel, or every second, third, ... one each way.

use std::ops::Range;

/// Those pixels of a frame that a map of it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ThinnedFrame {
    frame: [u32; 2],
    step: usize,
}

impl ThinnedFrame {
    /// Most columns of a map: more would not be told apart on a page.
    pub const MOST_COLUMNS: u32 = 1600;

    /// The pixels of a map of `frame`, columns and rows.
    #[must_use]
    pub fn new(frame: [u32; 2]) -> Self {
        Self::at_most(frame, Self::MOST_COLUMNS)
    }

    /// The pixels of a map of `frame` with so many columns at most.
    #[must_use]
    pub fn at_most(frame: [u32; 2], columns: u32) -> Self {
        Self { frame, step: frame[0].div_ceil(columns).max(1) as usize }
    }

    /// Columns and rows of the map.
    #[must_use]
    pub fn pixels(&self) -> [u32; 2] {
        self.frame.map(|n| n.div_ceil(self.step as u32))
    }

    /// The frame's columns that the map has.
    pub fn columns(&self) -> impl Iterator<Item = usize> + use<> {
        (0..self.frame[0] as usize).step_by(self.step)
    }

    /// Those of the frame's `rows` that the map has.
    pub fn rows(&self, rows: Range<usize>) -> impl Iterator<Item = usize> + use<> {
        let step = self.step;
        rows.filter(move |row| row % step == 0)
    }

    /// Of the values of all pixels of some rows, those of the map's.
    pub fn thin<'a, T>(
        &self,
        rows: Range<usize>,
        values: &'a [T],
    ) -> impl Iterator<Item = &'a T> + use<'a, T> {
        let (first, width, thinned) = (rows.start, self.frame[0] as usize, *self);
        let line =
            move |row: usize| thinned.columns().map(move |x| &values[(row - first) * width + x]);
        self.rows(rows).flat_map(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_together_are_the_map() {
        for width in [640, 1600, 1601, 4056, 9600] {
            let thinned = ThinnedFrame::new([width, 50]);
            let [columns, rows] = thinned.pixels();
            assert!(columns <= ThinnedFrame::MOST_COLUMNS && 2 * columns > width.min(1600));
            let place = |row: usize, x: usize| (row, x);
            let strip = |rows: Range<usize>| {
                let all =
                    rows.clone().flat_map(|row| (0..width as usize).map(move |x| place(row, x)));
                thinned.thin(rows, &all.collect::<Vec<_>>()).copied().collect::<Vec<_>>()
            };
            let whole = strip(0..50);
            assert_eq!(whole.len(), columns as usize * rows as usize);
            assert_eq!([strip(0..17), strip(17..18), strip(18..50)].concat(), whole);
        }
    }
}
