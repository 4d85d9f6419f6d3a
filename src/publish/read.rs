//! Files as a whole: of bounded length, and named by the user or by another file.

use super::FileError;
use super::error::READ;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

/// Most bytes of a file that is read: twice those of the most triangles that there may be, as OBJ.
const MOST_BYTES: u64 = 8_000_000_000;

/// Reads a whole file.
///
/// # Errors
/// [`FileError`] when it cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>, FileError> {
    read_at_most(path, MOST_BYTES)
}

/// Reads a whole file, unless it has more bytes than that; then none of them is kept.
///
/// # Errors
/// [`FileError`] when it cannot be read, or is longer.
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
///
/// # Errors
/// [`FileError`] when it cannot be read, is longer, or is no regular file.
pub fn read_named(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    if std::fs::metadata(path).is_ok_and(|facts| !facts.is_file() && !facts.is_dir()) {
        let text = "a file names it, and it is a pipe or a device; name a regular file there";
        return Err(FileError::new(READ, path)(io::Error::new(ErrorKind::InvalidInput, text)));
    }
    read_at_most(path, most)
}

/// Reads a whole file that a file in `folder` names. Unless `outside` is allowed it must be below that
/// folder, wherever links lead.
///
/// # Errors
/// [`FileError`] as of [`read_named`], and for a file elsewhere.
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

/// Paths of the files of a folder, in no order; folders in it are left out.
///
/// # Errors
/// [`FileError`] when it cannot be read.
pub fn files_of(folder: &Path) -> Result<Vec<PathBuf>, FileError> {
    let run = || -> io::Result<Vec<PathBuf>> {
        let paths = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
        paths.filter(|path| !path.as_ref().is_ok_and(|path| path.is_dir())).collect()
    };
    run().map_err(FileError::new(READ, folder))
}

/// Whether a path leads downwards alone.
fn is_plain(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
