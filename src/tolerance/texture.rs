//! Textures of a part: their shapes, slopes and heights, and the light that they scatter.

use crate::num::{cos, exp, radians, sin};
use std::f64::consts::{PI, SQRT_2};

/// Lengths, directions and radii that shape the textures, and the thermal expansion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureShape {
    /// Thermal expansion of the part, 1e-6 / K.
    pub cte_ppm_per_k: f64,
    /// Period of the waviness, mm.
    pub waviness_period_mm: f64,
    /// Direction in which the waves follow each other, from X towards Y, degrees.
    pub waviness_direction_deg: f64,
    /// Distance over which the autocorrelation of the random slope falls to 1/e, mm.
    pub slope_correlation_mm: f64,
    /// Radius of the ball cutter, mm.
    pub ball_radius_mm: f64,
    /// Direction in which its tracks follow each other, from X towards Y, degrees.
    pub stepover_direction_deg: f64,
    /// Wavelength of the light, nm.
    pub wavelength_nm: f64,
}

impl TextureShape {
    /// Unit vector of a direction.
    pub(super) fn way(degrees: f64) -> [f64; 2] {
        let angle = radians(degrees);
        [cos(angle), sin(angle)]
    }
}

/// RMS slope of a ripple of height `pv` and period `period`, of the same unit.
#[must_use]
pub fn ripple_slope(pv: f64, period: f64) -> f64 {
    PI * pv / (SQRT_2 * period)
}

/// Height of the cusps that a ball of radius `ball` leaves between tracks `stepover` apart.
#[must_use]
pub fn scallop_height(ball: f64, stepover: f64) -> f64 {
    let half = 0.5 * stepover;
    // Without cancellation.
    half * half / (ball + (ball * ball - half * half).sqrt())
}

/// Share of the light that heights of RMS `sigma`, along the normal and of the wavelength's unit, turn
/// or scatter: the total integrated scatter, (4 pi sigma / lambda)^2 where it is small (H. E. Bennett
/// and J. O. Porteus, *Relation between surface roughness and specular reflectance at normal
/// incidence*, 1961).
#[must_use]
pub fn scattered(sigma: f64, wavelength: f64) -> f64 {
    let phase = 4.0 * PI * sigma / wavelength;
    1.0 - exp(-phase * phase)
}

/// RMS displacement over a regular facet, as a share of the largest, at its corners: the mean square of
/// the distance from the middle of an equilateral triangle is a quarter of its circumradius'.
const FACET_RMS: f64 = 0.5;
/// Circumradius, px, of the equilateral triangle as large as facets are on the average that just keep a
/// bound of 1 px: meshes have 0.85 (round mirrors) to 1.5 facets to a pixel then. It would be 1 if all of
/// them were regular and just kept it.
pub(super) const FACET_RADIUS: f64 = 0.8;
/// Standard deviation of the square of the distance from the middle of an equilateral triangle, as a
/// share of its circumradius' square.
pub(super) const FACET_HEIGHT: f64 = 0.1935;

/// The bound, px, that so many facets to a pixel just keep.
#[must_use]
pub fn facets_bound(facets_per_pixel: f64) -> f64 {
    // The area of an equilateral triangle is 3 sqrt 3 / 4 of its circumradius' square.
    let radius = (1.0 / (0.75 * 3f64.sqrt() * facets_per_pixel)).sqrt();
    radius / FACET_RADIUS
}

/// RMS displacement by facets that just keep a bound of `limit` px.
pub(super) fn facet_rms(limit: f64) -> f64 {
    FACET_RMS * limit.abs()
}

/// RMS of the mean displacement over a pixel, px, by facets that just keep a bound of `limit` px. A flat
/// facet shows what belongs to its middle, so that facets finer than pixels average out.
#[must_use]
pub fn facets_displace(limit: f64) -> f64 {
    let limit = limit.abs();
    // Of irregular meshes, by sums over many; for fine ones the rim of the footprint, which cuts
    // facets, is what is left.
    let share = if limit == 0.0 { 0.0 } else { 1.0 / (1.0 + 0.7 / limit + 1.7 / (limit * limit)) };
    facet_rms(limit) * share
}

/// Share of the light that flat terraces of height `layer_um` turn: of heights spread evenly over a
/// layer.
pub(super) fn terraced(layer_um: f64, wavelength_nm: f64) -> f64 {
    scattered(1e3 * layer_um.abs() / 12f64.sqrt(), wavelength_nm)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cusps 2 nm high have an RMS of 0.596 nm.
    #[test]
    fn heights_far_below_the_wavelength_scatter_a_little() {
        let sigma = 2.0 * 8.0 / 720f64.sqrt();
        let share = scattered(sigma, 550.0);
        let phase = 4.0 * PI * sigma / 550.0;
        assert!((share / (phase * phase) - 1.0).abs() < 1e-3 && (share - 1.86e-4).abs() < 2e-6);
        assert!((scattered(20.0, 550.0) - 0.19).abs() < 0.01);
        assert_eq!(scattered(1e6, 550.0), 1.0);
        assert!(terraced(50.0, 550.0) == 1.0 && terraced(0.001, 550.0) < 1e-4);
    }

    #[test]
    fn cusps_are_as_high_as_the_shop_says() {
        let (ball, stepover): (f64, f64) = (3.0, 0.4);
        let exact = ball - (ball * ball - 0.25 * stepover * stepover).sqrt();
        assert!((scallop_height(ball, stepover) - exact).abs() < 1e-15);
        assert!((ripple_slope(1e-3, 2.0) / 1.110_720_734_539_591_6e-3 - 1.0).abs() < 1e-15);
    }
}
