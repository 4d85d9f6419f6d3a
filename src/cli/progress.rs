//! Progress on stderr: a spinner with the stage on a terminal, one line a stage elsewhere.

use crate::pipeline::{Observer, Stage};
use crate::report::visible;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::time::Duration;

/// Reports stages to stderr, or nothing at all.
pub(super) struct Progress {
    quiet: bool,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Looks at stderr to choose the form.
    pub(super) fn new(quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            bar.set_style(ProgressStyle::default_spinner());
            bar
        });
        Self { quiet, bar }
    }
}

impl Observer for Progress {
    fn begin(&self, stage: Stage) {
        if let Some(bar) = &self.bar {
            bar.reset();
            bar.set_message(stage.name());
            // The bar panics where its thread cannot be started; without one it stands still.
            if std::thread::Builder::new().spawn(|| ()).is_ok() {
                bar.enable_steady_tick(Duration::from_millis(80));
            }
        }
    }

    fn end(&self, stage: Stage, took: Duration, note: &str) {
        if self.quiet {
            return;
        }
        let line = format!("{:8} {:7.1} ms  {note}", stage.name(), took.as_secs_f64() * 1e3);
        let line = visible(&line);
        match &self.bar {
            Some(bar) => {
                bar.disable_steady_tick();
                bar.println(line);
                bar.finish_and_clear();
            }
            // Progress that cannot be shown is not worth failing for.
            None => drop(writeln!(std::io::stderr(), "{line}")),
        }
    }

    fn unchanged(&self, folder: &Path) {
        if !self.quiet {
            let folder = visible(&folder.display().to_string());
            // As above.
            drop(writeln!(
                std::io::stderr(),
                "unchanged  {folder}: profile, program and files are as the last build left them; \
                 --force builds again"
            ));
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
