//! `morion studio`: a page on this machine in which a profile is changed, and what comes of it is seen.
//!
//! The server listens on 127.0.0.1 alone and answers whoever has its token. It reads no file but the profile that it
//! is opened with and those of its own builds, and writes into one folder.

mod access;
mod build;
mod designs;
mod edit;
mod failure;
mod follow;
mod form;
mod message;
mod page;
mod routes;
mod server;
mod source;
mod view;
mod work_queue;

use crate::parallel;
use crate::pipeline::{ProfileText, SourceError};
use routes::{Studio, Subjects};
use source::tamed;
use std::io::{self, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::Builder;
use tempfile::NamedTempFile;
use thiserror::Error;
use work_queue::{Job, WorkQueue};

/// The folder of profiles and results below that for results.
const FOLDER: &str = "studio";
/// The profile that is opened where none is named.
const FIRST: &str = "conquistador";

/// How the studio is opened.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StudioOptions<'a> {
    /// The first profile, as typed.
    pub profile: Option<&'a str>,
    /// Folder for results.
    pub out: &'a Path,
    /// Port of 127.0.0.1; 0 for one that is free.
    pub port: u16,
    /// Whether the page is opened in a browser.
    pub opens: bool,
}

/// Why there is no studio.
#[derive(Debug, Error)]
pub(crate) enum StudioError {
    /// There is no profile, or it has faults.
    #[error(transparent)]
    Source(#[from] SourceError),
    /// The profile names a file.
    #[error("{named}: {sentence}")]
    Files {
        /// As typed.
        named: String,
        /// Which key, and what to do.
        sentence: String,
    },
    /// The system refuses to listen, or a thread.
    #[error("cannot listen on port {port} of 127.0.0.1: {source}; choose another --port")]
    Listen {
        /// The port asked for.
        port: u16,
        /// Why.
        source: io::Error,
    },
}

/// The studio of this process, once it is opened.
static OPENED: OnceLock<Arc<Studio>> = OnceLock::new();

/// Ends the build that goes on, if there is one, and starts no other: for the end of the program.
pub(crate) fn end_build() {
    if let Some(studio) = OPENED.get() {
        studio.end();
    }
}

/// Opens the studio, tells its address, and answers requests until the program is ended.
///
/// # Errors
/// [`StudioError`] when it cannot be opened.
pub(crate) fn serve(options: &StudioOptions, tell: impl FnOnce(&str)) -> Result<(), StudioError> {
    let StudioOptions { out, port, opens, .. } = *options;
    let named = options.profile.unwrap_or(FIRST);
    let found = ProfileText::find(named)?;
    if let Some(key) = view::named_file(&found.checked()?) {
        let sentence = view::files_refused(key);
        return Err(StudioError::Files { named: named.to_owned(), sentence });
    }
    let text = String::from_utf8_lossy(&found.bytes).into_owned();
    let (quick, quick_jobs) = WorkQueue::new();
    let (beside, beside_jobs) = WorkQueue::new();
    let (slow, slow_jobs) = WorkQueue::new();
    let studio = Arc::new(Studio {
        first: [tamed(&found.name), text],
        folder: out.join(FOLDER),
        quick,
        beside,
        slow,
        designs: Arc::default(),
        subjects: Subjects::default(),
        build: Mutex::new(None),
        opening: Mutex::new(None),
    });
    // A program has one studio.
    let _ = OPENED.set(Arc::clone(&studio));
    let refused = |source| StudioError::Listen { port, source };
    let threads = parallel::threads();
    let work = move |jobs: Receiver<Job>| {
        parallel::within(Some(threads), move || jobs.into_iter().for_each(|job| job()));
    };
    let thread = |name: &str| Builder::new().name(name.to_owned());
    thread("beside").spawn(move || work(beside_jobs)).map_err(refused)?;
    let giving_way = move || {
        give_way();
        work(slow_jobs);
    };
    thread("slow").spawn(giving_way).map_err(refused)?;
    let (_listening, address) = server::listen(Arc::clone(&studio), port).map_err(refused)?;
    tell(&address);
    if opens {
        let page = open(&address, &studio.folder).ok();
        *studio.opening.lock().unwrap_or_else(PoisonError::into_inner) = page;
    }
    // On this thread, which is of the pool.
    quick_jobs.iter().for_each(|job| job());
    Ok(())
}

/// Lets other threads go before this one and those that it starts, so that what follows a slider does not wait for
/// what may take longer.
fn give_way() {
    /// The largest value that Linux knows. There it is of this thread alone; elsewhere it would be of the whole program.
    #[cfg(target_os = "linux")]
    const NICE: i32 = 19;
    // (Where it is refused, all go alike.)
    #[cfg(target_os = "linux")]
    let _ = rustix::process::setpriority_process(None, NICE);
}

/// Opens an address in the user's browser by a page in `folder` that only the user can read: other users see the
/// arguments of programs. Where there is no browser, the address is on the terminal.
fn open(address: &str, folder: &Path) -> io::Result<NamedTempFile> {
    std::fs::create_dir_all(folder)?;
    let mut page = tempfile::Builder::new().prefix("open-").suffix(".html").tempfile_in(folder)?;
    let refresh = format!("<meta http-equiv=\"refresh\" content=\"0; url={address}\">");
    writeln!(page, "<!doctype html><title>Morion studio</title>{refresh}")?;
    let mut command = Command::new(match std::env::consts::OS {
        "macos" => "open",
        "windows" => "explorer",
        _ => "xdg-open",
    });
    command.arg(page.path().canonicalize()?);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    Ok(page)
}
