//! A calibrated camera: frame, focal lengths, principal point and distortion.

use super::{CameraModel, Distortion, DistortionFault};
use crate::num::hypot;
use crate::parallel;
use thiserror::Error;

/// Corners of pixels whose ways are worth a thread of their own: a millisecond's.
const WORTH_THREADS: usize = 64;

/// What a calibration finds of a camera. Its picture points are from the upper left corner of the frame, x to
/// the right and y downwards, with the centres of pixels at halves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Width and height of the frame in pixels.
    pub pixels: [u32; 2],
    /// Focal length across and down the picture, in pixels, positive.
    pub focal_px: [f64; 2],
    /// Picture point of the optical axis: OpenCV's, which has the centres of pixels at whole numbers, plus a
    /// half.
    pub principal_px: [f64; 2],
    /// Distortion of the lens.
    pub distortion: Distortion,
}

/// The pixel nearest to the principal point from which on no ray belongs to the picture.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("the pixel in column {} and row {} (from 0) has no ray of its own: {reason}", .pixel[0], .pixel[1])]
pub struct PixelFault {
    /// Column and row, from 0.
    pub pixel: [u32; 2],
    /// What is wrong there.
    pub reason: DistortionFault,
}

impl Calibration {
    /// The camera with its reference plane at `distance_mm` from the entrance pupil.
    #[must_use]
    pub fn camera(&self, distance_mm: f64) -> CameraModel {
        let Self { pixels, focal_px, principal_px, distortion } = *self;
        CameraModel::Calibrated { pixels, focal_px, principal_px, distortion, distance_mm }
    }

    /// The ray of a picture point: X / Z and Y / Z with Z along the optical axis away from the camera and y
    /// downwards.
    ///
    /// # Errors
    /// [`DistortionFault`] when there is none well before the camera.
    pub fn ray(&self, picture_px: [f64; 2]) -> Result<[f64; 2], DistortionFault> {
        self.distortion.undistorted(self.normalised(picture_px))
    }

    /// The picture point of a ray X / Z, Y / Z.
    #[must_use]
    pub fn picture_point(&self, ray: [f64; 2]) -> [f64; 2] {
        let distorted = self.distortion.distorted(ray);
        [0, 1].map(|k| self.focal_px[k] * distorted[k] + self.principal_px[k])
    }

    /// Checks that each pixel has a ray of its own, with a margin: along the straight ways from the principal
    /// point to all pixels' corners on the boundary of the frame the distortion does not fold over.
    ///
    /// # Errors
    /// [`PixelFault`] of the nearest place to the principal point that has none.
    pub fn check(&self) -> Result<(), PixelFault> {
        let corners: Vec<[f64; 2]> = self.boundary().collect();
        let faults = parallel::map_slice(&corners, WORTH_THREADS, |corner| {
            let (share, reason) = self.distortion.first_fault(self.normalised(*corner))?;
            let way = [0, 1].map(|k| share * (corner[k] - self.principal_px[k]));
            Some((way, reason))
        });
        let nearest = faults
            .into_iter()
            .flatten()
            .min_by(|(a, _), (b, _)| hypot(a[0], a[1]).total_cmp(&hypot(b[0], b[1])));
        let Some((way, reason)) = nearest else { return Ok(()) };
        let pixel = [0, 1].map(|k| {
            let place = (self.principal_px[k] + way[k]).floor();
            place.clamp(0.0, f64::from(self.pixels[k] - 1)) as u32
        });
        Err(PixelFault { pixel, reason })
    }

    /// The corners of pixels on the boundary of the frame.
    fn boundary(&self) -> impl Iterator<Item = [f64; 2]> {
        let [width, height] = self.pixels;
        let ends = [0.0, f64::from(width)];
        let across = (0..=width).map(f64::from);
        let rows = across.flat_map(move |x| [[x, 0.0], [x, f64::from(height)]]);
        let down = (1..height).map(f64::from);
        rows.chain(down.flat_map(move |y| ends.map(|x| [x, y])))
    }

    /// A picture point less the principal point, by the focal lengths.
    fn normalised(&self, picture_px: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (picture_px[k] - self.principal_px[k]) / self.focal_px[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(k1: f64) -> Calibration {
        let radial = [k1, 0.0, 0.0, 0.0, 0.0, 0.0];
        Calibration {
            pixels: [640, 480],
            focal_px: [400.0, 402.0],
            principal_px: [330.0, 236.5],
            distortion: Distortion::BrownConrady { radial, tangential: [0.0; 2], prism: [0.0; 4] },
        }
    }

    #[test]
    fn rays_and_picture_points_are_each_others_inverse() {
        let camera = camera(-0.1);
        assert_eq!(camera.check(), Ok(()));
        for point in [[0.0, 0.0], [639.5, 0.5], [330.0, 236.5], [100.0, 480.0]] {
            let again = camera.picture_point(camera.ray(point).unwrap());
            assert!((0..2).all(|k| (again[k] - point[k]).abs() < 1e-11), "{point:?} {again:?}");
        }
        assert_eq!(camera.ray([330.0, 236.5]), Ok([0.0, 0.0]));
    }

    /// Of r (1 + k1 r^2), which turns at 2 / (3 sqrt(-3 k1)).
    #[test]
    fn the_first_folded_pixel_is_named() {
        let folding = camera(-0.5);
        let fold = 2.0 / (3.0 * f64::sqrt(1.5));
        let PixelFault { pixel, reason } = folding.check().unwrap_err();
        assert_eq!(reason, DistortionFault::Folded);
        let place = [0, 1]
            .map(|k| (f64::from(pixel[k]) + 0.5 - folding.principal_px[k]) / folding.focal_px[k]);
        // The margin takes 3e-4 of the way, and a pixel's middle is off by 1 / 400 at most.
        assert!((hypot(place[0], place[1]) - fold).abs() < 3e-3, "{pixel:?}");
        let at = folding.check().unwrap_err().to_string();
        assert!(at.starts_with(&format!("the pixel in column {} and row {}", pixel[0], pixel[1])));
    }

    #[test]
    fn a_ray_to_the_side_is_no_ray_of_a_picture() {
        let wide = Calibration {
            focal_px: [200.0; 2],
            distortion: Distortion::KannalaBrandt { radial: [0.0; 4] },
            ..camera(0.0)
        };
        let PixelFault { pixel, reason } = wide.check().unwrap_err();
        assert!(
            matches!(reason, DistortionFault::Aside { angle_deg } if (89.0..89.1).contains(&angle_deg))
        );
        // 200 px per radian, from column 330: the left rim is nearer to 89 degrees than the corners are.
        assert_eq!(pixel[0], (330.0 - 200.0 * 89.0_f64.to_radians()) as u32);
    }
}
