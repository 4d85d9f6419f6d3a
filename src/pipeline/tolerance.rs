//! Tolerancing: trials to files, at once or in parts.

use super::run::{Command, Run};
use super::source::load;
use super::tolerance_spec::{PreparedStudy, prepared};
use super::{Error, Observer, Stage};
use crate::num::random::RandomStream;
use crate::parallel;
use crate::profile::Profile;
use crate::publish::{self, sha256};
use crate::report::Answer;
use crate::results::{MachiningReport, ToleranceReport};
use crate::tolerance::{
    Engine, Perturbation, PlotData, Study, ToleranceSpec, Trial, read_trial, trial_columns,
    trial_line, worst_offenders,
};
use crate::verdict::{CutterSurvey, MachiningOptions};
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// How a profile is toleranced: writes `tolerance.json`, `tolerance.html`, `trials.csv` and
/// `tolerance-timings.json` into NAME.
#[derive(Debug, Clone, PartialEq)]
pub struct ToleranceOptions {
    /// Numbers of the trials: at least one.
    pub range: Range<u64>,
    /// What they are drawn from.
    pub seed: u64,
    /// End early when the yield's 95 % interval is no wider than this.
    pub until: Option<f64>,
}

impl Default for ToleranceOptions {
    fn default() -> Self {
        Self { range: 0..2000, seed: 1, until: None }
    }
}

impl Command for ToleranceOptions {
    type Report = ToleranceReport;

    fn run(&self, run: &mut Run) -> Result<ToleranceReport, Error> {
        let study = prepared(run)?;
        let machining = tracks(run, &study)?;
        let trials = traced(run, &study.engine, self)?;
        concluded(run, &study, machining, self.seed, &trials)
    }
}

/// A part of a run that goes on elsewhere: its trials alone, written into NAME/trials-A-B.csv.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialsPart(pub ToleranceOptions);

/// The file of a part of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialsFile {
    /// The file, for [`merge`].
    pub path: PathBuf,
    /// How many trials it holds.
    pub trials: u64,
}

impl Command for TrialsPart {
    type Report = TrialsFile;

    fn run(&self, run: &mut Run) -> Result<TrialsFile, Error> {
        let PreparedStudy { engine, .. } = prepared(run)?;
        let trials = traced(run, &engine, &self.0)?;
        let Range { start, end } = self.0.range;
        let name = format!("trials-{start}-{end}.csv");
        let table = table(run.profile, &engine, self.0.seed, &trials);
        let text = format!("{PART}{start}..{end} {}\n{table}", quoted(&run.profile.named));
        run.files.add_bytes(&name, text.as_bytes())?;
        run.files.commit()?;
        Ok(TrialsFile { path: run.files.path_of(&name), trials: trials.len() as u64 })
    }
}

/// Answers by the trials of parts, in any order, as [`ToleranceOptions`] do by the same trials at once.
///
/// # Errors
/// [`Error::Part`] when a file is no part, or the parts do not follow each other or are of different runs;
/// or when a stage cannot be done.
pub fn merge(
    parts: &[PathBuf],
    out: &Path,
    observer: &dyn Observer,
) -> Result<ToleranceReport, Error> {
    let read = |path: &PathBuf| {
        let text = String::from_utf8(publish::read(path)?)
            .map_err(|_| fault(path, "it is no part of a run: not text"))?;
        Ok((path.clone(), text))
    };
    let parts: Vec<(PathBuf, String)> = parts.iter().map(read).collect::<Result<_, Error>>()?;
    let Some((first, text)) = parts.first() else {
        return Err(fault(Path::new("--merge"), "no part is named"));
    };
    let (_, named) = beginning(text).ok_or_else(|| fault(first, NO_PART))?;
    Merge { parts }.publish(&load(&named)?, out, observer)
}

/// Parts of one run: path and text of each.
struct Merge {
    parts: Vec<(PathBuf, String)>,
}

impl Command for Merge {
    type Report = ToleranceReport;

    fn run(&self, run: &mut Run) -> Result<ToleranceReport, Error> {
        let study = prepared(run)?;
        let (first, text) = &self.parts[0];
        let seed = seed_of(text).ok_or_else(|| fault(first, NO_PART))?;
        let trials = self.trials(&heading(run.profile, &study.engine, seed), &study.engine)?;
        run.timer.worked(Stage::Trials, TRIALS, [0, trials.len()], "the parts hold them");
        let machining = tracks(run, &study)?;
        concluded(run, &study, machining, seed, &trials)
    }
}

impl Merge {
    /// All trials in their order, of files that have this head.
    fn trials(&self, head: &str, engine: &Engine) -> Result<Vec<Trial>, Error> {
        let adjustments = engine.adjustments().len();
        let mut runs: Vec<(&PathBuf, Vec<Trial>)> = Vec::new();
        for (path, text) in &self.parts {
            let (range, _) = beginning(text).ok_or_else(|| fault(path, NO_PART))?;
            let body = text.split_once('\n').map_or("", |(_, body)| body);
            let Some(lines) = body.strip_prefix(head) else {
                let first = self.parts[0].0.display();
                let reason = format!(
                    "its profile, seed or version is not that of {first}, or the profile, a file that it \
                     names or the build whose facets it takes has changed since"
                );
                return Err(fault(path, &reason));
            };
            let trials: Option<Vec<Trial>> =
                lines.lines().map(|line| read_trial(line, adjustments)).collect();
            // The last line is whole when it ends.
            let whole = trials.filter(|trials| {
                !range.is_empty()
                    && text.ends_with('\n')
                    && trials.iter().map(|t| t.index).eq(range)
            });
            runs.push((path, whole.ok_or_else(|| fault(path, "its trials are not whole"))?));
        }
        runs.sort_by_key(|(_, trials)| trials[0].index);
        let mut all: Vec<Trial> = Vec::new();
        for (path, trials) in runs {
            if let Some(last) = all.last()
                && last.index + 1 != trials[0].index
            {
                let (first, next) = (trials[0].index, last.index + 1);
                let reason = format!("it begins with trial {first}, where {next} is to follow");
                return Err(fault(path, &reason));
            }
            all.extend(trials);
        }
        Ok(all)
    }
}

const NO_PART: &str =
    "it is no part of a run; `morion tolerance PROFILE --trials A..B --part` makes them";

fn fault(path: &Path, reason: &str) -> Error {
    Error::Part { path: path.to_owned(), reason: reason.to_owned() }
}

/// The range of a part, and the name of its profile.
fn beginning(text: &str) -> Option<(Range<u64>, String)> {
    let (range, named) = text.lines().next()?.strip_prefix(PART)?.split_once(' ')?;
    let (start, end) = range.split_once("..")?;
    Some((start.parse().ok()?..end.parse().ok()?, serde_json::from_str(named).ok()?))
}

/// What a part begins with; the profile as it was named follows, as a string of JSON.
const PART: &str = "# part of a run of morion tolerance ";

/// On one line, whatever is in it.
fn quoted(text: &str) -> Value {
    Value::String(text.to_owned())
}

fn seed_of(text: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix("# seed "))?.parse().ok()
}

/// The comments and the names of columns before a table's trials.
fn heading(profile: &Profile, engine: &Engine, seed: u64) -> String {
    let adjustments: Vec<String> =
        engine.adjustments().iter().map(|a| format!("{} {}", a.name, a.unit)).collect();
    let sources: Vec<String> =
        engine.spec.sources.iter().map(|source| source.kind.key().to_owned()).collect();
    // The files that a profile names are none of its bytes, and a build may say what facets do.
    let limits = engine.spec.sources.iter().map(|source| source.limit);
    let marks: Vec<u8> =
        engine.marks().into_iter().chain(limits).flat_map(f64::to_le_bytes).collect();
    let name = &profile.name;
    let controls = name.contains(char::is_control);
    let name = if controls { name.escape_debug().to_string() } else { name.clone() };
    format!(
        "# Morion {} trials of {name}\n# sha256 {}\n# system {}\n# seed {seed}\n{}\n",
        env!("CARGO_PKG_VERSION"),
        profile.sha256,
        sha256(&marks),
        trial_columns(&adjustments, &sources)
    )
}

/// Lines of a table that a thread writes at a time.
const LINES: usize = 256;

fn table(profile: &Profile, engine: &Engine, seed: u64, trials: &[Trial]) -> String {
    let adjustments = engine.adjustments().len();
    let lines = parallel::map_chunks(trials, LINES, |trials| {
        let mut text = String::new();
        for trial in trials {
            let stream = RandomStream { seed, trial: trial.index };
            let draws = engine.draw(&engine.spec.sources, &stream);
            trial_line(&mut text, trial, adjustments, draws.into_iter().map(|(_, value)| value));
        }
        text
    });
    heading(profile, engine, seed) + &lines.concat()
}

/// What the stage of trials counts.
const TRIALS: &str = "trials";

/// Trials between two questions whether the run is to end.
const TRACED_AT_A_TIME: usize = 2000;

fn traced(run: &Run, engine: &Engine, options: &ToleranceOptions) -> Result<Vec<Trial>, Error> {
    let ToleranceOptions { range, seed, until } = options.clone();
    let timer = &run.timer;
    let made = timer.always(Stage::Trials, || {
        let asked = (range.end - range.start) as usize;
        let mut made = Vec::new();
        for from in range.clone().step_by(TRACED_AT_A_TIME) {
            let to = range.end.min(from.saturating_add(TRACED_AT_A_TIME as u64));
            // Where the yield is looked at, all trials so far count.
            let part = if until.is_some() { range.clone() } else { from..to };
            made.extend(engine.trials(&engine.spec.sources, seed, part, until));
            if until.is_some() || timer.is_stopped() {
                break;
            }
        }
        timer.toleranced(Stage::Trials, engine.worked());
        let enough = "the yield is known well enough";
        timer.worked(Stage::Trials, TRIALS, [made.len(), asked - made.len()], enough);
        let note = format!("{} trials", made.len());
        (made, note)
    });
    run.check_wanted()?;
    Ok(made)
}

/// Writes the answers.
fn concluded(
    run: &mut Run,
    PreparedStudy { engine, facets_from, .. }: &PreparedStudy,
    machining: Option<MachiningReport>,
    seed: u64,
    trials: &[Trial],
) -> Result<ToleranceReport, Error> {
    let timer = &run.timer;
    let study = timer.always(Stage::Budget, || {
        let study = Study::new(engine, seed, trials);
        timer.toleranced(Stage::Budget, engine.worked());
        let note = format!("yield {:.2} %", 100.0 * study.yields.share);
        (study, note)
    });
    let offenders = worst_offenders(&study);
    let profile = run.profile;
    let report = ToleranceReport::new(profile.into(), study, *facets_from, offenders, machining);
    run.publish(Stage::Report, |files, timer| {
        let page = report.html(run.profile, &PlotData::new(engine, seed, trials));
        files.add_bytes("trials.csv", table(profile, engine, seed, trials).as_bytes())?;
        files.add_report("tolerance.json", &report.json())?;
        files.add_bytes("tolerance.html", page.as_bytes())?;
        let timings = format!("{:#}\n", serde_json::json!(timer.timings(timer.work())));
        files.add_bytes("tolerance-timings.json", timings.as_bytes())?;
        Ok(())
    })?;
    Ok(report)
}

/// What the ball cutter makes of the mirror as designed, where tool tracks are an error source.
fn tracks(
    run: &Run,
    PreparedStudy { design, engine, .. }: &PreparedStudy,
) -> Result<Option<MachiningReport>, Error> {
    let ToleranceSpec { sources, texture, budget_px, .. } = &engine.spec;
    if !run.profile.is_one_surface() || run.profile.part.forming.is_some() {
        return Ok(None);
    }
    let Some(tracks) = sources.iter().find(|source| source.kind == Perturbation::Stepover) else {
        return Ok(None);
    };
    let options = MachiningOptions {
        ball_mm: texture.ball_radius_mm,
        stepover_mm: Some(tracks.limit),
        // Lines run across the direction in which they follow each other.
        angle_deg: Some(texture.stepover_direction_deg - 90.0),
        budget_px: Some(*budget_px),
        as_cut: false,
        ..MachiningOptions::default()
    };
    run.stage(Stage::Cut, || {
        let profile = run.profile;
        let fail = |source| Error::Machining { profile: profile.name.clone(), source };
        let survey = CutterSurvey::new(profile, design, &options).map_err(fail)?;
        let note = survey.note();
        Ok((Some(survey.found), note))
    })
}
