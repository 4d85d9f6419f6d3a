//! Lens distortion: from the direction of a chief ray to its place in the picture, and back.
//!
//! Points are normalised image coordinates in OpenCV's sense, x = X / Z to the right and y = Y / Z downwards
//! with Z along the optical axis away from the camera: the place in the picture is the principal point plus
//! the focal lengths times the distorted point.

mod inverse_table;
mod lift;
mod radial_map;

pub(super) use inverse_table::InverseTable;

use crate::num::{Scalar, atan, degrees};
use lift::Lift;
use radial_map::RadialMap;
use std::f64::consts::FRAC_PI_2;
use thiserror::Error;

/// Least determinant, 1 at the centre, that a frame may have of the derivatives of the distorted point by the angle
/// to the optical axis (a vector, as long as the angle): nearer to the fold, a pixel holds a hundred times as
/// much of the world as in the centre. It leaves out the last 1e-4 or so of the way to a fold.
const LEAST_DETERMINANT: f64 = 0.01;
/// Largest angle of a ray to the optical axis, rad, 89 degrees: a ray beyond comes to the reference plane 57
/// distances from the axis, or never.
const MOST_ANGLE: f64 = FRAC_PI_2 * 89.0 / 90.0;
/// Its tangent.
const MOST_TANGENT: f64 = 57.289_961_630_759_42;
/// Points along the way to a frame's boundary at which the determinant is looked at, beside the steps of the
/// inverse, over each of which the Jacobian changes by half at most.
const LOOKS: u32 = 16;

/// Model of a lens's distortion with its coefficients, in OpenCV's naming.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distortion {
    /// A lens without distortion.
    None,
    /// The rational polynomial with tangential and thin-prism terms (Brown; Conrady). *Source:* OpenCV, module
    /// `calib3d`, detailed description.
    BrownConrady {
        /// k1 to k6: numerator 1 + k1 r^2 + k2 r^4 + k3 r^6, denominator with k4, k5 and k6.
        radial: [f64; 6],
        /// p1 and p2.
        tangential: [f64; 2],
        /// s1 to s4.
        prism: [f64; 4],
    },
    /// A fisheye lens: the image radius is a polynomial of the angle to the optical axis, t (1 + k1 t^2 + k2 t^4
    /// + k3 t^6 + k4 t^8). *Source:* Kannala and Brandt, *A generic camera model*, 2006; OpenCV, `cv::fisheye`.
    KannalaBrandt {
        /// k1 to k4.
        radial: [f64; 4],
    },
}

/// Reason why a place in the picture belongs to no ray before the camera.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DistortionFault {
    /// The model folds the picture over.
    #[error("the distortion folds the picture over there: two rays meet in a place, or none does")]
    Folded,
    /// The ray is at too great an angle.
    #[error(
        "its ray leaves at {angle_deg:.1} degrees from the optical axis, which must be 89 at most"
    )]
    Aside {
        /// Angle to the optical axis, degrees.
        angle_deg: f64,
    },
}

impl Distortion {
    /// The distorted point of an undistorted one.
    #[must_use]
    pub fn distorted<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        match self {
            Self::None => q,
            Self::BrownConrady { .. } => self.map().image(q),
            Self::KannalaBrandt { .. } => {
                let [x, y] = q;
                let per_angle = (x.square() + y.square()).atan_over_root();
                self.map().image([x * per_angle, y * per_angle])
            }
        }
    }

    /// The undistorted point of a distorted one: the inverse of [`Self::distorted`], to rounding, on the
    /// branch of the centre. It is followed along the straight way from there.
    ///
    /// # Errors
    /// [`DistortionFault`] when the model folds over on that way, or the ray is not well before the camera.
    pub fn undistorted(&self, p: [f64; 2]) -> Result<[f64; 2], DistortionFault> {
        if *self == Self::None {
            return self.ray(p);
        }
        let map = self.map();
        let mut lift = Lift::new(&map, p);
        if !lift.advance(1.0) {
            return Err(DistortionFault::Folded);
        }
        self.ray(lift.at)
    }

    /// How far the way from the centre to the distorted point `end` is undistorted with a margin: the first
    /// share of it that is not, and why.
    #[must_use]
    pub fn first_fault(&self, end: [f64; 2]) -> Option<(f64, DistortionFault)> {
        let map = self.map();
        let mut good = Lift::new(&map, end);
        for look in 1..=LOOKS {
            let share = f64::from(look) / f64::from(LOOKS);
            match self.reached(good, share) {
                Ok(next) => good = next,
                Err(fault) => {
                    let mut first = (share, fault);
                    // To a millionth of the way between looks: less than a pixel.
                    for _ in 0..20 {
                        let middle = 0.5 * (good.share + first.0);
                        match self.reached(good, middle) {
                            Ok(next) => good = next,
                            Err(fault) => first = (middle, fault),
                        }
                    }
                    return Some(first);
                }
            }
        }
        None
    }

    /// Goes on to `share`, where the determinant has its margin and the ray is before the camera.
    fn reached<'m>(&self, mut lift: Lift<'m>, share: f64) -> Result<Lift<'m>, DistortionFault> {
        if !lift.advance(share) {
            return Err(DistortionFault::Folded);
        }
        self.ray(lift.at)?;
        let [x, y] = lift.at;
        let u = x * x + y * y;
        // Of tan t by t, along and across.
        let by_angle = match self {
            Self::KannalaBrandt { .. } => 1.0,
            _ => (1.0 + u) / u.atan_over_root(),
        };
        if !(lift.determinant() * by_angle >= LEAST_DETERMINANT) {
            return Err(DistortionFault::Folded);
        }
        Ok(lift)
    }

    /// The ray of a point of the model's own plane: X / Z and Y / Z, of a fisheye lens the angle's vector.
    fn ray(&self, w: [f64; 2]) -> Result<[f64; 2], DistortionFault> {
        let u = w[0] * w[0] + w[1] * w[1];
        let is_angle = matches!(self, Self::KannalaBrandt { .. });
        let most = if is_angle { MOST_ANGLE } else { MOST_TANGENT };
        if !(u <= most * most) {
            let angle = if is_angle { u.sqrt() } else { atan(u.sqrt()) };
            return Err(DistortionFault::Aside { angle_deg: degrees(angle) });
        }
        let stretch = if is_angle { u.tan_over_root() } else { 1.0 };
        Ok(w.map(|w| w * stretch))
    }

    /// The model over its own plane: X / Z and Y / Z, of a fisheye lens the angle to the optical axis in the
    /// direction of these.
    fn map(&self) -> RadialMap {
        let mut map = RadialMap {
            numerator: [0.0; 4],
            denominator: [0.0; 3],
            tangential: [0.0; 2],
            prism: [0.0; 4],
        };
        match *self {
            Self::None => {}
            Self::BrownConrady { radial: [k1, k2, k3, k4, k5, k6], tangential, prism } => {
                map.numerator = [k1, k2, k3, 0.0];
                map.denominator = [k4, k5, k6];
                (map.tangential, map.prism) = (tangential, prism);
            }
            Self::KannalaBrandt { radial } => map.numerator = radial,
        }
        map
    }
}

#[cfg(test)]
mod tests;
