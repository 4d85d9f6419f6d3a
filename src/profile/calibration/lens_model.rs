//! Models of distortion, and the coefficients of each.

use crate::optics::Distortion;
use std::fmt;

/// Model of a lens's distortion, by the module of OpenCV that calibrates it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LensModel {
    /// `cv::calibrateCamera`: the polynomial of Brown and Conrady.
    OpenCv,
    /// `cv::fisheye::calibrate`: the polynomial of Kannala and Brandt.
    Fisheye,
}

impl fmt::Display for LensModel {
    /// The word of `camera.calibrated.model`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::OpenCv => "opencv",
            Self::Fisheye => "fisheye",
        })
    }
}

/// What a list of coefficients must be, and what it is.
#[derive(Debug, Clone, PartialEq)]
pub struct CoefficientFault {
    /// What it must be.
    pub must: String,
    /// What it is.
    pub found: String,
}

impl LensModel {
    /// The distortion of coefficients in OpenCV's order; none at all are those of a lens without distortion.
    ///
    /// # Errors
    /// [`CoefficientFault`] when there are more or fewer than the model has, or the sensor is tilted.
    pub fn distortion(self, coefficients: &[f64]) -> Result<Distortion, CoefficientFault> {
        let fault =
            |must: &str, found: String| Err(CoefficientFault { must: must.to_owned(), found });
        let counted = format!("a list of {}", coefficients.len());
        if self == Self::Fisheye {
            return match *coefficients {
                [k1, k2, k3, k4] => Ok(Distortion::KannalaBrandt { radial: [k1, k2, k3, k4] }),
                _ => {
                    fault("a list of 4 coefficients, k1 to k4, with the model \"fisheye\"", counted)
                }
            };
        }
        if !matches!(coefficients.len(), 0 | 4 | 5 | 8 | 12 | 14) {
            let must = "a list of 4, 5, 8, 12 or 14 coefficients (or none) in OpenCV's order: k1, k2, p1, p2, \
                        k3, k4, k5, k6, s1, s2, s3, s4, tau_x, tau_y";
            return fault(must, counted);
        }
        let mut all = [0.0; 14];
        all[..coefficients.len()].copy_from_slice(coefficients);
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tau_x, tau_y] = all;
        if [tau_x, tau_y] != [0.0; 2] {
            let must = "without a tilted sensor, tau_x and tau_y 0";
            return fault(must, format!("{tau_x} and {tau_y}"));
        }
        if all == [0.0; 14] {
            return Ok(Distortion::None);
        }
        let radial = [k1, k2, k3, k4, k5, k6];
        Ok(Distortion::BrownConrady { radial, tangential: [p1, p2], prism: [s1, s2, s3, s4] })
    }
}
