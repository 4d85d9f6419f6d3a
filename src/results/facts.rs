//! Facts that several answers have: the shapes of parts of their JSON.

use crate::num::stats::{Summary, or_null, unless_null};
use crate::profile::{Profile, ProfileFile};
use crate::publish::sha256;
use crate::solid::SolidCheck;
use serde::{Deserialize, Serialize};

/// Version of the report's schema: keys may be added, never changed.
pub const SCHEMA: u32 = 1;

/// Name and fingerprint of a profile.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProfileId {
    /// Name of the profile.
    pub name: String,
    /// SHA-256 of its text, hexadecimal.
    pub sha256: String,
    /// The files that it names; absent of one that names none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<ProfileFile>,
}

impl From<&Profile> for ProfileId {
    fn from(profile: &Profile) -> Self {
        let Profile { name, sha256, files, .. } = profile;
        Self { name: name.clone(), sha256: sha256.clone(), files: files.clone() }
    }
}

/// Pass or fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The part does what the profile asks.
    Pass,
    /// It does not.
    Fail,
}

impl Verdict {
    /// In a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "fail",
        }
    }
}

/// A file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileFacts {
    /// Name in the output folder.
    pub name: String,
    /// Name of its format.
    pub format: String,
    /// Length, bytes.
    pub bytes: u64,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

impl FileFacts {
    /// The facts of a file with these bytes.
    #[must_use]
    pub fn of(name: &str, format: &str, bytes: &[u8]) -> Self {
        Self {
            name: name.to_owned(),
            format: format.to_owned(),
            bytes: bytes.len() as u64,
            sha256: sha256(bytes),
        }
    }
}

/// A limit asked for and the bound proven.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Limited {
    /// Limit asked for; null where the profile sets none.
    pub limit: Option<f64>,
    /// Bound proven over every facet.
    pub bound: f64,
}

/// Numbers of triangles over the least possible, for the limits that are set; none where the mirror
/// bends in one direction alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OverOptimum {
    /// Triangles over the least number for the chord limit.
    pub chord: Option<f64>,
    /// Triangles over the least number for the facet limit.
    pub facet: Option<f64>,
}

/// What the mesh reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MeshFacts {
    /// Facets of the optical face.
    pub optical_triangles: usize,
    /// Facets of the solid.
    pub triangles: usize,
    /// Most of them, where the profile sets that in the place of limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_triangles: Option<usize>,
    /// Vertices of the solid.
    pub vertices: usize,
    /// Height between facet and mirror, um.
    pub chord_um: Limited,
    /// Image displacement by flat facets, pixels.
    pub facet_px: Limited,
    /// The part of it that rounding to single precision causes, pixels.
    pub rounding_px: f64,
    /// Triangles over the theoretical least.
    pub over_optimum: OverOptimum,
}

/// The check of a solid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SolidFacts {
    /// What was found.
    #[serde(flatten)]
    pub check: SolidCheck,
    /// Integral of the design, mm^3.
    pub volume_expected_mm3: f64,
    /// What is wrong, facet by facet.
    pub reasons: Vec<String>,
}

impl SolidFacts {
    /// The facts of `check`, beside the volume expected.
    #[must_use]
    pub fn new(check: &SolidCheck, volume_expected_mm3: f64) -> Self {
        Self { check: check.clone(), volume_expected_mm3, reasons: check.reasons() }
    }
}

/// What a sag table holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SagFacts {
    /// Rows of X, Y, Z and normal.
    pub rows: usize,
    /// Largest difference of Z from the design, mm.
    pub height_error_mm: f64,
    /// Largest angle to the design's normal, radians.
    pub normal_error_rad: f64,
}

/// The splines of a STEP file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StepFacts {
    /// Largest distance from the design, nm.
    pub fit_error_nm: f64,
    /// Control points of a panel along each axis; one along the second for a surface of revolution.
    pub control_points: [usize; 2],
    /// What an AP242 file says of datum features and tolerance; absent of an AP214 file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pmi: Option<PmiFacts>,
    /// The solid that the file was read back as; absent where it is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<StepBodyFacts>,
}

/// Product and manufacturing information of a part: what it is measured from, and how far its mirror may be off.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PmiFacts {
    /// Datum features, each with its letter.
    pub datums: Vec<String>,
    /// Width of the zone along the normals in which the mirror's faces lie, mm; absent where no limit of the picture
    /// gives one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface_profile_mm: Option<f64>,
    /// The form error that uses up the picture's limits first, by the key of its error source.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limited_by: Option<String>,
}

/// A STEP file as it was read back: one closed solid of curved faces, beside the design.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct StepBodyFacts {
    /// Number of faces.
    pub faces: usize,
    /// Number of edges.
    pub edges: usize,
    /// Largest distance of an edge from its faces, nm.
    pub gap_nm: f64,
    /// Volume, mm^3.
    pub volume_mm3: f64,
    /// Number of rays from the camera on which the face was held against the design.
    pub rays: usize,
    /// Largest distance from the design where they meet the file's faces, nm.
    pub surface_error_nm: f64,
    /// Largest angle to the design's normal there, radians.
    pub normal_error_rad: f64,
}

/// What the witness saw in one file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct TraceFacts {
    /// Name in the output folder.
    pub file: String,
    /// Number of camera rays aimed at the mirror.
    pub rays: usize,
    /// Number of rays that are reflected into the world.
    pub hit: usize,
    /// Number of rays that meet nothing.
    pub missed: usize,
    /// Number of rays whose reflection meets the part.
    pub shadowed: usize,
    /// Number of rays that meet the back of a facet.
    pub back_face: usize,
    /// Number of rays that an obstacle hides, before the mirror or behind it; left out where there is none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub obstructed: usize,
    /// Against the projection and the designed mirror, by facet normals.
    #[serde(flatten)]
    pub errors: ErrorFacts,
    /// The same by the file's interpolated normals, where it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interpolated_normals: Option<ErrorFacts>,
    /// The vertex farthest from the designed part's surface.
    pub worst_vertex: Option<VertexFacts>,
    /// The check of the file's mesh.
    pub solid: SolidFacts,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// A vertex and how far it is from where the part has its surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct VertexFacts {
    /// X, Y and Z of the vertex, mm.
    pub at_mm: [f64; 3],
    /// Distance, mm: along Z from the mirror or the base, or across from the outline.
    pub off_mm: f64,
}

/// Errors over the rays that hit; absent when none did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ErrorFacts {
    /// Angle between the direction seen and the projection's, mrad.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub ray_error_mrad: Option<Summary>,
    /// The same carried back to the image, pixels.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub pixel_error_px: Option<Summary>,
    /// Image displacement against the designed mirror, pixels.
    #[serde(serialize_with = "or_null", deserialize_with = "unless_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub facet_error_px: Option<Summary>,
}
