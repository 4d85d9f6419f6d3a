//! Error sources of a study: what can be off, by how much and how likely.

use super::texture::TextureShape;
use crate::num::random::RandomStream;
use crate::tolerance_terms::{Distribution, LimitUnit, MisalignmentField, Perturbation};

/// A perturbation with its limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorSource {
    /// Quantity that is off.
    pub kind: Perturbation,
    /// Limit, in the unit of the perturbation; negative only of a systematic error.
    pub limit: f64,
    /// Distribution about zero.
    pub distribution: Distribution,
    /// Share of the variance when a budget is allocated, against the others': what is expensive
    /// to hold gets more.
    pub weight: f64,
}

impl ErrorSource {
    /// Whether it is the same in every part: fixed, and no texture. Such errors add as they are,
    /// with their signs; they have no variance.
    #[must_use]
    pub fn is_systematic(&self) -> bool {
        self.distribution == Distribution::Fixed && !self.kind.is_texture()
    }

    /// Mean square of its error, in the square of its unit.
    #[must_use]
    pub(super) fn mean_square(&self) -> f64 {
        self.limit * self.limit * self.distribution.mean_square()
    }

    /// The same always at another limit.
    #[must_use]
    pub(super) fn fixed(&self, limit: f64) -> Self {
        Self { limit, distribution: Distribution::Fixed, ..*self }
    }

    /// Its error in a trial, in its own unit; of a texture its strength.
    #[must_use]
    pub fn draw(&self, stream: &RandomStream) -> f64 {
        let [u, _] = stream.pair(self.kind.row().stream, 0);
        self.limit * self.distribution.quantile(u)
    }
}

/// The number of the misalignment that a perturbation changes, and by how much for one of its unit; none of
/// perturbations of the surface.
pub(super) fn misalignment_per_unit(
    kind: Perturbation,
    pixel_mm: f64,
    texture: &TextureShape,
) -> Option<(MisalignmentField, f64)> {
    let (um, mrad, ppm) = (1e-3, 1e-3, 1e-6);
    let row = kind.row();
    let per_unit = match row.unit {
        LimitUnit::Microns => um,
        LimitUnit::Milliradians => mrad,
        LimitUnit::Ppm => ppm,
        LimitUnit::Kelvin => texture.cte_ppm_per_k * ppm,
        LimitUnit::Px => pixel_mm,
        LimitUnit::Millimetres | LimitUnit::ShareOfMap => 1.0,
    };
    row.acts_on.misalignment().map(|field| (field, per_unit))
}
