//! How sharp a picture is: blur ellipses, the Airy pattern and the pixel together, and the aperture at which
//! they are least.

use super::BlurEllipse;
use super::blur_ellipse::{Quantiles, quantiles};
use crate::num::{acos, j1, sin};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Diameter of the Airy disc, to its first dark ring, in wavelengths over the sine of the cone's half
/// angle: twice the first zero of the Bessel function J1 over 2 pi.
const AIRY: f64 = 1.219_669_891_266_504_5;
/// Spatial frequency of the reported contrast, cycles a pixel: a quarter of the sampling frequency.
const FREQUENCY: f64 = 0.25;

/// Blur of a picture in one focus, as a function of the aperture.
#[derive(Debug, Clone, Copy)]
pub struct Sharpness {
    /// Full length of the blur ellipses for an aperture radius of 1, px.
    lengths: Quantiles,
    /// Diameter of the Airy disc times the aperture's radius, px.
    airy: f64,
}

/// Blur and contrast through one aperture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ApertureSharpness {
    /// Full length of a pixel's blur ellipse that 95 % of the pixels do not exceed, px.
    pub geometric_px: f64,
    /// Diameter of the Airy disc, px.
    pub diffraction_px: f64,
    /// Root of the sum of both squares and of a pixel's: what 95 % of the spots do not exceed, px.
    pub spot_px: f64,
    /// Contrast at a quarter of the sampling frequency along the ellipse's length, for the median spot.
    pub mtf_p50: f64,
    /// Contrast that 95 % of the pixels reach.
    pub mtf_p05: f64,
}

impl Sharpness {
    /// Of `spots` in pixels, focused on `phi`, by light of a wavelength of `wavelength_px` pixels on the
    /// reference plane, where `cone` is the tangent of the cone's half angle for an aperture radius of 1;
    /// none without spots.
    #[must_use]
    pub fn new(spots: &[BlurEllipse], phi: f64, wavelength_px: f64, cone: f64) -> Option<Self> {
        let lengths = quantiles(spots.iter().map(|spot| spot.length(phi)).collect())?;
        Some(Self { lengths, airy: AIRY * wavelength_px / cone })
    }

    /// The radius of the aperture at which 95 % of the spots are least: where ellipse and Airy disc are
    /// equally long.
    #[must_use]
    pub fn best_radius(&self) -> f64 {
        (self.airy / self.lengths.p95).sqrt()
    }

    /// The spots through an aperture of this radius.
    #[must_use]
    pub fn at(&self, radius: f64) -> ApertureSharpness {
        let geometric_px = self.lengths.p95 * radius;
        let diffraction_px = self.airy / radius;
        let square = geometric_px * geometric_px + diffraction_px * diffraction_px + 1.0;
        let mtf = |length: f64| {
            let ellipse = disc(PI * FREQUENCY * length * radius);
            ellipse * airy_pattern(FREQUENCY * diffraction_px / (2.0 * AIRY)) * pixel(FREQUENCY)
        };
        ApertureSharpness {
            geometric_px,
            diffraction_px,
            spot_px: square.sqrt(),
            mtf_p50: mtf(self.lengths.p50),
            mtf_p05: mtf(self.lengths.p95),
        }
    }
}

/// Contrast of a disc or ellipse at `x`, pi times its cycles a length, up to where it first is none:
/// 2 J1(x) / x.
fn disc(x: f64) -> f64 {
    /// The first zero of J1.
    const NONE: f64 = 3.831_705_970_207_512;
    if x < 1e-6 {
        1.0
    } else if x >= NONE {
        0.0
    } else {
        2.0 * j1(x) / x
    }
}

/// Contrast of the Airy pattern at the share `s` of the frequency from which on there is none.
fn airy_pattern(s: f64) -> f64 {
    if s >= 1.0 { 0.0 } else { 2.0 / PI * (acos(s) - s * (1.0 - s * s).sqrt()) }
}

/// Contrast of a pixel's square.
fn pixel(frequency: f64) -> f64 {
    sin(PI * frequency) / (PI * frequency)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::cos;
    use crate::pencil::Pencil;
    use glam::{DMat2, DVec2};

    fn spots() -> Vec<BlurEllipse> {
        let spot = |k: u32| {
            let k = f64::from(k);
            let focus = DMat2::from_diagonal(DVec2::new(3.0 + 0.01 * k, 3.0 - 0.02 * k));
            BlurEllipse::new(&Pencil { seen: DVec2::ZERO, turn: DMat2::IDENTITY, focus })
                .scaled(20.0)
        };
        (0..200).map(spot).collect()
    }

    #[test]
    fn spots_are_sums_of_squares_and_the_best_aperture_is_the_best_of_many() {
        let (spots, phi) = (spots(), 2.5);
        let sharpness = Sharpness::new(&spots, phi, 0.006, 0.01).unwrap();
        for radius in [0.01, 0.05, 0.3] {
            let found = sharpness.at(radius);
            let mut all: Vec<f64> = spots
                .iter()
                .map(|spot| {
                    let [ellipse, airy] =
                        [spot.length(phi) * radius, AIRY * 0.006 / (0.01 * radius)];
                    (ellipse * ellipse + airy * airy + 1.0).sqrt()
                })
                .collect();
            all.sort_by(f64::total_cmp);
            assert!((found.spot_px - all[189]).abs() < 1e-12, "{radius}");
        }
        let best = sharpness.best_radius();
        let least = sharpness.at(best);
        assert!((least.geometric_px / least.diffraction_px - 1.0).abs() < 1e-12);
        for share in [0.5, 0.9, 1.1, 2.0] {
            assert!(sharpness.at(share * best).spot_px > least.spot_px);
        }
    }

    /// The Airy pattern's intensity is (2 J1(v) / v)^2: dark first where the disc is said to end; its
    /// contrast is the share that two displaced circles have in common.
    #[test]
    fn the_airy_pattern_is_dark_at_its_disc_and_its_contrast_that_of_overlapping_circles() {
        assert!(j1(PI * AIRY).abs() < 1e-15);
        let steps = 2000;
        for s in [0.0f64, 0.1, 0.35, 0.8, 0.99] {
            // Centres 2 s apart, radius 1: chords of the lens between them.
            let half = (1.0 - s * s).sqrt();
            let chord = |k: i32| -> f64 {
                let y: f64 = half * ((f64::from(k) + 0.5) / f64::from(steps) * 2.0 - 1.0);
                2.0 * ((1.0 - y * y).sqrt() - s).max(0.0)
            };
            let area = (0..steps).map(chord).sum::<f64>() * 2.0 * half / f64::from(steps);
            assert!((airy_pattern(s) - area / PI).abs() < 1e-4, "{s}");
        }
        assert_eq!(airy_pattern(1.0), 0.0);
    }

    #[test]
    fn contrast_of_an_ellipse_is_its_fourier_transform() {
        let n = 400;
        for x in [0.5, 2.0, 3.5] {
            let mut sum = [0.0; 2];
            for i in 0..n {
                for j in 0..n {
                    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0;
                    let (u, v) = (at(i), at(j));
                    if u * u + v * v < 1.0 {
                        sum[0] += cos(x * u);
                        sum[1] += 1.0;
                    }
                }
            }
            assert!((disc(x) - sum[0] / sum[1]).abs() < 1e-3, "{x}");
        }
        assert!(disc(0.0) == 1.0 && disc(4.0) == 0.0);
        assert!((pixel(0.25) - 0.900_316_316_157_106).abs() < 1e-12);
    }
}
