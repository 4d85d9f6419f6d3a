//! The folder that a command publishes into: room on its disk, a lock, temporary files.

use super::FileError;
use super::error::remedy;
use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tempfile::{NamedTempFile, TempDir};

const PREFIX: &str = ".morion-";
const SUFFIX: &str = ".tmp";
/// Where files cannot be locked: a temporary file older than this was left by a command that was
/// killed.
const ABANDONED: Duration = Duration::from_secs(3600);

/// Temporary files of this process. What has got its name or is gone may still be listed.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the files that this process is writing under temporary names, before it ends by a signal.
/// No other is begun afterwards: whoever wants to waits for ever.
pub fn abandon() {
    let temporary = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
    temporary.iter().for_each(|path| remove_temporary(path));
    std::mem::forget(temporary);
}

/// A folder that can be written to.
#[derive(Debug)]
pub(super) struct Folder {
    path: PathBuf,
    /// The folders that were made for it, itself first.
    made: Vec<PathBuf>,
}

/// Keeps other commands from giving files in a folder their names, until it is dropped.
#[derive(Debug)]
#[must_use]
pub(super) struct PublishLock {
    _folder: Option<File>,
}

/// A folder that goes with all that is in it when it is dropped.
#[derive(Debug)]
pub(super) struct TemporaryFolder {
    folder: TempDir,
    /// Tells other commands that it is not abandoned.
    _lock: Option<File>,
}

impl TemporaryFolder {
    /// Where it is.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes a temporary file or folder, as far as that is possible.
fn remove_temporary(path: &Path) {
    let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
}

impl Folder {
    /// Makes the folder and finds out, before any work is done, whether it can be written to.
    pub(crate) fn create(path: &Path) -> Result<Self, FileError> {
        let is_new = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
        let made = path.ancestors().take_while(is_new).map(Path::to_owned).collect();
        std::fs::create_dir_all(path).map_err(FileError::new("create the folder", path))?;
        let folder = Self { path: path.to_owned(), made };
        folder.temporary().map_err(FileError::new("write into the folder", path))?;
        folder.sweep();
        Ok(folder)
    }

    /// Finds out whether there is room for so many bytes. Where that is not known, there is.
    pub(crate) fn ensure_space(&self, bytes: u64) -> Result<(), FileError> {
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
        let full = io::Error::new(ErrorKind::StorageFull, text);
        Err(FileError::new("write into the folder", &self.path)(full))
    }

    /// Bytes that are free on its disk, as far as is known.
    pub(crate) fn free(&self) -> Option<u64> {
        fs4::available_space(&self.path).ok()
    }

    /// The lock under which files that belong together get their names; other commands wait for it.
    /// Where folders cannot be locked there is nothing to wait for.
    pub(super) fn lock(&self) -> PublishLock {
        PublishLock { _folder: self.locked(File::lock) }
    }

    fn locked(&self, lock: impl FnOnce(&File) -> io::Result<()>) -> Option<File> {
        let folder = File::open(&self.path).ok()?;
        lock(&folder).ok()?;
        Some(folder)
    }

    /// Removes what killed commands left behind, as far as that is possible.
    fn sweep(&self) {
        let _lock = self.lock();
        let Ok(entries) = std::fs::read_dir(&self.path) else { return };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with(PREFIX) && name.ends_with(SUFFIX) && abandoned(&entry.path()) {
                remove_temporary(&entry.path());
            }
        }
    }

    /// Finds out whether [`Folder::remove`] could not do its work.
    pub(super) fn ensure_removable(&self, name: &str) -> Result<(), FileError> {
        let path = self.path.join(name);
        let is_file = !path.is_dir();
        let error = || FileError::new("remove", &path)(ErrorKind::IsADirectory.into());
        is_file.then_some(()).ok_or_else(error)
    }

    /// Removes a file of an earlier build, if there is one.
    pub(super) fn remove(&self, name: &str) -> Result<(), FileError> {
        let path = self.path.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(FileError::new("remove", &path)(error))
            }
            _ => Ok(()),
        }
    }

    /// Removes the folders that were made for it, as far as they are empty.
    pub(super) fn remove_unused(&self) {
        for folder in &self.made {
            let _ = std::fs::remove_dir(folder);
        }
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// A temporary folder in it, for files of which there are too many to keep each open.
    pub(super) fn temporary_folder(&self) -> io::Result<TemporaryFolder> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        // As of files: no sweep comes before the lock.
        let _lock = self.locked(File::lock_shared);
        let mut known = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = builder.tempdir_in(&self.path)?;
        known.push(folder.path().to_owned());
        drop(known);
        let lock = File::open(folder.path()).ok();
        let _ = lock.as_ref().map(File::try_lock);
        Ok(TemporaryFolder { folder, _lock: lock })
    }

    pub(super) fn temporary(&self) -> io::Result<NamedTempFile> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        {
            // As any new file: the umask decides, not the privacy of temporary files.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        // No sweep comes between the two.
        let _lock = self.locked(File::lock_shared);
        let mut known = TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner);
        let file = builder.tempfile_in(&self.path).map_err(|error| {
            // Without the temporary name, which nobody has to know.
            let plain = io::Error::from(error.kind());
            if remedy("write", &plain).is_empty() { error } else { plain }
        })?;
        known.push(file.path().to_owned());
        drop(known);
        #[cfg(unix)]
        let _ = file.as_file().try_lock();
        Ok(file)
    }
}

/// Whether the command that wrote this temporary file is no longer there.
fn abandoned(path: &Path) -> bool {
    let age = || path.metadata().ok()?.modified().ok()?.elapsed().ok();
    let old = || age().is_some_and(|age| age > ABANDONED);
    match File::open(path).map(|file| file.try_lock()) {
        Ok(Ok(())) if cfg!(unix) => true,
        Ok(Err(TryLockError::WouldBlock)) => false,
        _ => old(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_holds_what_is_free_and_no_more() {
        let temporary = tempfile::tempdir().unwrap();
        let folder = Folder::create(temporary.path()).unwrap();
        let free = folder.free().unwrap();
        assert!(folder.ensure_space(free / 2).is_ok());
        let error = folder.ensure_space(u64::MAX).unwrap_err().to_string();
        assert!(
            error.starts_with("cannot write into the folder ") && error.contains(" MB are free")
        );
    }
}
