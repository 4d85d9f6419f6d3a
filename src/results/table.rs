//! Look-up tables of pixels.

use super::{FileFacts, ProfileId};
use crate::num::stats::{Summary, or_null};
use serde::Serialize;

/// Tables from pixels to directions and places of a floor, and back: `table.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TableReport {
    /// The version of the report's schema, whose rules hold for these keys too.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// Pixels of the frame, across and down.
    pub frame_px: [usize; 2],
    /// Pixels along each side of the block that a node is in the middle of.
    pub every: usize,
    /// Nodes across and down.
    pub nodes: [usize; 2],
    /// Names of the numbers at each node of `table.npy`, in their order.
    pub numbers: Vec<String>,
    /// The file of the pose; none of the system as designed.
    pub pose: Option<String>,
    /// Directions.
    pub directions: FieldFacts,
    /// Places of the floor; none where none was asked for.
    pub floor: Option<FloorFacts>,
    /// Bytes that the tables of the header for C take.
    pub header_bytes: usize,
    /// The panorama's map.
    pub panorama: PlaceMapFacts,
    /// The files written but for this one.
    pub files: Vec<FileFacts>,
    /// Remarks.
    pub warnings: Vec<String>,
}

/// How good a table is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FieldFacts {
    /// What reading between the nodes is off by, pixels; none where nothing is told.
    #[serde(serialize_with = "or_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub off_px: Option<Summary>,
    /// Share of the places that show something which the table tells.
    pub told: f64,
    /// Standard deviation among parts as the study of tolerances has it, over the nodes: of directions their angle, mrad; of the floor
    /// the distance, mm.
    #[serde(serialize_with = "or_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub deviation: Option<Summary>,
}

/// The floor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FloorFacts {
    /// Its Z in the part's frame, mm.
    pub z_mm: f64,
    /// Places farther from the axis are not told, mm.
    pub range_mm: f64,
    /// Its table.
    #[serde(flatten)]
    pub field: FieldFacts,
    /// The map of its plan.
    pub plan: PlaceMapFacts,
}

/// A map from a picture to the frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PlaceMapFacts {
    /// Pixels across and down.
    pub pixels: [usize; 2],
    /// Degrees of a panorama's, or millimetres of a plan's, to a pixel.
    pub per_px: f64,
    /// What is at the upper left corner: azimuth and elevation, degrees, or X and Y, mm.
    pub corner: [f64; 2],
    /// Share of the pixels that the frame shows.
    pub seen: f64,
}
