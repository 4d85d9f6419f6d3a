//! Inspection of a made part by a coordinate measuring machine (CMM): where to touch it, and what its points say of the
//! mirror's form.

mod dmis;
mod form_fit;
mod plan;

pub use dmis::write_dmis;
pub use form_fit::{FittedTerm, FormFit, fit_form};
pub use plan::{InspectionPlan, MOST_DEGREE, PlannedPoint, least_margin_mm, plan_points, rims};
