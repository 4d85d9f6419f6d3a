//! Pictures, the rays that show them, and their samples.

use crate::geom::{DVec3, Ray};
use crate::raster::{EncodingError, png};
use crate::trace::Outcome;

/// sRGB code of [`Outcome::Missed`]: dark grey.
pub const MISSED: u32 = 0x3a3a3c;
/// sRGB code of [`Outcome::Shadowed`]: dark red.
pub const SHADOWED: u32 = 0x7a1018;
/// sRGB code of [`Outcome::BackFace`]: magenta.
pub const BACK_FACE: u32 = 0xff00ff;

/// End of the camera ray through one point of the picture, and the ray that leaves into the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureRay {
    /// How the camera ray ends.
    pub outcome: Outcome,
    /// The reflected ray in the part frame, where the outcome is [`Outcome::Hit`].
    pub leaving: Ray,
}

impl PictureRay {
    /// A camera ray that is reflected and leaves as `leaving`.
    #[must_use]
    pub fn reflected(leaving: Ray) -> Self {
        Self { outcome: Outcome::Hit, leaving }
    }

    /// A camera ray from which nothing leaves.
    #[must_use]
    pub const fn lost(outcome: Outcome) -> Self {
        Self { outcome, leaving: Ray { origin: DVec3::ZERO, direction: DVec3::ZERO } }
    }
}

/// Pixels of a picture and the samples in each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleGrid {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples along each side of a pixel at edges; 0 counts as 1.
    pub samples_per_side: u32,
    /// Angle of the world that one pixel covers, in radians.
    pub pixel_rad: f64,
}

/// An 8-bit sRGB picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green and blue of each pixel, row by row from the top left.
    pub rgb: Vec<u8>,
    /// Number of samples: the pixels' centres, and those within edges.
    pub samples: u64,
}

impl Picture {
    /// The picture turned by half a turn: what a camera held upside down takes.
    #[must_use]
    pub fn turned(mut self) -> Self {
        self.rgb.reverse();
        self.rgb.chunks_exact_mut(3).for_each(<[u8]>::reverse);
        self
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// A picture without pixels, or whose `rgb` is not 3 width height bytes long, cannot be written.
    pub fn to_png(&self) -> Result<Vec<u8>, EncodingError> {
        png::encode(self.width, self.height, &self.rgb)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_moves_the_first_pixel_to_the_last_place() {
        let rgb = vec![1, 2, 3, 4, 5, 6];
        let picture = Picture { width: 2, height: 1, rgb, samples: 2 };
        assert_eq!(picture.turned().rgb, [4, 5, 6, 1, 2, 3]);
    }
}
