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
mod crossing;
mod engine;
mod field;
mod footprint;
mod inverse;
mod linear;
mod local;
mod model;
mod plots;
mod preset;
mod replay;
mod samples;
mod source;
mod spread;
mod study;
mod tally;
mod trials;
mod yardstick;
mod yields;

pub use compensate::{Adjustment, Compensator, Criterion, Pixels};
pub use engine::{Engine, Made, Question, Reference, extent};
pub use field::{Measure, form_of_pv};
pub use inverse::{Impact, Joint, Unmet};
pub use plots::{Offender, Points, worst_offenders};
pub use preset::{MOUNT, Process};
pub use replay::{Judged, Placing, Witnessed};
pub use source::{Distribution, Kind, Source, Texture, ripple_slope, scallop_height};
pub use spread::{Spread, facets_bound, facets_displace, scattered};
pub use study::{AdjustmentFacts, Gap, SourceFacts, Study};
pub use tally::{Piece, Tally};
pub use trials::{Statistics, Trial, quantile};
pub use yields::Yield;
