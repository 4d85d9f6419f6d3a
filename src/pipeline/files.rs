//! Files: the only door to the disk. Nothing appears under its own name before it is whole.

use sha2::{Digest, Sha256};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
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

const PREFIX: &str = ".morion-";
const SUFFIX: &str = ".tmp";
/// A temporary file older than this was left by a build that was killed.
const ABANDONED: Duration = Duration::from_secs(3600);

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
    sha256: String,
}

/// Passes bytes on and hashes them.
struct Hashing<W> {
    out: W,
    hash: Sha256,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.out.write(bytes)?;
        self.hash.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Folder {
    /// Makes the folder and finds out, before any work is done, whether it can be written to.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        std::fs::create_dir_all(path).map_err(FileError::new("create the folder", path))?;
        let folder = Self { path: path.to_owned() };
        folder.temporary().map_err(FileError::new("write into the folder", path))?;
        folder.sweep();
        Ok(folder)
    }

    /// Finds out whether there is room for so many bytes. Where that is not known, there is.
    pub fn holds(&self, bytes: u64) -> Result<(), FileError> {
        let free = self.free().unwrap_or(u64::MAX);
        let mb = |bytes: u64| bytes as f64 / 1e6;
        if bytes <= free {
            return Ok(());
        }
        let text = format!(
            "the files take at least {:.1} MB, and {:.1} MB are free; make room, choose another \
             --out, or ask for fewer formats or looser limits",
            mb(bytes),
            mb(free)
        );
        let full = io::Error::new(io::ErrorKind::StorageFull, text);
        Err(FileError::new("write into the folder", &self.path)(full))
    }

    /// Bytes that are free on its disk, as far as is known.
    pub fn free(&self) -> Option<u64> {
        fs4::available_space(&self.path).ok()
    }

    /// Removes what killed builds left behind, as far as that is possible.
    fn sweep(&self) {
        let Ok(entries) = std::fs::read_dir(&self.path) else { return };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let age =
                entry.metadata().and_then(|m| m.modified()).ok().and_then(|t| t.elapsed().ok());
            let abandoned = age.is_some_and(|age| age > ABANDONED);
            if name.starts_with(PREFIX) && name.ends_with(SUFFIX) && abandoned {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Finds out whether [`Folder::remove`] could not do its work.
    pub fn clears(&self, name: &str) -> Result<(), FileError> {
        let path = self.path.join(name);
        let is_file = !path.is_dir();
        let error = || FileError::new("remove", &path)(io::ErrorKind::IsADirectory.into());
        is_file.then_some(()).ok_or_else(error)
    }

    /// Removes a file of an earlier build, if there is one.
    pub fn remove(&self, name: &str) -> Result<(), FileError> {
        let path = self.path.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(FileError::new("remove", &path)(error))
            }
            _ => Ok(()),
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn temporary(&self) -> io::Result<NamedTempFile> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        {
            // As any new file: the umask decides, not the privacy of temporary files.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        builder.tempfile_in(&self.path)
    }

    /// Writes a file under a temporary name, down to the disk: a full disk is an error here.
    pub fn stage(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<Staged, FileError> {
        let target = self.path.join(name);
        let run = || -> io::Result<(TempPath, String)> {
            // Renaming would find this out too, when other files have their names already.
            if target.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            let hashing = Hashing { out: self.temporary()?, hash: Sha256::new() };
            let mut out = BufWriter::with_capacity(1 << 20, hashing);
            write(&mut out)?;
            let Hashing { out: file, hash } =
                out.into_inner().map_err(io::IntoInnerError::into_error)?;
            // File systems may take the bytes now and find no room for them later; and a renamed
            // file must not be empty after a power cut.
            file.as_file().sync_all()?;
            Ok((file.into_temp_path(), hex(&hash.finalize())))
        };
        let (temporary, sha256) = run().map_err(FileError::new("write", &target))?;
        Ok(Staged { temporary, target, sha256 })
    }
}

impl Staged {
    /// Where it is now.
    pub fn path(&self) -> &Path {
        &self.temporary
    }

    /// The name that it will have.
    pub fn name(&self) -> &str {
        self.target.file_name().and_then(|name| name.to_str()).unwrap_or_default()
    }

    /// SHA-256 of what was written, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Its bytes, as they are on the disk now.
    pub fn read(&self) -> Result<Vec<u8>, FileError> {
        std::fs::read(&self.temporary).map_err(FileError::new("read back", &self.target))
    }

    /// Gives it its own name, replacing what was there.
    pub fn publish(self) -> Result<(), FileError> {
        let Self { temporary, target, .. } = self;
        temporary.persist(&target).map_err(|e| FileError::new("write", &target)(e.error))
    }
}

/// Reads a whole file.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    std::fs::read(path).map_err(FileError::new("read", path))
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Bytes in hexadecimal.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_holds_what_is_free_and_no_more() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path()).unwrap();
        let free = folder.free().unwrap();
        assert!(folder.holds(free / 2).is_ok());
        let error = folder.holds(u64::MAX).unwrap_err().to_string();
        assert!(
            error.starts_with("cannot write into the folder ") && error.contains(" MB are free")
        );
    }
}
