//! Files: the only door to the disk. Nothing appears under its own name before it is whole.

use crate::profile::hex;
use sha2::{Digest, Sha256};
use std::fs::{File, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tempfile::NamedTempFile;
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
    fn new(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self { action, path, source }
    }
}

const READ: &str = "read";

/// What to do about an error that the system accounts for.
fn remedy(action: &str, source: &io::Error) -> &'static str {
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
    for path in temporary.iter() {
        let _ = std::fs::remove_file(path);
    }
    std::mem::forget(temporary);
}

/// The folder that one build writes to.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
}

/// A file that is whole and flushed, but still under a temporary name beside its own.
#[derive(Debug)]
pub struct Staged {
    temporary: NamedTempFile,
    target: PathBuf,
    sha256: String,
}

/// Keeps other commands from giving files in a folder their names, until it is dropped.
#[derive(Debug)]
#[must_use]
pub struct PublishLock {
    _folder: Option<File>,
}

/// Passes bytes on and hashes them.
struct HashingWriter<W> {
    out: W,
    hash: Sha256,
}

impl<W: Write> Write for HashingWriter<W> {
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
    pub fn ensure_space(&self, bytes: u64) -> Result<(), FileError> {
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
    pub fn free(&self) -> Option<u64> {
        fs4::available_space(&self.path).ok()
    }

    /// Waits for the turn to publish files that belong together. Where folders cannot be locked
    /// there is nothing to wait for.
    fn turn(&self) -> PublishLock {
        PublishLock { _folder: self.locked(File::lock) }
    }

    fn locked(&self, lock: impl FnOnce(&File) -> io::Result<()>) -> Option<File> {
        let folder = File::open(&self.path).ok()?;
        lock(&folder).ok()?;
        Some(folder)
    }

    /// Removes what killed commands left behind, as far as that is possible.
    fn sweep(&self) {
        let _turn = self.turn();
        let Ok(entries) = std::fs::read_dir(&self.path) else { return };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with(PREFIX) && name.ends_with(SUFFIX) && abandoned(&entry.path()) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Finds out whether [`Folder::remove`] could not do its work.
    fn ensure_removable(&self, name: &str) -> Result<(), FileError> {
        let path = self.path.join(name);
        let is_file = !path.is_dir();
        let error = || FileError::new("remove", &path)(ErrorKind::IsADirectory.into());
        is_file.then_some(()).ok_or_else(error)
    }

    /// Removes a file of an earlier build, if there is one.
    fn remove(&self, name: &str) -> Result<(), FileError> {
        let path = self.path.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(FileError::new("remove", &path)(error))
            }
            _ => Ok(()),
        }
    }

    /// Gives files that belong together their names, in their order, and removes those that are `stale`.
    /// The old ones that speak of others go first: a command that is killed leaves files of one set, or
    /// a folder without a report.
    pub fn replace(&self, files: Vec<Staged>, stale: &[&str]) -> Result<(), FileError> {
        stale.iter().try_for_each(|name| self.ensure_removable(name))?;
        let _turn = self.turn();
        for staged in files.iter().rev().filter(|staged| staged.speaks_of_others()) {
            self.remove(staged.name())?;
        }
        files.into_iter().try_for_each(Staged::publish)?;
        stale.iter().try_for_each(|name| self.remove(name))
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
        // No sweep comes between the two.
        let _turn = self.locked(File::lock_shared);
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

    /// Writes a file under a temporary name, down to the disk: a full disk is an error here.
    pub fn stage(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<Staged, FileError> {
        let target = self.path.join(name);
        let run = || -> io::Result<(NamedTempFile, String)> {
            // Renaming would find this out too, when other files have their names already.
            if target.is_dir() {
                return Err(ErrorKind::IsADirectory.into());
            }
            let file = self.temporary()?;
            let hashing = HashingWriter { out: file.as_file(), hash: Sha256::new() };
            let mut out = BufWriter::with_capacity(1 << 20, hashing);
            write(&mut out)?;
            let HashingWriter { hash, .. } =
                out.into_inner().map_err(io::IntoInnerError::into_error)?;
            // File systems may take the bytes now and find no room for them later; and a renamed
            // file must not be empty after a power cut.
            file.as_file().sync_all()?;
            Ok((file, hex(&hash.finalize())))
        };
        let (temporary, sha256) = run().map_err(FileError::new("write", &target))?;
        Ok(Staged { temporary, target, sha256 })
    }
}

impl Staged {
    /// Where it is now.
    pub fn path(&self) -> &Path {
        self.temporary.path()
    }

    /// The name that it will have.
    pub fn name(&self) -> &str {
        self.target.file_name().and_then(|name| name.to_str()).unwrap_or_default()
    }

    /// Whether it ensure_space figures of other files of its set.
    fn speaks_of_others(&self) -> bool {
        [".json", ".html"].iter().any(|end| self.name().ends_with(end))
    }

    /// SHA-256 of what was written, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Its bytes, as they are on the disk now.
    pub fn read(&self) -> Result<Vec<u8>, FileError> {
        std::fs::read(self.path()).map_err(FileError::new("read back", &self.target))
    }

    /// Gives it its own name, replacing what was there.
    pub fn publish(self) -> Result<(), FileError> {
        let Self { temporary, target, .. } = self;
        let published = temporary.persist(&target);
        published.map(drop).map_err(|e| FileError::new("write", &target)(e.error))
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

/// Most bytes of a file that is read: twice those of the most triangles that there may be, as OBJ.
const MOST_BYTES: u64 = 8_000_000_000;

/// Reads a whole file.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    read_at_most(path, MOST_BYTES)
}

/// Reads a whole file, unless it has more bytes than that; then none of them is kept.
pub fn read_at_most(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let run = || -> io::Result<Vec<u8>> {
        let file = File::open(path)?;
        let mut bytes = Vec::new();
        // Devices and pipes have no length.
        let length = file.metadata()?.len();
        if length <= most {
            bytes.try_reserve_exact(length as usize)?;
            file.take(most + 1).read_to_end(&mut bytes)?;
        }
        if length.max(bytes.len() as u64) <= most {
            return Ok(bytes);
        }
        let text = format!("it has more than {most} bytes; is it the right file?");
        Err(io::Error::new(ErrorKind::FileTooLarge, text))
    };
    run().map_err(FileError::new(READ, path))
}

/// Reads a whole file that another file names, as [`read_at_most`] does. Pipes and devices, which may
/// wait or run without end, are for the user alone to name.
pub fn read_named(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    if std::fs::metadata(path).is_ok_and(|facts| !facts.is_file() && !facts.is_dir()) {
        let text = "a file names it, and it is a pipe or a device; name a regular file there";
        return Err(FileError::new(READ, path)(io::Error::new(ErrorKind::InvalidInput, text)));
    }
    read_at_most(path, most)
}

/// Reads a whole file that a file in `folder` names. Unless `outside` is allowed it must be below that
/// folder, wherever links lead.
pub fn read_below(folder: &Path, name: &Path, outside: bool) -> Result<Vec<u8>, FileError> {
    let path = folder.join(name);
    let home = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let is_below = || Ok(path.canonicalize()?.starts_with(home.canonicalize()?));
    if !outside && !is_below().unwrap_or_else(|_: io::Error| is_plain(name)) {
        let text = "a file names it, and it is outside that file's folder; move it there, or give \
                    --allow-outside";
        return Err(FileError::new(READ, &path)(io::Error::new(ErrorKind::PermissionDenied, text)));
    }
    read_named(&path, MOST_BYTES)
}

/// Whether a path leads downwards alone.
fn is_plain(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
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

    fn names(path: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(path).unwrap();
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
    }

    #[cfg(unix)]
    #[test]
    fn what_a_killed_command_left_goes_and_what_another_writes_stays() {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path();
        std::fs::write(path.join(".morion-killed.tmp"), "half a f").unwrap();
        std::fs::write(path.join("morion-mine.tmp"), "").unwrap();
        let folder = Folder::create(path).unwrap();
        assert_eq!(names(path), ["morion-mine.tmp"]);
        let staged = folder.stage("a", |out| out.write_all(b"whole")).unwrap();
        let other = Folder::create(path).unwrap();
        assert_eq!(staged.read().unwrap(), b"whole");
        let turn = folder.turn();
        staged.publish().unwrap();
        drop(turn);
        assert_eq!(std::fs::read(path.join("a")).unwrap(), b"whole");
        let dropped = other.stage("b", |out| out.write_all(b"whole")).unwrap();
        drop(dropped);
        assert_eq!(names(path).len(), 2);
    }

    #[test]
    fn a_file_of_too_many_bytes_is_not_read() {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path().join("file");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read_at_most(&path, 5).unwrap(), b"12345");
        let error = read_at_most(&path, 4).unwrap_err().to_string();
        assert!(
            error.ends_with("file: it has more than 4 bytes; is it the right file?"),
            "{error}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_an_end_is_not_read_to_the_end() {
        assert!(read_at_most(Path::new("/dev/zero"), 1000).is_err());
    }

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
