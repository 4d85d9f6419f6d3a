//! Tolerancing: trials to files, at once or in parts.

use super::files::{self, Folder};
use super::machining::{MachiningOptions, scalloped, survey};
use super::observer::StageTimer;
use super::source::load;
use super::tolerance_spec::{PreparedStudy, prepared};
use super::{Error, Observer, Stage};
use crate::design::Design;
use crate::num::random::RandomStream;
use crate::profile::Profile;
use crate::report::{Answer, MachiningReport, ProfileId, ToleranceReport};
use crate::tolerance::{
    Engine, Perturbation, PlotData, Study, ToleranceSpec, Trial, read_trial, trial_columns,
    trial_line, worst_offenders,
};
use serde_json::Value;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Trials of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Trials {
    /// Their numbers: at least one.
    pub range: Range<u64>,
    /// Seed that they are drawn from.
    pub seed: u64,
    /// End early when the yield's 95 % interval is no wider than this.
    pub until: Option<f64>,
}

/// Answers the profile that `named` means by `trials`, into `out`/NAME: `tolerance.json`,
/// `tolerance.html`, `trials.csv` and `tolerance-timings.json`.
///
/// # Errors
/// [`enum@Error`] when there is no such profile, it cannot be designed or has no projection, or the disk refuses.
pub fn tolerance(
    named: &str,
    trials: &Trials,
    out: &Path,
    observer: &dyn Observer,
) -> Result<ToleranceReport, Error> {
    let clock = StageTimer::new(observer);
    let source = load(named)?;
    let folder = Folder::create(&out.join(&source.profile.name))?;
    let asked = prepared(&clock, named, &source)?;
    let machining = tracks(&clock, (&source.profile, &asked.design), &asked.engine)?;
    let made = traced(&clock, &asked.engine, trials);
    concluded(&clock, (&source.profile, machining), &asked, trials.seed, &made, &folder)
}

/// A part of a run that goes on elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialsFile {
    /// The file, for [`tolerance_merged`].
    pub path: PathBuf,
    /// How many trials it holds.
    pub trials: u64,
}

/// Makes `trials` alone, into `out`/NAME/trials-A-B.csv.
///
/// # Errors
/// As [`tolerance`].
pub fn tolerance_part(
    named: &str,
    trials: &Trials,
    out: &Path,
    observer: &dyn Observer,
) -> Result<TrialsFile, Error> {
    let clock = StageTimer::new(observer);
    let source = load(named)?;
    let folder = Folder::create(&out.join(&source.profile.name))?;
    let PreparedStudy { engine, .. } = prepared(&clock, named, &source)?;
    let made = traced(&clock, &engine, trials);
    let Range { start, end } = trials.range;
    let name = format!("trials-{start}-{end}.csv");
    let (profile, seed) = (&source.profile, trials.seed);
    let text =
        format!("{PART}{start}..{end} {}\n{}", quoted(named), table(profile, &engine, seed, &made));
    folder.stage(&name, |out| out.write_all(text.as_bytes()))?.publish()?;
    Ok(TrialsFile { path: folder.path().join(name), trials: made.len() as u64 })
}

/// Answers by the trials of parts, in any order, as [`tolerance`] does by the same trials at once.
///
/// # Errors
/// As [`tolerance`], and [`Error::Part`] when a file is no part, or the parts do not follow each
/// other or are of different runs.
pub fn tolerance_merged(
    parts: &[PathBuf],
    out: &Path,
    observer: &dyn Observer,
) -> Result<ToleranceReport, Error> {
    let clock = StageTimer::new(observer);
    let Some(first) = parts.first() else {
        return Err(part_fault(Path::new("--merge"), "no part is named"));
    };
    let mut read: Vec<(&Path, String)> = Vec::new();
    for path in parts {
        let text = String::from_utf8(files::read(path)?)
            .map_err(|_| part_fault(path, "it is no part of a run: not text"))?;
        read.push((path, text));
    }
    let (_, named) = heading_of_part(&read[0].1).ok_or_else(|| part_fault(first, NO_PART))?;
    let source = load(&named)?;
    let folder = Folder::create(&out.join(&source.profile.name))?;
    let asked = prepared(&clock, &named, &source)?;
    let engine = &asked.engine;
    let seed = seed_of(&read[0].1).ok_or_else(|| part_fault(first, NO_PART))?;
    let head = heading(&source.profile, engine, seed);
    let mut runs: Vec<(&Path, Vec<Trial>)> = Vec::new();
    for (path, text) in &read {
        let (range, _) = heading_of_part(text).ok_or_else(|| part_fault(path, NO_PART))?;
        let body = text.split_once('\n').map_or("", |(_, body)| body);
        let lines = body.strip_prefix(&head).ok_or_else(|| {
            let reason = format!(
                "its profile, seed or version is not that of {}, or the profile, a file that it names or \
                 the build whose facets it takes has changed since",
                first.display()
            );
            part_fault(path, &reason)
        })?;
        let trials = whole_trials(lines, range, engine.adjustments().len());
        runs.push((path, trials.ok_or_else(|| part_fault(path, "its trials are not whole"))?));
    }
    let all = joined(runs)?;
    clock.worked(Stage::Trials, TRIALS, [0, all.len()], "the parts hold them");
    let machining = tracks(&clock, (&source.profile, &asked.design), engine)?;
    concluded(&clock, (&source.profile, machining), &asked, seed, &all, &folder)
}

const NO_PART: &str =
    "it is no part of a run; `morion tolerance PROFILE --trials A..B --part` makes them";

fn part_fault(path: &Path, reason: &str) -> Error {
    Error::Part { path: path.to_owned(), reason: reason.to_owned() }
}

/// The numbers of the trials of a part, and the profile as it was named.
fn heading_of_part(text: &str) -> Option<(Range<u64>, String)> {
    let (range, named) = text.lines().next()?.strip_prefix(PART)?.split_once(' ')?;
    let (start, end) = range.split_once("..")?;
    Some((start.parse().ok()?..end.parse().ok()?, serde_json::from_str(named).ok()?))
}

/// The trials of a part's lines, if they are all that it has in its name.
fn whole_trials(lines: &str, range: Range<u64>, adjustments: usize) -> Option<Vec<Trial>> {
    let trials: Option<Vec<Trial>> =
        lines.lines().map(|line| read_trial(line, adjustments)).collect();
    // The last line is whole when it ends.
    trials.filter(|trials| {
        !range.is_empty() && lines.ends_with('\n') && trials.iter().map(|t| t.index).eq(range)
    })
}

/// The trials of parts in any order, which have to follow each other.
fn joined(mut runs: Vec<(&Path, Vec<Trial>)>) -> Result<Vec<Trial>, Error> {
    runs.sort_by_key(|(_, trials)| trials[0].index);
    let mut all: Vec<Trial> = Vec::new();
    for (path, trials) in runs {
        if let Some(last) = all.last()
            && last.index + 1 != trials[0].index
        {
            let (first, next) = (trials[0].index, last.index + 1);
            let reason = format!("it begins with trial {first}, where {next} is to follow");
            return Err(part_fault(path, &reason));
        }
        all.extend(trials);
    }
    Ok(all)
}

/// First words of a part's file; the profile as it was named follows, as a string of JSON.
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
    let keys = engine.spec.sources.iter().map(|source| source.kind.key().to_owned());
    let sources: Vec<String> = keys.collect();
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
        files::sha256(&marks),
        trial_columns(&adjustments, &sources)
    )
}

fn table(profile: &Profile, engine: &Engine, seed: u64, trials: &[Trial]) -> String {
    let mut text = heading(profile, engine, seed);
    let adjustments = engine.adjustments().len();
    for trial in trials {
        let stream = RandomStream { seed, trial: trial.index };
        let draws = engine.draw(&engine.spec.sources, &stream);
        trial_line(&mut text, trial, adjustments, draws.into_iter().map(|(_, value)| value));
    }
    text
}

/// Name of the work that the stage of trials counts.
const TRIALS: &str = "trials";

fn traced(clock: &StageTimer, engine: &Engine, trials: &Trials) -> Vec<Trial> {
    let Trials { range, seed, until } = trials.clone();
    clock.always(Stage::Trials, || {
        let asked = (range.end - range.start) as usize;
        let made = engine.trials(&engine.spec.sources, seed, range, until);
        clock.toleranced(Stage::Trials, engine.worked());
        let enough = "the yield is known well enough";
        clock.worked(Stage::Trials, TRIALS, [made.len(), asked - made.len()], enough);
        let note = format!("{} trials", made.len());
        (made, note)
    })
}

/// Writes the answers.
fn concluded(
    clock: &StageTimer,
    (profile, machining): (&Profile, Option<MachiningReport>),
    PreparedStudy { engine, facets_from, .. }: &PreparedStudy,
    seed: u64,
    trials: &[Trial],
    folder: &Folder,
) -> Result<ToleranceReport, Error> {
    let study = clock.always(Stage::Budget, || {
        let study = Study::new(engine, seed, trials);
        clock.toleranced(Stage::Budget, engine.worked());
        let note = format!("yield {:.2} %", 100.0 * study.yields.share);
        (study, note)
    });
    let id = ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() };
    let offenders = worst_offenders(&study);
    let report = ToleranceReport::new(id, study, *facets_from, offenders, machining);
    clock.stage(Stage::Report, || {
        let page = report.html(&PlotData::new(engine, seed, trials));
        let page = page.map_err(|error| Error::Plot(error.to_string()))?;
        let table = table(profile, engine, seed, trials);
        let trials = folder.stage("trials.csv", |out| out.write_all(table.as_bytes()))?;
        let json = report.json();
        let answers = folder.stage("tolerance.json", |out| out.write_all(json.as_bytes()))?;
        let page = folder.stage("tolerance.html", |out| out.write_all(page.as_bytes()))?;
        let timings = format!("{:#}\n", clock.timings(&clock.work()));
        let timings =
            folder.stage("tolerance-timings.json", |out| out.write_all(timings.as_bytes()))?;
        folder.replace(vec![trials, page, timings, answers], &[])?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(report)
}

/// Survey of the mirror as the ball cutter leaves it, where tool tracks are an error source.
fn tracks(
    clock: &StageTimer,
    (profile, design): (&Profile, &Design),
    engine: &Engine,
) -> Result<Option<MachiningReport>, Error> {
    let ToleranceSpec { sources, texture, budget_px, .. } = &engine.spec;
    let Some(tracks) = sources.iter().find(|source| source.kind == Perturbation::Stepover) else {
        return Ok(None);
    };
    let cutting = MachiningOptions {
        ball_mm: texture.ball_radius_mm,
        stepover_mm: Some(tracks.limit),
        // Lines run across the direction in which they follow each other.
        angle_deg: Some(texture.stepover_direction_deg - 90.0),
        budget_px: Some(*budget_px),
        scallop_um: None,
        allowance_mm: 0.0,
        as_cut: false,
    };
    clock.stage(Stage::Cut, || {
        let found = survey(profile, design, &cutting)?;
        let note = scalloped(&found);
        Ok((Some(found), note))
    })
}
