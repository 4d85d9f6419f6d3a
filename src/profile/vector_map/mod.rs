//! Maps of a picture: a vector for each of a grid of image points, from NumPy, OpenEXR or text.

mod npy;
mod text;

use crate::geom::DVec3;
use crate::raster::exr_channels;
use thiserror::Error;

/// Most samples: each takes 64 bytes of interpolation. Between samples its error falls with the fourth power of their
/// distance, so that a smooth picture needs far fewer than a frame has pixels.
const MOST_SAMPLES: usize = 4_000_000;
/// Most bytes of a file: some 100 for each sample, as text.
pub(super) const MOST_BYTES: u64 = 400_000_000;

/// Vectors on a grid over a picture, row by row from the upper left.
#[derive(Debug, Clone, PartialEq)]
pub struct VectorMap {
    /// Vectors in a row.
    pub columns: usize,
    /// The vectors; of not-a-numbers where the picture may show anything.
    pub vectors: Vec<DVec3>,
}

/// Reason why a file holds no map.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VectorMapError {
    /// Of none of the three formats.
    #[error("it is no NumPy array (.npy), no OpenEXR picture (.exr) and no text (.csv)")]
    Unknown,
    /// A NumPy file that is damaged or of a kind that is not read.
    #[error("NumPy array: {0}")]
    Npy(String),
    /// A picture that is damaged, or without its channels.
    #[error("{0}")]
    Exr(String),
    /// A line of text that is no sample.
    #[error("line {line}: {account}")]
    Text {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        account: String,
    },
    /// No samples.
    #[error("it holds no samples")]
    Empty,
    /// Too many samples.
    #[error(
        "a map must have at most {MOST_SAMPLES} samples, found {found}; between samples it is interpolated to the fourth \
         order, so every second or fourth one will do"
    )]
    TooMany {
        /// Columns times rows.
        found: usize,
    },
}

impl VectorMap {
    /// Reads a NumPy array of shape (rows, columns, 3) in single or double precision, an OpenEXR picture whose
    /// channels R, G and B are X, Y and Z, or lines of row, column, X, Y and Z, both counted from 0; a place without
    /// a line is a gap.
    ///
    /// # Errors
    /// [`VectorMapError`], the first fault met.
    pub fn parse(bytes: &[u8]) -> Result<Self, VectorMapError> {
        if bytes.starts_with(npy::MAGIC) {
            return npy::parse(bytes);
        }
        if bytes.starts_with(b"\x76\x2f\x31\x01") {
            let channels = exr_channels(bytes, [f32::NAN; 3]);
            let ([columns, rows], rgb) =
                channels.map_err(|error| VectorMapError::Exr(error.to_string()))?;
            checked(columns, rows)?;
            let vectors = rgb.into_iter().map(|xyz| DVec3::from_array(xyz.map(f64::from)));
            return Ok(Self { columns, vectors: vectors.collect() });
        }
        let text = std::str::from_utf8(bytes).map_err(|_| VectorMapError::Unknown)?;
        text::parse(text)
    }
}

/// The number of samples of so many columns and rows, if a map may have so many.
fn checked(columns: usize, rows: usize) -> Result<usize, VectorMapError> {
    let found = columns.saturating_mul(rows);
    match found {
        0 => Err(VectorMapError::Empty),
        found if found > MOST_SAMPLES => Err(VectorMapError::TooMany { found }),
        found => Ok(found),
    }
}

#[cfg(test)]
mod tests;
