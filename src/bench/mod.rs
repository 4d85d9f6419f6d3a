//! Run time against error: what each setting costs, and what it brings.

mod design;
mod fit;
mod frames;
mod memory;
mod mesh;
mod milling;
mod plots;
mod profile_edit;
mod results;
mod suggest;
mod trials;
mod witness;

pub use results::{
    BenchReport, BenchRun, BenchSweep, BenchTime, ConvergenceOrder, SCHEMA, SuggestedProgram,
    SuggestedSettings, Suggestion,
};

use crate::design::Design;
use crate::pipeline::{FileError, Observer, SourceError, Stage, StageTimer, designed, load};
use crate::profile::Profile;
use crate::profile::shipped;
use crate::publish::{self, Transaction};
use crate::report::Answer;
use fit::{convergence_order, mark_pareto};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};
use thiserror::Error;

/// A benchmark cannot be run or drawn.
#[derive(Debug, Error)]
pub enum BenchError {
    /// A profile cannot be read.
    #[error(transparent)]
    Profile(#[from] SourceError),
    /// A stage cannot be done.
    #[error(transparent)]
    Stage(Box<crate::pipeline::Error>),
    /// The disk refuses.
    #[error(transparent)]
    File(#[from] FileError),
    /// The pool of one thread cannot be started, or a plot not be drawn.
    #[error("cannot benchmark: {0}")]
    Plot(String),
}

impl From<crate::pipeline::Error> for BenchError {
    fn from(error: crate::pipeline::Error) -> Self {
        Self::Stage(Box::new(error))
    }
}

/// What to sweep.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BenchOptions {
    /// The profiles, as typed; all shipped ones where none is named.
    pub profiles: Vec<String>,
    /// Few settings, one run of each.
    pub quick: bool,
    /// Name the cheapest settings that reach this pixel error, RMS, and write profiles with them.
    pub suggest_px: Option<f64>,
}

/// Runs of each setting, of which the median counts; fewer where they take longer than that.
const RUNS: usize = 5;
const PATIENCE: Duration = Duration::from_millis(1500);

/// A mirror to be swept.
struct Subject {
    named: String,
    profile: Profile,
    design: Design,
}

impl Subject {
    fn name(&self) -> &str {
        &self.profile.name
    }

    /// The bytes of its profile.
    fn text(&self) -> Result<Vec<u8>, BenchError> {
        let known = shipped().iter().find(|profile| profile.name == self.named);
        match known {
            Some(known) if !Path::new(&self.named).is_file() => Ok(known.text.as_bytes().to_vec()),
            _ => Ok(publish::read(Path::new(&self.named))?),
        }
    }
}

/// Sweeps design degree, mesh limits, the witness's rays, Monte Carlo trials, and stepovers of programs; writes `bench.json` and
/// for each sweep a table (CSV) and a plot (SVG, PNG) into `out`/bench, and profiles with the suggested
/// settings beside them.
///
/// # Errors
/// [`BenchError`] when a stage cannot be done or the disk refuses.
pub fn bench(
    out: &Path,
    options: &BenchOptions,
    observer: &dyn Observer,
) -> Result<BenchReport, BenchError> {
    let clock = StageTimer::new(observer);
    let mut files = Transaction::open(&out.join("bench"))?;
    let named: Vec<String> = match options.profiles.is_empty() {
        true => shipped().iter().map(|profile| profile.name.to_owned()).collect(),
        false => options.profiles.clone(),
    };
    let subject = |named: String| {
        let profile = load(&named)?;
        let design = designed(&profile)?;
        Ok::<_, BenchError>(Subject { named, profile, design })
    };
    let subjects: Vec<Subject> = named.into_iter().map(subject).collect::<Result<_, _>>()?;
    let quick = options.quick;
    let swept = |stage: Stage, sweep: &dyn Fn() -> Result<BenchSweep, BenchError>| {
        clock.stage(stage, || {
            let sweep = sweep()?;
            let note = format!("{}: {} runs", sweep.name, sweep.runs.len());
            Ok::<_, BenchError>((sweep, note))
        })
    };
    let mut sweeps = vec![
        swept(Stage::Design, &|| design::sweep(&subjects, quick))?,
        swept(Stage::Mesh, &|| mesh::sweep(&subjects, mesh::GoverningLimit::Facet, quick))?,
        swept(Stage::Mesh, &|| mesh::sweep(&subjects, mesh::GoverningLimit::Chord, quick))?,
        swept(Stage::Trace, &|| witness::sweep(&subjects, quick))?,
        swept(Stage::Trials, &|| trials::sweep(&subjects, quick))?,
        swept(Stage::Trace, &|| frames::sweep(&subjects, quick))?,
        swept(Stage::Plan, &|| Ok(milling::sweep(&subjects, quick)))?,
    ];
    sweeps.iter_mut().for_each(|sweep| mark_pareto(&mut sweep.runs));

    let mut suggestions = Vec::new();
    if let Some(target_px) = options.suggest_px {
        for subject in subjects.iter().filter(|subject| subject.design.view.is_some()) {
            let (mut suggestion, text) = suggest::suggest(subject, &sweeps, target_px)?;
            if let (Some(found), Some(text)) = (&suggestion.settings, text) {
                files.add_bytes(&found.file, text.as_bytes())?;
            }
            suggestion.program = milling::suggest(subject, &sweeps, target_px);
            if let Some(found) = &suggestion.program
                && let Some(text) = milling::edited(&subject.text()?, found)
            {
                files.add_bytes(&found.file, text.as_bytes())?;
            }
            suggestions.push(suggestion);
        }
    }
    let bench = BenchReport { schema: SCHEMA, sweeps, suggestions };
    clock.stage(Stage::Report, || {
        add_files(&bench, &mut files)?;
        files.commit()?;
        Ok::<_, BenchError>(((), files.place()))
    })?;
    Ok(bench)
}

/// Adds each sweep's table and plots, and all as JSON.
fn add_files(bench: &BenchReport, files: &mut Transaction) -> Result<(), BenchError> {
    for sweep in &bench.sweeps {
        let png = sweep.png().map_err(|error| BenchError::Plot(error.to_string()))?;
        let svg = sweep.svg().into_bytes();
        let made = [("csv", sweep.csv().into_bytes()), ("svg", svg), ("png", png)];
        for (ending, bytes) in made {
            let name = format!("{}.{ending}", sweep.name);
            files.add_bytes(&name, &bytes)?;
        }
    }
    files.add_report("bench.json", &bench.json())?;
    Ok(())
}

/// The median time of some runs, after one that is not counted, in ms; and what the first made.
fn timed<T, E>(quick: bool, run: impl Fn() -> Result<T, E>) -> Result<(f64, T), E> {
    let began = Instant::now();
    let made = run()?;
    let mut times = vec![began.elapsed()];
    if !quick {
        times.clear();
        while times.len() < RUNS && (times.is_empty() || began.elapsed() < PATIENCE) {
            let began = Instant::now();
            run()?;
            times.push(began.elapsed());
        }
    }
    times.sort_unstable();
    Ok((1e3 * times[times.len() / 2].as_secs_f64(), made))
}

/// A run of a curve.
fn run(
    (profile, series): (&str, &str),
    setting: f64,
    time_ms: f64,
    error: f64,
    figures: BTreeMap<&'static str, f64>,
) -> BenchRun {
    let (profile, series) = (profile.to_owned(), series.to_owned());
    BenchRun { profile, series, setting, time_ms, error, pareto: false, figures }
}
