//! Cameras: which ray each point of the picture sends out.

use crate::geom::{Chart, DVec2, Ray};

/// A camera on the axis looking along -Z, orthographic (telecentric) or pinhole, its picture
/// centred on the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Columns and rows of the sensor.
    pub pixels: [u32; 2],
    /// Side of a (square) pixel on the reference plane, mm.
    pub pixel_mm: f64,
    /// Where its rays go.
    pub chart: Chart,
}

impl Camera {
    /// The point (X, Y) mm on the reference plane under the picture point (`x`, `y`) pixels: x to
    /// the right, y downwards, both from the upper left corner; pixel centres at halves.
    #[inline]
    #[must_use]
    pub fn image_point(&self, x: f64, y: f64) -> DVec2 {
        let [width, height] = self.pixels.map(f64::from);
        DVec2::new(x - 0.5 * width, 0.5 * height - y) * self.pixel_mm
    }

    /// The ray through an image point, from the pinhole or from height `top_mm`.
    #[inline]
    #[must_use]
    pub fn ray(&self, q: DVec2, top_mm: f64) -> Ray {
        self.chart.ray(q, top_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_square_centred_and_run_right_and_down() {
        let chart = Chart { vergence: 0.0, plane_mm: 0.0 };
        let camera = Camera { pixels: [4, 2], pixel_mm: 0.5, chart };
        assert_eq!(camera.image_point(0.5, 0.5), DVec2::new(-0.75, 0.25));
        assert_eq!(camera.image_point(3.5, 1.5), DVec2::new(0.75, -0.25));
        assert_eq!(camera.image_point(2.0, 1.0), DVec2::ZERO);
    }
}
