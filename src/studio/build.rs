//! Builds, each by the program itself in a process of its own, which can be ended without harm.

use super::failure::RequestFailure;
use crate::parallel;
use crate::publish::Transaction;
use serde_json::{Value as Json, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
#[cfg(unix)]
use std::time::Duration;

/// Bytes of a process's output that are kept: reports have some thousands.
const MOST_BYTES: usize = 4 << 20;
/// How long a build may take to remove what it was writing.
#[cfg(unix)]
const PATIENCE: Duration = Duration::from_secs(5);
/// The file that lists the others of a build.
const RECORD: &str = "timings.json";

/// What a process has written so far.
type Written = Arc<Mutex<String>>;

/// The last build.
#[derive(Debug)]
pub(super) struct Build {
    name: String,
    folder: PathBuf,
    child: Child,
    progress: Written,
    answer: Written,
    readers: Vec<JoinHandle<()>>,
    is_cancelled: bool,
    end: Option<End>,
}

/// What came of a build.
#[derive(Debug)]
struct End {
    code: Option<i32>,
    files: Vec<String>,
}

impl Build {
    /// Starts the build of the profile `text`, which is written as `NAME.toml` into `folder`, as are its results into
    /// `folder/NAME`.
    ///
    /// # Errors
    /// [`RequestFailure`] when the text cannot be written or the process not be started.
    pub(super) fn start(name: &str, text: &str, folder: &Path) -> Result<Self, RequestFailure> {
        let file = format!("{name}.toml");
        let mut files = Transaction::open(folder)?;
        files.add_bytes(&file, text.as_bytes())?;
        files.commit()?;
        let mut command = Command::new(std::env::current_exe()?);
        command.arg("--threads").arg(parallel::threads().to_string()).arg("build");
        command.arg(folder.join(file)).arg("--out").arg(folder).args(["--format", "json"]);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn()?;
        let (progress, answer) = (Written::default(), Written::default());
        let readers = [
            child.stderr.take().map(|pipe| reader(Box::new(pipe), &progress)),
            child.stdout.take().map(|pipe| reader(Box::new(pipe), &answer)),
        ];
        let readers = readers.into_iter().flatten().collect::<Result<_, _>>()?;
        let (name, folder) = (name.to_owned(), folder.join(name));
        let is_cancelled = false;
        Ok(Self { name, folder, child, progress, answer, readers, is_cancelled, end: None })
    }

    /// Whether it goes on.
    pub(super) fn is_running(&mut self) -> bool {
        if self.end.is_none()
            && let Ok(Some(status)) = self.child.try_wait()
        {
            self.readers.drain(..).for_each(|reader| drop(reader.join()));
            self.end = Some(End { code: status.code(), files: files(&self.folder) });
        }
        self.end.is_none()
    }

    /// How far it is, and what came of it.
    pub(super) fn status(&mut self) -> Json {
        let is_running = self.is_running();
        let lines = written(&self.progress);
        let lines: Vec<&str> = lines.lines().collect();
        let answer = written(&self.answer);
        let first =
            || answer.lines().next().and_then(|line| serde_json::from_str::<Json>(line).ok());
        let code = self.end.as_ref().and_then(|end| end.code);
        let (state, report) = match code {
            _ if is_running => ("running", None),
            Some(0 | 1) => ("done", serde_json::from_str::<Json>(&answer).ok()),
            _ if self.is_cancelled => ("cancelled", None),
            _ => ("failed", first()),
        };
        let of_report = |key: &str| report.as_ref().and_then(|report| report.get(key));
        json!({
            "state": state,
            "name": self.name,
            "lines": lines,
            "verdict": of_report("verdict"),
            "reasons": of_report("reasons"),
            "error": of_report("error"),
            "files": if state == "done" { self.files() } else { &[] },
        })
    }

    /// Ends it, if it goes on; it removes what it was writing.
    pub(super) fn cancel(&mut self) {
        if !self.is_running() {
            return;
        }
        self.is_cancelled = true;
        #[cfg(unix)]
        self.terminate();
        if self.is_running() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }

    /// Asks the process to end, and waits for it to do so.
    #[cfg(unix)]
    fn terminate(&mut self) {
        let process = rustix::process::Pid::from_child(&self.child);
        // (One that has ended by itself is found out below.)
        let _ = rustix::process::kill_process(process, rustix::process::Signal::TERM);
        let began = std::time::Instant::now();
        while began.elapsed() < PATIENCE && self.is_running() {
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Names of the files that it left.
    fn files(&self) -> &[String] {
        self.end.as_ref().map_or(&[], |end| &end.files)
    }

    /// A file of the build by its exact name.
    ///
    /// # Errors
    /// [`RequestFailure`] where there is none.
    pub(super) fn open(&self, name: &str) -> Result<File, RequestFailure> {
        let known = self.files().iter().find(|known| *known == name);
        let missing = || RequestFailure::said(404, "the last build has no file of this name");
        Ok(File::open(self.folder.join(known.ok_or_else(missing)?))?)
    }
}

impl Drop for Build {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// A thread that reads a pipe to its end.
fn reader(pipe: Box<dyn Read + Send>, text: &Written) -> std::io::Result<JoinHandle<()>> {
    let text = Arc::clone(text);
    Builder::new().name("build".to_owned()).spawn(move || {
        for line in BufReader::new(pipe).split(b'\n').map_while(Result::ok) {
            let mut text = written(&text);
            if text.len() + line.len() <= MOST_BYTES {
                *text += &String::from_utf8_lossy(&line);
                text.push('\n');
            }
        }
    })
}

fn written(text: &Written) -> MutexGuard<'_, String> {
    text.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Names of the files that the last build in `folder` left, as its record lists them, and the record's own.
fn files(folder: &Path) -> Vec<String> {
    let record = std::fs::read(folder.join(RECORD)).unwrap_or_default();
    let record: Json = serde_json::from_slice(&record).unwrap_or_default();
    let outputs = record["outputs"].as_array().into_iter().flatten();
    let names = outputs.filter_map(|output| Some(output["name"].as_str()?.to_owned()));
    let is_plain = |name: &String| Path::new(name).file_name().is_some_and(|own| own == &**name);
    let mut names: Vec<String> = names.filter(is_plain).collect();
    if !names.is_empty() {
        names.push(RECORD.to_owned());
    }
    names
}
