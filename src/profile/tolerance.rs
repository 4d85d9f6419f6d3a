//! The table `[tolerance]` of a profile.

use crate::tolerance_terms::{
    Compensator, Criterion, Distribution, FormMeasure, MadeFrom, Perturbation, ProcessPreset,
    Reference,
};

/// The profile's words on errors; what is absent is as usual for the preset.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerance {
    /// Way of making the part.
    pub preset: ProcessPreset,
    /// The most that the criterion may be, in pixels.
    pub budget_px: f64,
    /// The most that textures may blur within a pixel, in pixels; [`Self::budget_px`] where the profile does
    /// not say.
    pub budget_blur_px: Option<f64>,
    /// File that the shop makes the part from; what is exported first where the profile does not say.
    pub made_from: Option<MadeFrom>,
    /// Figure that is held against it.
    pub criterion: Criterion,
    /// Picture that displacements are measured from.
    pub reference: Reference,
    /// Measure of the form errors' limits.
    pub form: FormMeasure,
    /// The share of parts that must keep the budget, inside 0 to 1.
    pub target_yield: f64,
    /// Adjustments of each made system.
    pub compensators: Vec<Compensator>,
    /// Thermal expansion, 1e-6 / K.
    pub expansion_ppm_per_k: Option<f64>,
    /// Period of the waviness, in millimetres.
    pub waviness_period_mm: Option<f64>,
    /// Direction in which waves follow each other, from X towards Y, in degrees.
    pub waviness_direction_deg: Option<f64>,
    /// Correlation length of the random slope, in millimetres.
    pub slope_correlation_mm: Option<f64>,
    /// Radius of the ball cutter, in millimetres.
    pub ball_radius_mm: Option<f64>,
    /// Direction in which its tracks follow each other, from X towards Y, in degrees.
    pub stepover_direction_deg: Option<f64>,
    /// A file of measured form errors: lines of X, Y and departure along Z in millimetres.
    pub map_file: Option<String>,
    /// Limits of error sources, in their units; 0 for none, negative ones of fixed errors alone.
    pub limits: Vec<(Perturbation, f64)>,
    /// Distributions of error sources.
    pub distributions: Vec<(Perturbation, Distribution)>,
    /// Weights of error sources when a budget is allotted.
    pub weights: Vec<(Perturbation, f64)>,
}

impl Tolerance {
    /// The limit of an error source, in its unit; none where the profile does not say.
    #[must_use]
    pub fn limit(&self, of: Perturbation) -> Option<f64> {
        value(&self.limits, of)
    }

    /// The distribution of an error source; none where the profile does not say.
    #[must_use]
    pub fn distribution(&self, of: Perturbation) -> Option<Distribution> {
        value(&self.distributions, of)
    }

    /// The weight of an error source; none where the profile does not say.
    #[must_use]
    pub fn weight(&self, of: Perturbation) -> Option<f64> {
        value(&self.weights, of)
    }
}

fn value<T: Copy>(table: &[(Perturbation, T)], of: Perturbation) -> Option<T> {
    table.iter().find(|(source, _)| *source == of).map(|(_, value)| *value)
}

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            preset: ProcessPreset::PrecisionCnc,
            budget_px: 1.0,
            budget_blur_px: None,
            made_from: None,
            criterion: Criterion::Rms,
            reference: Reference::Design,
            form: FormMeasure::Pv,
            target_yield: 0.95,
            compensators: vec![
                Compensator::Shift,
                Compensator::Rotation,
                Compensator::Magnification,
            ],
            expansion_ppm_per_k: None,
            waviness_period_mm: None,
            waviness_direction_deg: None,
            slope_correlation_mm: None,
            ball_radius_mm: None,
            stepover_direction_deg: None,
            map_file: None,
            limits: Vec::new(),
            distributions: Vec::new(),
            weights: Vec::new(),
        }
    }
}
