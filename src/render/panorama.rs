//! Pictures as worlds: an equirectangular panorama far away.

use std::f64::consts::TAU;

use super::World;
use super::angle_tables::AngleTables;
use crate::geom::Ray;
use crate::num;
use crate::raster::Raster;

/// Mip pyramid of a picture: its halves, quarters and so on, for samples that cover many pixels.
#[derive(Debug, Clone)]
pub(super) struct MipPyramid {
    /// The picture first.
    levels: Vec<Raster>,
}

impl MipPyramid {
    /// Averages `picture`, in linear light, down to one pixel.
    #[must_use]
    pub(super) fn new(picture: Raster) -> Self {
        let mut levels = vec![picture];
        while let Some(last) = levels.last().filter(|last| last.width.max(last.height) > 1) {
            let half = downsampled(last);
            levels.push(half);
        }
        Self { levels }
    }

    /// Width and height of the picture.
    #[must_use]
    pub(super) fn size(&self) -> [usize; 2] {
        [self.levels[0].width, self.levels[0].height]
    }

    /// The light at the shares `u` of the width from the left and `v` of the height from the top, to a
    /// sample that covers `texels` pixels of the picture along each side. Left and right are joined.
    #[must_use]
    pub(super) fn light(&self, u: f64, v: f64, texels: f64) -> [f32; 3] {
        let at = |level: usize| {
            let picture = &self.levels[level.min(self.levels.len() - 1)];
            picture.sample(u * picture.width as f64, v * picture.height as f64, true)
        };
        // Also for NaN.
        if !(texels > 1.0) {
            return at(0);
        }
        let level = num::log(texels) / std::f64::consts::LN_2;
        let (fine, share) = (level.floor(), (level - level.floor()) as f32);
        let (a, b) = (at(fine as usize), at(fine as usize + 1));
        std::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
    }
}

/// Half as many columns and rows, rounded up, by area.
fn downsampled(picture: &Raster) -> Raster {
    let (width, height) = (picture.width.div_ceil(2), picture.height.div_ceil(2));
    // The pixels under each of `fewer`, and the shares of its area that they fill.
    let covers = |count: usize, fewer: usize| -> Vec<Vec<(usize, f32)>> {
        let cover = |k: usize| {
            let (lo, hi) = (k * count, (k + 1) * count);
            let part = |p: usize| {
                let overlap = hi.min((p + 1) * fewer) - lo.max(p * fewer);
                (p, overlap as f32 / count as f32)
            };
            (lo / fewer..hi.div_ceil(fewer)).map(part).collect()
        };
        (0..fewer).map(cover).collect()
    };
    let (columns, rows) = (covers(picture.width, width), covers(picture.height, height));
    let mut half = Raster::new(width, height, [0.0; 3]);
    for (line, row) in half.rgb.chunks_exact_mut(width).zip(&rows) {
        for (pixel, column) in line.iter_mut().zip(&columns) {
            for &(y, b) in row {
                for &(x, a) in column {
                    let light = picture.rgb[y * picture.width + x];
                    *pixel = std::array::from_fn(|c| pixel[c] + a * b * light[c]);
                }
            }
        }
    }
    half
}

/// An equirectangular picture around everything: its width is a full turn, its middle column is azimuth
/// 0, azimuth grows to the right; its middle row is the horizon, elevation grows upwards in steps as wide
/// as the columns'. Twice as wide as high it is the whole sphere; lower, its first and last row go on
/// above and below.
pub struct PanoramaWorld {
    pyramid: MipPyramid,
    angles: AngleTables,
}

impl PanoramaWorld {
    /// Takes over a picture; none when it is higher than half its width, or empty.
    #[must_use]
    pub fn new(picture: Raster) -> Option<Self> {
        let fits = picture.height > 0 && 2 * picture.height <= picture.width;
        fits.then(|| Self { pyramid: MipPyramid::new(picture), angles: AngleTables::new() })
    }
}

impl World for PanoramaWorld {
    fn light(&self, ray: &Ray, footprint_rad: f64) -> [f32; 3] {
        let d = ray.direction;
        let level = (d.x * d.x + d.y * d.y).sqrt();
        let [width, height] = self.pyramid.size().map(|n| n as f64);
        let u = 0.5 + self.angles.atan2(d.x, d.y) / TAU;
        let v = 0.5 - self.angles.elevation(d.z, level) / TAU * (width / height);
        self.pyramid.light(u, v, footprint_rad * width / TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::num::{cos, radians, sin};

    fn towards(azimuth_deg: f64, elevation_deg: f64) -> Ray {
        let [a, e] = [azimuth_deg, elevation_deg].map(radians);
        let direction = DVec3::new(cos(e) * sin(a), cos(e) * cos(a), sin(e));
        Ray { origin: DVec3::new(3.0, 5.0, 1.0), direction }
    }

    /// Red is the column, green the row, from 0 to 1.
    fn ramp(width: usize, height: usize) -> Raster {
        let at = |k: usize| {
            let (x, y) = ((k % width) as f32 + 0.5, (k / width) as f32 + 0.5);
            [x / width as f32, y / height as f32, 0.5]
        };
        Raster { width, height, rgb: (0..width * height).map(at).collect() }
    }

    #[test]
    fn directions_find_their_pixels() {
        for height in [180, 60] {
            let world = PanoramaWorld::new(ramp(360, height)).unwrap();
            let reach = height as f64 / 2.0;
            for azimuth in [-170.0, -90.25, 0.0, 33.3, 90.0, 178.0] {
                for elevation in [-0.9 * reach, -10.0, 0.0, 7.7, 0.9 * reach] {
                    let [red, green, _] =
                        world.light(&towards(azimuth, elevation), 1e-6).map(f64::from);
                    assert!((red - (0.5 + azimuth / 360.0)).abs() < 1e-6, "{azimuth} {red}");
                    let exact = 0.5 - elevation / height as f64;
                    assert!((green - exact).abs() < 1e-6, "{elevation} {green} {exact}");
                }
            }
        }
    }

    #[test]
    fn poles_and_what_lies_beyond_the_rows_have_the_edges_colours() {
        let world = PanoramaWorld::new(ramp(360, 60)).unwrap();
        assert!((world.light(&towards(12.0, 80.0), 1e-6)[1] - 0.5 / 60.0).abs() < 1e-6);
        assert!((world.light(&towards(12.0, -90.0), 1e-6)[1] - 59.5 / 60.0).abs() < 1e-6);
        assert!(
            PanoramaWorld::new(ramp(10, 6)).is_none() && PanoramaWorld::new(ramp(0, 0)).is_none()
        );
    }

    #[test]
    fn halves_keep_the_mean_and_small_samples_the_detail() {
        for (width, height) in [(16, 8), (37, 11), (5, 1)] {
            let dots =
                |k: usize| [if k.is_multiple_of(3) { 1.0 } else { 0.0 }, (k * k % 7) as f32, 0.25];
            let picture = Raster { width, height, rgb: (0..width * height).map(dots).collect() };
            let mean = |p: &Raster, c: usize| {
                p.rgb.iter().map(|light| f64::from(light[c])).sum::<f64>() / p.rgb.len() as f64
            };
            let expected = [0, 1, 2].map(|c| mean(&picture, c));
            let pyramid = MipPyramid::new(picture.clone());
            for (c, expected) in expected.into_iter().enumerate() {
                let last = pyramid.levels.last().unwrap();
                assert!((mean(last, c) - expected).abs() < 1e-5, "{width} {height}");
                let all = f64::from(pyramid.light(0.3, 0.6, 1e9)[c]);
                assert!((all - expected).abs() < 1e-5, "{width} {height}");
            }
            let one = pyramid.light(3.5 / width as f64, 0.5 / height as f64, 1.0);
            assert!(one.iter().zip(picture.rgb[3]).all(|(a, b)| (a - b).abs() < 1e-6));
        }
    }

    #[test]
    fn a_wide_sample_of_fine_stripes_sees_their_mean() {
        let stripes = |k: usize| [if k.is_multiple_of(2) { 1.0 } else { 0.0 }; 3];
        let rgb = (0..512 * 256).map(stripes).collect();
        let world = PanoramaWorld::new(Raster { width: 512, height: 256, rgb }).unwrap();
        let texel = TAU / 512.0;
        for azimuth in [0.0, 10.1, 50.3, -77.7] {
            let wide = world.light(&towards(azimuth, 3.0), 4.0 * texel)[0];
            assert!((wide - 0.5).abs() < 1e-3, "{wide}");
        }
    }
}
