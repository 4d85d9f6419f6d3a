//! What is asked of `morion tolerance`.

/// The profile's words on errors; what is absent is as usual for the preset.
#[derive(Clone, Debug, PartialEq)]
pub struct Tolerance {
    /// How the part is made: one of [`PRESETS`].
    pub preset: &'static str,
    /// The most that the criterion may be, in pixels.
    pub budget_px: f64,
    /// The most that textures may blur within a pixel, in pixels; [`Self::budget_px`] where the profile does
    /// not say.
    pub budget_blur_px: Option<f64>,
    /// What the shop makes the part from, the mesh or the STEP; what is exported first where the profile
    /// does not say: one of [`MADE_FROM`].
    pub made_from: Option<&'static str>,
    /// What is held against it: one of [`CRITERIA`].
    pub criterion: &'static str,
    /// What displacements are measured from: one of [`REFERENCES`].
    pub reference: &'static str,
    /// What the limits of form errors are: one of [`FORMS`].
    pub form: &'static str,
    /// The share of parts that must keep the budget, inside 0 to 1.
    pub target_yield: f64,
    /// What is adjusted: some of [`COMPENSATORS`].
    pub compensators: Vec<&'static str>,
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
    /// Limits of error sources by their keys; 0 for none, negative ones of fixed errors alone.
    pub limits: Vec<(&'static str, f64)>,
    /// Their distributions: each one of [`DISTRIBUTIONS`].
    pub distributions: Vec<(&'static str, &'static str)>,
    /// Their weights when a budget is allotted.
    pub weights: Vec<(&'static str, f64)>,
}

/// Ways of making; the first is taken where none is named.
pub const PRESETS: [&str; 6] =
    ["precision-cnc", "spdt", "ultra-precision-cnc", "standard-cnc", "polished", "sla-print"];
/// Figures that can be held against the budget.
pub const CRITERIA: [&str; 2] = ["rms", "p95"];
/// What a part can be made from.
pub const MADE_FROM: [&str; 2] = ["mesh", "step"];
/// What the size of a form error can be.
pub const FORMS: [&str; 2] = ["pv", "rms"];
/// What displacements can be measured from.
pub const REFERENCES: [&str; 2] = ["design", "projection"];
/// What can be adjusted.
pub const COMPENSATORS: [&str; 5] = ["shift", "rotation", "magnification", "tilt", "despace"];
/// How likely errors can be.
pub const DISTRIBUTIONS: [&str; 4] = ["uniform", "normal", "truncated", "fixed"];

impl Default for Tolerance {
    fn default() -> Self {
        Self {
            preset: PRESETS[0],
            budget_px: 1.0,
            budget_blur_px: None,
            made_from: None,
            criterion: CRITERIA[0],
            reference: REFERENCES[0],
            form: FORMS[0],
            target_yield: 0.95,
            compensators: COMPENSATORS[..3].to_vec(),
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
