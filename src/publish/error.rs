//! Why a file cannot be read or written, and what to do about it.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Reading or writing failed.
#[derive(Debug, Error)]
#[error("cannot {action} {}: {source}{}", path.display(), remedy(action, source))]
pub struct FileError {
    /// What was tried.
    pub action: &'static str,
    /// On which file or folder.
    pub path: PathBuf,
    /// The system's account.
    pub source: io::Error,
}

impl FileError {
    pub(super) fn new(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { action, path, source }
    }
}

pub(super) const READ: &str = "read";

/// What to do about an error that the system accounts for.
pub(super) fn remedy(action: &str, source: &io::Error) -> &'static str {
    match source.kind() {
        // Ours say it themselves.
        _ if source.get_ref().is_some() => "",
        ErrorKind::PermissionDenied if action == READ => "; allow it to be read",
        _ if action == READ => "",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; choose a folder that can be written to with --out"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "; make room, or choose another --out",
        ErrorKind::FileTooLarge => {
            "; the file system or the shell (ulimit -f) allows no file of this size"
        }
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => {
            "; move the file that is in the way, or choose another --out"
        }
        ErrorKind::IsADirectory => "; move the folder that is in the way, or choose another --out",
        ErrorKind::NotFound => "; the folder was removed meanwhile: run the command again",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_system_come_with_a_remedy() {
        let told = |action, kind: ErrorKind| {
            FileError::new(action, Path::new("there"))(kind.into()).to_string()
        };
        for (kind, words) in [
            (ErrorKind::StorageFull, "make room"),
            (ErrorKind::ReadOnlyFilesystem, "that can be written to with --out"),
            (ErrorKind::NotFound, "removed meanwhile"),
            (ErrorKind::IsADirectory, "move the folder"),
        ] {
            let error = told("write", kind);
            assert!(error.starts_with("cannot write there: ") && error.contains(words), "{error}");
        }
        assert_eq!(told(READ, ErrorKind::NotFound), "cannot read there: entity not found");
    }
}
