//! The files of one command: each is written under a temporary name, and all get their own names at once.

use super::folder::{Folder, TemporaryFolder};
use super::{FileError, HashingWriter, sha256};
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::thread::{Builder, JoinHandle};
use tempfile::NamedTempFile;

/// Files of one command, published together or not at all.
///
/// It is opened before any work, so that a folder that cannot be written to is refused at once. Dropped
/// without a [`Transaction::commit`] it leaves the folder as it was.
#[derive(Debug)]
pub struct Transaction {
    /// Where they go; none: memory.
    folder: Option<Folder>,
    staged: Vec<StagedFile>,
    /// The file that speaks of all others: it is published last.
    report: Option<StagedFile>,
    /// Files of earlier commands that must not stay beside these.
    stale: Vec<String>,
    /// The files that were committed to memory.
    committed: Vec<OutputFile>,
    /// Where files are of which there are many, until they are published.
    many: Option<TemporaryFolder>,
}

/// A file in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputFile {
    /// Name in the folder that it would have been published in.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// A file that is whole, but not published yet.
#[derive(Debug)]
pub struct StagedFile {
    name: String,
    sha256: String,
    content: Content,
    /// The thread that synchronises it to the disk.
    synchronised: Option<JoinHandle<io::Result<()>>>,
}

#[derive(Debug)]
enum Content {
    /// Under a temporary name beside the one that it will have.
    Temporary(NamedTempFile, PathBuf),
    /// In a temporary folder; and the name that it will have.
    OneOfMany(PathBuf, PathBuf),
    Memory(Vec<u8>),
}

impl Content {
    /// Where it is on the disk, and where it will be; or else its bytes.
    fn paths(&self) -> Result<[&Path; 2], &[u8]> {
        match self {
            Self::Temporary(file, target) => Ok([file.path(), target]),
            Self::OneOfMany(path, target) => Ok([path, target]),
            Self::Memory(bytes) => Err(bytes),
        }
    }
}

impl Transaction {
    /// A transaction in the folder `path`, which is made if need be, with a write tried in it.
    ///
    /// # Errors
    /// [`FileError`] when the folder cannot be made or written to.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let mut files = Self::in_memory();
        files.folder = Some(Folder::create(path)?);
        Ok(files)
    }

    /// A transaction whose files stay in memory.
    pub fn in_memory() -> Self {
        let (staged, stale, committed) = (Vec::new(), Vec::new(), Vec::new());
        Self { folder: None, staged, report: None, stale, committed, many: None }
    }

    /// The folder; none in memory.
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_ref().map(Folder::path)
    }

    /// The place of the files, in words.
    pub fn place(&self) -> String {
        self.folder().map_or("memory".to_owned(), |path| path.display().to_string())
    }

    /// Where a file of this name is published; its bare name in memory.
    pub fn path_of(&self, name: &str) -> PathBuf {
        self.folder().map_or(PathBuf::from(name), |folder| folder.join(name))
    }

    /// Bytes that are free on the disk, as far as is known.
    pub fn free(&self) -> Option<u64> {
        self.folder.as_ref()?.free()
    }

    /// Makes sure of room for so many bytes. Where that is not known, there is.
    ///
    /// # Errors
    /// [`FileError`] when there is none.
    pub fn ensure_space(&self, bytes: u64) -> Result<(), FileError> {
        self.folder.as_ref().map_or(Ok(()), |folder| folder.ensure_space(bytes))
    }

    /// Adds the file that `write` makes. A full disk is an error here, or of [`Self::commit`], which waits until
    /// all bytes are on the disk.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be written.
    pub fn add(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<&StagedFile, FileError> {
        let staged = StagedFile::new(self.folder.as_ref(), name, write)?;
        self.staged.push(staged);
        Ok(&self.staged[self.staged.len() - 1])
    }

    /// Adds a file with these bytes.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be written.
    pub fn add_bytes(&mut self, name: &str, bytes: &[u8]) -> Result<&StagedFile, FileError> {
        self.add(name, |out| out.write_all(bytes))
    }

    /// Adds one of many files with these bytes, which are on the disk then: nothing is kept open for it.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be written.
    pub fn add_of_many(&mut self, name: &str, bytes: &[u8]) -> Result<&StagedFile, FileError> {
        let Some(folder) = &self.folder else { return self.add_bytes(name, bytes) };
        let target = folder.path().join(name);
        let mut run = || -> io::Result<Content> {
            if target.is_dir() {
                return Err(ErrorKind::IsADirectory.into());
            }
            if self.many.is_none() {
                self.many = Some(folder.temporary_folder()?);
            }
            let path = self.many.as_ref().ok_or(ErrorKind::NotFound)?.path().join(name);
            let mut file = File::create(&path)?;
            file.write_all(bytes)?;
            file.sync_all()?;
            Ok(Content::OneOfMany(path, target.clone()))
        };
        let content = run().map_err(FileError::new("write", &target))?;
        let (name, sha256) = (name.to_owned(), sha256(bytes));
        self.staged.push(StagedFile { name, sha256, content, synchronised: None });
        Ok(&self.staged[self.staged.len() - 1])
    }

    /// Adds the file that speaks of all others, to be published last: where it is new, they are.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be written.
    pub fn add_report(&mut self, name: &str, text: &str) -> Result<&StagedFile, FileError> {
        let write = |out: &mut dyn Write| out.write_all(text.as_bytes());
        let staged = StagedFile::new(self.folder.as_ref(), name, write)?;
        Ok(self.report.insert(staged))
    }

    /// Takes a file out again.
    pub fn withdraw(&mut self, name: &str) {
        self.staged.retain(|staged| staged.name != name);
    }

    /// Removes a file of earlier commands on commit, if there is one.
    pub fn remove(&mut self, name: &str) {
        self.stale.push(name.to_owned());
    }

    /// The files added so far, the report last.
    pub fn files(&self) -> impl Iterator<Item = &StagedFile> {
        self.staged.iter().chain(&self.report)
    }

    /// The file with this name.
    ///
    /// # Errors
    /// [`FileError`] when none was added.
    pub fn staged(&self, name: &str) -> Result<&StagedFile, FileError> {
        let missing =
            || FileError::new("read back", &self.path_of(name))(ErrorKind::NotFound.into());
        self.files().find(|staged| staged.name == name).ok_or_else(missing)
    }

    /// Gives all files their names, in the order in which they were added, and removes the stale ones.
    /// Old ones that speak of others go first: a command that is killed leaves files of one set, or a
    /// folder without a report.
    ///
    /// # Errors
    /// [`FileError`] when the disk refuses.
    pub fn commit(&mut self) -> Result<(), FileError> {
        self.staged.iter_mut().chain(&mut self.report).try_for_each(StagedFile::synchronise)?;
        let files: Vec<StagedFile> = self.staged.drain(..).chain(self.report.take()).collect();
        let stale = std::mem::take(&mut self.stale);
        let Some(folder) = &self.folder else {
            self.committed.extend(files.into_iter().filter_map(StagedFile::into_memory));
            return Ok(());
        };
        stale.iter().try_for_each(|name| folder.ensure_removable(name))?;
        let _lock = folder.lock();
        // (One that is alone speaks of nothing that changes.)
        if files.len() > 1 {
            for staged in files.iter().rev().filter(|staged| staged.speaks_of_others()) {
                folder.remove(&staged.name)?;
            }
        }
        files.into_iter().try_for_each(StagedFile::publish)?;
        self.many = None;
        stale.iter().try_for_each(|name| folder.remove(name))
    }

    /// The files that were committed to memory.
    pub fn into_files(mut self) -> Vec<OutputFile> {
        std::mem::take(&mut self.committed)
    }
}

impl Drop for Transaction {
    /// Leaves no new folder without a file.
    fn drop(&mut self) {
        self.staged.clear();
        self.report = None;
        self.many = None;
        if let Some(folder) = &self.folder {
            folder.remove_unused();
        }
    }
}

/// Synchronises a file to the disk, on a thread of its own if one can be started: for the disk the processor need
/// not wait. File systems may take the bytes of a file and find no room for them later; and a renamed file must
/// not be empty after a power cut.
fn synchronise(file: &File) -> io::Result<Option<JoinHandle<io::Result<()>>>> {
    /// Bytes of its stack: what it needs is little, and memory may be short.
    const STACK: usize = 1 << 16;
    let spawn = |own: File| Builder::new().stack_size(STACK).spawn(move || own.sync_all());
    match file.try_clone().and_then(spawn) {
        Ok(thread) => Ok(Some(thread)),
        Err(_) => file.sync_all().map(|()| None),
    }
}

impl StagedFile {
    fn new(
        folder: Option<&Folder>,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<Self, FileError> {
        let target = folder.map_or(PathBuf::from(name), |folder| folder.path().join(name));
        let run = || -> io::Result<(Content, String, Option<_>)> {
            let Some(folder) = folder else {
                let mut bytes = Vec::new();
                let mut out = HashingWriter::new(&mut bytes);
                write(&mut out)?;
                let sha256 = out.sha256();
                return Ok((Content::Memory(bytes), sha256, None));
            };
            // Renaming would find this out too, when other files have their names already.
            if target.is_dir() {
                return Err(ErrorKind::IsADirectory.into());
            }
            let file = folder.temporary()?;
            let hashing = HashingWriter::new(file.as_file());
            let mut out = BufWriter::with_capacity(1 << 20, hashing);
            write(&mut out)?;
            let hashing = out.into_inner().map_err(io::IntoInnerError::into_error)?;
            let sha256 = hashing.sha256();
            let synchronised = synchronise(file.as_file())?;
            Ok((Content::Temporary(file, target.clone()), sha256, synchronised))
        };
        let (content, sha256, synchronised) = run().map_err(FileError::new("write", &target))?;
        Ok(Self { name: name.to_owned(), sha256, content, synchronised })
    }

    /// Waits until all of its bytes are on the disk.
    fn synchronise(&mut self) -> Result<(), FileError> {
        let (Some(thread), Content::Temporary(_, target)) =
            (self.synchronised.take(), &self.content)
        else {
            return Ok(());
        };
        let done = thread.join().unwrap_or_else(|_| Err(ErrorKind::Other.into()));
        done.map_err(FileError::new("write", target))
    }

    /// Where it is now; none in memory.
    pub fn path(&self) -> Option<&Path> {
        self.content.paths().ok().map(|[path, _]| path)
    }

    /// The name that it will have.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// SHA-256 of what was written, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Its bytes, as they are on the disk now.
    ///
    /// # Errors
    /// [`FileError`] when they cannot be read.
    pub fn read(&self) -> Result<Vec<u8>, FileError> {
        match self.content.paths() {
            Ok([path, target]) => std::fs::read(path).map_err(FileError::new("read back", target)),
            Err(bytes) => Ok(bytes.to_vec()),
        }
    }

    /// Its bytes as [`Self::read`] has them, to be read one after the other.
    ///
    /// # Errors
    /// [`FileError`] when it cannot be opened.
    pub fn open(&self) -> Result<Box<dyn Read + Send + '_>, FileError> {
        match self.content.paths() {
            Ok([path, target]) => match File::open(path) {
                Ok(file) => Ok(Box::new(file)),
                Err(error) => Err(FileError::new("read back", target)(error)),
            },
            Err(bytes) => Ok(Box::new(bytes)),
        }
    }

    /// That it cannot be read back.
    pub fn unreadable(&self, error: io::Error) -> FileError {
        let place = self.content.paths().map_or(Path::new(&self.name), |[_, target]| target);
        FileError::new("read back", place)(error)
    }

    /// Whether it holds figures of other files of its set.
    fn speaks_of_others(&self) -> bool {
        [".json", ".html"].iter().any(|end| self.name.ends_with(end))
    }

    /// Gives it its own name, replacing what was there.
    fn publish(self) -> Result<(), FileError> {
        match self.content {
            Content::Temporary(file, target) => file
                .persist(&target)
                .map(drop)
                .map_err(|e| FileError::new("write", &target)(e.error)),
            Content::OneOfMany(path, target) => {
                std::fs::rename(path, &target).map_err(FileError::new("write", &target))
            }
            Content::Memory(_) => Ok(()),
        }
    }

    fn into_memory(self) -> Option<OutputFile> {
        let Content::Memory(bytes) = self.content else { return None };
        Some(OutputFile { name: self.name, bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut files = Transaction::open(path).unwrap();
        assert_eq!(names(path), ["morion-mine.tmp"]);
        files.add_bytes("a", b"whole").unwrap();
        let mut other = Transaction::open(path).unwrap();
        assert_eq!(files.files().next().unwrap().read().unwrap(), b"whole");
        files.commit().unwrap();
        assert_eq!(std::fs::read(path.join("a")).unwrap(), b"whole");
        other.add_bytes("b", b"whole").unwrap();
        drop(other);
        assert_eq!(names(path).len(), 2);
    }

    #[test]
    fn many_files_wait_in_a_folder_of_their_own() {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path();
        let mut files = Transaction::open(path).unwrap();
        for k in 0..3 {
            files.add_of_many(&format!("{k}.png"), &[k; 5]).unwrap();
        }
        assert_eq!(files.staged("2.png").unwrap().read().unwrap(), [2; 5]);
        assert_eq!(names(path).len(), 1);
        // Another command leaves them alone.
        drop(Transaction::open(path).unwrap());
        files.commit().unwrap();
        let mut left = names(path);
        left.sort();
        assert_eq!(left, ["0.png", "1.png", "2.png"]);
        let mut failed = Transaction::open(&path.join("new")).unwrap();
        failed.add_of_many("0.png", b"half").unwrap();
        drop(failed);
        assert_eq!(names(path).len(), 3);
    }

    #[cfg(unix)]
    #[test]
    fn the_folder_of_a_killed_command_goes() {
        let temporary = tempfile::tempdir().unwrap();
        let left = temporary.path().join(".morion-killed.tmp");
        std::fs::create_dir(&left).unwrap();
        std::fs::write(left.join("0.png"), "half a f").unwrap();
        Transaction::open(temporary.path()).unwrap();
        assert!(names(temporary.path()).is_empty());
    }

    #[test]
    fn the_report_is_last_and_stale_files_go_with_the_commit() {
        let temporary = tempfile::tempdir().unwrap();
        let path = temporary.path();
        std::fs::write(path.join("old.stl"), "old").unwrap();
        let mut files = Transaction::open(path).unwrap();
        files.add_report("report.json", "{}").unwrap();
        files.add_bytes("picture.png", b"pixels").unwrap();
        files.add_bytes("made.for.the.rays", b"alone").unwrap();
        files.withdraw("made.for.the.rays");
        files.remove("old.stl");
        files.remove("never.there");
        let order: Vec<&str> = files.files().map(StagedFile::name).collect();
        assert_eq!(order, ["picture.png", "report.json"]);
        assert_eq!(std::fs::read(path.join("old.stl")).unwrap(), b"old");
        files.commit().unwrap();
        let mut left = names(path);
        left.sort();
        assert_eq!(left, ["picture.png", "report.json"]);
    }

    #[test]
    fn files_in_memory_are_those_of_a_folder() {
        let temporary = tempfile::tempdir().unwrap();
        let mut both = [Transaction::open(temporary.path()).unwrap(), Transaction::in_memory()];
        for files in &mut both {
            files.add_bytes("a", b"first").unwrap();
            files.add_report("b.json", "{}").unwrap();
        }
        let hashes = both.each_ref().map(|files| {
            files.files().map(|file| file.sha256().to_owned()).collect::<Vec<String>>()
        });
        assert_eq!(hashes[0], hashes[1]);
        let [mut on_disk, mut in_memory] = both;
        on_disk.commit().unwrap();
        in_memory.commit().unwrap();
        for OutputFile { name, bytes } in in_memory.into_files() {
            assert_eq!(std::fs::read(temporary.path().join(name)).unwrap(), bytes);
        }
    }
}
