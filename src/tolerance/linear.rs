//! First derivatives of the displacements by every error, exact.

use super::engine::{Engine, PerturbedSystem, ToleranceSpec};
use super::error_source::{ErrorSource, Perturbation};
use super::model::{OpticalSystem, PLACED, PartPose, PerturbedState, PixelSample, TextureSite};
use super::spread::{facets_displace, terraced};
use super::work_counts::{WorkCounts, WorkKind};
use crate::num::Dual;
use crate::num::random::RandomStream;
use crate::parallel;

/// Columns between those of form errors and the map's: the waviness' two and the terraces'.
const TEXTURES: usize = 3;

/// Columns of derivatives: x and y of each sample, px, for each internal unit of an error, in the
/// order placing numbers, form errors, waviness' cosine and sine, terraces, map.
#[derive(Debug, Clone)]
pub struct Linear {
    columns: Vec<Vec<f64>>,
    forms: usize,
    /// By the surface's height and its slopes along X and Y at the hit: x and y of each sample.
    by_form: Vec<[[f64; 2]; 3]>,
}

impl Linear {
    /// Of `system`, which has so many form errors; columns that no source and no compensator may
    /// need are there too but for the map's.
    pub(super) fn new(system: &OpticalSystem, spec: &ToleranceSpec, forms: usize) -> Self {
        let count = PLACED + forms + TEXTURES + usize::from(spec.map.is_some());
        let per = 1.0 / system.camera.pixel_mm;
        let of = |sample: &PixelSample| -> (Vec<[f64; 2]>, [[f64; 2]; 3]) {
            let mut work = WorkCounts::default();
            let mut state = system.perfect::<Dual<PLACED>>();
            state.placed = std::array::from_fn(|k| Dual::variable(0.0, k));
            let [x, y] = system.content(sample, &PartPose::new(&state.placed), &state, &mut work);
            let placed = (0..PLACED).map(|k| [x.slope[k] * per, y.slope[k] * per]);
            // What is added to the surface acts through its height and slope at the hit.
            let by = system.by_form(sample, &mut work).map(|by| by.map(|x| x * per));
            let units = system.form_units(sample);
            let done = PLACED + by.len();
            let avoided = units.len().saturating_sub(by.len());
            work.count(WorkKind::Derivatives, [done, avoided]);
            system.counter.add(work);
            let formed = |unit: &[f64; 3]| [0, 1].map(|i| (0..3).map(|k| unit[k] * by[k][i]).sum());
            let (before, map) = units.split_at(forms + 2);
            // Flat terraces have none of the slope.
            let flat = [0.0, -sample.slope[0], -sample.slope[1]];
            let all = before.iter().chain([&flat]).chain(map).map(formed);
            (placed.chain(all).collect(), by)
        };
        let all: Vec<_> = parallel::map_slice(&system.samples, 1, of);
        let column = |k: usize| all.iter().flat_map(|(columns, _)| columns[k]).collect();
        Self {
            columns: (0..count).map(column).collect(),
            forms,
            by_form: all.iter().map(|(_, by)| *by).collect(),
        }
    }

    /// The column of a placing number.
    #[must_use]
    pub fn placed(&self, k: usize) -> &[f64] {
        &self.columns[k]
    }

    /// By the surface's height and its slopes along X and Y at each sample's hit: x and y, px.
    #[must_use]
    pub fn by_form(&self) -> &[[[f64; 2]; 3]] {
        &self.by_form
    }

    /// All columns.
    #[must_use]
    pub fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// Amplitudes of the columns in a state; one more at the end where there is no map.
    #[must_use]
    pub fn amplitudes(&self, state: &PerturbedState<f64>) -> Vec<f64> {
        let placed = state.placed.iter().copied();
        let wave = state.wave.unwrap_or_default();
        let map = state.map.unwrap_or(0.0);
        let rest = [state.terraced, map];
        placed.chain(state.form.iter().copied()).chain(wave).chain(rest).collect()
    }
}

impl Engine {
    /// Displacement of a made system by first derivatives alone.
    #[must_use]
    pub fn linear_displacement(&self, made: &PerturbedSystem) -> Vec<f64> {
        let mut sum = self.base.clone();
        let amplitudes = self.linear.amplitudes(&made.state);
        let acting: Vec<(f64, &[f64])> = amplitudes
            .iter()
            .zip(&self.linear.columns)
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
                let by = self.linear.by_form[k];
                by_tracks = [0, 1].map(|i| (0..3).map(|j| found[j] * by[j][i]).sum());
            }
            out.iter_mut().zip(noise).zip(by_tracks).for_each(|((out, a), b)| *out += a + b);
        }
        sum
    }

    /// What all parts have in common after adjustment, by first derivatives: the displacement without
    /// errors, and those of the systematic sources, which add with their signs. Of x and y of each
    /// sample, px.
    #[must_use]
    pub fn mean_field(&self, sources: &[ErrorSource]) -> Vec<f64> {
        let fixed = sources.iter().filter(|source| source.is_systematic());
        let values: Vec<(Perturbation, f64)> =
            fixed.map(|source| (source.kind, source.limit)).collect();
        // Nothing in it is drawn.
        let made = self.make(&values, RandomStream { seed: 0, trial: 0 });
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
        let square = source.limit * source.limit * source.distribution.mean_square();
        let strength = square.sqrt();
        let Self { linear, .. } = self;
        let count = self.samples() as f64;
        let of = |k: usize| {
            let mut column = linear.columns[k].clone();
            self.compensation.apply(&mut column);
            column.iter().map(|x| x * x).sum::<f64>() / count
        };
        let free = 1.0 - self.adjustments().len() as f64 / (2.0 * count);
        let pixel = self.system.camera.pixel_mm;
        let form = |k: usize| 1e-6 * of(PLACED + k);
        square
            * match source.kind {
                Perturbation::Slope => {
                    let first = self.forms.len();
                    let modes = self.modes.iter().enumerate();
                    modes.map(|(m, a)| a * a * form(first + m)).sum()
                }
                Perturbation::Waviness => 0.125 * (form(linear.forms) + form(linear.forms + 1)),
                Perturbation::Stepover => {
                    let way = self.system.track_way();
                    let by = |k: usize| {
                        let [_, x, y] = linear.by_form[k];
                        let moved = [0, 1].map(|i| way[0] * x[i] + way[1] * y[i]);
                        let TextureSite { groove, footprint } = &self.system.samples[k].site;
                        let seen = groove * groove * footprint.sawtooth_share(way, strength);
                        seen * (moved[0] * moved[0] + moved[1] * moved[1])
                    };
                    let mean = (0..self.samples()).map(by).sum::<f64>() / count;
                    free * mean / 12.0
                }
                Perturbation::Facets => {
                    let moved = facets_displace(strength);
                    return free * moved * moved;
                }
                Perturbation::Layers => {
                    let share = terraced(strength, self.spec.texture.wavelength_nm);
                    return share * share * of(PLACED + linear.forms + 2);
                }
                Perturbation::Map if self.spec.map.is_some() => {
                    of(PLACED + linear.forms + TEXTURES)
                }
                Perturbation::Map => 0.0,
                Perturbation::Legendre(..) | Perturbation::Zernike(_) => {
                    self.forms.iter().position(|form| *form == source.kind).map_or(0.0, form)
                }
                kind => super::engine::placed_by(kind, pixel, &self.spec.texture)
                    .map_or(0.0, |(k, unit)| unit * unit * of(k)),
            }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::design;
    use crate::geom::DVec2;
    use crate::pipeline::load;
    use crate::tolerance::{Criterion, FormMeasure, Process, Reference};

    fn length(field: &[f64]) -> f64 {
        field.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Polynomials stand for the mirror and the form errors: how far that is from the mirror's own
    /// derivatives.
    #[test]
    fn derivatives_of_polynomials_are_the_mirrors_own() {
        let name = "conquistador";
        let design = design(&load(name).unwrap().profile, None).unwrap();
        let view = design.view.as_ref().unwrap();
        let process = Process::ALL[2];
        let source = |kind: Perturbation| {
            let (limit, distribution) = process.usual(kind);
            ErrorSource { kind, limit, distribution, weight: 1.0 }
        };
        let kinds =
            Perturbation::all().filter(|k| !matches!(k, Perturbation::Map | Perturbation::Facets));
        let spec = ToleranceSpec {
            sources: kinds.map(source).collect(),
            form: FormMeasure::Pv,
            texture: process.texture,
            map: None,
            compensators: Vec::new(),
            criterion: Criterion::Rms,
            reference: Reference::Design,
            budget_px: 1.0,
            budget_blur_px: 1.0,
            target_yield: 0.9,
            samples: 40,
        };
        let engine = Engine::new(&design.mirror, &design.camera, view, spec).unwrap();
        assert_eq!(engine.expanded(), engine.samples());
        let mut plain = engine.system.clone();
        for sample in &mut plain.samples {
            (sample.base, sample.form) = (None, Vec::new());
        }
        let forms = engine.forms.len() + engine.modes.len();
        let exact = Linear::new(&plain, &engine.spec, forms);
        // What does nearly nothing is rounding.
        let largest = exact.columns().iter().map(|c| length(c)).fold(0.0, f64::max);
        for (k, (found, exact)) in engine.linear.columns().iter().zip(exact.columns()).enumerate() {
            let off: Vec<f64> = found.iter().zip(exact).map(|(a, b)| a - b).collect();
            let off = length(&off) / length(exact).max(1e-4 * largest);
            assert!(off < 1e-10, "{name} {k}: {off:e}");
        }
        // Displacements of a whole trial.
        let made = engine.trial(&engine.spec.sources, 1, 3);
        let pose = PartPose::new(&made.state.placed);
        for (sample, plain) in engine.system.samples.iter().zip(&plain.samples) {
            let content = |system: &OpticalSystem, sample: &PixelSample| {
                let work = &mut WorkCounts::default();
                DVec2::from_array(system.content(sample, &pose, &made.state, work))
            };
            let off = content(&engine.system, sample) - content(&engine.system, plain);
            let off = off.length() / engine.system.camera.pixel_mm;
            assert!(off < 1e-8, "{name} {off:e}");
        }
    }
}
