//! Cameras: which ray each point of the picture sends out.

use super::Distortion;
use crate::geom::{Chart, DVec2, Ray};
use crate::num::units::{Mm, Px};

/// Camera that looks into the mirror, by its frame and its focal length in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CameraModel {
    /// Telecentric camera: all its rays are parallel to the optical axis.
    Orthographic {
        /// Width and height of the frame in pixels.
        pixels: [u32; 2],
    },
    /// Camera whose rays all pass through one point on the optical axis.
    Pinhole {
        /// Width and height of the frame in pixels.
        pixels: [u32; 2],
        /// Focal length in pixels, positive.
        focal_px: f64,
        /// Distance of the reference plane from the pinhole, mm, positive.
        distance_mm: f64,
    },
    /// Camera whose rays all pass through the middle of its entrance pupil, as a calibration found it.
    Calibrated {
        /// Width and height of the frame in pixels.
        pixels: [u32; 2],
        /// Focal length across and down the picture, in pixels, positive.
        focal_px: [f64; 2],
        /// Picture point of the optical axis, as of [`Camera::image_point`]: pixel centres at halves.
        principal_px: [f64; 2],
        /// Distortion of the lens; every pixel of the frame has a ray.
        distortion: Distortion,
        /// Distance of the reference plane from the entrance pupil along the optical axis, mm, positive.
        distance_mm: f64,
    },
}

impl CameraModel {
    /// Width and height of the frame in pixels.
    #[must_use]
    pub fn pixels(&self) -> [u32; 2] {
        match *self {
            Self::Orthographic { pixels }
            | Self::Pinhole { pixels, .. }
            | Self::Calibrated { pixels, .. } => pixels,
        }
    }

    /// Side of a pixel on the reference plane, mm: the frame of a telecentric camera is as wide as the
    /// mirror, `width_mm`. Of a calibrated camera it is that on the optical axis, the geometric mean of both
    /// sides.
    #[must_use]
    pub fn pixel_mm(&self, width_mm: f64) -> f64 {
        match *self {
            Self::Orthographic { pixels } => width_mm / f64::from(pixels[0]),
            Self::Pinhole { focal_px, distance_mm, .. } => distance_mm / focal_px,
            Self::Calibrated { focal_px: [across, down], distance_mm, .. } => {
                distance_mm / (across * down).sqrt()
            }
        }
    }

    /// Curvature of the wavefronts on the reference plane, 1/mm: 0 for parallel rays.
    #[must_use]
    pub fn vergence(&self) -> f64 {
        match *self {
            Self::Orthographic { .. } => 0.0,
            Self::Pinhole { distance_mm, .. } | Self::Calibrated { distance_mm, .. } => {
                1.0 / distance_mm
            }
        }
    }
}

/// A camera on the axis looking along -Z, orthographic (telecentric) or pinhole, its picture
/// centred on the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Columns and rows of the sensor.
    pub pixels: [u32; 2],
    /// Side of a (square) pixel on the reference plane, mm.
    pub pixel_mm: f64,
    /// Coordinates along its rays.
    pub chart: Chart,
}

impl Camera {
    /// The same camera with so many columns and rows in as wide a frame.
    #[must_use]
    pub fn with_pixels(self, pixels: [u32; 2]) -> Self {
        let scale = f64::from(self.pixels[0]) / f64::from(pixels[0]);
        Self { pixels, pixel_mm: self.pixel_mm * scale, ..self }
    }

    /// Camera of a model over a mirror `width_mm` wide, its reference plane at Z = 0.
    #[must_use]
    pub fn new(model: &CameraModel, width_mm: f64) -> Self {
        let chart = Chart { vergence: model.vergence(), plane_mm: 0.0 };
        Self { pixels: model.pixels(), pixel_mm: model.pixel_mm(width_mm), chart }
    }

    /// The point (X, Y) mm on the reference plane under the picture point (`x`, `y`) pixels: x to
    /// the right, y downwards, both from the upper left corner; pixel centres at halves.
    #[inline]
    #[must_use]
    pub fn image_point(&self, x: f64, y: f64) -> DVec2 {
        let [width, height] = self.pixels.map(f64::from);
        DVec2::new(x - 0.5 * width, 0.5 * height - y) * self.pixel_mm
    }

    /// A length in the image as one on the reference plane.
    #[must_use]
    pub fn to_mm(&self, px: Px) -> Mm {
        Mm(px.0 * self.pixel_mm)
    }

    /// A length on the reference plane as one in the image.
    #[must_use]
    pub fn to_px(&self, mm: Mm) -> Px {
        Px(mm.0 / self.pixel_mm)
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
