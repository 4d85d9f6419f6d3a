//! The map as a file for other programs.
//!
//! Both formats hold, for each pixel of the picture, the column and the row of the photo in the
//! convention of OpenCV's `remap`: pixel centres at whole numbers, the first one's at (0, 0); -1 where
//! nothing is seen.

use super::RemapTable;
use crate::raster::npy;
use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, Vec2, WritableImage,
};
use std::io::Cursor;
use thiserror::Error;

/// A map could not be encoded.
#[derive(Debug, Error)]
#[error("the map cannot be encoded: {0}")]
pub struct MapEncodingError(#[from] exr::error::Error);

impl RemapTable {
    /// Column and row for pixel `k`.
    fn entry(&self, k: usize) -> [f32; 2] {
        let place = self.places[k];
        if place[0].is_nan() { [-1.0; 2] } else { place.map(|x| x - 0.5) }
    }

    /// Column and row of the photo for each pixel of the picture, row by row from the top left, in the convention of OpenCV's `remap`:
    /// pixel centres are at whole numbers; -1 where nothing is seen.
    #[must_use]
    pub fn entries(&self) -> Vec<[f32; 2]> {
        (0..self.places.len()).map(|k| self.entry(k)).collect()
    }

    /// A NumPy array of shape (rows, columns, 2) in single precision, little-endian.
    #[must_use]
    pub fn npy(&self) -> Vec<u8> {
        let [width, height] = self.size;
        npy(&[height, width, 2], (0..self.places.len()).flat_map(|k| self.entry(k)))
    }

    /// An OpenEXR picture with two channels in single precision, losslessly compressed: R is the column, G the row.
    ///
    /// # Errors
    /// [`MapEncodingError`] when there is not room enough.
    pub fn exr(&self) -> Result<Vec<u8>, MapEncodingError> {
        let [width, height] = self.size;
        let value = |at: Vec2<usize>| {
            let [x, y] = self.entry(at.y() * width + at.x());
            (x, y)
        };
        let channels =
            SpecificChannels::build().with_channel("R").with_channel("G").with_pixel_fn(value);
        let attributes = LayerAttributes::named(Text::new_or_panic("map"));
        let layer = Layer::new((width, height), attributes, Encoding::SMALL_LOSSLESS, channels);
        let mut bytes = Cursor::new(Vec::new());
        Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes)?;
        Ok(bytes.into_inner())
    }
}
