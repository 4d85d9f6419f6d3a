//! Pixels that stand for the picture.

use super::super::footprint::Footprint;
use super::super::line_of_sight::LineOfSight;
use super::super::local_polynomial::ExpansionSquare;
use crate::geom::{DVec2, DVec3};

/// Place of the mirror that a pixel sees, as far as textures depend on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TextureSite {
    /// Curvature that the tool's tracks have there, 1/mm.
    pub groove: f64,
    /// The pixel's footprint: it sees the mean of a texture over this.
    pub footprint: Footprint,
}

/// Pixel that sees the mirror, and the mirror there.
#[derive(Debug, Clone)]
pub(crate) struct PixelSample {
    /// Its image point, mm from the axis.
    pub point: DVec2,
    /// Its ray.
    pub sight: LineOfSight,
    /// The image point where the content that it sees belongs, of the system as designed.
    pub content: DVec2,
    /// Number of the panel that it sees.
    pub panel: usize,
    /// Where it sees the designed mirror, mm.
    pub hit: DVec3,
    /// Slope (Z_X, Z_Y) of the designed mirror there.
    pub slope: [f64; 2],
    /// The square about the hit on which the polynomials hold.
    pub square: ExpansionSquare,
    /// The same place, for textures.
    pub site: TextureSite,
    /// Height and slopes of the designed surface: degree and coefficients of polynomials, where
    /// these are it to rounding. (Derivatives of the height's would have its rounding magnified.)
    pub base: Option<(usize, Vec<[f64; 3]>)>,
    /// Shares of the form errors' waves and of the waviness that the pixel sees, in their order.
    pub seen: Vec<f64>,
}
