//! Displacements and their variances by first derivatives.

use super::engine::Engine;
use super::error_source::ErrorSource;
use super::linear_model::LinearModel;
use super::model::{OpticalSystem, TextureSite};
use super::perturbed_system::PerturbedSystem;
use super::texture::{facets_displace, terraced};
use crate::tolerance_terms::{ActsOn, Perturbation, Texture};

impl Engine {
    /// Displacement of a made system by first derivatives alone.
    #[must_use]
    pub fn linear_displacement(&self, made: &PerturbedSystem) -> Vec<f64> {
        let mut sum = self.base.clone();
        let amplitudes = self.linear.amplitudes(&made.state);
        let acting: Vec<(f64, &[f64])> = amplitudes
            .iter()
            .zip(self.linear.columns())
            .filter(|(a, _)| **a != 0.0)
            .map(|(a, column)| (*a, column.as_slice()))
            .collect();
        // Four at a time: the sum is fetched less often.
        let fours = acting.chunks_exact(4);
        for &(a, column) in fours.remainder() {
            sum.iter_mut().zip(column).for_each(|(sum, c)| *sum += a * c);
        }
        for four in fours {
            let columns = four[0].1.iter().zip(four[1].1).zip(four[2].1.iter().zip(four[3].1));
            for (sum, ((p, q), (r, s))) in sum.iter_mut().zip(columns) {
                *sum += (four[0].0 * p + four[1].0 * q) + (four[2].0 * r + four[3].0 * s);
            }
        }
        for (k, out) in sum.chunks_exact_mut(2).enumerate() {
            let noise = made.noise(k);
            let mut by_tracks = [0.0; 2];
            if let Some(tracks) = made.state.tracks {
                let found = self.system.tracks_at(k, tracks);
                let by = self.linear.by_form()[k];
                by_tracks = [0, 1].map(|i| (0..3).map(|j| found[j] * by[j][i]).sum());
            }
            out.iter_mut().zip(noise).zip(by_tracks).for_each(|((out, a), b)| *out += a + b);
        }
        sum
    }

    /// Displacement that all parts have in common after adjustment, by first derivatives: that without
    /// errors, and those of the systematic sources, which add with their signs; x and y of each
    /// sample, px.
    #[must_use]
    pub fn mean_field(&self, sources: &[ErrorSource]) -> Vec<f64> {
        let fixed = sources.iter().filter(|source| source.is_systematic());
        let values: Vec<(Perturbation, f64)> =
            fixed.map(|source| (source.kind, source.limit)).collect();
        let made = self.with_errors(&values);
        let mut field = self.linear_displacement(&made);
        self.compensation.apply(&mut field);
        field
    }

    /// Variance of the displacement, px^2, that a source causes after adjustment: the mean square of
    /// a random one; none of a systematic one, which is part of the [`Engine::mean_field`].
    #[must_use]
    pub fn variance(&self, source: &ErrorSource) -> f64 {
        if source.is_systematic() { 0.0 } else { self.mean_square(source) }
    }

    /// Mean square of the displacement, px^2, that a source alone causes after adjustment, by first
    /// derivatives and its distribution. Patterns finer than the distance of samples count as
    /// independent from sample to sample.
    #[must_use]
    pub fn mean_square(&self, source: &ErrorSource) -> f64 {
        let square = source.mean_square();
        let alike = self.common_columns(&self.linear, source);
        let alike: f64 =
            alike.into_iter().map(|([a, b], column)| a * (b * self.adjusted_square(column))).sum();
        match source.kind.row().acts_on {
            ActsOn::Texture(Texture::Stepover) => square * self.stepover_square(square.sqrt()),
            ActsOn::Layers => alike,
            ActsOn::Facets => {
                let moved = facets_displace(square.sqrt());
                self.unadjusted_share() * moved * moved
            }
            _ => square * alike,
        }
    }

    /// Columns of `linear` in which the samples move together by a random source, each with two factors of its mean square for one of the
    /// source's unit; of layers for their own height. None of tracks and facets, by which each moves on its own.
    pub(super) fn common_columns<'m>(
        &self,
        linear: &'m LinearModel,
        source: &ErrorSource,
    ) -> Vec<([f64; 2], &'m [f64])> {
        /// Of amplitudes in micrometres.
        const FORM: f64 = 1e-6;
        match source.kind.row().acts_on {
            ActsOn::Mounting(_) | ActsOn::Camera(_) | ActsOn::Size => {
                let placed = self.misalignment_per_unit(source.kind).into_iter();
                placed.map(|(k, unit)| ([1.0, unit * unit], linear.misalignment(k))).collect()
            }
            ActsOn::Form(_) => {
                let form = self.forms.iter().position(|form| *form == source.kind).into_iter();
                form.map(|k| ([1.0, FORM], linear.form(k))).collect()
            }
            ActsOn::Map => linear.map().into_iter().map(|map| ([1.0; 2], map)).collect(),
            ActsOn::Texture(Texture::Waviness) => {
                linear.waviness().map(|wave| ([0.125, FORM], wave)).into()
            }
            ActsOn::Texture(Texture::Slope) => {
                let first = self.forms.len();
                let modes = self.modes.iter().enumerate();
                modes.map(|(m, a)| ([a * a, FORM], linear.form(first + m))).collect()
            }
            ActsOn::Layers => {
                let height_um = source.mean_square().sqrt();
                let share = terraced(height_um, self.spec.texture.wavelength_nm);
                vec![([share * share, 1.0], linear.terraces())]
            }
            ActsOn::Texture(Texture::Stepover) | ActsOn::Facets => Vec::new(),
        }
    }

    /// Mean square, px^2, of a column of derivatives after adjustment.
    fn adjusted_square(&self, column: &[f64]) -> f64 {
        let mut column = column.to_vec();
        self.compensation.apply(&mut column);
        column.iter().map(|x| x * x).sum::<f64>() / self.samples() as f64
    }

    /// Share of a displacement that is independent from sample to sample which adjustments leave.
    pub(super) fn unadjusted_share(&self) -> f64 {
        1.0 - self.adjustments().len() as f64 / (2.0 * self.samples() as f64)
    }

    /// Mean square of the displacement, px^2, by tool tracks `stepover_mm` apart, by the square of that.
    fn stepover_square(&self, stepover_mm: f64) -> f64 {
        let by = |k: usize| {
            let (seen, moved) = moved_by_tracks(&self.system, &self.linear, k, stepover_mm);
            seen * (moved[0] * moved[0] + moved[1] * moved[1])
        };
        let mean = (0..self.samples()).map(by).sum::<f64>() / self.samples() as f64;
        self.unadjusted_share() * mean / 12.0
    }
}

/// Displacement of sample `k`, px, by a slope of 1 across tool tracks, and twelve times the mean square of the slope that tracks
/// `stepover_mm` apart have in its footprint, for a stepover of one millimetre.
pub(super) fn moved_by_tracks(
    system: &OpticalSystem,
    linear: &LinearModel,
    k: usize,
    stepover_mm: f64,
) -> (f64, [f64; 2]) {
    let way = system.tool.way;
    let [_, x, y] = linear.by_form()[k];
    let moved = [0, 1].map(|i| way[0] * x[i] + way[1] * y[i]);
    let TextureSite { groove, footprint } = &system.samples[k].site;
    (groove * groove * footprint.sawtooth_share(way, stepover_mm), moved)
}

#[cfg(test)]
mod tests {
    use crate::geom::DVec2;
    use crate::num::max_or_nan;
    use crate::tolerance::full_trace::tests::engine;
    use crate::tolerance::linear_model::LinearModel;
    use crate::tolerance::model::{OpticalSystem, PartPose, PixelSample};
    use crate::tolerance::work_counts::WorkCounts;

    fn length(field: &[f64]) -> f64 {
        field.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Largest relative difference of columns, and largest difference of displacements in a trial, px, with
    /// polynomials for the mirror and the form errors from those of the mirror's own derivatives.
    /// Columns shorter than the share `floor` of the longest are rounding.
    fn polynomials_against_the_mirror(name: &str, floor: f64) -> [f64; 2] {
        let engine = engine(name);
        assert_eq!(engine.expanded(), engine.samples(), "{name}");
        let mut plain = engine.system.clone();
        for sample in &mut plain.samples {
            sample.base = None;
        }
        let forms = engine.forms.len() + engine.modes.len();
        let exact = LinearModel::new(&plain, &engine.spec, forms);
        let largest = exact.columns().iter().map(|c| length(c)).fold(0.0, f64::max);
        let pairs = engine.linear.columns().iter().zip(exact.columns());
        let columns = pairs.map(|(found, exact)| {
            let off: Vec<f64> = found.iter().zip(exact).map(|(a, b)| a - b).collect();
            length(&off) / length(exact).max(floor * largest)
        });
        let made = engine.trial(&engine.spec.sources, 1, 3);
        let pose = PartPose::new(&made.state.misalignment);
        let pairs = engine.system.samples.iter().zip(&plain.samples);
        let displacements = pairs.map(|(sample, plain)| {
            let content = |system: &OpticalSystem, sample: &PixelSample| {
                let work = &mut WorkCounts::default();
                DVec2::from_array(system.content(sample, &pose, &made.state, work))
            };
            let off = content(&engine.system, sample) - content(&engine.system, plain);
            off.length() / engine.system.camera.pixel_mm
        });
        [columns.fold(0.0, max_or_nan), displacements.fold(0.0, max_or_nan)]
    }

    /// Under a pinhole too, where the mirror's second derivatives over X and Y are those of its chart.
    #[test]
    fn derivatives_of_polynomials_are_the_mirrors_own() {
        // What is symmetric about the axis does not feel being turned.
        let cases = [
            ("conquistador", 1e-4, 1e-10),
            ("hyperbolic", 1e-3, 1e-9),
            ("phone", 1e-3, 1e-9),
            ("conical", 1e-3, 1e-9),
        ];
        for (name, floor, most) in cases {
            let [columns, displacements] = polynomials_against_the_mirror(name, floor);
            assert!(columns < most, "{name}: {columns:e}");
            assert!(displacements < 1e-8, "{name}: {displacements:e}");
        }
    }
}
