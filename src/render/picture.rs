//! Pictures: supersampled at edges in linear light, coded as sRGB, written as PNG.

use crate::parallel;

use super::World;
use super::samples::{EdgePixels, PIECE_ROWS, PictureRay, SampleGrid, Sight, edges};
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
/// sRGB code of [`Outcome::Obstructed`]: light grey, as no lit world is all over.
pub const OBSTRUCTED: u32 = 0x9a9a9a;

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
        let edges = edges(grid, rows.clone(), (0, coarse));
        let fine = |piece| {
            let lights = grid.samples(&edges, 0, piece).map(|(_, [x, y])| light(x, y));
            means(grid, &lights.collect::<Vec<_>>())
        };
        let (rgb, samples) = refined_rows(grid, rows, (coarse, &edges), fine);
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

/// The mean light of each pixel whose samples' are `lights`, pixel by pixel.
fn means(grid: &SampleGrid, lights: &[[f32; 3]]) -> Vec<[f32; 3]> {
    lights.chunks_exact(grid.samples_of_pixel()).map(|pixel| mean(pixel.iter().copied())).collect()
}

/// The mean of some lights.
fn mean(lights: impl ExactSizeIterator<Item = [f32; 3]>) -> [f32; 3] {
    let count = lights.len() as f32;
    let add = |sum: [f32; 3], light: [f32; 3]| std::array::from_fn(|c| sum[c] + light[c]);
    lights.fold([0.0_f32; 3], add).map(|s| s / count)
}

/// Some rows of a picture, as red, green and blue of each pixel, and the number of their samples: `coarse`
/// is the light at their pixels' centres, and `fine` gives the mean light of each edge pixel of some of the
/// rows, in order.
fn refined_rows(
    grid: &SampleGrid,
    rows: Range<usize>,
    (coarse, edges): (&[[f32; 3]], &[bool]),
    fine: impl Fn(Range<usize>) -> Vec<[f32; 3]> + Sync,
) -> (Vec<u8>, u64) {
    let width = grid.width as usize;
    let mut rgb = vec![0; 3 * width * rows.len()];
    let size = (width * PIECE_ROWS).max(1);
    parallel::map_chunks_mut(&mut rgb, 3 * size, |piece, rgb| {
        let first = rows.start + piece * PIECE_ROWS;
        let mut fine = fine(first..(first + PIECE_ROWS).min(rows.end)).into_iter();
        let pixels = coarse[piece * size..].iter().zip(&edges[piece * size..]);
        for (pixel, (coarse, edge)) in rgb.chunks_exact_mut(3).zip(pixels) {
            let light = if *edge { fine.next().unwrap_or(*coarse) } else { *coarse };
            for (code, light) in pixel.iter_mut().zip(light) {
                *code = encode(light);
            }
        }
    });
    let sampled = edges.iter().filter(|edge| **edge).count();
    (rgb, (sampled * grid.samples_of_pixel() + width * rows.len()) as u64)
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
    /// `sight` those of the samples of some of its pixels. `done` gets red, green and blue of the
    /// pixels of each strip; the number of samples is returned.
    ///
    /// # Errors
    /// Those of `done`.
    pub fn paint<E>(
        &self,
        rows: Vec<Range<usize>>,
        mut centres: impl FnMut(Range<usize>) -> Vec<PictureRay>,
        sight: &dyn Sight,
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
                let (rgb, count) = self.fine(&strip, [&above, below], sight);
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
        sight: &dyn Sight,
    ) -> (Vec<u8>, u64) {
        let footprint = self.grid.pixel_rad / f64::from(self.grid.samples_per_side.max(1));
        let first = strip.rows.start - above.len() / (self.grid.width as usize).max(1);
        let coarse = [above, &strip.light, below].concat();
        let CoarseStrip { rows, centres, light } = strip;
        let edges = edges(&self.grid, rows.clone(), (first, &coarse));
        let pixels = EdgePixels { grid: &self.grid, first: rows.start, centres, edges: &edges };
        let sight = sight.samples(pixels);
        let each = self.grid.samples_of_pixel();
        let fine = |piece| {
            let mut means = Vec::new();
            sight(piece, &mut |rays| {
                let light = |pixel: &[PictureRay]| {
                    mean(pixel.iter().map(|ray| self.light(*ray, footprint)))
                };
                means.extend(rays.chunks_exact(each).map(light));
            });
            means
        };
        refined_rows(&self.grid, rows.clone(), (light, &edges), fine)
    }

    fn light(&self, end: PictureRay, footprint: f64) -> [f32; 3] {
        match end.outcome {
            Outcome::Hit => self.world.light(&end.leaving, footprint),
            Outcome::Shadowed(_) => hex(SHADOWED),
            Outcome::Missed => hex(MISSED),
            Outcome::BackFace => hex(BACK_FACE),
            Outcome::Obstructed(_) => hex(OBSTRUCTED),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::f64::consts::PI;

    use super::*;
    use crate::geom::{DVec3, Ray};
    use crate::num;
    use crate::render::TestWorld;
    use crate::render::samples::OneByOne;

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
            &OneByOne(|_: &PictureRay, [x, y]: [f64; 2]| see(x, y)),
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
