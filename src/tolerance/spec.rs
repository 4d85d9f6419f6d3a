//! Specification of a tolerance study.

use super::error_source::ErrorSource;
use super::texture::TextureShape;
use crate::geom::BicubicSpline;
use crate::tolerance_terms::{Compensator, Criterion, FormMeasure, Reference};

/// Specification of a tolerance study: errors, adjustments, budgets and the yield that is wanted.
#[derive(Debug, Clone)]
pub struct ToleranceSpec {
    /// Errors, each with its limit.
    pub sources: Vec<ErrorSource>,
    /// Measure of the form errors' limits.
    pub form: FormMeasure,
    /// Shapes of the textures.
    pub texture: TextureShape,
    /// A measured form error, over X and Y of the part, mm.
    pub map: Option<BicubicSpline>,
    /// Adjustments of each made system.
    pub compensators: Vec<Compensator>,
    /// Figure that is held against the budget.
    pub criterion: Criterion,
    /// Picture that displacements are measured from.
    pub reference: Reference,
    /// Largest value of the criterion, px.
    pub budget_px: f64,
    /// Largest blur by textures within a pixel, px.
    pub budget_blur_px: f64,
    /// The share of parts that must keep the budget.
    pub target_yield: f64,
    /// About how many pixels stand for the picture.
    pub samples: usize,
}
