//! A grid of bins in which the points near a place are found.

use crate::geom::DVec2;
use crate::mesh::sizing::frame_field::{FrameField, cell_extent};

/// The number of no point.
const NONE: u32 = u32::MAX;
/// Bins to the side, at most: 32 MB in all.
const MOST_BINS: f64 = 2000.0;

/// Numbers of points by bin.
pub(crate) struct SpatialGrid {
    min: DVec2,
    scale: DVec2,
    width: usize,
    height: usize,
    /// The last point of each bin, and for each point the one before it in its bin.
    first: Vec<u32>,
    next: Vec<u32>,
}

impl SpatialGrid {
    /// An empty grid over the domain of `frames`, with bins about as large as its cells.
    pub(crate) fn new(frames: &FrameField) -> Self {
        let domain = frames.sizing.domain();
        // The mean is that of small cells: large ones that cover many bins cost little, but bins with many points cost
        // their number squared.
        let size = frames
            .sizing
            .cell_centres()
            .map(|q| cell_extent(&frames.at(q)))
            .fold(DVec2::splat(0.0), |sum, e| sum + e.recip());
        let count = frames.sizing.cell_centres().count() as f64;
        let bins = (domain.size() * size / count).ceil().clamp(DVec2::ONE, DVec2::splat(MOST_BINS));
        let (width, height) = (bins.x as usize, bins.y as usize);
        Self {
            min: domain.min,
            scale: bins / domain.size(),
            width,
            height,
            first: vec![NONE; width * height],
            next: Vec::new(),
        }
    }

    fn bin(&self, q: DVec2) -> [usize; 2] {
        let place = (q - self.min) * self.scale;
        [
            (place.x.max(0.0) as usize).min(self.width - 1),
            (place.y.max(0.0) as usize).min(self.height - 1),
        ]
    }

    /// Adds the point at `q`; numbers are those of the calls.
    pub(crate) fn add(&mut self, q: DVec2, index: u32) {
        let [i, j] = self.bin(q);
        let slot = j * self.width + i;
        self.next.push(self.first[slot]);
        self.first[slot] = index;
    }

    /// Visits the points of all bins that the box from `lo` to `hi` touches.
    pub(crate) fn each(&self, lo: DVec2, hi: DVec2, mut visit: impl FnMut(u32)) {
        let ([i0, j0], [i1, j1]) = (self.bin(lo), self.bin(hi));
        for j in j0..=j1 {
            for i in i0..=i1 {
                let mut at = self.first[j * self.width + i];
                while at != NONE {
                    visit(at);
                    at = self.next[at as usize];
                }
            }
        }
    }
}
