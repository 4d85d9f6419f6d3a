//! The rays through the pixel centres of a camera.

use crate::geom::{DVec2, DVec3, Ray};
use crate::optics::Camera;

/// A camera's rays, with the places of its pixels' centres worked out once.
#[derive(Debug, Clone)]
pub struct Rays {
    pub camera: Camera,
    /// Where parallel rays start.
    pub top_mm: f64,
    /// X of the pixels' centres by column, and Y by row, on the reference plane, mm.
    pub centres: [Vec<f64>; 2],
}

impl Rays {
    pub fn new(camera: &Camera, top_mm: f64) -> Self {
        let [columns, rows] = camera.pixels.map(|n| (0..n).map(|k| f64::from(k) + 0.5));
        let centres = [
            columns.map(|x| camera.image_point(x, 0.0).x).collect(),
            rows.map(|y| camera.image_point(0.0, y).y).collect(),
        ];
        Self { camera: *camera, top_mm, centres }
    }

    /// The ray of a pixel.
    #[inline]
    pub fn at(&self, column: usize, row: usize) -> Ray {
        let [xs, ys] = &self.centres;
        self.camera.ray(DVec2::new(xs[column], ys[row]), self.top_mm)
    }

    /// The place at distance `t` on the ray of a pixel.
    #[inline]
    pub fn place(&self, column: usize, row: usize, t: f64) -> DVec3 {
        let Ray { origin, direction } = self.at(column, row);
        // (Nothing is left of the product of parallel rays.)
        if self.camera.chart.vergence == 0.0 {
            origin.with_z(origin.z - t)
        } else {
            origin + direction * t
        }
    }
}
