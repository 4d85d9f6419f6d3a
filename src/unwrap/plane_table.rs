//! The remap table of one plane of a video's frames, worked out for speed: for each sample of the picture which samples of the photo it is
//! made of, and by which kernel.

use super::RemapTable;
use super::cubic_kernel::{Taps, kernels, sampled};
use crate::parallel;
use crate::video::PlaneGrid;
use std::ops::Range;

/// Resampling of a plane.
#[derive(Debug)]
pub(super) struct PlaneTable {
    /// Samples of the picture's plane across.
    pub width: usize,
    /// Samples of the photo's plane across.
    from_width: usize,
    rows: Vec<PlaneRow>,
}

/// A row of the picture's plane.
#[derive(Debug)]
struct PlaneRow {
    /// Index in the photo's plane of the upper left of the 4 x 4 samples that each is made of.
    first: Vec<u32>,
    /// Number of the kernel of each.
    kernel: Vec<u16>,
    /// Columns at which nothing is seen.
    unseen: Vec<Range<usize>>,
}

impl PlaneTable {
    /// The table of a plane with samples at `grid`, in the photo as in the picture.
    pub(super) fn new(map: &RemapTable, grid: PlaneGrid) -> Self {
        let [from_width, from_height] = grid.count(map.photo);
        let panels: Vec<_> = (0..map.panels())
            .map(|panel| {
                let [columns, rows] = map.panel_pixels(panel);
                let [columns, rows] = [(0, columns), (1, rows)]
                    .map(|(axis, pixels)| within(grid, axis, &pixels, map.photo[axis]));
                let is_wide = columns.len() >= 4 && rows.len() >= 4;
                if is_wide { [columns, rows] } else { [0..from_width, 0..from_height] }
            })
            .collect();
        let [width, height] = grid.count(map.size);
        let row = |y: usize| {
            let taps = |x: usize| {
                let (place, panel) = place(map, grid, [x, y])?;
                let [columns, rows] = &panels[panel];
                let [x, y] = grid.sample(place);
                let (across, down) = (Taps::at(x, columns), Taps::at(y, rows));
                let first = down.first * from_width + across.first;
                Some((first as u32, Taps::kernel(across, down)))
            };
            let taps: Vec<_> = (0..width).map(taps).collect();
            let unseen = runs(width, |x| taps[x].is_none());
            let (first, kernel) = taps.into_iter().map(Option::unwrap_or_default).unzip();
            PlaneRow { first, kernel, unseen }
        };
        Self { width, from_width, rows: parallel::map(height, 1, row) }
    }

    /// Rows of the picture's plane.
    pub(super) fn height(&self) -> usize {
        self.rows.len()
    }

    /// Row `y` of the picture's plane from the photo's plane.
    pub(super) fn resample(&self, y: usize, from: &[u8], black: u8, row: &mut [u8]) {
        let PlaneRow { first, kernel, unseen } = &self.rows[y];
        let kernels = kernels();
        for ((first, kernel), value) in first.iter().zip(kernel).zip(&mut *row) {
            *value = sampled(from, self.from_width, *first, &kernels[usize::from(*kernel)]);
        }
        for columns in unseen {
            row[columns.clone()].fill(black);
        }
    }
}

/// The place in the photo, px, of a sample of the picture, and the panel that shows it: the mean of the pixels that the sample is between,
/// as far as these are seen next to each other.
fn place(map: &RemapTable, grid: PlaneGrid, at: [usize; 2]) -> Option<([f64; 2], usize)> {
    let [columns, rows] = [0, 1].map(|axis| grid.pixels(axis, at[axis], map.size[axis]));
    let pixels = rows.map(|y| columns.map(|x| map.places[y * map.size[0] + x]));
    let mut seen = pixels.into_iter().flatten().filter(|place| !place[0].is_nan());
    let first = seen.next()?;
    let (mut sum, mut count) = (first.map(f64::from), 1.0);
    for place in seen.filter(|place| map.are_neighbours(first, *place)) {
        sum = [0, 1].map(|k| sum[k] + f64::from(place[k]));
        count += 1.0;
    }
    Some((sum.map(|sum| sum / count), map.panel(first)))
}

/// Samples of an axis of `count` pixels that lie in these pixels alone.
fn within(grid: PlaneGrid, axis: usize, pixels: &Range<usize>, count: usize) -> Range<usize> {
    let (step, first) = (grid.step[axis] as f64, grid.first[axis]);
    let samples = grid.count([count; 2])[axis];
    let from = ((pixels.start as f64 + 0.5 - first) / step).ceil().max(0.0) as usize;
    let to = ((pixels.end as f64 - 0.5 - first) / step).floor() as usize + 1;
    from..if pixels.end == count { samples } else { to.min(samples) }
}

/// The runs of `0..count` for which `is_in` holds.
fn runs(count: usize, is_in: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for k in (0..count).filter(|k| is_in(*k)) {
        match runs.last_mut() {
            Some(run) if run.end == k => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::video::PixelFormat;

    #[test]
    fn samples_that_lie_across_an_edge_of_a_panel_are_left_out() {
        let centred = PixelFormat::Y4M[0].others.unwrap();
        let upper = PixelFormat::Y4M[2].others.unwrap();
        for (grid, pixels, samples) in [
            (PlaneGrid::PIXELS, 3..9, 3..9),
            (centred, 0..5, 0..2),
            (centred, 5..11, 3..6),
            (centred, 4..10, 2..5),
            (upper, 0..5, 0..3),
            (upper, 5..11, 3..6),
        ] {
            assert_eq!(within(grid, 0, &pixels, 11), samples, "{grid:?} {pixels:?}");
        }
    }

    #[test]
    fn runs_are_as_long_as_they_go() {
        assert_eq!(runs(6, |k| k != 2 && k != 5), [0..2, 3..5]);
        assert!(runs(3, |_| false).is_empty());
    }
}
