//! What became of the ray of one pixel.

use super::ray_end::Outcome;
use crate::geom::DVec3;

/// Errors of one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayErrors {
    /// Angle between the reflected direction and the expected one, radians.
    pub angle_rad: f64,
    /// Distance in the image between the ray's image point and that where its content belongs, mm.
    pub image_mm: f64,
    /// Distance in the image between the content shown and that of the designed mirror, mm.
    pub facet_mm: f64,
}

/// Trace of the ray of one pixel: outcome, reflected ray and errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelTrace {
    /// Its end.
    pub outcome: Outcome,
    /// Whether the designed mirror is under the ray.
    pub aimed: bool,
    /// Unit direction of the reflected ray; the zero vector for rays that are not reflected.
    pub direction: DVec3,
    /// Point where the ray meets its nearest facet, mm; the zero vector without one.
    pub hit_point: DVec3,
    /// Errors by the facet's own normal, for aimed rays that hit, where a projection is given.
    pub errors: Option<RayErrors>,
}

impl PixelTrace {
    /// A ray that meets nothing and is not aimed.
    pub(super) const MISSED: Self = Self {
        outcome: Outcome::Missed,
        aimed: false,
        direction: DVec3::ZERO,
        hit_point: DVec3::ZERO,
        errors: None,
    };
}
