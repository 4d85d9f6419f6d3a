//! Calls that take long: on a thread of their own, without the interpreter's lock, with progress, and ended by an interrupt.

use crate::errors;
use morion::{Observer, Stage};
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// Time between two questions whether the user interrupts.
const ASK: Duration = Duration::from_millis(50);
/// Stack of the thread, bytes: that of a program's first thread.
const STACK: usize = 8 << 20;

/// Observer of a call: it hands stages on to Python, and wants the call to end after an interrupt.
pub(crate) struct Watch {
    /// Called with a stage's name, its run time in seconds (`None` at its beginning), and a note.
    progress: Option<Py<PyAny>>,
    is_stopped: AtomicBool,
    /// What the callable raised.
    raised: Mutex<Option<PyErr>>,
}

impl Watch {
    fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Runs a stage that has no observer of its own.
    pub(crate) fn stage<T>(&self, stage: Stage, work: impl FnOnce() -> T) -> T {
        self.begin(stage);
        let start = Instant::now();
        let value = work();
        self.end(stage, start.elapsed(), "");
        value
    }

    fn tell(&self, stage: Stage, took: Option<Duration>, note: &str) {
        let Some(progress) = self.progress.as_ref().filter(|_| !self.is_stopped()) else { return };
        let seconds = took.map(|took| took.as_secs_f64());
        // (None where the interpreter ends.)
        let told = Python::try_attach(|py| progress.call1(py, (stage.name(), seconds, note)));
        if let Some(Err(error)) = told {
            self.stop();
            if let Ok(mut raised) = self.raised.lock() {
                *raised = Some(error);
            }
        }
    }
}

impl Observer for Watch {
    fn begin(&self, stage: Stage) {
        self.tell(stage, None, "");
    }

    fn end(&self, stage: Stage, took: Duration, note: &str) {
        self.tell(stage, Some(took), note);
    }

    fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }
}

/// The value of `work`, done on a thread of its own without the interpreter's lock. A signal's exception (`KeyboardInterrupt`) ends the
/// call at once; the thread then ends with the stage that it is in, and publishes nothing.
///
/// # Errors
/// `MorionError` with what `work` says, that of a signal, and that of `progress`.
pub(crate) fn long_call<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T, String> + Send + 'static,
) -> PyResult<T> {
    let watch = Watch { progress, is_stopped: AtomicBool::new(false), raised: Mutex::default() };
    let watch = Arc::new(watch);
    let (send, receive) = channel();
    let seen = Arc::clone(&watch);
    let job = move || {
        let _ = send.send(work(&seen));
    };
    Builder::new()
        .name("morion".to_owned())
        .stack_size(STACK)
        .spawn(job)
        .map_err(|error| errors::error(py, &format!("no thread can be started: {error}")))?;
    let done = wait(py, &watch, receive)?;
    let raised = watch.raised.lock().ok().and_then(|mut raised| raised.take());
    match raised {
        Some(error) => Err(error),
        None => done.map_err(|message| errors::error(py, &message)),
    }
}

fn wait<T: Send>(
    py: Python<'_>,
    watch: &Watch,
    mut receive: Receiver<Result<T, String>>,
) -> PyResult<Result<T, String>> {
    loop {
        let done;
        (done, receive) = py.detach(move || (receive.recv_timeout(ASK), receive));
        match done {
            Ok(done) => return Ok(done),
            Err(RecvTimeoutError::Timeout) => py.check_signals().inspect_err(|_| watch.stop())?,
            Err(RecvTimeoutError::Disconnected) => {
                return Ok(Err("a fault of morion ended the call: please report it".to_owned()));
            }
        }
    }
}
