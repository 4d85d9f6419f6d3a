//! From errors, drawn or given, to a perturbed system.

use super::engine::Engine;
use super::error_source::{ErrorSource, misalignment_per_unit};
use super::model::PerturbedState;
use super::perturbed_system::PerturbedSystem;
use super::texture::{facets_displace, terraced};
use crate::num::random::RandomStream;
use crate::num::{cos, sin};
use crate::tolerance_terms::{ActsOn, MisalignmentField, Perturbation, Texture};
use std::f64::consts::{SQRT_2, TAU};

impl Engine {
    /// The system that `values`, each in its source's unit, make; `stream` gives the patterns.
    pub fn make(&self, values: &[(Perturbation, f64)], stream: RandomStream) -> PerturbedSystem {
        let state = PerturbedState::perfect(self.system.fields.len());
        let mut made = PerturbedSystem { state, facets_px: 0.0, stream };
        for &(kind, value) in values {
            self.perturb(&mut made, kind, value);
        }
        made
    }

    /// The same where nothing is drawn: the system that has these errors alone.
    pub fn with_errors(&self, values: &[(Perturbation, f64)]) -> PerturbedSystem {
        self.make(values, RandomStream { seed: 0, trial: 0 })
    }

    /// Adds an error of `value`, in its source's unit, to a system.
    fn perturb(&self, made: &mut PerturbedSystem, kind: Perturbation, value: f64) {
        let PerturbedSystem { state, facets_px, stream } = made;
        let row = kind.row();
        let phase = || stream.pair(row.stream, 1)[0];
        match row.acts_on {
            ActsOn::Mounting(_) | ActsOn::Camera(_) | ActsOn::Size => {
                if let Some((field, unit)) = self.misalignment_per_unit(kind) {
                    *state.misalignment.value_mut(field) += unit * value;
                }
            }
            ActsOn::Form(_) => {
                if let Some(k) = self.forms.iter().position(|form| *form == kind) {
                    state.form[k] += 1e-3 * value;
                }
            }
            ActsOn::Map => state.map = Some(value),
            ActsOn::Texture(Texture::Waviness) => {
                let (a, phase) = (0.5e-3 * value, TAU * phase());
                state.wave = Some([a * cos(phase), -a * sin(phase)]);
            }
            ActsOn::Texture(Texture::Slope) => {
                let slope = 1e-3 * value;
                let first = self.forms.len();
                for (m, pair) in self.modes.chunks(2).enumerate() {
                    let normals = stream.normals(row.stream, 1 + m as u32);
                    for (k, (deviation, normal)) in pair.iter().zip(normals).enumerate() {
                        state.form[first + 2 * m + k] = slope * deviation * normal;
                    }
                }
            }
            ActsOn::Texture(Texture::Stepover) => {
                if value != 0.0 {
                    state.tracks = Some([value.abs(), phase()]);
                }
            }
            ActsOn::Layers => {
                state.terraced = terraced(value, self.spec.texture.wavelength_nm);
            }
            // Evenly over a disc, the mean square is half of its radius'.
            ActsOn::Facets => *facets_px = SQRT_2 * facets_displace(value),
        }
    }

    /// The number of the misalignment that a perturbation changes, and by how much for one of its unit.
    pub(super) fn misalignment_per_unit(
        &self,
        kind: Perturbation,
    ) -> Option<(MisalignmentField, f64)> {
        misalignment_per_unit(kind, self.system.camera.pixel_mm, &self.spec.texture)
    }

    /// The errors of a trial, each in its source's unit.
    #[must_use]
    pub fn draw(&self, sources: &[ErrorSource], stream: &RandomStream) -> Vec<(Perturbation, f64)> {
        sources.iter().map(|source| (source.kind, source.draw(stream))).collect()
    }
}
