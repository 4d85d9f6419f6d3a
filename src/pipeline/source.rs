//! Where profiles come from: a file, or one of the shipped ones by its bare name.

use super::files::{self, FileError};
use crate::profile::{Complaints, Profile, shipped};
use std::path::Path;
use thiserror::Error;

/// Why there is no profile.
#[derive(Debug, Error)]
pub enum SourceError {
    /// The file has faults, all listed.
    #[error("{0}")]
    Faulty(#[from] Complaints),
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The name cannot be a folder's.
    #[error("{named}: the file's name gives no name for the output folder; rename the file")]
    Nameless {
        /// As typed.
        named: String,
    },
    /// Neither a file nor a shipped profile.
    #[error("{named}: no such file, and no profile of that name is shipped{hint}")]
    Unknown {
        /// As typed.
        named: String,
        /// What could be meant.
        hint: String,
    },
}

/// Loads and checks the profile that `named` means: a file if there is one, else a shipped profile.
///
/// # Errors
/// [`SourceError`], with every complaint about the file.
pub fn load(named: &str) -> Result<Profile, SourceError> {
    let path = Path::new(named);
    let known = shipped().iter().find(|profile| profile.name == named);
    // A folder called like a shipped profile (an output of it, say) does not hide it.
    if let (Some(profile), false) = (known, path.is_file()) {
        return Ok(Profile::parse(profile.name, profile.name, profile.text.as_bytes())?);
    }
    if !path.exists() {
        let closest = shipped()
            .iter()
            .map(|profile| (strsim::jaro_winkler(named, profile.name), profile.name))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let hint = match closest {
            Some((likeness, name)) if likeness > 0.8 => format!("; did you mean {name}?"),
            _ => " (morion profiles lists those)".into(),
        };
        return Err(SourceError::Unknown { named: named.into(), hint });
    }
    let bytes = files::read(path)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    if matches!(&*stem, "" | "." | "..") {
        return Err(SourceError::Nameless { named: named.into() });
    }
    Ok(Profile::parse(&stem, named, &bytes)?)
}
