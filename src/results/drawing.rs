//! The figures of a drawing of the part.

use super::{FileFacts, PmiFacts, ProfileId};
use serde::{Deserialize, Serialize};

/// A drawing of the part, in the shape of `drawing.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DrawingReport {
    /// Version of these keys.
    pub schema: u32,
    /// Profile.
    pub profile: ProfileId,
    /// The figures.
    #[serde(flatten)]
    pub drawing: DrawingFacts,
    /// The files.
    pub files: Vec<FileFacts>,
}

/// Every figure of a drawing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DrawingFacts {
    /// Its paper.
    pub paper: String,
    /// Arrangement of its views.
    pub projection: String,
    /// Scale of its views, as `1:2`.
    pub scale: String,
    /// Length of the part along each axis, mm.
    pub size_mm: [f64; 3],
    /// Least X and Y of the part, mm.
    pub least_mm: [f64; 2],
    /// Length of the mirror along X and Y, mm.
    pub mirror_mm: [f64; 2],
    /// Least X and Y of the mirror, mm.
    pub mirror_least_mm: [f64; 2],
    /// Z of the mirror's lowest place, mm.
    pub lowest_mm: f64,
    /// Whether the part's outside is round.
    pub is_round: bool,
    /// Height of the flat rim, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_mm: Option<f64>,
    /// Radius of the part's corners, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_radius_mm: Option<f64>,
    /// Leg of the chamfers of 45 degrees along the part's outer edges, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge_chamfer_mm: Option<f64>,
    /// Least thickness of base, walls and mirror around a cavity, mm; absent of solid parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shell_mm: Option<f64>,
    /// Holes, marks and drains, in the order of their numbers on the drawing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub features: Vec<DrawnFeature>,
    /// Radius of curvature of the best-fit sphere, mm, negative for a dome; absent of a flat mirror.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sphere_radius_mm: Option<f64>,
    /// Departure of the mirror from it, square to the surface from peak to valley, mm.
    pub sphere_departure_mm: f64,
    /// Datum features and the mirror's profile tolerance.
    #[serde(flatten)]
    pub pmi: PmiFacts,
    /// Largest slope error of the mirror, mrad RMS: the angle of its normals, form included; absent where no limit of the
    /// picture gives one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope_error_mrad: Option<f64>,
    /// Places of the mirror, X, Y and Z, mm.
    pub sag_mm: Vec<[f64; 3]>,
    /// Number of points of the inspection's plan.
    pub inspection_points: usize,
    /// Place of the camera, and where it looks.
    pub camera: String,
}

/// A hole or mark of the part, as a drawing has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DrawnFeature {
    /// Its number, after `H` for a hole and `M` for a mark.
    pub name: String,
    /// X and Y of its centre, mm.
    pub at_mm: [f64; 2],
    /// Its diameter, mm.
    pub diameter_mm: f64,
    /// What it is.
    pub what: String,
}

impl DrawnFeature {
    /// The name of a hole by its number among all holes of the part, from 1.
    #[must_use]
    pub(crate) fn hole_name(number: usize) -> String {
        format!("H{number}")
    }
}
