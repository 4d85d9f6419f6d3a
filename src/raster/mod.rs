//! Pictures in linear light: read from files, sampled between their pixels, written as PNG.

mod canvas;
mod decode;
mod false_colour;
mod npy;
pub mod palette;
pub mod png;
pub mod srgb;
mod text;

pub use ::png::EncodingError;
pub use canvas::{Canvas, Srgb};
pub use decode::exr_channels;
#[cfg(test)]
pub(crate) use false_colour::decoded;
pub use false_colour::{FalseColourMap, MarkedPlace, ink_on, key_text, letter};
pub use npy::npy;
pub use text::{BitmapFont, TextBitmap};

use std::fmt;
use std::ops::Range;
use thiserror::Error;

/// A picture in linear light. Colours of files that are coded (PNG, JPEG) have 1 for white, those
/// of EXR files any range.
#[derive(Clone, PartialEq)]
pub struct Raster {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green and blue of each pixel, row by row from the top left.
    pub rgb: Vec<[f32; 3]>,
}

impl fmt::Debug for Raster {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Raster of {} x {}", self.width, self.height)
    }
}

/// Reason why bytes could not be decoded.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RasterError {
    /// Neither PNG nor JPEG nor EXR.
    #[error("this is no PNG, JPEG or EXR picture; convert it to one of these")]
    Unknown,
    /// The picture has no pixels, or more than there may be.
    #[error(
        "the picture has {width} x {height} pixels; it must have at least one, at most {MOST_SIDE} a \
         side and {MOST_PIXELS} in all"
    )]
    Size {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The bytes end before the picture does.
    #[error("the {format} picture is cut off; copy the file again")]
    CutOff {
        /// Of which format it is.
        format: &'static str,
    },
    /// The picture is damaged, or of a kind that cannot be read.
    #[error("the {format} picture cannot be read ({account}); save it again as {format} or PNG")]
    Damaged {
        /// Of which format it is.
        format: &'static str,
        /// The decoder's account.
        account: String,
    },
}

/// Most pixels of a side.
pub const MOST_SIDE: u32 = 65_535;
/// Most pixels in all: 16384 x 8192, 1.6 GB.
pub const MOST_PIXELS: u64 = 1 << 27;

impl Raster {
    /// A picture of one colour.
    #[must_use]
    pub fn new(width: usize, height: usize, colour: [f32; 3]) -> Self {
        Self { width, height, rgb: vec![colour; width * height] }
    }

    /// Reads a PNG, JPEG (both taken for sRGB, and turned as their Exif tag says) or EXR file
    /// (linear), recognised by content. Opacity is left out.
    ///
    /// # Errors
    /// [`RasterError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, RasterError> {
        decode::decode(bytes)
    }

    /// The picture as a PNG file of 8-bit sRGB; what lies outside 0 to 1 is clipped.
    ///
    /// # Errors
    /// A picture without pixels cannot be written.
    pub fn to_png(&self) -> Result<Vec<u8>, EncodingError> {
        let codes: Vec<u8> =
            self.rgb.as_flattened().iter().map(|light| srgb::encode(*light)).collect();
        // What does not fit is larger than any picture may be, and refused.
        let [width, height] =
            [self.width, self.height].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        png::encode(width, height, &codes)
    }

    /// The part of the picture in these columns and rows.
    ///
    /// # Panics
    /// When it does not have them all.
    #[must_use]
    pub fn crop(&self, columns: Range<usize>, rows: Range<usize>) -> Self {
        let (width, height) = (columns.len(), rows.len());
        let line = |row: usize| &self.rgb[row * self.width..][..self.width][columns.clone()];
        Self { width, height, rgb: rows.flat_map(line).copied().collect() }
    }

    /// The light at a place in pixels, x to the right from the left edge and y down from the top
    /// edge, so that the first pixel's centre is (0.5, 0.5). Beyond an edge its pixels repeat; with
    /// `wrap` the left and the right edge are joined. A place that is no number is black.
    ///
    /// The cubic of Catmull and Rom (R. G. Keys 1981, a = -1/2): unlike bilinear interpolation it
    /// does not blur between pixels, moves no edge and is exact for quadratics; light that it makes
    /// negative beside a bright pixel is taken as none.
    #[must_use]
    pub fn sample(&self, x: f64, y: f64, wrap: bool) -> [f32; 3] {
        if self.rgb.is_empty() || !x.is_finite() || !y.is_finite() {
            return [0.0; 3];
        }
        let (columns, across) = taps(x, self.width, wrap);
        let (rows, down) = taps(y, self.height, false);
        let mut sum = [0.0; 3];
        for (row, b) in rows.into_iter().zip(down) {
            let line = &self.rgb[row * self.width..][..self.width];
            for (column, a) in columns.into_iter().zip(across) {
                let light = line[column];
                sum = std::array::from_fn(|c| sum[c] + a * b * light[c]);
            }
        }
        sum.map(|light| if light < 0.0 { 0.0 } else { light })
    }
}

/// The four pixels around place `at` of a row of `count`, and their weights.
fn taps(at: f64, count: usize, wrap: bool) -> ([usize; 4], [f32; 4]) {
    let last = count as i64 - 1;
    let at = at - 0.5;
    // Far outside all four are the edge's pixel; the cast saturates.
    let whole = at.floor();
    let first = (whole as i64).saturating_sub(1);
    let index = |k: i64| {
        let k = first.saturating_add(k);
        (if wrap { k.rem_euclid(last + 1) } else { k.clamp(0, last) }) as usize
    };
    let t = (at - whole) as f32;
    let weights = [
        ((2.0 - t) * t - 1.0) * t * 0.5,
        ((3.0 * t - 5.0) * t * t + 2.0) * 0.5,
        ((4.0 - 3.0 * t) * t + 1.0) * t * 0.5,
        (t - 1.0) * t * t * 0.5,
    ];
    ([0, 1, 2, 3].map(index), weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;
    use crate::num::{cos, sin};
    use std::f64::consts::TAU;

    /// The picture of a function of the pixels' centres.
    fn picture(width: usize, height: usize, f: impl Fn(f64, f64) -> [f64; 3]) -> Raster {
        let at = |k: usize| f((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        let rgb = (0..width * height).map(|k| at(k).map(|x| x as f32)).collect();
        Raster { width, height, rgb }
    }

    #[test]
    fn centres_are_at_halves_and_quadratics_are_exact() {
        let f =
            |x: f64, y: f64| [0.1 * x + 0.2 * y, 0.02 * x * x + 0.3, 0.01 * y * y + 0.02 * x * y];
        let picture = picture(9, 7, f);
        for y in 0..7 {
            for x in 0..9 {
                let found = picture.sample(x as f64 + 0.5, y as f64 + 0.5, false);
                assert_eq!(found, picture.rgb[y * 9 + x]);
            }
        }
        let mut draws = Draws::new(1);
        for _ in 0..200 {
            let (x, y) = (draws.inside([1.5, 7.5]), draws.inside([1.5, 5.5]));
            let (found, exact) = (picture.sample(x, y, false), f(x, y));
            for c in 0..3 {
                assert!((f64::from(found[c]) - exact[c]).abs() < 1e-6, "{x} {y}");
            }
        }
    }

    #[test]
    fn the_error_falls_with_the_third_power_of_the_pixel() {
        let worst = |n: usize| {
            let f = |x: f64, y: f64| {
                let (a, b) = (TAU * x / n as f64, TAU * y / n as f64);
                [2.0 + sin(a), 2.0 + cos(a + b), 2.0 + sin(b)]
            };
            let picture = picture(n, n, f);
            let mut draws = Draws::new(2);
            let mut worst: f64 = 0.0;
            for _ in 0..400 {
                let x = draws.inside([-3.0, n as f64 + 3.0]);
                let y = draws.inside([2.0, n as f64 - 2.0]);
                let (found, exact) = (picture.sample(x, y, true), f(x, y));
                worst =
                    (0..3).map(|c| (f64::from(found[c]) - exact[c]).abs()).fold(worst, f64::max);
            }
            worst
        };
        let errors = [16, 32, 64].map(worst);
        assert!(errors[0] / errors[1] > 6.5 && errors[1] / errors[2] > 6.5, "{errors:?}");
    }

    #[test]
    fn edges_repeat_or_join() {
        let picture = picture(6, 4, |x, y| [x, y, 0.0]);
        for far in [-1e300, -40.0, -2.0] {
            assert_eq!(picture.sample(far, 1.5, false), [0.5, 1.5, 0.0]);
            assert_eq!(picture.sample(2.5, far, false), [2.5, 0.5, 0.0]);
        }
        assert_eq!(picture.sample(1e300, 1e300, false), [5.5, 3.5, 0.0]);
        for turn in [-12.0, -6.0, 0.0, 6.0] {
            for x in [0.5, 3.25, 5.9] {
                let (a, b) = (picture.sample(x + turn, 2.2, true), picture.sample(x, 2.2, true));
                assert!((a[0] - b[0]).abs() < 1e-5, "{x}");
            }
        }
        let seam = picture.sample(0.0, 1.5, true);
        assert!((seam[0] - 3.0).abs() < 1e-6, "{seam:?}");
        assert!(picture.sample(0.0, 1.5, false)[0] < 0.5);
    }

    #[test]
    fn a_crop_has_the_pixels_of_its_columns_and_rows() {
        let picture = picture(6, 4, |x, y| [x, y, 0.0]).crop(1..4, 2..4);
        assert_eq!([picture.width, picture.height], [3, 2]);
        assert_eq!([picture.rgb[0], picture.rgb[5]], [[1.5, 2.5, 0.0], [3.5, 3.5, 0.0]]);
    }

    #[test]
    fn places_that_are_no_numbers_are_black_and_light_is_not_negative() {
        let dot = picture(5, 1, |x, _| [if x == 2.5 { 9.0 } else { 0.0 }; 3]);
        assert_eq!(dot.sample(f64::NAN, 0.5, true), [0.0; 3]);
        assert_eq!(dot.sample(2.5, f64::INFINITY, true), [0.0; 3]);
        for k in 0..50 {
            assert!(dot.sample(f64::from(k) * 0.1, 0.5, false)[0] >= 0.0);
        }
        let nothing = Raster::new(0, 3, [0.0; 3]);
        assert_eq!(nothing.sample(0.5, 0.5, true), [0.0; 3]);
        assert!(nothing.to_png().is_err());
    }
}
