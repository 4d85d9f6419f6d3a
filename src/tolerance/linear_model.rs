//! First derivatives of the displacements by every error, exact.

use super::model::{OpticalSystem, PartPose, PerturbedState, PixelSample};
use super::spec::ToleranceSpec;
use super::work_counts::{WorkCounts, WorkKind};
use crate::num::Dual;
use crate::parallel;
use crate::tolerance_terms::{Misalignment, MisalignmentField};

/// Columns of the misalignment.
const PLACED: usize = MisalignmentField::COUNT;
/// Columns between those of form errors and the map's: the waviness' two and the terraces'.
const TEXTURES: usize = 3;

/// Columns of derivatives: x and y of each sample, px, for each internal unit of an error, in the
/// order misalignment, form errors, waviness' cosine and sine, terraces, map.
#[derive(Debug, Clone)]
pub(super) struct LinearModel {
    columns: Vec<Vec<f64>>,
    forms: usize,
    /// Derivatives by the surface's height and its slopes along X and Y at the hit: x and y of each sample, px.
    by_form: Vec<[[f64; 2]; 3]>,
}

impl LinearModel {
    /// The model of `system`, which has so many form errors; columns that no source and no compensator may
    /// need are there too but for the map's.
    pub(super) fn new(system: &OpticalSystem, spec: &ToleranceSpec, forms: usize) -> Self {
        let count = PLACED + forms + TEXTURES + usize::from(spec.map.is_some());
        let per = 1.0 / system.camera.pixel_mm;
        let of = |sample: &PixelSample| -> (Vec<[f64; 2]>, [[f64; 2]; 3]) {
            let mut work = WorkCounts::default();
            let mut state = PerturbedState::<Dual<PLACED>>::perfect(system.fields.len());
            state.misalignment = Misalignment::from_fn(|field| Dual::variable(0.0, field as usize));
            let pose = PartPose::new(&state.misalignment);
            let [x, y] = system.content(sample, &pose, &state, &mut work);
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

    /// The column of a number of the misalignment.
    #[must_use]
    pub(super) fn misalignment(&self, field: MisalignmentField) -> &[f64] {
        &self.columns[field as usize]
    }

    /// The column of form error `k`, by mm of its amplitude.
    #[must_use]
    pub(super) fn form(&self, k: usize) -> &[f64] {
        &self.columns[PLACED + k]
    }

    /// The columns of the waviness' cosine and sine, by mm of their amplitudes.
    #[must_use]
    pub(super) fn waviness(&self) -> [&[f64]; 2] {
        [0, 1].map(|k| self.form(self.forms + k))
    }

    /// The column of the share of light that terraces reflect.
    #[must_use]
    pub(super) fn terraces(&self) -> &[f64] {
        self.form(self.forms + 2)
    }

    /// The column of the measured form error, if there is one.
    #[must_use]
    pub(super) fn map(&self) -> Option<&[f64]> {
        self.columns.get(PLACED + self.forms + TEXTURES).map(Vec::as_slice)
    }

    /// Derivatives by the surface's height and its slopes along X and Y at each sample's hit: x and y, px.
    #[must_use]
    pub(super) fn by_form(&self) -> &[[[f64; 2]; 3]] {
        &self.by_form
    }

    /// All columns.
    #[must_use]
    pub(super) fn columns(&self) -> &[Vec<f64>] {
        &self.columns
    }

    /// Amplitudes of the columns in a state; one more at the end where there is no map.
    #[must_use]
    pub(super) fn amplitudes(&self, state: &PerturbedState<f64>) -> Vec<f64> {
        let placed = state.misalignment.values().into_iter();
        let wave = state.wave.unwrap_or_default();
        let map = state.map.unwrap_or(0.0);
        let rest = [state.terraced, map];
        placed.chain(state.form.iter().copied()).chain(wave).chain(rest).collect()
    }
}
