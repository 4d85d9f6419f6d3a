//! Picture files to linear light: one reader a format, the checks that all of them share.

mod exif;
mod exr;
mod jpeg;
mod png;
#[cfg(test)]
mod tests;

pub use exr::channels as exr_channels;

use super::{MOST_PIXELS, MOST_SIDE, Raster, RasterError};

/// The first bytes of a picture file, by which its format is known.
const SIGNATURES: [(&[u8], Reader); 3] = [
    (b"\x89PNG\r\n\x1a\n", png::decode),
    (b"\xff\xd8\xff", jpeg::decode),
    (b"\x76\x2f\x31\x01", exr::decode),
];

type Reader = fn(&[u8]) -> Result<Raster, RasterError>;

/// See [`Raster::decode`].
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, RasterError> {
    let known = SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature));
    known.map_or(Err(RasterError::Unknown), |(_, reader)| reader(bytes))
}

/// Columns and rows, if a raster may have so many.
fn checked(width: u32, height: u32) -> Result<[usize; 2], RasterError> {
    let side = 1..=MOST_SIDE;
    let pixels = u64::from(width) * u64::from(height);
    if side.contains(&width) && side.contains(&height) && pixels <= MOST_PIXELS {
        Ok([width as usize, height as usize])
    } else {
        Err(RasterError::Size { width, height })
    }
}

/// One pixel's colour from its samples: grey, grey and opacity, RGB, or RGB and opacity.
fn colour<T: Copy, U>(samples: &[T], light: impl Fn(T) -> U) -> [U; 3] {
    match *samples {
        [grey] | [grey, _] => [grey; 3].map(light),
        [red, green, blue, ..] => [red, green, blue].map(light),
        [] => unreachable!("a pixel has at least one sample"),
    }
}
