//! Frames of a video through a mirror -> frames of a panorama, a view or a plan.

use super::RemapTable;
use super::plane_table::PlaneTable;
use crate::parallel;
use crate::video::{PixelFormat, VideoFrame};

/// Resampling of the planes of a video's frames.
///
/// Code values are resampled as they are, as by OpenCV's `remap` with `INTER_CUBIC`: no linear light, and one place for each sample where a
/// still picture has the mean of several. Every value is in whole numbers and by itself: its bits depend neither on the machine nor on
/// the number of threads.
#[derive(Debug)]
pub struct FrameTable {
    pixels: PixelFormat,
    /// Of the first plane, and of the others where these have other samples.
    planes: Vec<PlaneTable>,
    /// Number of the table of each plane.
    of_plane: Vec<usize>,
}

impl FrameTable {
    /// The tables of a map for frames of the photo's size with such pixels.
    #[must_use]
    pub fn new(map: &RemapTable, pixels: PixelFormat) -> Self {
        let mut grids = Vec::new();
        let mut number = |grid| {
            grids.iter().position(|known| *known == grid).unwrap_or_else(|| {
                grids.push(grid);
                grids.len() - 1
            })
        };
        let of_plane = pixels.grids().map(&mut number).collect();
        let planes = grids.iter().map(|grid| PlaneTable::new(map, *grid)).collect();
        Self { pixels, planes, of_plane }
    }

    /// Paints the picture of a frame.
    ///
    /// # Panics
    /// When one of them has another size or other planes than the table is for.
    pub fn paint(&self, photo: &VideoFrame, picture: &mut VideoFrame) {
        let mut rows = Vec::new();
        for (k, plane) in picture.planes.iter_mut().enumerate() {
            let table = &self.planes[self.of_plane[k]];
            assert_eq!(plane.len(), table.width * table.height(), "the size that the table is for");
            let (from, black) = (&photo.planes[k][..], self.pixels.black_of(k));
            let lines = plane.chunks_exact_mut(table.width).enumerate();
            rows.extend(lines.map(|(y, row)| (table, y, from, black, row)));
        }
        parallel::for_each_mut(&mut rows, 1, |_, (table, y, from, black, row)| {
            table.resample(*y, from, *black, row);
        });
    }
}
