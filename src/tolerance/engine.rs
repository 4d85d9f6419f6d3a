//! A designed system prepared for trials, and adjustment of their displacements.

use super::compensate::{Adjustment, Compensation, DisplacementPx};
use super::error_source::ErrorSource;
use super::extent::{extent, reach};
use super::form_field::{FormField, slope_modes};
use super::linear_model::LinearModel;
use super::model::{OpticalSystem, PixelSample};
use super::spec::ToleranceSpec;
use super::work_counts::WorkCounts;
use crate::geom::DVec2;
use crate::mirror::Mirror;
use crate::optics::{Camera, ImagingTask};
use crate::tolerance_terms::{Compensator, MisalignmentField, Perturbation, Reference};

/// A designed system prepared for trials: its samples, error sources, adjustments and derivatives.
#[derive(Debug, Clone)]
pub struct Engine {
    /// Specification of the study.
    pub spec: ToleranceSpec,
    pub(super) system: OpticalSystem,
    /// Standard deviations of the random slope's waves, whose amplitudes come after the other form
    /// errors'.
    pub(super) modes: Vec<f64>,
    pub(super) forms: Vec<Perturbation>,
    pub(super) linear: LinearModel,
    pub(super) compensation: Compensation,
    /// Displacement without errors: zero against the design.
    pub(super) base: Vec<f64>,
}

impl Engine {
    /// Prepares `spec` for a mirror under a camera that shows a view; none where no pixel sees
    /// the target in it.
    #[must_use]
    pub fn new(
        mirror: &Mirror,
        camera: &Camera,
        view: &ImagingTask,
        spec: ToleranceSpec,
    ) -> Option<Self> {
        let (centre, half) = extent(mirror);
        let size = 2.0 * half[0].max(half[1]);
        let (mut forms, mut fields) = (Vec::new(), Vec::new());
        for source in &spec.sources {
            if let Some(term) = source.kind.form_term() {
                forms.push(source.kind);
                fields.push(FormField::of_term(term, (centre, half), spec.form));
            }
        }
        let slope = spec.sources.iter().any(|source| source.kind == Perturbation::Slope);
        let length = spec.texture.slope_correlation_mm;
        let waves = if slope { slope_modes(length, size) } else { Vec::new() };
        let (waves, modes): (Vec<FormField>, Vec<f64>) = waves.into_iter().unzip();
        fields.extend(waves);
        let texture = spec.texture;
        let reach = reach(&spec.sources, &spec.texture, camera, size);
        let map = spec.map.clone();
        let parts = (mirror, camera, view);
        let system = OpticalSystem::new(parts, fields, &texture, map, spec.samples, reach);
        let pixel = camera.pixel_mm;
        let base = match spec.reference {
            Reference::Design => vec![0.0; 2 * system.samples.len()],
            Reference::Projection => {
                let off = system.samples.iter().map(|s| (s.content - s.point) / pixel);
                off.flat_map(|d: DVec2| d.to_array()).collect()
            }
        };
        let linear = LinearModel::new(&system, &spec, forms.len() + modes.len());
        let compensation = compensation(&system, &linear, &spec.compensators);
        let seen = !system.samples.is_empty();
        let made = Self { spec, system, modes, forms, linear, compensation, base };
        seen.then_some(made)
    }

    /// The engine prepared for errors of these limits: polynomials hold where hits then go. None where
    /// that gains nothing.
    pub(super) fn widened(&self, sources: &[ErrorSource]) -> Option<Self> {
        let (_, half) = extent(&self.system.mirror);
        let size = 2.0 * half[0].max(half[1]);
        let reach = reach(sources, &self.spec.texture, &self.system.camera, size);
        let system = self.system.widened(reach)?;
        Some(Self {
            spec: self.spec.clone(),
            system,
            modes: self.modes.clone(),
            forms: self.forms.clone(),
            linear: self.linear.clone(),
            compensation: self.compensation.clone(),
            base: self.base.clone(),
        })
    }

    /// Wave vectors, 1/mm, of the random slope, and each one's share of its RMS.
    pub(super) fn slope_waves(&self) -> Vec<([f64; 2], f64)> {
        let fields = self.system.fields[self.forms.len()..].iter().zip(&self.modes);
        let of = |(field, deviation): (&FormField, &f64)| match field {
            FormField::Cosine(k) => {
                let length = (k[0] * k[0] + k[1] * k[1]).sqrt();
                Some((*k, deviation * length))
            }
            _ => None,
        };
        fields.filter_map(of).collect()
    }

    /// The engine with samples that see points of textures, as single rays do.
    #[must_use]
    pub fn pointwise(&self) -> Self {
        Self { system: self.system.pointwise(), ..self.clone() }
    }

    /// Number of pixels that stand for the picture.
    #[must_use]
    pub fn samples(&self) -> usize {
        self.system.samples.len()
    }

    /// Share of the picture of the mirror that the samples stand for: where they see the target.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.system.share
    }

    /// Numbers that differ between systems: what each sample sees as designed, and units of the form
    /// errors and the measured one there.
    #[must_use]
    pub fn marks(&self) -> Vec<f64> {
        let of = |sample: &PixelSample| {
            let units = self.system.form_units(sample).into_iter().flatten();
            sample.content.to_array().into_iter().chain(units).collect::<Vec<f64>>()
        };
        self.system.samples.iter().flat_map(of).collect()
    }

    /// Number of them near whose hits polynomials stand for the mirror: trials do not evaluate the
    /// mirror itself there.
    #[must_use]
    pub fn expanded(&self) -> usize {
        self.system.expanded()
    }

    /// The work of this engine, and of those made of it, since it was last asked for.
    #[must_use]
    pub fn worked(&self) -> WorkCounts {
        self.system.counter.take()
    }

    /// Image points of these pixels, and where the content belongs that they see as designed, mm.
    pub fn places(&self) -> impl Iterator<Item = (DVec2, DVec2)> {
        self.system.samples.iter().map(|sample| (sample.point, sample.content))
    }

    /// Displacement of the designed picture against the projection.
    #[must_use]
    pub fn nominal(&self) -> DisplacementPx {
        let pixel = self.system.camera.pixel_mm;
        let off = self.system.samples.iter().map(|s| (s.content - s.point) / pixel);
        DisplacementPx::of(&off.flat_map(|d: DVec2| d.to_array()).collect::<Vec<f64>>())
    }

    /// Adjustments that are made.
    #[must_use]
    pub fn adjustments(&self) -> &[Adjustment] {
        self.compensation.adjustments()
    }

    /// Figures before and after adjustment, and how far each adjustment was moved: none is where rays
    /// are lost.
    #[must_use]
    pub fn compensate(
        &self,
        mut displacement: Vec<f64>,
    ) -> (DisplacementPx, DisplacementPx, Vec<f64>) {
        let before = DisplacementPx::of(&displacement);
        if !before.kept() {
            return (DisplacementPx::LOST, DisplacementPx::LOST, Vec::new());
        }
        let steps = self.compensation.apply(&mut displacement);
        let after = if steps.is_empty() { before } else { DisplacementPx::of(&displacement) };
        (before, after, steps)
    }
}

fn compensation(
    system: &OpticalSystem,
    linear: &LinearModel,
    asked: &[Compensator],
) -> Compensation {
    Compensation::new(adjustments(system, linear, asked))
}

/// The adjustments that are asked for, also those that others can do as well.
pub(super) fn adjustments(
    system: &OpticalSystem,
    linear: &LinearModel,
    asked: &[Compensator],
) -> Vec<Adjustment> {
    let pixel = system.camera.pixel_mm;
    let column = |of: &dyn Fn(DVec2) -> [f64; 2]| -> Vec<f64> {
        system.samples.iter().flat_map(|s| of(s.point / pixel)).collect()
    };
    let placed = |field| linear.misalignment(field).to_vec();
    let mut all = Vec::new();
    let mut add = |name, unit, per_step, column| {
        all.push(Adjustment { name, unit, per_step, column });
    };
    for compensator in asked {
        match compensator {
            Compensator::Shift => {
                add("shift x", "px", 1.0, column(&|_| [1.0, 0.0]));
                add("shift y", "px", 1.0, column(&|_| [0.0, 1.0]));
            }
            Compensator::Rotation => add("rotation", "mrad", 1e3, column(&|q| [-q.y, q.x])),
            Compensator::Magnification => {
                add("magnification", "ppm", 1e6, column(&|q| q.to_array()));
            }
            Compensator::Tilt => {
                add("tilt x", "mrad", 1e3, placed(MisalignmentField::TiltX));
                add("tilt y", "mrad", 1e3, placed(MisalignmentField::TiltY));
            }
            Compensator::Despace => add("despace", "um", 1e3, placed(MisalignmentField::ShiftZ)),
        }
    }
    all
}
