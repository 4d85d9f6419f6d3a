//! One frame: planes of code values, and how they lie in a stream.

use super::pixel_format::LEAST_SIDE;
use super::{PixelFormat, VideoError};
use crate::raster::{MOST_PIXELS, MOST_SIDE};

/// Code values of a frame, plane by plane, each row by row from the top left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VideoFrame {
    /// The planes: luma and two of chroma; grey; or red, green and blue.
    pub planes: Vec<Vec<u8>>,
}

impl VideoFrame {
    /// A frame of `size` pixels with zeros.
    #[must_use]
    pub fn new(format: &PixelFormat, size: [usize; 2]) -> Self {
        let plane = |[width, height]: [usize; 2]| vec![0; width * height];
        Self { planes: format.grids().map(|grid| plane(grid.count(size))).collect() }
    }

    /// The same values with those of a pixel one after the other.
    pub(super) fn interleave(&self, bytes: &mut [u8]) {
        let [red, green, blue] = &self.planes[..] else { return };
        for (pixel, ((r, g), b)) in bytes.chunks_exact_mut(3).zip(red.iter().zip(green).zip(blue)) {
            pixel.copy_from_slice(&[*r, *g, *b]);
        }
    }

    /// Takes values that come pixel by pixel.
    pub(super) fn separate(&mut self, bytes: &[u8]) {
        let [red, green, blue] = &mut self.planes[..] else { return };
        for (pixel, ((r, g), b)) in bytes.chunks_exact(3).zip(red.iter_mut().zip(green).zip(blue)) {
            [*r, *g, *b] = [pixel[0], pixel[1], pixel[2]];
        }
    }
}

/// The size of frames that can be taken.
///
/// # Errors
/// [`VideoError::Size`] of any other.
pub(super) fn checked_size(size: [usize; 2]) -> Result<[usize; 2], VideoError> {
    let fits = size.iter().all(|side| (LEAST_SIDE..=MOST_SIDE as usize).contains(side));
    let is_small = fits && size[0] as u64 * size[1] as u64 <= MOST_PIXELS;
    if is_small { Ok(size) } else { Err(VideoError::Size { size }) }
}
