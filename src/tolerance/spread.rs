//! What textures spread within a pixel, and what they scatter.
//!
//! The mean of a displacement over a pixel's footprint moves its content; the deviation from that mean
//! blurs it. Heights much smaller than the wavelength turn no rays: they scatter a share of the light,
//! and the rest is reflected as by the smooth mirror.

use super::engine::Engine;
use super::error_source::{ErrorSource, Perturbation, ripple_slope};
use crate::num::exp;
use serde::Serialize;
use std::f64::consts::PI;

/// What a texture at its limit does besides displacing content, over the picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct BlurAndScatter {
    /// Blur within a pixel, px: root of the mean square distance from its mean, of the light that is
    /// turned.
    pub blur_px: f64,
    /// Share of the light that its heights scatter.
    pub scattered: f64,
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
const FACET_RADIUS: f64 = 0.8;
/// Standard deviation of the square of the distance from the middle of an equilateral triangle, as a
/// share of its circumradius' square.
const FACET_HEIGHT: f64 = 0.1935;

/// The bound, px, that so many facets to a pixel just keep.
#[must_use]
pub fn facets_bound(facets_per_pixel: f64) -> f64 {
    // The area of an equilateral triangle is 3 sqrt 3 / 4 of its circumradius' square.
    let radius = (1.0 / (0.75 * 3f64.sqrt() * facets_per_pixel)).sqrt();
    radius / FACET_RADIUS
}

/// RMS displacement by facets that just keep a bound of `limit` px.
fn facet_rms(limit: f64) -> f64 {
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

/// At one place: mean square blur of the turned light, px^2, and the variance of the heights that do it,
/// mm^2 along Z, for the variance of slope that the mean over the footprint leaves out.
type Local = (f64, f64);

impl Engine {
    /// What `source` spreads at its limit, in the mean of its distribution.
    #[must_use]
    pub fn spread(&self, source: &ErrorSource) -> BlurAndScatter {
        let value = source.limit * source.distribution.mean_square().sqrt();
        let Some(local) = self.local(source.kind, value) else { return BlurAndScatter::default() };
        let count = self.samples();
        let wavelength_mm = 1e-6 * self.spec.texture.wavelength_nm;
        let mut sum = [0.0; 2];
        for k in 0..count {
            let (blur, heights) = local(k);
            let [p, q] = self.system.samples[k].slope;
            let share = scattered((heights / (1.0 + p * p + q * q)).sqrt(), wavelength_mm);
            sum[0] += share * blur;
            sum[1] += share;
        }
        let [square, share] = sum.map(|sum| sum / count as f64);
        BlurAndScatter { blur_px: square.sqrt(), scattered: share }
    }

    /// What a texture of strength `value` spreads at each sample; none of other errors.
    fn local(&self, kind: Perturbation, value: f64) -> Option<Box<dyn Fn(usize) -> Local + '_>> {
        let texture = &self.spec.texture;
        let samples = &self.system.samples;
        // Square of what a slope of 1 along a direction displaces, px^2.
        let by = |k: usize, way: [f64; 2]| {
            let [_, x, y] = self.linear.by_form()[k];
            [0, 1].map(|i| way[0] * x[i] + way[1] * y[i]).into_iter().map(|d| d * d).sum::<f64>()
        };
        // A wave of some RMS slope.
        let wave = move |k: usize, vector: [f64; 2], slope: f64| -> Local {
            let seen = samples[k].site.footprint.ripple(vector);
            let length = (vector[0] * vector[0] + vector[1] * vector[1]).sqrt();
            let left = slope * slope * (1.0 - seen * seen);
            (left * by(k, vector.map(|x| x / length)), left / (length * length))
        };
        Some(match kind {
            Perturbation::Waviness => {
                let slope = ripple_slope(1e-3 * value, texture.waviness_period_mm);
                Box::new(move |k| wave(k, self.system.wave(), slope))
            }
            Perturbation::Slope => {
                let waves = self.waves();
                Box::new(move |k| {
                    let all =
                        waves.iter().map(|&(vector, share)| wave(k, vector, 1e-3 * value * share));
                    all.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1))
                })
            }
            Perturbation::Stepover => {
                let way = self.system.track_way();
                Box::new(move |k| {
                    let site = &samples[k].site;
                    let left = 1.0 - site.footprint.sawtooth_share(way, value);
                    let curvature = site.groove * site.groove * left;
                    let square = value * value;
                    // Of a parabola c x^2 / 2 over a period s: c^2 s^4 / 720.
                    (curvature * square / 12.0 * by(k, way), curvature * square * square / 720.0)
                })
            }
            Perturbation::Facets => {
                let [all, mean] = [facet_rms(value), facets_displace(value)];
                Box::new(move |k| {
                    let left = (all * all - mean * mean).max(0.0);
                    // Both slopes together, and a facet's radius.
                    let slope = left / (0.5 * (by(k, [1.0, 0.0]) + by(k, [0.0, 1.0])));
                    let area = samples[k].site.footprint.area();
                    let radius = FACET_RADIUS * value.abs() * area.sqrt();
                    let height = FACET_HEIGHT * radius;
                    (left, slope * height * height)
                })
            }
            _ => return None,
        })
    }
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
}
