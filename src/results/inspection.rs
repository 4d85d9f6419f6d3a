//! The inspection of a made part: the plan of its points, and what measured points say of its form.

use super::{FileFacts, PmiFacts, ProfileId};
use crate::num::stats::Summary;
use serde::Serialize;

/// A plan of points for a coordinate measuring machine, in the shape of `inspection.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct InspectionReport {
    /// Version of these keys.
    pub schema: u32,
    /// Profile.
    pub profile: ProfileId,
    /// Degree of the form that the points are enough for.
    pub degree: usize,
    /// Number of points.
    pub points: usize,
    /// Distance between neighbours on the plane of the picture, mm.
    pub spacing_mm: f64,
    /// Least distance of a point from rims, ridges and steps, mm.
    pub margin_mm: f64,
    /// Datum features of the part's frame, and the zone in which the points have to lie.
    #[serde(flatten)]
    pub pmi: PmiFacts,
    /// The files.
    pub files: Vec<FileFacts>,
}

/// What measured points say of the form of a mirror, after the best pose.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MeasuredForm {
    /// Points in the file.
    pub points: usize,
    /// Those on the mirror that are no outliers.
    pub used: usize,
    /// Radius of the ball whose centres they are, mm; absent of points on the part.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probe_mm: Option<f64>,
    /// Low terms of the form error; none where the points are too few.
    pub terms: Vec<FormTermFacts>,
    /// Standard deviation of what the terms leave, um; absent where the points are too few.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest_um: Option<f64>,
    /// Pixel errors of the mirror with these terms, px, traced against the projection; absent without a projection, or
    /// where a ray does not meet it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixel_error_px: Option<Summary>,
    /// Width of the zone along the normals in which the points have to lie, mm; absent where no limit of the picture
    /// gives one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_profile_mm: Option<f64>,
    /// Points outside of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outside: Option<usize>,
}

/// A term of a form error.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FormTermFacts {
    /// Key of its error source.
    pub term: String,
    /// Its size from peak to valley along Z, um.
    pub pv_um: f64,
    /// Its standard uncertainty from the points' noise and number, um.
    pub uncertainty_um: f64,
}
