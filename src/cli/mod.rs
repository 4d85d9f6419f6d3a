//! Arguments, terminal manners and exit codes.

mod args;
mod progress;
#[cfg(unix)]
mod signals;
mod styles;

use crate::bench::{BenchOptions, bench};
use crate::parallel;
use crate::pipeline::{
    self, Effort, MachiningOptions, RenderOptions, ReplayOptions, Source, Trials, VerifyOptions,
    Way, blur, build_with, frame, inspect, load, machining, render, replay, tolerance,
    tolerance_merged, tolerance_part, unwrap,
};
use crate::profile::{Profile, Shipped, shipped};
use crate::report::{Answer, Aperture, Verdict, visible};
use args::{Arguments, Command, MapFormatArg, PrintFormat, RowsArg};
use clap::Parser;
use progress::Progress;
use serde_json::json;
use std::io::{ErrorKind, Write};
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// The part passed.
const PASSED: u8 = 0;
/// A negative verdict.
const FAILED: u8 = 1;
/// It could not be done: usage, profile, input or output.
const UNABLE: u8 = 2;

/// Runs the program: parses the arguments, does the work, and returns the exit code.
#[must_use]
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    arguments.color.write_global();
    #[cfg(unix)]
    signals::watch();
    let told = || {
        execute(&arguments).unwrap_or_else(|error| {
            let style = anstyle::Style::new().bold().fg_color(Some(anstyle::AnsiColor::Red.into()));
            let _ = writeln!(
                anstream::stderr(),
                "{style}error{style:#}: {}",
                visible(&error.to_string())
            );
            UNABLE
        })
    };
    ExitCode::from(parallel::within(arguments.threads, told))
}

type Failure = Box<dyn std::error::Error>;

fn execute(arguments: &Arguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.quiet);
    match &arguments.command {
        Command::Build { profiles, out, dry_run, force, no_skip } => {
            let effort = match (no_skip, force) {
                (true, _) => Effort::Most,
                (_, true) => Effort::Afresh,
                _ => Effort::Least,
            };
            let sources = load_all(profiles)?;
            let (mut code, mut failures) = (PASSED, Vec::new());
            for source in &sources {
                let done = if *dry_run {
                    pipeline::dry_run(source, &progress)
                        .map(|forecast| conclude(arguments, &forecast))
                } else {
                    build_with(source, out, effort, &progress)
                        .map(|report| conclude(arguments, &report))
                };
                match done {
                    Ok(concluded) => code = code.max(concluded?),
                    Err(error) => failures.push(error.to_string()),
                }
            }
            if failures.is_empty() { Ok(code) } else { Err(failures.join("\n").into()) }
        }
        Command::Check { profile } => {
            let profile = load(profile)?.profile;
            show(
                arguments,
                || visible(&format!("{}: valid ({})\n", profile.name, profile.sha256)),
                || line(&json!({ "name": profile.name, "sha256": profile.sha256 })),
            )?;
            Ok(PASSED)
        }
        Command::Verify { file, profile, align, units, out } => {
            let inspection = VerifyOptions {
                units: units.map(Into::into),
                align: align.then(|| out.clone().unwrap_or_else(|| "out".into())),
            };
            let report = inspect(&load(profile)?, file, &inspection, &progress)?;
            conclude(arguments, &report)
        }
        Command::Render { profile, scene, smooth, square_mm, unit_mm, allow_outside, out } => {
            let wanted = RenderOptions {
                scene,
                smooth: *smooth,
                square_mm: *square_mm,
                unit_mm: *unit_mm,
                allow_outside: *allow_outside,
            };
            let rendering = render(&load(profile)?, &wanted, out, &progress)?;
            conclude(arguments, &rendering)
        }
        Command::Unwrap { photo, profile, out, cuts, map, projection, width } => {
            let remap = Way::Remap {
                projection: projection.map(RowsArg::chosen),
                width: width.map(NonZeroUsize::get),
                map: map.map(MapFormatArg::chosen),
            };
            let way = if *cuts { Way::Cuts } else { remap };
            let unwrapped = unwrap(&load(profile)?, photo, way, out, &progress)?;
            conclude(arguments, &unwrapped)
        }
        Command::Frame { profile, min, out } => {
            let report = frame(&load(profile)?, out, *min, &progress)?;
            conclude(arguments, &report)
        }
        Command::Blur { profile, pupil_mm, na, focus_mm, out } => {
            let pupil = pupil_mm.map(|pupil_mm| Aperture::Pupil { pupil_mm });
            let aperture = pupil.or(na.map(|na| Aperture::Na { na }));
            let report = blur(&load(profile)?, aperture, *focus_mm, out, &progress)?;
            conclude(arguments, &report)
        }
        Command::Tolerance {
            profile: Some(named),
            replay: Some(trial),
            without,
            seed,
            out,
            ..
        } => {
            let wanted = ReplayOptions { trial: *trial, seed: *seed, without };
            let report = replay(named, &wanted, out, &progress)?;
            conclude(arguments, &report)
        }
        Command::Tolerance { profile, trials, seed, until, part, merge, out, .. } => {
            let trials = Trials { range: trials.clone(), seed: *seed, until: *until };
            let report = match profile {
                None => tolerance_merged(merge, out, &progress)?,
                Some(named) if *part => {
                    let part = tolerance_part(named, &trials, out, &progress)?;
                    let (path, trials) = (part.path.display().to_string(), part.trials);
                    print(&match arguments.format {
                        PrintFormat::Text => visible(&format!("{path}: {trials} trials\n")),
                        PrintFormat::Json => line(&json!({ "part": path, "trials": trials })),
                    })?;
                    return Ok(PASSED);
                }
                Some(named) => tolerance(named, &trials, out, &progress)?,
            };
            conclude(arguments, &report)
        }
        Command::Machining {
            profile,
            ball_mm,
            stepover_mm,
            angle_deg,
            budget_px,
            scallop_um,
            allowance_mm,
            no_as_cut,
            out,
        } => {
            let cutting = MachiningOptions {
                ball_mm: *ball_mm,
                stepover_mm: *stepover_mm,
                angle_deg: *angle_deg,
                budget_px: *budget_px,
                scallop_um: *scallop_um,
                allowance_mm: *allowance_mm,
                as_cut: !no_as_cut,
            };
            let found = machining(&load(profile)?, &cutting, out, &progress)?;
            conclude(arguments, &found)
        }
        Command::Bench { profiles, quick, suggest, out } => {
            let wanted =
                BenchOptions { profiles: profiles.clone(), quick: *quick, suggest_px: *suggest };
            let bench = bench(out, &wanted, &progress)?;
            conclude(arguments, &bench)?;
            let missed = bench.suggestions.iter().any(|found| found.settings.is_none());
            Ok(if missed && !profiles.is_empty() { FAILED } else { PASSED })
        }
        Command::Profiles { show: None } => {
            for Shipped { name, text } in shipped() {
                let summary = Profile::parse(name, name, text.as_bytes())?.summary;
                show(
                    arguments,
                    || format!("{name:21} {summary}\n"),
                    || line(&json!({ "name": name, "summary": summary })),
                )?;
            }
            Ok(PASSED)
        }
        Command::Profiles { show: Some(name) } => {
            let Some(profile) = shipped().iter().find(|profile| profile.name == name) else {
                return Err(
                    format!("no profile {name} is shipped; `morion profiles` lists them").into()
                );
            };
            print(profile.text)?;
            Ok(PASSED)
        }
    }
}

impl RowsArg {
    fn chosen(self) -> pipeline::Rows {
        match self {
            Self::Cylindrical => pipeline::Rows::Cylindrical,
            Self::Equirectangular => pipeline::Rows::Equirectangular,
            Self::Mercator => pipeline::Rows::Mercator,
        }
    }
}

impl MapFormatArg {
    fn chosen(self) -> pipeline::MapFormat {
        match self {
            Self::Npy => pipeline::MapFormat::Npy,
            Self::Exr => pipeline::MapFormat::Exr,
        }
    }
}

/// All profiles, or all their faults; two of one name would overwrite each other.
fn load_all(named: &[String]) -> Result<Vec<Source>, Failure> {
    let (mut sources, mut faults) = (Vec::<Source>::new(), Vec::new());
    for named in named {
        match load(named) {
            Ok(Source { profile, .. })
                if sources.iter().any(|s| s.profile.name == profile.name) =>
            {
                faults.push(format!("{named}: another profile is called {} too", profile.name));
            }
            Ok(source) => sources.push(source),
            Err(fault) => faults.push(fault.to_string()),
        }
    }
    if faults.is_empty() { Ok(sources) } else { Err(faults.join("\n").into()) }
}

/// Says on stderr what is no error; a message that nobody can read is not worth failing for.
fn warn(warning: &str) {
    let style = anstyle::Style::new().bold().fg_color(Some(anstyle::AnsiColor::Yellow.into()));
    let _ = writeln!(anstream::stderr(), "{style}warning{style:#}: {}", visible(warning));
}

/// Prints an answer, its warnings to stderr, and turns its verdict into an exit code.
fn conclude(arguments: &Arguments, answer: &impl Answer) -> Result<u8, Failure> {
    let head = answer.head();
    head.warnings.iter().for_each(|warning| warn(warning));
    show(arguments, || answer.text(), || answer.json())?;
    Ok(if head.verdict == Some(Verdict::Fail) { FAILED } else { PASSED })
}

/// Prints a result as asked.
fn show(
    arguments: &Arguments,
    text: impl FnOnce() -> String,
    json: impl FnOnce() -> String,
) -> Result<(), Failure> {
    print(&match arguments.format {
        PrintFormat::Text => styles::styled(&text()),
        PrintFormat::Json => json(),
    })
}

/// A JSON value on a line of its own.
fn line(value: &serde_json::Value) -> String {
    format!("{value}\n")
}

/// Prints to stdout; a reader that has gone away is no error.
fn print(text: &str) -> Result<(), Failure> {
    let mut out = anstream::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(format!("cannot write to standard output: {error}").into())
        }
        _ => Ok(()),
    }
}
