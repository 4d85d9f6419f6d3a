//! Classes of pixels: filled, or lost for a cause.

use super::pixel_trace::{PixelTrace, RayErrors};
use super::ray_end::Outcome;

/// Class of a pixel: filled, or lost for the first of these causes that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelClass {
    /// It shows its part of the world.
    Filled,
    /// The designed mirror is not under its ray.
    Beyond,
    /// The nearest facet shows it the back.
    BackFace,
    /// Its ray is reflected and then meets the part.
    Shadow,
    /// An obstacle is in the way of its ray, before the mirror or behind it.
    Obstacle,
    /// It shows something else than the designed mirror does, or nothing, within a pixel of where
    /// the mirror ends.
    Rim,
    /// It shows something else than the designed mirror does within a pixel of the ridge: part of
    /// the other panel.
    Ridge,
    /// Its ray meets nothing, far from the rim.
    Missed,
    /// What it shows belongs farther away than the tolerance.
    Content,
}

impl PixelClass {
    /// The causes of loss, in the order of [`LostPixels`].
    ///
    /// [`LostPixels`]: super::LostPixels
    pub const LOST: [Self; 8] = [
        Self::Beyond,
        Self::Rim,
        Self::Ridge,
        Self::Shadow,
        Self::Content,
        Self::BackFace,
        Self::Missed,
        Self::Obstacle,
    ];
}

/// Class of a pixel as far as it alone tells: of others it depends on where the mirror ends.
pub(super) fn own_class(pixel: &PixelTrace, tolerance_mm: f64) -> Option<PixelClass> {
    let keeps = |error: fn(&RayErrors) -> f64| {
        pixel.errors.is_some_and(|errors| error(&errors) <= tolerance_mm)
    };
    match pixel.outcome {
        _ if !pixel.aimed => Some(PixelClass::Beyond),
        Outcome::BackFace => Some(PixelClass::BackFace),
        Outcome::Shadowed(_) => Some(PixelClass::Shadow),
        Outcome::Obstructed(_) => Some(PixelClass::Obstacle),
        Outcome::Hit if keeps(|errors| errors.image_mm) => Some(PixelClass::Filled),
        Outcome::Hit if keeps(|errors| errors.facet_mm) => Some(PixelClass::Content),
        Outcome::Hit | Outcome::Missed => None,
    }
}
