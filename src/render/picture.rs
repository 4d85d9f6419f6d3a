//! Pictures: supersampled in linear light, coded as sRGB, written as PNG.

use glam::DVec3;
use rayon::prelude::*;

use super::{
    srgb::{encode, hex},
    world::TestWorld,
};

/// sRGB code of [`Seen::Missed`]: dark grey.
pub const MISSED: u32 = 0x3a3a3c;
/// sRGB code of [`Seen::Shadowed`]: dark red.
pub const SHADOWED: u32 = 0x7a1018;
/// sRGB code of [`Seen::BackFace`]: magenta.
pub const BACK_FACE: u32 = 0xff00ff;

/// What one point of the picture sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen {
    /// The world, in this unit direction of the part frame.
    World(DVec3),
    /// The mirror, but another part of it blocks the way to the world.
    Shadowed,
    /// Nothing: the ray passes by the mirror.
    Missed,
    /// The wrong side of a facet; a sound part never shows it.
    BackFace,
}

/// The grid of samples of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Canvas {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples along each side of a pixel; 0 counts as 1.
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
}

impl Picture {
    /// Paints what `see` finds of `world`.
    ///
    /// `see` takes a point in pixels, x to the right from the left edge and y down from the top edge, so
    /// that the first pixel's centre is (0.5, 0.5). The bytes do not depend on the number of threads.
    #[must_use]
    pub fn paint(
        canvas: &Canvas,
        world: &TestWorld,
        see: impl Fn(f64, f64) -> Seen + Sync,
    ) -> Self {
        let side = canvas.samples_per_side.max(1);
        let footprint = canvas.pixel_rad / f64::from(side);
        let [missed, shadowed, back_face] = [MISSED, SHADOWED, BACK_FACE].map(hex);
        let light = |x: f64, y: f64| match see(x, y) {
            Seen::World(direction) => world.colour(direction, footprint),
            Seen::Shadowed => shadowed,
            Seen::Missed => missed,
            Seen::BackFace => back_face,
        };
        let share = 1.0 / (side as f32 * side as f32);
        let place = |pixel: u32, k: u32| f64::from(pixel) + (f64::from(k) + 0.5) / f64::from(side);

        let stride = 3 * canvas.width as usize;
        let mut rgb = vec![0; stride * canvas.height as usize];
        let rows = rgb.par_chunks_exact_mut(stride.max(3)).enumerate();
        rows.for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let mut sum = [0.0_f32; 3];
                for j in 0..side {
                    for i in 0..side {
                        let light = light(place(x as u32, i), place(y as u32, j));
                        sum = std::array::from_fn(|k| sum[k] + light[k]);
                    }
                }
                for (code, sum) in pixel.iter_mut().zip(sum) {
                    *code = encode(sum * share);
                }
            }
        });
        Self {
            width: canvas.width,
            height: canvas.height,
            rgb,
        }
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// A picture without pixels, or whose `rgb` is not 3 width height bytes long, cannot be written.
    pub fn to_png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        // Half as large again as with the next level, but twenty times faster.
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::Filter::Adaptive);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::num;

    const WIDTH: u32 = 720;
    const SCALE: f64 = 2.0 * PI / WIDTH as f64;

    /// A panorama of half a degree of azimuth a pixel, the horizon at y = 60.
    fn panorama(x: f64, y: f64) -> Seen {
        let (a, z) = ((x - 360.0) * SCALE, (60.0 - y) * SCALE);
        Seen::World(DVec3::new(num::sin(a), num::cos(a), z).normalize())
    }

    fn painted(samples_per_side: u32) -> Picture {
        let canvas = Canvas {
            width: WIDTH,
            height: 120,
            samples_per_side,
            pixel_rad: SCALE,
        };
        Picture::paint(&canvas, &TestWorld::new(), panorama)
    }

    fn at(picture: &Picture, x: u32, y: u32) -> [i32; 3] {
        let start = 3 * (y * picture.width + x) as usize;
        std::array::from_fn(|k| i32::from(picture.rgb[start + k]))
    }

    fn bright(picture: &Picture, x: u32, y: u32) -> i32 {
        at(picture, x, y).iter().sum()
    }

    #[test]
    fn horizontals_of_an_ideal_panorama_are_straight() {
        let picture = painted(2);
        let circle = 60.0 - num::tan(num::radians(-15.0)) / SCALE;
        for x in 0..WIDTH {
            let darkest = (85..100).min_by_key(|&y| bright(&picture, x, y));
            // Meridians and numbers are dark as well.
            if (22..178).contains(&(x % 180)) && (x + 1) % 30 > 2 {
                assert_eq!(darkest, Some(circle as u32), "column {x}");
            }
            let horizon = bright(&picture, x, 59).max(bright(&picture, x, 60));
            assert!(horizon < 450, "column {x}: {horizon}");
        }
    }

    #[test]
    fn meridians_fall_on_their_pixels() {
        let picture = painted(1);
        // Azimuth -150 is at x = 60: half of the line in each of the pixels 59 and 60.
        let row: Vec<i32> = (57..63).map(|x| bright(&picture, x, 75)).collect();
        assert!((row[2] - row[3]).abs() <= 2, "{row:?}");
        assert!(row[1] - row[2] > 40 && row[4] - row[3] > 40, "{row:?}");
        assert!(
            (row[0] - row[1]).abs() <= 3 && (row[4] - row[5]).abs() <= 3,
            "{row:?}"
        );
    }

    #[test]
    fn more_samples_agree_with_the_analytic_cover() {
        let (coarse, fine) = (painted(1), painted(6));
        let apart = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
        let sum: f64 = coarse.rgb.iter().zip(&fine.rgb).map(apart).sum();
        let mean = sum / fine.rgb.len() as f64;
        assert!(mean < 2.0, "{mean}");
        assert_ne!(coarse.rgb, fine.rgb);
    }

    #[test]
    fn the_count_of_threads_does_not_show() {
        let [one, two] = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let picture = pool.unwrap().install(|| painted(3));
            (picture.to_png().unwrap(), picture)
        });
        assert!(one == two);
    }

    #[test]
    fn png_gives_the_pixels_back() {
        let picture = painted(1);
        let bytes = picture.to_png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        assert_eq!((info.width, info.height), (picture.width, picture.height));
        assert_eq!(info.color_type, png::ColorType::Rgb);
        assert!(rgb == picture.rgb);
        assert!(3 * bytes.len() < rgb.len(), "{} bytes", bytes.len());
    }

    #[test]
    fn samples_are_averaged_in_linear_light() {
        let canvas = Canvas {
            width: 3,
            height: 1,
            samples_per_side: 2,
            pixel_rad: 0.01,
        };
        let picture = Picture::paint(&canvas, &TestWorld::new(), |x, y| {
            assert!([0.25, 0.75].contains(&x.fract()) && [0.25, 0.75].contains(&y));
            match x {
                ..1.0 => Seen::Missed,
                ..1.5 => Seen::BackFace,
                _ => Seen::Shadowed,
            }
        });
        let code = |hex: u32| [16, 8, 0].map(|shift| (hex >> shift & 0xff) as i32);
        assert_eq!(at(&picture, 0, 0), code(MISSED));
        assert_eq!(at(&picture, 2, 0), code(SHADOWED));
        let half = (hex(SHADOWED)[0] + 1.0) / 2.0;
        assert_eq!(at(&picture, 1, 0)[0], i32::from(encode(half)));
    }

    #[test]
    fn an_empty_picture_is_an_error_not_a_panic() {
        let canvas = Canvas {
            width: 0,
            height: 4,
            samples_per_side: 0,
            pixel_rad: 0.01,
        };
        let picture = Picture::paint(&canvas, &TestWorld::new(), panorama);
        assert!(picture.to_png().is_err());
    }
}
