//! Files: the only door to the disk. Nothing appears under its own name before it is whole.

use crate::export::Label;
use sha2::{Digest, Sha256};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};
use thiserror::Error;

/// Reading or writing failed.
#[derive(Debug, Error)]
#[error("cannot {action} {}: {source}", path.display())]
pub struct FileError {
    /// What was tried.
    pub action: &'static str,
    /// On which file or folder.
    pub path: PathBuf,
    /// The system's account.
    pub source: io::Error,
}

impl FileError {
    fn new(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { action, path, source }
    }
}

/// The folder that one build writes to.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
}

/// A file that is whole and flushed, but still under a temporary name beside its own.
#[derive(Debug)]
pub struct Staged {
    temporary: TempPath,
    target: PathBuf,
}

impl Folder {
    /// Makes the folder and finds out, before any work is done, whether it can be written to.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        std::fs::create_dir_all(path).map_err(FileError::new("create the folder", path))?;
        let folder = Self { path: path.to_owned() };
        folder.temporary().map_err(FileError::new("write into the folder", path))?;
        Ok(folder)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn temporary(&self) -> io::Result<NamedTempFile> {
        tempfile::Builder::new().prefix(".morion-").suffix(".tmp").tempfile_in(&self.path)
    }

    /// Writes a file under a temporary name, down to the disk: a full disk is an error here.
    pub fn stage(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<Staged, FileError> {
        let target = self.path.join(name);
        let run = || -> io::Result<TempPath> {
            // Renaming would find this out too, when other files have their names already.
            if target.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            let mut out = BufWriter::with_capacity(1 << 20, self.temporary()?);
            write(&mut out)?;
            let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
            #[cfg(unix)]
            {
                // Temporary files are private; results are as readable as any new file.
                use std::os::unix::fs::PermissionsExt;
                file.as_file().set_permissions(std::fs::Permissions::from_mode(0o644))?;
            }
            // File systems may take the bytes now and find no room for them later; and a renamed file
            // must not be empty after a power cut.
            file.as_file().sync_all()?;
            Ok(file.into_temp_path())
        };
        let temporary = run().map_err(FileError::new("write", &target))?;
        Ok(Staged { temporary, target })
    }
}

impl Staged {
    /// Where it is now.
    pub fn path(&self) -> &Path {
        &self.temporary
    }

    /// Its bytes, as they are on the disk now.
    pub fn read(&self) -> Result<Vec<u8>, FileError> {
        std::fs::read(&self.temporary).map_err(FileError::new("read back", &self.target))
    }

    /// Gives it its own name, replacing what was there.
    pub fn publish(self) -> Result<(), FileError> {
        let Self { temporary, target } = self;
        temporary.persist(&target).map_err(|e| FileError::new("write", &target)(e.error))
    }
}

/// Reads a whole file.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    std::fs::read(path).map_err(FileError::new("read", path))
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What each file says about itself.
pub fn label(profile: &crate::profile::Profile, tolerances: String) -> Label {
    Label { profile: profile.name.clone(), sha256: profile.sha256.clone(), tolerances }
}
