//! What became of a photo.

use super::{FileFacts, ProfileId};
use crate::num::stats::{Summary, or_null};
use crate::unwrap::RemapTable;
use serde::Serialize;

/// A photo through a mirror, unwrapped.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct UnwrapReport {
    /// The version of the report's schema whose keys these are.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// The photo.
    pub photo: PhotoFacts,
    /// The frames of a stream or the pictures of a folder; absent of a single photo.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<FramesFacts>,
    /// The file of the pose; absent of the system as designed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<String>,
    /// The panorama; absent where another picture was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub panorama: Option<PanoramaFacts>,
    /// The view in perspective, if one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<ViewFacts>,
    /// The plan of the floor, if one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ground: Option<GroundFacts>,
    /// The table behind it; absent for simple cuts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<UnwrapMapFacts>,
    /// The files written.
    pub files: Vec<FileFacts>,
    /// Remarks.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// A photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PhotoFacts {
    /// Name of the photo or of the folder, as it was given; "-" of a stream.
    pub name: String,
    /// Columns and rows.
    pub pixels: [usize; 2],
    /// Pixels of the photo to one of the sensor, across.
    pub pixels_per_sensor_pixel: f64,
}

/// Frames of a video.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FramesFacts {
    /// "pictures" of a folder; of Y4M the name of its colour tag; of raw frames "rgb24" or "gray8".
    pub format: &'static str,
    /// Number of frames that were unwrapped.
    pub count: u64,
}

/// A panorama.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PanoramaFacts {
    /// "remap" or "cuts".
    pub way: &'static str,
    /// Name of the law by which rows map to elevation.
    pub projection: &'static str,
    /// Columns and rows.
    pub pixels: [usize; 2],
    /// Azimuth at the left and at the right edge, degrees; for cuts as the mirror is meant to show them.
    pub azimuth_deg: [f64; 2],
    /// Elevation at the lower and at the upper edge, degrees.
    pub elevation_deg: [f64; 2],
}

/// A view in perspective.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ViewFacts {
    /// Columns and rows.
    pub pixels: [usize; 2],
    /// Azimuth of its middle, degrees.
    pub azimuth_deg: f64,
    /// Elevation of its middle, degrees.
    pub elevation_deg: f64,
    /// Angle from its left to its right edge, degrees.
    pub field_deg: f64,
}

/// A plan of a floor as seen from the mirror, X to the right.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct GroundFacts {
    /// Columns and rows.
    pub pixels: [usize; 2],
    /// Z of the floor in the part's frame, mm.
    pub height_mm: f64,
    /// Places farther from the axis are not shown, mm.
    pub range_mm: f64,
    /// Millimetres to a pixel.
    pub mm_per_px: f64,
    /// X and Y of the upper left corner, mm.
    pub corner_mm: [f64; 2],
    /// Y of a row less that of the row above it, mm: less than 0 where Y is up.
    pub row_mm: f64,
}

/// A table of places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct UnwrapMapFacts {
    /// Share of the picture's pixels that the photo shows.
    pub seen: f64,
    /// Distance on the sensor between where things are seen and where the projection has them; of directions in the designed mirror alone.
    #[serde(serialize_with = "or_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub distortion_px: Option<Summary>,
}

impl From<&RemapTable> for UnwrapMapFacts {
    fn from(map: &RemapTable) -> Self {
        Self { seen: map.seen(), distortion_px: map.distortion_px }
    }
}
