//! Tolerancing: sensitivities of the picture to errors of making and mounting, the yield, and limits for a
//! budget.
//!
//! An [`Engine`] traces samples of the picture through a camera and a mirror with errors, in full,
//! and knows the exact first derivatives of their displacements. Monte Carlo trials are full traces;
//! the linear model serves sensitivities, shares of variance and first guesses of limits, and is held
//! against the full traces.
//!
//! A displacement is of content: where in the picture that belongs which a pixel sees, in the mean over
//! its footprint. What textures spread within it is blur, and heights far below the wavelength scatter.
//!
//! Shadows are not modelled, nor the end of rays that errors lead over the rim or the ridge: the surface
//! goes on there.

mod allocation;
mod asked;
mod blur;
mod compensate;
mod engine;
mod error_source;
mod extent;
mod footprint;
mod form_field;
mod form_limit;
mod full_trace;
mod line_of_sight;
mod linear_model;
mod linear_prediction;
mod local_polynomial;
mod low_form_terms;
mod model;
mod perturb;
mod perturbed_system;
mod plot_data;
mod preset;
mod quadratic_yield_model;
mod replay;
mod sampling;
mod sensitivity;
mod sight_lines;
mod slope_limit;
mod solve_for_target;
mod spec;
mod study;
mod texture;
mod trial_table;
mod trials;
mod work_counts;
mod yields;

pub use crate::tolerance_terms::{
    ActsOn, Compensator, Criterion, Distribution, ErrorSourceRow, FormMeasure, FormTerm,
    Perturbation, ProcessPreset, Reference,
};
pub use allocation::{AllocatedLimits, AllocationError};
pub use asked::TracksError;
pub use blur::BlurAndScatter;
pub use compensate::{Adjustment, DisplacementPx};
pub use engine::Engine;
pub use error_source::ErrorSource;
pub use extent::extent;
pub use form_field::form_of_pv;
pub use form_limit::FormLimit;
pub use low_form_terms::LowFormTerms;
pub use perturbed_system::PerturbedSystem;
pub use plot_data::{Offender, PlotData, worst_offenders};
pub use preset::Process;
pub use replay::{Displacement, RigidTransform, Witnessed};
pub use sensitivity::Sensitivity;
pub use sight_lines::{CovariancePx, SightLines};
pub use spec::ToleranceSpec;
pub use study::{AdjustmentFacts, LinearityGap, SourceFacts, Study};
pub use texture::{
    TextureShape, facets_bound, facets_displace, ripple_slope, scallop_height, scattered,
};
pub use trial_table::{read_trial, trial_columns, trial_line};
pub use trials::{Statistics, Trial, quantile};
pub use work_counts::{WorkCounts, WorkKind};
pub use yields::Yield;
