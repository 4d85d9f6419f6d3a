//! Pictures: supersampled at edges in linear light, coded as sRGB, written as PNG.

use crate::parallel;

use super::World;
use crate::geom::{DVec3, Ray};
use crate::raster::{
    EncodingError, png,
    srgb::{encode, hex},
};
use crate::trace::Outcome;
use std::ops::Range;

/// sRGB code of [`Outcome::Missed`]: dark grey.
pub const MISSED: u32 = 0x3a3a3c;
/// sRGB code of [`Outcome::Shadowed`]: dark red.
pub const SHADOWED: u32 = 0x7a1018;
/// sRGB code of [`Outcome::BackFace`]: magenta.
pub const BACK_FACE: u32 = 0xff00ff;

/// Difference in linear light that makes an edge: a few times what the sky changes from pixel to
/// pixel, a fraction of a thin line.
const EDGE: f32 = 0.06;

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
    /// The picture of `coarse`, the linear light at each pixel's centre, row by row, with pixels that
    /// differ from a neighbour sampled again on a grid; the others keep their centre's colour.
    ///
    /// `light` takes a point in pixels, x to the right from the left edge and y down from the top
    /// edge, so that the first pixel's centre is (0.5, 0.5). The bytes do not depend on the number of
    /// threads.
    ///
    /// # Panics
    /// When `coarse` has not one entry a pixel.
    #[must_use]
    pub fn refined(
        grid: &SampleGrid,
        coarse: &[[f32; 3]],
        light: impl Fn(f64, f64) -> [f32; 3] + Sync,
    ) -> Self {
        let rows = 0..grid.height as usize;
        assert_eq!(coarse.len(), grid.width as usize * rows.len(), "one centre a pixel");
        let (rgb, samples) = refined_rows(grid, rows, (0, coarse), |_, [x, y]| light(x, y));
        Self { width: grid.width, height: grid.height, rgb, samples }
    }

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

/// Some rows of a picture, as red, green and blue of each pixel, and the number of their samples: `coarse`
/// is the light at pixels' centres from a row on, of the neighbouring rows too where there are any, and
/// `light` takes a pixel's number in it and a point of the pixel.
fn refined_rows(
    grid: &SampleGrid,
    rows: Range<usize>,
    (first, coarse): (usize, &[[f32; 3]]),
    light: impl Fn(usize, [f64; 2]) -> [f32; 3] + Sync,
) -> (Vec<u8>, u64) {
    let (width, height) = (grid.width as usize, grid.height as usize);
    let side = grid.samples_per_side.max(1);
    let number = |x: usize, y: usize| (y - first) * width + x;
    let fine = |x: usize, y: usize| {
        let mut sum = [0.0_f32; 3];
        let place = |p: usize, k: u32| p as f64 + (f64::from(k) + 0.5) / f64::from(side);
        for k in 0..side * side {
            let light = light(number(x, y), [place(x, k % side), place(y, k / side)]);
            sum = std::array::from_fn(|c| sum[c] + light[c]);
        }
        sum.map(|s| s / (side * side) as f32)
    };
    let is_edge = |x: usize, y: usize| {
        let here = coarse[number(x, y)];
        let differs = |x: usize, y: usize| {
            let other = coarse[number(x, y)];
            here.iter().zip(other).any(|(a, b)| (a - b).abs() > EDGE)
        };
        (x > 0 && differs(x - 1, y))
            || (x + 1 < width && differs(x + 1, y))
            || (y > 0 && differs(x, y - 1))
            || (y + 1 < height && differs(x, y + 1))
    };
    let mut rgb = vec![0; 3 * width * rows.len()];
    let edges = parallel::map_chunks_mut(&mut rgb, (3 * width).max(3), |k, row| {
        let (y, mut edges) = (rows.start + k, 0);
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let edge = side > 1 && is_edge(x, y);
            edges += u64::from(edge);
            let light = if edge { fine(x, y) } else { coarse[number(x, y)] };
            for (code, light) in pixel.iter_mut().zip(light) {
                *code = encode(light);
            }
        }
        edges
    });
    let samples = edges.iter().sum::<u64>() * u64::from(side * side) + (width * rows.len()) as u64;
    (rgb, samples)
}

/// A picture of a world that is painted strip after strip of rows, from the top, with what it takes of the
/// rows beside.
pub struct StripPainter<'a> {
    grid: SampleGrid,
    world: &'a dyn World,
}

/// A strip whose centres are painted.
struct CoarseStrip {
    rows: Range<usize>,
    centres: Vec<PictureRay>,
    light: Vec<[f32; 3]>,
}

impl<'a> StripPainter<'a> {
    /// The painter of `world` on the pixels of `grid`.
    #[must_use]
    pub fn new(grid: SampleGrid, world: &'a dyn World) -> Self {
        Self { grid, world }
    }

    /// Paints the strips of `rows`: `centres` gives the rays of the pixels' centres of one, row by row, and
    /// `see` that of any point of a pixel whose centre's it is given. `done` gets red, green and blue of the
    /// pixels of each strip; the number of samples is returned.
    ///
    /// # Errors
    /// Those of `done`.
    pub fn paint<E>(
        &self,
        rows: Vec<Range<usize>>,
        mut centres: impl FnMut(Range<usize>) -> Vec<PictureRay>,
        see: impl Fn(&PictureRay, [f64; 2]) -> PictureRay + Sync,
        mut done: impl FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<u64, E> {
        let width = self.grid.width as usize;
        let mut samples = 0;
        // The last row of the strip before, and the strip that waits for the first row of the next.
        let (mut above, mut waiting): (Vec<[f32; 3]>, Option<CoarseStrip>) = (vec![], None);
        let strips = rows.into_iter().map(Some).chain([None]);
        for rows in strips {
            let next = rows.map(|rows| self.coarse(rows.clone(), centres(rows)));
            if let Some(strip) = waiting.take() {
                let below = next.as_ref().map_or(&[][..], |next| &next.light[..width]);
                let (rgb, count) = self.fine(&strip, [&above, below], &see);
                done(&rgb)?;
                samples += count;
                above = strip.light[strip.light.len() - width..].to_vec();
            }
            waiting = next;
        }
        Ok(samples)
    }

    fn coarse(&self, rows: Range<usize>, centres: Vec<PictureRay>) -> CoarseStrip {
        let light =
            parallel::map_slice(&centres, 4096, |&end| self.light(end, self.grid.pixel_rad));
        CoarseStrip { rows, centres, light }
    }

    fn fine(
        &self,
        strip: &CoarseStrip,
        [above, below]: [&[[f32; 3]]; 2],
        see: &(impl Fn(&PictureRay, [f64; 2]) -> PictureRay + Sync),
    ) -> (Vec<u8>, u64) {
        let footprint = self.grid.pixel_rad / f64::from(self.grid.samples_per_side.max(1));
        let first = strip.rows.start - above.len() / (self.grid.width as usize).max(1);
        let coarse = [above, &strip.light, below].concat();
        refined_rows(&self.grid, strip.rows.clone(), (first, &coarse), |pixel, at| {
            self.light(see(&strip.centres[pixel - above.len()], at), footprint)
        })
    }

    fn light(&self, end: PictureRay, footprint: f64) -> [f32; 3] {
        match end.outcome {
            Outcome::Hit => self.world.light(&end.leaving, footprint),
            Outcome::Shadowed(_) => hex(SHADOWED),
            Outcome::Missed => hex(MISSED),
            Outcome::BackFace => hex(BACK_FACE),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::f64::consts::PI;

    use super::*;
    use crate::num;
    use crate::render::TestWorld;

    const WIDTH: u32 = 720;
    const SCALE: f64 = 2.0 * PI / WIDTH as f64;

    /// Paints `world`: `centres` holds the ray of each pixel's centre, row by row, and `see` gives that of
    /// any other point.
    fn paint(
        grid: &SampleGrid,
        world: &dyn World,
        centres: &[PictureRay],
        see: impl Fn(f64, f64) -> PictureRay + Sync,
    ) -> Picture {
        in_strips(grid, world, grid.height.max(1) as usize, centres, see)
    }

    /// The same in strips of so many rows.
    fn in_strips(
        grid: &SampleGrid,
        world: &dyn World,
        step: usize,
        centres: &[PictureRay],
        see: impl Fn(f64, f64) -> PictureRay + Sync,
    ) -> Picture {
        let (width, height) = (grid.width as usize, grid.height as usize);
        let mut rgb = Vec::new();
        let rows = (0..height).step_by(step).map(|y| y..(y + step).min(height)).collect();
        let Ok(samples) = StripPainter::new(*grid, world).paint::<Infallible>(
            rows,
            |rows| centres[rows.start * width..rows.end * width].to_vec(),
            |_, [x, y]| see(x, y),
            |strip| {
                rgb.extend_from_slice(strip);
                Ok(())
            },
        );
        Picture { width: grid.width, height: grid.height, rgb, samples }
    }

    #[test]
    fn strips_do_not_show() {
        let grid = SampleGrid { width: WIDTH, height: 120, samples_per_side: 3, pixel_rad: SCALE };
        let centres = centres(&grid, panorama);
        let world = TestWorld::new();
        let whole = paint(&grid, &world, &centres, panorama);
        for step in [1, 7, 64, 119] {
            assert!(in_strips(&grid, &world, step, &centres, panorama) == whole, "{step} rows");
        }
    }

    /// A panorama of half a degree of azimuth a pixel, the horizon at y = 60.
    fn panorama(x: f64, y: f64) -> PictureRay {
        let (a, z) = ((x - 360.0) * SCALE, (60.0 - y) * SCALE);
        let direction = DVec3::new(num::sin(a), num::cos(a), z).normalize();
        PictureRay::reflected(Ray { origin: DVec3::ZERO, direction })
    }

    fn painted(samples_per_side: u32) -> Picture {
        let grid = SampleGrid { width: WIDTH, height: 120, samples_per_side, pixel_rad: SCALE };
        paint(&grid, &TestWorld::new(), &centres(&grid, panorama), panorama)
    }

    /// The rays of the pixel centres.
    fn centres(grid: &SampleGrid, see: impl Fn(f64, f64) -> PictureRay) -> Vec<PictureRay> {
        let pixels = 0..grid.width * grid.height;
        let centre = |k| see(f64::from(k % grid.width) + 0.5, f64::from(k / grid.width) + 0.5);
        pixels.map(centre).collect()
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
        assert!((row[0] - row[1]).abs() <= 3 && (row[4] - row[5]).abs() <= 3, "{row:?}");
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
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        assert_eq!((info.width, info.height), (picture.width, picture.height));
        assert_eq!(info.color_type, ::png::ColorType::Rgb);
        assert!(rgb == picture.rgb);
        assert!(3 * bytes.len() < rgb.len(), "{} bytes", bytes.len());
    }

    #[test]
    fn samples_are_averaged_in_linear_light() {
        let grid = SampleGrid { width: 3, height: 1, samples_per_side: 2, pixel_rad: 0.01 };
        let see = |x: f64, _: f64| match x {
            ..1.0 => PictureRay::lost(Outcome::Missed),
            ..1.5 => PictureRay::lost(Outcome::BackFace),
            _ => PictureRay::lost(Outcome::Shadowed(0)),
        };
        let picture = paint(&grid, &TestWorld::new(), &centres(&grid, see), see);
        let code = |hex: u32| [16, 8, 0].map(|shift| (hex >> shift & 0xff) as i32);
        assert_eq!(at(&picture, 0, 0), code(MISSED));
        assert_eq!(at(&picture, 2, 0), code(SHADOWED));
        let half = (hex(SHADOWED)[0] + 1.0) / 2.0;
        assert_eq!(at(&picture, 1, 0)[0], i32::from(encode(half)));
    }

    #[test]
    fn only_edges_are_sampled_again() {
        let grid = SampleGrid { width: 8, height: 4, samples_per_side: 2, pixel_rad: 0.01 };
        let see = |x: f64, _: f64| {
            PictureRay::lost(if x < 4.3 { Outcome::Missed } else { Outcome::BackFace })
        };
        let visited = std::sync::Mutex::new(Vec::new());
        let noting = |x: f64, y: f64| {
            visited.lock().unwrap().push(x as u32);
            see(x, y)
        };
        let centres = centres(&grid, see);
        let picture = paint(&grid, &TestWorld::new(), &centres, noting);
        assert!(visited.lock().unwrap().iter().all(|x| [3, 4].contains(x)));
        assert_eq!(at(&picture, 2, 1), at(&picture, 3, 1));
        assert_eq!(picture.samples, 8 * 4 + 2 * 4 * 4);
        assert!(bright(&picture, 4, 1) < bright(&picture, 5, 1));
    }

    #[test]
    fn turning_moves_the_first_pixel_to_the_last_place() {
        let rgb = vec![1, 2, 3, 4, 5, 6];
        let picture = Picture { width: 2, height: 1, rgb, samples: 2 };
        assert_eq!(picture.turned().rgb, [4, 5, 6, 1, 2, 3]);
    }

    #[test]
    fn an_empty_picture_is_an_error_not_a_panic() {
        let grid = SampleGrid { width: 0, height: 4, samples_per_side: 0, pixel_rad: 0.01 };
        let picture = paint(&grid, &TestWorld::new(), &[], panorama);
        assert!(picture.to_png().is_err());
    }
}
