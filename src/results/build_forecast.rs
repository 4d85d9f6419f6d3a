//! What a build would make, foreseen without making it.

use super::{ProfileId, SCHEMA};
use serde::Serialize;

/// What a build of one profile would come to. Numbers are forecasts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BuildForecast {
    /// The version of the report's schema whose keys these are.
    pub schema: u32,
    /// Whether nothing was written: always true.
    pub dry_run: bool,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// The mesh; none where the build would go on without one.
    pub mesh: Option<MeshForecast>,
    /// The mesh files.
    pub files: Vec<FileForecast>,
    /// Why files that are asked for would not be written.
    pub reasons: Vec<String>,
    /// What may be a nuisance later, and what to do about it.
    pub warnings: Vec<String>,
}

/// The mesh that is foreseen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MeshForecast {
    /// Facets of the optical face.
    pub optical_triangles: usize,
    /// Facets of the solid.
    pub triangles: usize,
    /// Most of them, where the profile sets that in the place of limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_triangles: Option<usize>,
    /// Height between facet and mirror, um.
    pub chord_um: ForecastLimit,
    /// Image displacement by flat facets, pixels.
    pub facet_px: ForecastLimit,
}

/// A limit asked for, and what is foreseen for a number of triangles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ForecastLimit {
    /// Limit asked for; null where the profile sets none.
    pub limit: Option<f64>,
    /// Limit that the number of triangles is foreseen to keep; null where limits rule.
    pub foreseen: Option<f64>,
}

/// A mesh file that is foreseen.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FileForecast {
    /// Name in the output folder.
    pub name: String,
    /// Name of its format.
    pub format: &'static str,
    /// Length, bytes.
    pub bytes: u64,
}

impl BuildForecast {
    /// The forecast for `profile`; nothing in it yet but the mesh and the files.
    #[must_use]
    pub fn new(profile: ProfileId, mesh: Option<MeshForecast>, files: Vec<FileForecast>) -> Self {
        let (reasons, warnings) = (Vec::new(), Vec::new());
        Self { schema: SCHEMA, dry_run: true, profile, mesh, files, reasons, warnings }
    }
}
