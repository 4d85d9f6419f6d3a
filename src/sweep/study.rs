//! A study as it is found: its text, and the profile that it names.

use super::grid::Grid;
use super::report_keys::ReportKeys;
use crate::pipeline::{ProfileText, SourceError};
use crate::profile::{Profile, StudyContext, SweepSpec};
use crate::publish;
use crate::results::ProfileId;
use std::cell::RefCell;
use std::path::Path;

/// Far more bytes than a study may have, which says so itself of those that have somewhat more.
const MOST_TEXT: u64 = 16_000_000;

/// A checked study with its profile.
#[derive(Debug, Clone)]
pub struct SweepStudy {
    pub(super) spec: SweepSpec,
    /// Text of the profile.
    pub(super) base: ProfileText,
    /// Name and fingerprint of the profile.
    pub(super) profile: ProfileId,
}

impl SweepStudy {
    /// Loads and checks the study in a file, and the profile that it names: a file beside the study if there is one,
    /// else a shipped profile.
    ///
    /// # Errors
    /// [`SourceError`], with every complaint about the study, or about the profile.
    pub fn load(path: &Path) -> Result<Self, SourceError> {
        let named = path.display().to_string();
        let bytes = publish::read_at_most(path, MOST_TEXT)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if matches!(&*name, "" | "." | "..") {
            return Err(SourceError::Nameless { named });
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let found = RefCell::new(None);
        let find = |profile: &str| {
            let text = found_text(folder, profile).map_err(|error| told(&error))?;
            let own = String::from_utf8_lossy(&text.bytes).into_owned();
            *found.borrow_mut() = Some(text);
            Ok(own)
        };
        let keys = RefCell::new(None);
        let column = |command, key: &str| {
            keys.borrow_mut().get_or_insert_with(|| ReportKeys::of(command)).check(key)
        };
        let context = StudyContext { profile: &find, column: &column };
        let spec = SweepSpec::parse(&name, &named, &bytes, context)?;
        let Some(base) = found.into_inner() else { return Err(SourceError::Nameless { named }) };
        let profile: &Profile = &base.checked()?;
        Ok(Self { spec, base, profile: profile.into() })
    }

    /// The study's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.spec.name
    }

    /// Number of its points.
    #[must_use]
    pub fn points(&self) -> usize {
        Grid::new(&self.spec.axes).count()
    }

    /// Text of the profile of a point; none of a point that there is not, or whose values have no place in the text.
    #[must_use]
    pub fn profile_of(&self, point: usize) -> Option<String> {
        let grid = Grid::new(&self.spec.axes);
        (point < grid.count()).then(|| self.spec.text_with(grid.values(point)).ok())?
    }
}

/// The text of the profile that a study in `folder` names.
fn found_text(folder: &Path, profile: &str) -> Result<ProfileText, SourceError> {
    let beside = folder.join(profile);
    match ProfileText::shipped(profile) {
        Some(shipped) if !beside.is_file() => Ok(shipped),
        _ => ProfileText::find(&beside.display().to_string()),
    }
}

/// Why there is no profile, as a hint.
fn told(error: &SourceError) -> String {
    match error {
        SourceError::Unknown { named, hint } => {
            format!("there is no file {named}, and no such profile is shipped{hint}")
        }
        error => error.to_string(),
    }
}
