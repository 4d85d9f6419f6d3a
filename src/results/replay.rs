//! A replayed trial, its errors and its pose.

use super::{FileFacts, ProfileId, Reason, Verdict};
use crate::solid::SolidCheck;
use crate::tolerance::{Criterion, Displacement, Reference, RigidTransform, Witnessed};
use serde::Serialize;
use serde_json::{Map, Value};

/// Replay of a trial as files, traced: `replay.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ReplayReport {
    /// Version of these keys.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// Seed of the trials.
    pub seed: u64,
    /// Number of the trial.
    pub trial: u64,
    /// Pixels that stand for the picture.
    pub samples: usize,
    /// Figure that is held against the budget.
    pub criterion: Criterion,
    /// What displacements are measured from.
    pub reference: Reference,
    /// All errors of the trial.
    pub errors: Vec<DrawnError>,
    /// Those that are not in the files: the stand-in for facets, and what was left out.
    pub without: Vec<String>,
    /// The trial's figures, as in `trials.csv`.
    pub repeated: Displacement,
    /// The figures of the smooth surface that the files are of, without those errors.
    pub smooth: Displacement,
    /// Edges of the optical face are no longer than this before it is displaced, mm; none where
    /// the mesh of the design is fine enough for everything.
    pub longest_edge_mm: Option<f64>,
    /// The files, read back.
    pub files: Vec<ReplayFile>,
    /// Whether every file is a solid, has the surface, and shows the smooth surface's figures
    /// within its facet error.
    pub verdict: Verdict,
    /// Why it fails; empty for a pass.
    pub reasons: Vec<Reason>,
}

/// An error of a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DrawnError {
    /// Its key in the profile, which ends in its unit.
    pub source: String,
    /// Its value; of a texture its strength.
    pub value: f64,
}

/// A file of the imperfect part.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ReplayFile {
    /// The file.
    #[serde(flatten)]
    pub file: FileFacts,
    /// Facets in all.
    pub triangles: usize,
    /// Facets of the optical face.
    pub optical_triangles: usize,
    /// The check of the mesh that was read.
    pub solid: SolidCheck,
    /// The largest distance along Z of the optical face's vertices from the made surface, mm.
    pub off_surface_mm: f64,
    /// What rounding to the file's digits explains, mm.
    pub rounding_mm: f64,
    /// What it shows.
    #[serde(flatten)]
    pub witnessed: Witnessed,
}

/// `pose.json`: what a file of the part cannot hold.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PoseFile {
    /// Version of these keys.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// Seed of the trials.
    pub seed: u64,
    /// Number of the trial.
    pub trial: u64,
    /// How the part is mounted, about the middle of its base: turns about X, then Y, then the
    /// axis.
    #[cfg_attr(test, schemars(schema_with = "error_schemas::mounting_errors"))]
    pub part: Map<String, Value>,
    /// The same as a motion, for the file's coordinates.
    pub world_from_file: RigidTransform,
    /// The camera's errors.
    #[cfg_attr(test, schemars(schema_with = "error_schemas::camera_errors"))]
    pub camera: Map<String, Value>,
    /// Errors of size, which the files have already.
    #[cfg_attr(test, schemars(schema_with = "error_schemas::size_errors"))]
    pub in_the_files: Map<String, Value>,
    /// How much larger the part is by them.
    pub growth: f64,
}

/// JSON Schemas of objects with a number for each error source of a kind.
#[cfg(test)]
mod error_schemas {
    use crate::tolerance_terms::{ActsOn, ErrorSourceRow};
    use schemars::{Schema, SchemaGenerator, json_schema};
    use serde_json::{Map, Value, json};

    /// The JSON Schema of an object with a number for each error source whose effect `acts`.
    fn errors(acts: fn(ActsOn) -> bool) -> Schema {
        let rows = || ErrorSourceRow::TABLE.iter().filter(|row| acts(row.acts_on));
        let property = |row: &ErrorSourceRow| {
            let description =
                format!("{}, {}", row.what.concat().trim().trim_end_matches('.'), row.unit.label());
            (row.key.to_owned(), json!({ "type": "number", "description": description }))
        };
        let properties: Map<String, Value> = rows().map(property).collect();
        let required: Vec<&str> = rows().map(|row| row.key).collect();
        json_schema!({ "type": "object", "properties": properties, "required": required })
    }

    pub(super) fn mounting_errors(_: &mut SchemaGenerator) -> Schema {
        errors(ActsOn::is_mounting)
    }

    pub(super) fn camera_errors(_: &mut SchemaGenerator) -> Schema {
        errors(ActsOn::is_camera)
    }

    pub(super) fn size_errors(_: &mut SchemaGenerator) -> Schema {
        errors(ActsOn::is_size)
    }
}
