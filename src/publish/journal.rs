//! A journal: lines that are on the disk as soon as they are known, for work that goes on where it ended.

use super::FileError;
use super::error::READ;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The journal that this process is writing, and the lines that it has added.
static UNDER_WAY: Mutex<Option<(PathBuf, u64)>> = Mutex::new(None);

/// A file of lines to which one process at a time adds.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
}

impl Journal {
    /// Opens the journal at `path`, which is made where it is not there. A last line without an end, as a killed
    /// process may leave it, is cut off.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be written to, or another process writes into it.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let run = || -> io::Result<File> {
            let mut options = OpenOptions::new();
            let mut file = options.read(true).append(true).create(true).open(path)?;
            // Where files cannot be locked, nothing tells another process.
            if let Err(TryLockError::WouldBlock) = file.try_lock() {
                let text = "another sweep of this study writes into it; wait until that has ended, or give each \
                            its own --shard";
                return Err(io::Error::new(ErrorKind::WouldBlock, text));
            }
            let whole = whole_lines(&mut file)?;
            file.set_len(whole)?;
            Ok(file)
        };
        let file = run().map_err(FileError::new("write", path))?;
        *UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner) = Some((path.to_owned(), 0));
        Ok(Self { file, path: path.to_owned() })
    }

    /// Adds a line, which has no end of a line itself.
    ///
    /// # Errors
    /// [`FileError`] when the disk refuses.
    pub fn add(&mut self, line: &str) -> Result<(), FileError> {
        // In one call, so that a process that is killed between calls leaves whole lines.
        let line = format!("{line}\n");
        self.file.write_all(line.as_bytes()).map_err(FileError::new("write", &self.path))?;
        if let Some((_, added)) = &mut *UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner) {
            *added += 1;
        }
        Ok(())
    }

    /// Ends it, once all of its lines are on the disk.
    ///
    /// # Errors
    /// [`FileError`] when the disk refuses.
    pub fn close(self) -> Result<(), FileError> {
        *UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.file.sync_all().map_err(FileError::new("write", &self.path))
    }
}

/// The number of bytes up to the end of the last whole line.
fn whole_lines(file: &mut File) -> io::Result<u64> {
    let mut length = file.metadata()?.len();
    let mut piece = Vec::new();
    while length > 0 {
        let from = length.saturating_sub(1 << 16);
        file.seek(SeekFrom::Start(from))?;
        piece.clear();
        (&mut *file).take(length - from).read_to_end(&mut piece)?;
        if let Some(end) = piece.iter().rposition(|byte| *byte == b'\n') {
            return Ok(from + end as u64 + 1);
        }
        length = from;
    }
    Ok(0)
}

/// The whole lines of the journal at `path`, as far as they are text; what follows the last of them is still being
/// written, or was left by a killed process.
///
/// # Errors
/// [`FileError`] when it cannot be read.
pub fn journal_lines(path: &Path) -> Result<Vec<String>, FileError> {
    let mut file = File::open(path).map_err(FileError::new(READ, path))?;
    let whole = whole_lines(&mut file).map_err(FileError::new(READ, path))?;
    let mut bytes = Vec::new();
    let mut run = || -> io::Result<usize> {
        file.seek(SeekFrom::Start(0))?;
        (&mut file).take(whole).read_to_end(&mut bytes)
    };
    run().map_err(FileError::new(READ, path))?;
    let lines = bytes.split(|byte| *byte == b'\n');
    Ok(lines.filter_map(|line| Some(std::str::from_utf8(line).ok()?.to_owned())).collect())
}

/// What a signal leaves of a journal: its path and the lines that this process has added; none where there is no
/// journal.
pub fn journal_under_way() -> Option<(PathBuf, u64)> {
    UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_was_cut_off_goes_and_whole_ones_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        for left in ["", "half a li"] {
            std::fs::write(&path, format!("first\nsecond\n{left}")).unwrap();
            assert_eq!(journal_lines(&path).unwrap(), ["first", "second", ""]);
            let mut journal = Journal::open(&path).unwrap();
            journal.add("third").unwrap();
            journal.close().unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), "first\nsecond\nthird\n");
        }
        // One that is longer than a piece of reading, and nothing but a cut line.
        let long = "x".repeat(200_000);
        for (text, whole) in
            [(format!("a\n{long}"), 2), (long.clone(), 0), (format!("{long}\n"), 200_001)]
        {
            std::fs::write(&path, text).unwrap();
            Journal::open(&path).unwrap().close().unwrap();
            assert_eq!(std::fs::metadata(&path).unwrap().len(), whole);
        }
    }

    #[cfg(unix)]
    #[test]
    fn two_at_once_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("journal");
        let first = Journal::open(&path).unwrap();
        let refused = Journal::open(&path).unwrap_err().to_string();
        assert!(refused.contains("--shard"), "{refused}");
        first.close().unwrap();
        assert!(Journal::open(&path).is_ok());
    }
}
