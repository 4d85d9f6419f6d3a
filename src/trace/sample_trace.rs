//! Samples of some pixels of a camera: the nearest facets of their rays, which are rasterized as those of the
//! pixels' centres are, with the answers of a search for each.

use super::camera_rays::CameraRays;
use super::rasterizer::{PixelHit, Rasterizer};
use super::ray_end::{RayEnd, reflect_at_facet};
use super::scene::Scene;
use crate::geom::Ray;
use crate::optics::Camera;
use std::ops::Range;
use std::sync::Arc;

/// Rays through the samples of the pixels of a camera: equal rows and columns of them in each.
#[derive(Debug, Clone)]
pub struct SampleRays {
    rays: Arc<CameraRays>,
    side: u32,
}

impl SampleRays {
    /// Rays through `side` x `side` samples of each pixel, where they are parallel from height `top_mm`.
    #[must_use]
    pub fn new(camera: &Camera, top_mm: f64, side: u32) -> Self {
        Self { rays: Arc::new(CameraRays::through_samples(camera, top_mm, side)), side }
    }

    /// Ray through a sample, by its column and row among all samples.
    #[inline]
    #[must_use]
    pub fn at(&self, column: usize, row: usize) -> Ray {
        self.rays.at(column, row)
    }
}

/// First reflections of the rays through the samples of some pixels.
#[derive(Debug)]
pub struct SampleTrace<'a> {
    rasterizer: Rasterizer<'a>,
    rays: &'a SampleRays,
    rows: Range<usize>,
}

impl SampleRays {
    /// Which samples of rows of pixels are those of the `wanted` pixels, row by row of samples.
    #[must_use]
    pub fn wanted(&self, pixels: &[bool]) -> Vec<bool> {
        let side = self.side as usize;
        let columns = self.rays.camera.pixels[0] as usize / side;
        let mut wanted = Vec::with_capacity(pixels.len() * side * side);
        for row in pixels.chunks(columns.max(1)) {
            for _ in 0..side {
                wanted.extend(row.iter().flat_map(|wanted| std::iter::repeat_n(*wanted, side)));
            }
        }
        wanted
    }
}

impl<'a> SampleTrace<'a> {
    /// Traces the `wanted` samples ([`SampleRays::wanted`]) of the `rows` of pixels in `scene`. `None` where they
    /// cannot be rasterized.
    #[must_use]
    pub fn new(
        scene: &'a Scene,
        rays: &'a SampleRays,
        rows: Range<usize>,
        wanted: Vec<bool>,
    ) -> Option<Self> {
        let side = rays.side as usize;
        let samples = rows.start * side..rows.end * side;
        let rasterizer = Rasterizer::new(scene, &rays.rays, samples, Some(wanted))?;
        Some(Self { rasterizer, rays, rows })
    }

    /// Ends of the rays of all samples of `rows` of pixels, row by row of samples, in the place of what is in
    /// `ends`; of those that are not wanted they mean nothing. The rows begin a multiple of 32 after the first
    /// that is traced.
    pub fn ends_into(&self, rows: Range<usize>, ends: &mut Vec<RayEnd>) {
        let band_rows = self.rays.rays.band_rows();
        debug_assert_eq!((rows.start - self.rows.start) % band_rows, 0);
        let (columns, side) = (self.rays.rays.camera.pixels[0] as usize, self.rays.side as usize);
        let (first, rays) = (rows.start * side, self.rasterizer.rays());
        ends.resize(columns * rows.len() * side, RayEnd::MISSED);
        for (band, ends) in ends.chunks_mut(columns * band_rows).enumerate() {
            self.rasterizer.draw(first + band * band_rows, ends, |hit| {
                let PixelHit { column, row, t, facet, normal } = hit;
                let along = rays.at(column, row).direction;
                let (outcome, direction) = reflect_at_facet(along, normal);
                RayEnd { outcome, facet, t, direction }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{Chart, DVec3, TriMesh};

    /// A bumpy square of many facets over one large one.
    fn bumps() -> TriMesh {
        let side = 30u32;
        let vertex = |k: u32| {
            let (x, y) = (f64::from(k % side), f64::from(k / side));
            DVec3::new(x - 14.5, y - 14.5, 0.3 * f64::from(k * 7 % 11) + 2.0)
        };
        let quad = |k: u32| {
            let a = k / (side - 1) * side + k % (side - 1);
            [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
        };
        let mut vertices: Vec<DVec3> = (0..side * side).map(vertex).collect();
        let mut triangles: Vec<[u32; 3]> = (0..(side - 1) * (side - 1)).flat_map(quad).collect();
        triangles.push([0, 1, 2].map(|k| vertices.len() as u32 + k));
        vertices.extend(
            [(-20.0, -20.0), (30.0, -20.0), (-20.0, 30.0)].map(|(x, y)| DVec3::new(x, y, 1.0)),
        );
        TriMesh { vertices, triangles }
    }

    #[test]
    fn samples_that_are_wanted_meet_what_a_search_finds() {
        let scene = Scene::new(bumps());
        for (vergence, side) in [(0.0, 2), (0.0, 3), (0.02, 2)] {
            let chart = Chart::on_axis(vergence, 0.0);
            let camera = Camera {
                pixels: [50, 80],
                pixel_mm: 0.7,
                chart,
                picture: crate::optics::PictureMap::default(),
            };
            let rays = SampleRays::new(&camera, scene.above_mm(), side);
            let (rows, side) = (32..77, side as usize);
            let pixels: Vec<bool> = (0..50 * rows.len()).map(|k| k * 7 % 5 < 2).collect();
            let trace =
                SampleTrace::new(&scene, &rays, rows.clone(), rays.wanted(&pixels)).unwrap();
            let (mut tried, mut hits) = (0, 0);
            for rows in [32..64, 64..77] {
                let mut ends = Vec::new();
                trace.ends_into(rows.clone(), &mut ends);
                assert_eq!(ends.len(), 50 * side * rows.len() * side);
                for (k, end) in ends.iter().enumerate() {
                    let (column, row) = (k % (50 * side), rows.start * side + k / (50 * side));
                    if pixels[(row / side - 32) * 50 + column / side] {
                        assert_eq!(*end, scene.trace_primary(&rays.at(column, row)));
                        let place =
                            |k: usize| (k / side) as f64 + ((k % side) as f64 + 0.5) / side as f64;
                        let point = camera.image_point(place(column), place(row));
                        assert_eq!(rays.at(column, row), camera.ray(point, scene.above_mm()));
                        tried += 1;
                        hits += usize::from(end.facet != RayEnd::NO_FACET);
                    }
                }
            }
            assert!(hits > 1000 && hits < tried, "{hits} of {tried}");
        }
    }
}
