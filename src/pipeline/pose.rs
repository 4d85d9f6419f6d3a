//! `pose.json`: how a part is mounted, and the errors of its camera.

use super::Error;
use crate::profile::Profile;
use crate::publish;
use crate::tolerance_terms::{ActsOn, ErrorSourceRow, Perturbation};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Errors by their keys, as `tolerance --replay` writes them; what is absent is none.
#[derive(Deserialize)]
struct PoseText {
    #[serde(default)]
    profile: Option<PoseProfile>,
    #[serde(default)]
    part: BTreeMap<String, f64>,
    #[serde(default)]
    camera: BTreeMap<String, f64>,
    #[serde(default)]
    in_the_files: BTreeMap<String, f64>,
}

#[derive(Deserialize)]
struct PoseProfile {
    sha256: String,
}

/// Whether what an error acts on belongs to a table.
type Acts = fn(ActsOn) -> bool;

/// Errors of mounting, camera and size.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct KnownErrors {
    /// Each in its unit.
    pub errors: Vec<(Perturbation, f64)>,
    /// Fingerprint of the profile that it was written for, if it says so.
    pub profile: Option<String>,
}

impl KnownErrors {
    /// That of a file.
    ///
    /// # Errors
    /// [`Error::File`] of a file that cannot be read, [`Error::Pose`] of one that is none.
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let fault = |reason| Error::Pose { file: path.display().to_string(), reason };
        let bytes = publish::read(path)?;
        let text: PoseText =
            serde_json::from_slice(&bytes).map_err(|error| fault(error.to_string()))?;
        let PoseText { profile, part, camera, in_the_files } = text;
        let tables: [(&str, Acts, _); 3] = [
            ("part", ActsOn::is_mounting, part),
            ("camera", ActsOn::is_camera, camera),
            ("in_the_files", ActsOn::is_size, in_the_files),
        ];
        let mut errors = Vec::new();
        for (table, acts, values) in tables {
            for (key, value) in values {
                let rows = || ErrorSourceRow::TABLE.iter().filter(|row| acts(row.acts_on));
                let Some(row) = rows().find(|row| row.key == key) else {
                    let known: Vec<&str> = rows().map(|row| row.key).collect();
                    let known = known.join(", ");
                    return Err(fault(format!(
                        "{table}.{key} is none of its keys, which are {known}"
                    )));
                };
                errors.push((row.perturbation, value));
            }
        }
        Ok(Self { errors, profile: profile.map(|profile| profile.sha256) })
    }

    /// A warning where it was written for another profile.
    pub(super) fn warning(&self, profile: &Profile) -> Option<String> {
        let sha256 = self.profile.as_ref()?;
        (*sha256 != profile.sha256).then(|| {
            "the pose was written for another version of the profile: it is taken as it is"
                .to_owned()
        })
    }
}
