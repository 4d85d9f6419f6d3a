//! `pose.json`: how a part is mounted, and the errors of its camera.

use super::Error;
use crate::profile::{Profile, ProfileFile};
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

/// The profile that it was written for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct PoseProfile {
    sha256: String,
    /// The files that the profile names.
    #[serde(default)]
    files: Vec<ProfileFile>,
}

/// Whether what an error acts on belongs to a table.
type Acts = fn(ActsOn) -> bool;

/// Errors of mounting, camera and size.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct KnownErrors {
    /// Each in its unit.
    pub errors: Vec<(Perturbation, f64)>,
    /// The profile that it was written for, if it says so.
    pub profile: Option<PoseProfile>,
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
        Ok(Self { errors, profile })
    }

    /// A warning where it was written for another profile.
    pub(super) fn warning(&self, profile: &Profile) -> Option<String> {
        let id = self.profile.as_ref()?;
        // (One that tells of no files may be older than they are.)
        let has_others = !id.files.is_empty() && id.files != profile.files;
        (id.sha256 != profile.sha256 || has_others).then(|| {
            let is_text = id.sha256 != profile.sha256;
            let what = if is_text { "the profile" } else { "a file that the profile names" };
            format!("the pose was written for another version of {what}: it is taken as it is")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Shipped, shipped};

    /// A pose tells of another text, or of other files beside the same text; one that tells of no files is taken by the text alone.
    #[test]
    fn a_pose_of_another_profile_or_of_other_files_is_told() {
        let Shipped { name, text } = shipped()[0];
        let mut profile = Profile::parse(name, name, text.as_bytes()).unwrap();
        profile.files = vec![ProfileFile::new("camera.yaml", b"one")];
        let told = |sha256: &str, files: &[ProfileFile]| {
            let written = PoseProfile { sha256: sha256.to_owned(), files: files.to_vec() };
            let errors = KnownErrors { profile: Some(written), ..KnownErrors::default() };
            errors.warning(&profile).is_some()
        };
        let [one, two] = [b"one", b"two"].map(|bytes| [ProfileFile::new("camera.yaml", bytes)]);
        let sha256 = profile.sha256.clone();
        assert_eq!([told(&sha256, &one), told(&sha256, &[])], [false; 2]);
        assert_eq!([told(&sha256, &two), told("another", &one)], [true; 2]);
    }
}
