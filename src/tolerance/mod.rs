//! How well a system must be made and mounted, which error hurts most, and what share of parts
//! will be good.
//!
//! An [`Engine`] traces samples of the picture through a camera and a mirror with errors, in full,
//! and knows the exact first derivatives of their displacements. Monte Carlo trials are full traces;
//! the linear model serves sensitivities, shares of variance and first guesses of limits, and is held
//! against the full traces.
//!
//! A displacement is of content: where in the picture that belongs which a pixel sees, in the mean over
//! its footprint. What textures spread within it is blur, and heights far below the wavelength scatter.
//!
//! What is not modelled: shadows, and that rays end which errors lead over the rim or the ridge (the
//! surface goes on there).

mod compensate;
mod engine;
mod error_source;
mod footprint;
mod form_field;
mod inverse;
mod linear;
mod local_polynomial;
mod model;
mod plot_data;
mod preset;
mod quadratic_yield_model;
mod replay;
mod sampling;
mod solve_for_target;
mod spread;
mod study;
mod trials;
mod work_counts;
mod yields;

pub use compensate::{Adjustment, Compensator, Criterion, DisplacementPx};
pub use engine::{Engine, PerturbedSystem, Reference, ToleranceSpec, extent};
pub use error_source::{
    Distribution, ErrorSource, Perturbation, TextureShape, ripple_slope, scallop_height,
};
pub use form_field::{FormMeasure, form_of_pv};
pub use inverse::{AllocatedLimits, AllocationError, Sensitivity};
pub use plot_data::{Offender, PlotData, worst_offenders};
pub use preset::{MOUNT, Process};
pub use replay::{Displacement, RigidTransform, Witnessed};
pub use spread::{BlurAndScatter, facets_bound, facets_displace, scattered};
pub use study::{AdjustmentFacts, LinearityGap, SourceFacts, Study};
pub use trials::{Statistics, Trial, quantile};
pub use work_counts::{WorkCounts, WorkKind};
pub use yields::Yield;
