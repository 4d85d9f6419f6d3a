//! How large a spot each pixel sees through a lens.

use super::ProfileId;
use super::SharpnessFacts;
#[cfg(test)]
use crate::num::stats::finite_or_null;
use crate::pencil::Quantiles;
use crate::profile::Aperture;
use serde::Serialize;

/// Blur of a mirror through an open lens: `blur.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BlurReport {
    /// Version of these keys.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// Columns and rows of the sensor.
    pub pixels: [u32; 2],
    /// Pixels whose centres are aimed at the mirror.
    pub aimed: usize,
    /// The lens as it was asked for.
    pub aperture: Aperture,
    /// Whether the focus is the best one, for want of another.
    pub focus_is_best: bool,
    /// The spots in that focus.
    pub spots: SpotFacts,
    /// The spots in the focus that makes their 95th percentile smallest.
    pub best: SpotFacts,
    /// Where the mirror's virtual images of the world lie, along the chief rays.
    pub images: VirtualImages,
    /// How sharp the picture is with diffraction and pixel; absent where spots are points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<SharpnessFacts>,
}

/// The plane in focus, across the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FocusPlane {
    /// Its Z in the part frame, mm; null infinitely far away.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub z_mm: f64,
    /// Its distance from the entrance pupil, mm; null infinitely far away, absent of a telecentric camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(test, schemars(schema_with = "finite_or_null"))]
    pub distance_mm: Option<f64>,
}

/// Blur with one focus.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SpotFacts {
    /// The plane in focus.
    pub focus: FocusPlane,
    /// Full length of a pixel's blur ellipse, px.
    pub length_px: Quantiles,
    /// Twice the root mean square distance of its rays from the chief ray, px.
    pub rms_diameter_px: Quantiles,
    /// The aperture with which 95 % of the lengths are at most one pixel.
    pub largest: Aperture,
}

/// Where the virtual images lie.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct VirtualImages {
    /// The farthest from the camera and the nearest line image of any pixel.
    pub range: [FocusPlane; 2],
    /// Distance along the axis between a pixel's two line images, mm.
    pub astigmatism_mm: Quantiles,
}
