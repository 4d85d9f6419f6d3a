//! Tolerancing: the profile's words to a question, trials to files.

use super::files::{self, Folder, Staged};
use super::machining::{Cutting, scalloped, survey};
use super::observer::Clock;
use super::source::{heights_beside, load};
use super::{Error, Observer, Source, Stage, designed};
use crate::design::Design;
use crate::geom::Outline;
use crate::mirror::{Knots, Patches};
use crate::num::random::Stream;
use crate::profile::{Profile, SagAxis};
use crate::report::{Machining, ProfileId, ToleranceReport, read_trial, trial_columns, trial_line};
use crate::tolerance::{
    Compensator, Criterion, Distribution, Engine, Kind, Measure, Points, Process, Question,
    Reference, Source as ErrorSource, Study, Texture, Trial, form_of_pv, worst_offenders,
};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Which trials.
#[derive(Debug, Clone, PartialEq)]
pub struct Trials {
    /// Their numbers: at least one.
    pub range: Range<u64>,
    /// What they are drawn from.
    pub seed: u64,
    /// End early when the yield's 95 % interval is no wider than this.
    pub until: Option<f64>,
}

/// About how many pixels stand for the picture.
const SAMPLES: usize = 1050;

/// Answers the profile that `named` means by `trials`, into `out`/NAME: `tolerance.json`,
/// `tolerance.html` and `trials.csv`.
///
/// # Errors
/// [`enum@Error`] when there is no such profile, it cannot be designed or has no projection, or the disk refuses.
pub fn tolerance(
    named: &str,
    trials: &Trials,
    out: &Path,
    observer: &dyn Observer,
) -> Result<ToleranceReport, Error> {
    let clock = Clock::new(observer);
    let source = load(named)?;
    let folder = Folder::create(&out.join(&source.profile.name))?;
    let (design, engine) = prepared(&clock, named, &source)?;
    let machining = tracks(&clock, (&source.profile, &design), &engine)?;
    let made = traced(&clock, &engine, trials);
    concluded(&clock, (&source.profile, machining), &engine, trials.seed, &made, &folder)
}

/// A part of a run that goes on elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
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
) -> Result<Part, Error> {
    let clock = Clock::new(observer);
    let source = load(named)?;
    let folder = Folder::create(&out.join(&source.profile.name))?;
    let (_, engine) = prepared(&clock, named, &source)?;
    let made = traced(&clock, &engine, trials);
    let Range { start, end } = trials.range;
    let name = format!("trials-{start}-{end}.csv");
    let (profile, seed) = (&source.profile, trials.seed);
    let text = format!("{PART}{start}..{end} {named}\n{}", table(profile, &engine, seed, &made));
    folder.stage(&name, |out| out.write_all(text.as_bytes()))?.publish()?;
    Ok(Part { path: folder.path().join(name), trials: made.len() as u64 })
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
    let clock = Clock::new(observer);
    let fault = |path: &Path, reason: String| Error::Part { path: path.to_owned(), reason };
    let Some(first) = parts.first() else {
        return Err(fault(Path::new("--merge"), "no part is named".into()));
    };
    let mut read: Vec<(&PathBuf, String)> = Vec::new();
    for path in parts {
        let text = String::from_utf8(files::read(path)?)
            .map_err(|_| fault(path, "it is no part of a run: not text".into()))?;
        read.push((path, text));
    }
    let asked = |text: &str| -> Option<(Range<u64>, String)> {
        let (range, named) = text.lines().next()?.strip_prefix(PART)?.split_once(' ')?;
        let (start, end) = range.split_once("..")?;
        Some((start.parse().ok()?..end.parse().ok()?, named.to_owned()))
    };
    let no_part =
        "it is no part of a run; `morion tolerance PROFILE --trials A..B --part` makes them";
    let (_, named) = asked(&read[0].1).ok_or_else(|| fault(first, no_part.into()))?;
    let source = load(&named)?;
    let folder = Folder::create(&out.join(&source.profile.name))?;
    let (design, engine) = prepared(&clock, &named, &source)?;
    let seed = seed_of(&read[0].1).ok_or_else(|| fault(first, no_part.into()))?;
    let head = heading(&source.profile, &engine, seed);
    let adjustments = engine.adjustments().len();
    let mut runs: Vec<(&PathBuf, Vec<Trial>)> = Vec::new();
    for (path, text) in &read {
        let (range, _) = asked(text).ok_or_else(|| fault(path, no_part.into()))?;
        let body = text.split_once('\n').map_or("", |(_, body)| body);
        let Some(lines) = body.strip_prefix(&head) else {
            let reason = format!(
                "its profile, seed or version is not that of {}, or the profile or a file that it names \
                 has changed since",
                first.display()
            );
            return Err(fault(path, reason));
        };
        let trials: Option<Vec<Trial>> =
            lines.lines().map(|line| read_trial(line, adjustments)).collect();
        // The last line is whole when it ends.
        let whole = trials.filter(|trials| {
            !range.is_empty() && text.ends_with('\n') && trials.iter().map(|t| t.index).eq(range)
        });
        runs.push((path, whole.ok_or_else(|| fault(path, "its trials are not whole".into()))?));
    }
    runs.sort_by_key(|(_, trials)| trials[0].index);
    let mut all: Vec<Trial> = Vec::new();
    for (path, trials) in runs {
        if let Some(last) = all.last()
            && last.index + 1 != trials[0].index
        {
            let (first, next) = (trials[0].index, last.index + 1);
            let reason = format!("it begins with trial {first}, where {next} is to follow");
            return Err(fault(path, reason));
        }
        all.extend(trials);
    }
    let machining = tracks(&clock, (&source.profile, &design), &engine)?;
    concluded(&clock, (&source.profile, machining), &engine, seed, &all, &folder)
}

/// What a part begins with; the profile as it was named follows.
const PART: &str = "# part of a run of morion tolerance ";

fn seed_of(text: &str) -> Option<u64> {
    text.lines().find_map(|line| line.strip_prefix("# seed "))?.parse().ok()
}

/// The comments and the names of columns before a table's trials.
fn heading(profile: &Profile, engine: &Engine, seed: u64) -> String {
    let adjustments: Vec<String> =
        engine.adjustments().iter().map(|a| format!("{} {}", a.name, a.unit)).collect();
    let sources: Vec<String> =
        engine.question.sources.iter().map(|source| source.kind.key()).collect();
    // The files that a profile names are none of its bytes.
    let marks: Vec<u8> = engine.marks().into_iter().flat_map(f64::to_le_bytes).collect();
    format!(
        "# Morion {} trials of {}\n# sha256 {}\n# system {}\n# seed {seed}\n{}\n",
        env!("CARGO_PKG_VERSION"),
        profile.name,
        profile.sha256,
        files::sha256(&marks),
        trial_columns(&adjustments, &sources)
    )
}

fn table(profile: &Profile, engine: &Engine, seed: u64, trials: &[Trial]) -> String {
    let mut text = heading(profile, engine, seed);
    for trial in trials {
        let stream = Stream { seed, trial: trial.index };
        let draws = engine.draw(&engine.question.sources, &stream);
        trial_line(&mut text, trial, draws.into_iter().map(|(_, value)| value));
    }
    text
}

/// The design, and what is asked of it.
pub(super) fn prepared(
    clock: &Clock,
    named: &str,
    source: &Source,
) -> Result<(Design, Engine), Error> {
    let profile = &source.profile;
    let design = clock.stage(Stage::Design, || designed(source))?;
    let map = match &profile.tolerance.map_file {
        Some(file) => {
            let grid = heights_beside(named, file)?;
            let knots = |a: &SagAxis| Knots { first: a.first_mm, step: a.step_mm, count: a.count };
            Patches::new(knots(&grid.x), knots(&grid.y), &grid.z_mm)
        }
        None => None,
    };
    let name = || profile.name.clone();
    let view = design
        .view
        .as_ref()
        .ok_or_else(|| Error::NoProjection { work: "tolerance", profile: name() })?;
    let asked = question(profile, &design, map)?;
    let engine = clock.stage(Stage::Sensitivities, || {
        let engine = Engine::new(&design.mirror, &design.camera, view, asked)
            .ok_or_else(|| Error::Unseen { profile: name() })?;
        let sources = engine.question.sources.len();
        let [pixels, expanded] = [engine.samples(), engine.expanded()];
        let note = format!("{sources} sources, {pixels} pixels, {expanded} by polynomials");
        Ok::<_, Error>((engine, note))
    })?;
    Ok((design, engine))
}

fn traced(clock: &Clock, engine: &Engine, trials: &Trials) -> Vec<Trial> {
    let Trials { range, seed, until } = trials.clone();
    clock.always(Stage::Trials, || {
        let made = engine.trials(&engine.question.sources, seed, range, until);
        let note = format!("{} trials", made.len());
        (made, note)
    })
}

/// Writes the answers.
fn concluded(
    clock: &Clock,
    (profile, machining): (&Profile, Option<Machining>),
    engine: &Engine,
    seed: u64,
    trials: &[Trial],
    folder: &Folder,
) -> Result<ToleranceReport, Error> {
    let study = clock.always(Stage::Budget, || {
        let study = Study::new(engine, seed, trials);
        let note = format!("yield {:.2} %", 100.0 * study.yields.share);
        (study, note)
    });
    let id = ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() };
    let offenders = worst_offenders(&study);
    let report = ToleranceReport::new(id, study, offenders, machining);
    clock.stage(Stage::Report, || {
        let page = report.html(&Points::new(engine, seed, trials));
        let page = page.map_err(|error| Error::Plot(error.to_string()))?;
        let table = table(profile, engine, seed, trials);
        let trials = folder.stage("trials.csv", |out| out.write_all(table.as_bytes()))?;
        let json = report.json();
        let answers = folder.stage("tolerance.json", |out| out.write_all(json.as_bytes()))?;
        let page = folder.stage("tolerance.html", |out| out.write_all(page.as_bytes()))?;
        [trials, page, answers].into_iter().try_for_each(Staged::publish)?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(report)
}

/// What the ball cutter makes of the mirror as designed, where tool tracks are an error source.
fn tracks(
    clock: &Clock,
    (profile, design): (&Profile, &Design),
    engine: &Engine,
) -> Result<Option<Machining>, Error> {
    let Question { sources, texture, budget_px, .. } = &engine.question;
    let Some(tracks) = sources.iter().find(|source| source.kind == Kind::ToolMarks) else {
        return Ok(None);
    };
    let cutting = Cutting {
        ball_mm: texture.ball_radius_mm,
        stepover_mm: tracks.limit,
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

/// What the profile asks, with what is usual where it says nothing.
fn question(profile: &Profile, design: &Design, map: Option<Patches>) -> Result<Question, Error> {
    let asked = &profile.tolerance;
    let process = Process::named(asked.preset).expect("the profile knows the presets");
    let form = if asked.form == "rms" { Measure::Rms } else { Measure::Pv };
    let round = matches!(design.mirror.outline, Outline::Ring { .. });
    let applies = |kind: &Kind| match kind {
        Kind::Legendre(..) => !round,
        Kind::Zernike(_) => round,
        Kind::Telecentricity => design.camera.chart.vergence == 0.0,
        Kind::Map => map.is_some(),
        _ => true,
    };
    let source = |kind: Kind| {
        let key = kind.key();
        let (usual, distribution) = match kind {
            Kind::Facets => (profile.mesh.facet_px.unwrap_or(0.0), Distribution::Fixed),
            kind => process.usual(kind),
        };
        let of = |values: &[(&str, f64)]| values.iter().find(|v| v.0 == key).map(|v| v.1);
        let word = asked.distributions.iter().find(|v| v.0 == key).map(|v| v.1);
        ErrorSource {
            kind,
            // (A usual figure has few digits.)
            limit: of(&asked.limits).unwrap_or_else(|| match form_of_pv(kind, form) {
                1.0 => usual,
                share => (1e3 * usual * share).round() * 1e-3,
            }),
            distribution: word.map_or(distribution, distribution_of),
            weight: of(&asked.weights).unwrap_or(1.0),
        }
    };
    let sources: Vec<ErrorSource> =
        Kind::all().filter(applies).map(source).filter(|source| source.limit > 0.0).collect();
    let usual = process.texture;
    let texture = Texture {
        cte_ppm_per_k: asked.expansion_ppm_per_k.unwrap_or(usual.cte_ppm_per_k),
        waviness_period_mm: asked.waviness_period_mm.unwrap_or(usual.waviness_period_mm),
        waviness_direction_deg: asked
            .waviness_direction_deg
            .unwrap_or(usual.waviness_direction_deg),
        slope_correlation_mm: asked.slope_correlation_mm.unwrap_or(usual.slope_correlation_mm),
        ball_radius_mm: asked.ball_radius_mm.unwrap_or(usual.ball_radius_mm),
        stepover_direction_deg: asked
            .stepover_direction_deg
            .unwrap_or(usual.stepover_direction_deg),
    };
    let tracks = sources.iter().find(|source| source.kind == Kind::ToolMarks);
    if let Some(tracks) = tracks.filter(|t| t.limit >= 2.0 * texture.ball_radius_mm) {
        let (stepover_mm, ball_radius_mm) = (tracks.limit, texture.ball_radius_mm);
        return Err(Error::Tracks { profile: profile.name.clone(), stepover_mm, ball_radius_mm });
    }
    Ok(Question {
        sources,
        form,
        texture,
        map,
        compensators: asked.compensators.iter().map(|word| compensator_of(word)).collect(),
        criterion: if asked.criterion == "p95" { Criterion::P95 } else { Criterion::Rms },
        reference: match asked.reference {
            "projection" => Reference::Projection,
            _ => Reference::Design,
        },
        budget_px: asked.budget_px,
        target_yield: asked.target_yield,
        samples: SAMPLES,
    })
}

fn distribution_of(word: &str) -> Distribution {
    match word {
        "uniform" => Distribution::Uniform,
        "normal" => Distribution::Normal,
        "truncated" => Distribution::Truncated,
        _ => Distribution::Fixed,
    }
}

fn compensator_of(word: &str) -> Compensator {
    match word {
        "shift" => Compensator::Shift,
        "rotation" => Compensator::Rotation,
        "magnification" => Compensator::Magnification,
        "tilt" => Compensator::Tilt,
        _ => Compensator::Despace,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::shipped;
    use crate::profile::tolerance::{COMPENSATORS, DISTRIBUTIONS, PRESETS};
    use std::fmt::Write;

    fn profile(edit: &str) -> Profile {
        let shipped = shipped().iter().find(|p| p.name == "conquistador").unwrap();
        let text = format!("{}\n{edit}", shipped.text);
        Profile::parse("case", "case.toml", text.as_bytes()).unwrap_or_else(|c| panic!("{c}"))
    }

    #[test]
    fn every_word_of_a_profile_means_something_of_its_own() {
        let means = |distribution: Distribution| {
            serde_json::to_value(distribution).unwrap().as_str().unwrap().to_owned()
        };
        assert!(DISTRIBUTIONS.iter().all(|word| means(distribution_of(word)) == *word));
        let means = |c: Compensator| serde_json::to_value(c).unwrap().as_str().unwrap().to_owned();
        assert!(COMPENSATORS.iter().all(|word| means(compensator_of(word)) == *word));
        assert_eq!(PRESETS.len(), Process::ALL.len());
        assert!(PRESETS.iter().all(|word| Process::named(word).is_some()));
        // Every key of an error is known to the profile, and there are no others.
        let mut lines = String::from("[tolerance]\nmap_file = \"map.csv\"\n[tolerance.weights]\n");
        for kind in Kind::all() {
            let _ = writeln!(lines, "{} = 2", kind.key());
        }
        let read = profile(&lines).tolerance;
        assert_eq!(read.weights.len(), Kind::all().count());
        assert!(read.weights.iter().all(|(key, _)| Kind::of_key(key).is_some()));
    }

    #[test]
    fn every_shipped_profile_has_24_sources_and_its_own_words_count() {
        for shipped in shipped() {
            let source: Source =
                Profile::parse(shipped.name, shipped.name, shipped.text.as_bytes()).unwrap().into();
            let (design, _) = designed(&source).unwrap();
            let asked = question(&source.profile, &design, None).unwrap();
            assert!(asked.sources.len() >= 24, "{}: {}", shipped.name, asked.sources.len());
        }
        let source: Source = profile(
            "[tolerance]\npreset = \"spdt\"\nball_radius_mm = 0.7\ncriterion = \"p95\"\n\
             compensators = [\"tilt\"]\n[tolerance.limits]\ntilt_x_mrad = 3\ntilt_y_mrad = 0\n\
             [tolerance.distributions]\ntilt_x_mrad = \"normal\"\n",
        )
        .into();
        let (design, _) = designed(&source).unwrap();
        let asked = question(&source.profile, &design, None).unwrap();
        let tilt = asked.sources.iter().find(|s| s.kind == Kind::TiltX).unwrap();
        assert_eq!((tilt.limit, tilt.distribution), (3.0, Distribution::Normal));
        assert!(asked.sources.iter().all(|s| s.kind != Kind::TiltY));
        assert_eq!((asked.texture.ball_radius_mm, asked.criterion), (0.7, Criterion::P95));
        assert_eq!(asked.compensators, [Compensator::Tilt]);
        let wide: Source =
            profile("[tolerance]\nball_radius_mm = 0.01\n[tolerance.limits]\nstepover_mm = 0.02\n")
                .into();
        assert!(matches!(question(&wide.profile, &design, None), Err(Error::Tracks { .. })));
    }
}
