//! Run time against error: what each setting costs, and what it brings.

mod design;
mod fit;
mod mesh;
mod suggest;
mod trials;
mod witness;

use super::files::{self, Folder};
use super::observer::{Clock, Observer, Stage};
use super::source::{Source, load};
use super::{Error, designed};
use crate::design::Design;
use crate::profile::shipped;
use crate::report::{Bench, Run, Sweep};
use fit::{mark_pareto, order};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// What to sweep.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Benching {
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
    source: Source,
    design: Design,
}

impl Subject {
    fn name(&self) -> &str {
        &self.source.profile.name
    }

    /// The bytes of its profile.
    fn text(&self) -> Result<Vec<u8>, Error> {
        let known = shipped().iter().find(|profile| profile.name == self.named);
        match known {
            Some(known) if !Path::new(&self.named).is_file() => Ok(known.text.as_bytes().to_vec()),
            _ => Ok(files::read(Path::new(&self.named))?),
        }
    }
}

/// Sweeps design degree, mesh limits, the witness's rays and Monte Carlo trials; writes `bench.json` and
/// for each sweep a table (CSV) and a plot (SVG, PNG) into `out`/bench, and profiles with the suggested
/// settings beside them.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done or the disk refuses.
pub fn bench(out: &Path, wanted: &Benching, observer: &dyn Observer) -> Result<Bench, Error> {
    let clock = Clock::new(observer);
    let folder = Folder::create(&out.join("bench"))?;
    let named: Vec<String> = match wanted.profiles.is_empty() {
        true => shipped().iter().map(|profile| profile.name.to_owned()).collect(),
        false => wanted.profiles.clone(),
    };
    let subject = |named: String| {
        let source = load(&named)?;
        let design = designed(&source)?.0;
        Ok::<_, Error>(Subject { named, source, design })
    };
    let subjects: Vec<Subject> = named.into_iter().map(subject).collect::<Result<_, _>>()?;
    let quick = wanted.quick;
    let swept = |stage: Stage, sweep: &dyn Fn() -> Result<Sweep, Error>| {
        clock.stage(stage, || {
            let sweep = sweep()?;
            let note = format!("{}: {} runs", sweep.name, sweep.runs.len());
            Ok::<_, Error>((sweep, note))
        })
    };
    let mut sweeps = vec![
        swept(Stage::Design, &|| design::sweep(&subjects, quick))?,
        swept(Stage::Mesh, &|| mesh::sweep(&subjects, mesh::Rule::Facet, quick))?,
        swept(Stage::Mesh, &|| mesh::sweep(&subjects, mesh::Rule::Chord, quick))?,
        swept(Stage::Trace, &|| witness::sweep(&subjects, quick))?,
        swept(Stage::Trials, &|| trials::sweep(&subjects, quick))?,
    ];
    sweeps.iter_mut().for_each(|sweep| mark_pareto(&mut sweep.runs));

    let mut suggestions = Vec::new();
    let mut staged = Vec::new();
    if let Some(target_px) = wanted.suggest_px {
        for subject in subjects.iter().filter(|subject| subject.design.view.is_some()) {
            let (suggestion, text) = suggest::suggest(subject, &sweeps, target_px)?;
            if let (Some(found), Some(text)) = (&suggestion.settings, text) {
                staged.push(folder.stage(&found.file, |out| out.write_all(text.as_bytes()))?);
            }
            suggestions.push(suggestion);
        }
    }
    let bench = Bench { schema: 2, sweeps, suggestions };
    clock.stage(Stage::Report, || {
        let fail = |error: Box<dyn std::error::Error>| Error::Bench(error.to_string());
        for sweep in &bench.sweeps {
            let (svg, png) = (sweep.svg().map_err(fail)?, sweep.png().map_err(fail)?);
            let files =
                [("csv", sweep.csv().into_bytes()), ("svg", svg.into_bytes()), ("png", png)];
            for (ending, bytes) in files {
                let name = format!("{}.{ending}", sweep.name);
                staged.push(folder.stage(&name, |out| out.write_all(&bytes))?);
            }
        }
        staged.push(folder.stage("bench.json", |out| out.write_all(bench.json().as_bytes()))?);
        staged.into_iter().try_for_each(files::Staged::publish)?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(bench)
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
) -> Run {
    let (profile, series) = (profile.to_owned(), series.to_owned());
    Run { profile, series, setting, time_ms, error, pareto: false, figures }
}
