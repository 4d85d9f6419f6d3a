//! Rays of a picture's pixels, and the samples of those at edges, which are seen again.

use crate::geom::{DVec3, Ray};
use crate::parallel;
use crate::trace::Outcome;
use std::ops::Range;

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

impl SampleGrid {
    /// Number of samples of a pixel at an edge.
    pub(super) fn samples_of_pixel(&self) -> usize {
        (self.samples_per_side.max(1) as usize).pow(2)
    }

    /// The samples of the pixels of `rows` that are `edges`, which begin with the row `first`: each pixel's
    /// number among these and the sample's place, pixel by pixel, row by row of samples.
    pub(super) fn samples(
        &self,
        edges: &[bool],
        first: usize,
        rows: Range<usize>,
    ) -> impl Iterator<Item = (usize, [f64; 2])> {
        let (width, side) = (self.width as usize, self.samples_per_side.max(1));
        let place = move |p: usize, k: u32| place(side, p, k);
        let pixels = (rows.start - first) * width..(rows.end - first) * width;
        pixels.filter(|&pixel| edges[pixel]).flat_map(move |pixel| {
            let (x, y) = (pixel % width, first + pixel / width);
            (0..side * side).map(move |k| (pixel, [place(x, k % side), place(y, k / side)]))
        })
    }
}

/// Where sample `k` of so many along a side of pixel `p` is.
fn place(side: u32, p: usize, k: u32) -> f64 {
    p as f64 + (f64::from(k) + 0.5) / f64::from(side)
}

/// Rows of a strip whose samples are seen by one thread, whatever the number of threads.
pub(super) const PIECE_ROWS: usize = 32;

/// Which pixels of some rows differ from a neighbour; `coarse` is the light at pixels' centres from a row on, of
/// the neighbouring rows too where there are any.
pub(super) fn edges(
    grid: &SampleGrid,
    rows: Range<usize>,
    (first, coarse): (usize, &[[f32; 3]]),
) -> Vec<bool> {
    let (width, height) = (grid.width as usize, grid.height as usize);
    let number = |x: usize, y: usize| (y - first) * width + x;
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
    let mut edges = vec![false; width * rows.len()];
    if grid.samples_per_side > 1 {
        parallel::map_chunks_mut(&mut edges, (PIECE_ROWS * width).max(1), |piece, edges| {
            for (k, edge) in edges.iter_mut().enumerate() {
                *edge = is_edge(k % width, rows.start + piece * PIECE_ROWS + k / width);
            }
        });
    }
    edges
}

/// Pixels of a strip that are seen again sample by sample.
#[derive(Clone, Copy)]
pub struct EdgePixels<'a> {
    /// The picture's pixels and samples.
    pub grid: &'a SampleGrid,
    /// The strip's first row.
    pub first: usize,
    /// The rays of the pixels' centres of all of its rows, row by row.
    pub centres: &'a [PictureRay],
    /// Which of these pixels are seen again.
    pub edges: &'a [bool],
}

/// What hands over the rays of the samples of the edge pixels of some rows, `PIECE_ROWS` at the most: those of
/// whole pixels at a time, in the order of [`EdgePixels::samples`].
pub type SampleSight<'a> = Box<dyn Fn(Range<usize>, &mut dyn FnMut(&[PictureRay])) + Sync + 'a>;

impl<'a> EdgePixels<'a> {
    /// The samples of some of the rows: each pixel's number in the strip and the sample's place, pixel by
    /// pixel, row by row of samples.
    pub fn samples(&self, rows: Range<usize>) -> impl Iterator<Item = (usize, [f64; 2])> + 'a {
        self.grid.samples(self.edges, self.first, rows)
    }
}

/// What gives the rays of the samples of a strip's edge pixels.
pub trait Sight: Sync {
    /// That of the samples of `pixels`.
    fn samples<'a>(&'a self, pixels: EdgePixels<'a>) -> SampleSight<'a>;
}

/// The sight that asks its function for sample by sample, with the ray of its pixel's centre.
pub struct OneByOne<F>(pub F);

impl<F: Fn(&PictureRay, [f64; 2]) -> PictureRay + Sync> Sight for OneByOne<F> {
    fn samples<'a>(&'a self, pixels: EdgePixels<'a>) -> SampleSight<'a> {
        let see = move |(pixel, at): (usize, [f64; 2])| self.0(&pixels.centres[pixel], at);
        Box::new(move |rows, take| {
            let mut rays = Vec::new();
            for y in rows {
                rays.clear();
                rays.extend(pixels.samples(y..y + 1).map(see));
                take(&rays);
            }
        })
    }
}

/// The sight that asks its function for lines of samples across the picture: by their x and their one y.
pub struct LineByLine<F>(pub F);

impl<F: Fn(&[f64], f64) -> Vec<PictureRay> + Sync> Sight for LineByLine<F> {
    fn samples<'a>(&'a self, pixels: EdgePixels<'a>) -> SampleSight<'a> {
        let EdgePixels { grid, first, edges, .. } = pixels;
        let (width, side) = (grid.width as usize, grid.samples_per_side.max(1));
        Box::new(move |rows, take| {
            let mut rays = Vec::new();
            for y in rows {
                let row = &edges[(y - first) * width..][..width];
                let columns = (0..width).filter(|&x| row[x]);
                let columns: Vec<f64> =
                    columns.flat_map(|x| (0..side).map(move |k| place(side, x, k))).collect();
                let lines: Vec<Vec<PictureRay>> =
                    (0..side).map(|k| self.0(&columns, place(side, y, k))).collect();
                rays.clear();
                for pixel in (0..columns.len()).step_by(side as usize) {
                    let of_pixel = lines.iter().map(|line| &line[pixel..pixel + side as usize]);
                    of_pixel.for_each(|samples| rays.extend_from_slice(samples));
                }
                take(&rays);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_give_the_samples_in_the_order_of_the_pixels() {
        let grid = SampleGrid { width: 5, height: 4, samples_per_side: 3, pixel_rad: 0.01 };
        let edges: Vec<bool> = (0..15).map(|k| k % 4 == 1 || k == 6).collect();
        let ray = |x: f64, y: f64| {
            let origin = DVec3::new(x, y, 0.0);
            PictureRay::reflected(Ray { origin, direction: DVec3::Z })
        };
        let centres = vec![PictureRay::lost(Outcome::Missed); 15];
        let pixels = EdgePixels { grid: &grid, first: 1, centres: &centres, edges: &edges };
        let alone = OneByOne(|_: &PictureRay, [x, y]: [f64; 2]| ray(x, y));
        let lines = LineByLine(|xs: &[f64], y: f64| xs.iter().map(|x| ray(*x, y)).collect());
        let all = |sight: SampleSight, rows: Range<usize>| {
            let mut all = Vec::new();
            sight(rows, &mut |rays| {
                assert!(rays.len().is_multiple_of(9), "whole pixels");
                all.extend_from_slice(rays);
            });
            all
        };
        for rows in [1..4, 2..3] {
            let found = all(lines.samples(pixels), rows.clone());
            assert!(!found.is_empty());
            assert_eq!(found, all(alone.samples(pixels), rows));
        }
    }
}
