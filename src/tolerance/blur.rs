//! Blur by textures within a pixel, and the light that they scatter.
//!
//! The mean of a displacement over a pixel's footprint moves its content; the deviation from that mean
//! blurs it. Heights much smaller than the wavelength turn no rays: they scatter a share of the light,
//! and the rest is reflected as by the smooth mirror.

use super::engine::Engine;
use super::error_source::ErrorSource;
use super::texture::{
    FACET_HEIGHT, FACET_RADIUS, facet_rms, facets_displace, ripple_slope, scattered,
};
use crate::tolerance_terms::{ActsOn, Texture};
use serde::Serialize;

/// Blur and scatter by a texture at its limit, over the picture.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BlurAndScatter {
    /// Blur within a pixel, px: root of the mean square distance from its mean, of the light that is
    /// turned.
    pub blur_px: f64,
    /// Share of the light that its heights scatter.
    pub scattered: f64,
}

/// Blur at one sample by the slopes that the mean over its footprint leaves out.
#[derive(Debug, Clone, Copy, Default)]
struct LocalBlur {
    /// Mean square blur of the turned light, px^2.
    square_px2: f64,
    /// Variance of the heights that have these slopes, mm^2 along Z.
    heights_mm2: f64,
}

impl Engine {
    /// Blur and scatter of `source` at its limit, in the mean of its distribution; none of errors that are
    /// no texture.
    #[must_use]
    pub fn blur_and_scatter(&self, source: &ErrorSource) -> BlurAndScatter {
        let acts_on = source.kind.row().acts_on;
        if !acts_on.is_texture() {
            return BlurAndScatter::default();
        }
        let value = source.limit * source.distribution.mean_square().sqrt();
        let waves = self.slope_waves();
        let count = self.samples();
        let wavelength_mm = 1e-6 * self.spec.texture.wavelength_nm;
        let mut sum = [0.0; 2];
        for k in 0..count {
            let local = match acts_on {
                ActsOn::Texture(Texture::Waviness) => self.waviness_blur(k, value),
                ActsOn::Texture(Texture::Slope) => self.slope_blur(k, &waves, value),
                ActsOn::Texture(Texture::Stepover) => self.stepover_blur(k, value),
                _ => self.facet_blur(k, value),
            };
            let [p, q] = self.system.samples[k].slope;
            let sigma_mm = (local.heights_mm2 / (1.0 + p * p + q * q)).sqrt();
            let share = scattered(sigma_mm, wavelength_mm);
            sum[0] += share * local.square_px2;
            sum[1] += share;
        }
        let [square, share] = sum.map(|sum| sum / count as f64);
        BlurAndScatter { blur_px: square.sqrt(), scattered: share }
    }

    /// Square of the displacement, px^2, by a slope of 1 along `way` at sample `k`.
    fn slope_gain(&self, k: usize, way: [f64; 2]) -> f64 {
        let [_, x, y] = self.linear.by_form()[k];
        [0, 1].map(|i| way[0] * x[i] + way[1] * y[i]).into_iter().map(|d| d * d).sum::<f64>()
    }

    /// Blur by a ripple of wave vector `vector`, 1/mm, and RMS slope `slope`.
    fn ripple_blur(&self, k: usize, vector: [f64; 2], slope: f64) -> LocalBlur {
        let seen = self.system.samples[k].site.footprint.ripple(vector);
        let length = (vector[0] * vector[0] + vector[1] * vector[1]).sqrt();
        let left = slope * slope * (1.0 - seen * seen);
        LocalBlur {
            square_px2: left * self.slope_gain(k, vector.map(|x| x / length)),
            heights_mm2: left / (length * length),
        }
    }

    fn waviness_blur(&self, k: usize, value_um: f64) -> LocalBlur {
        let slope = ripple_slope(1e-3 * value_um, self.spec.texture.waviness_period_mm);
        self.ripple_blur(k, self.system.wave, slope)
    }

    fn slope_blur(&self, k: usize, waves: &[([f64; 2], f64)], value_mrad: f64) -> LocalBlur {
        let all = waves
            .iter()
            .map(|&(vector, share)| self.ripple_blur(k, vector, 1e-3 * value_mrad * share));
        all.fold(LocalBlur::default(), |a, b| LocalBlur {
            square_px2: a.square_px2 + b.square_px2,
            heights_mm2: a.heights_mm2 + b.heights_mm2,
        })
    }

    fn stepover_blur(&self, k: usize, stepover_mm: f64) -> LocalBlur {
        let way = self.system.tool.way;
        let site = &self.system.samples[k].site;
        let left = 1.0 - site.footprint.sawtooth_share(way, stepover_mm);
        let curvature = site.groove * site.groove * left;
        let square = stepover_mm * stepover_mm;
        LocalBlur {
            square_px2: curvature * square / 12.0 * self.slope_gain(k, way),
            // Of a parabola c x^2 / 2 over a period s: c^2 s^4 / 720.
            heights_mm2: curvature * square * square / 720.0,
        }
    }

    fn facet_blur(&self, k: usize, bound_px: f64) -> LocalBlur {
        let [all, mean] = [facet_rms(bound_px), facets_displace(bound_px)];
        let left = (all * all - mean * mean).max(0.0);
        // Both slopes together, and a facet's radius.
        let slope =
            left / (0.5 * (self.slope_gain(k, [1.0, 0.0]) + self.slope_gain(k, [0.0, 1.0])));
        let area = self.system.samples[k].site.footprint.area();
        let radius = FACET_RADIUS * bound_px.abs() * area.sqrt();
        let height = FACET_HEIGHT * radius;
        LocalBlur { square_px2: left, heights_mm2: slope * height * height }
    }
}
