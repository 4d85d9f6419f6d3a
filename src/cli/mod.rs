//! Arguments, terminal manners and exit codes.

mod args;
mod byte_streams;
mod commands;
mod failure;
mod memory;
mod number_args;
mod picture_args;
mod progress;
mod schemas;
mod shell_help;
#[cfg(unix)]
mod signals;
mod styles;

use crate::bench::{BenchOptions, bench};
use crate::parallel;
use crate::pipeline::{
    Command, DrawingOptions, ProgramOptions, ToleranceOptions, TrialsPart, check, dry_run, load,
    merge,
};
use crate::profile::{Profile, Shipped, shipped};
use crate::report::{Answer, TextLayout, visible};
use crate::results::{NamedOutput, PartTrials, ShardReport, ShippedProfile, Verdict};
#[cfg(feature = "studio")]
use crate::studio::{StudioOptions, serve};
use crate::sweep::{self, SweepStudy, sweep, sweep_shard};
#[cfg(feature = "studio")]
use args::StudioArgs;
use args::{
    Arguments, BenchArgs, BuildArgs, CommandArg, PrintFormat, ProfilesArgs, SchemaArgs, SweepArgs,
    ToleranceArgs,
};
use clap::Parser;
use failure::CommandFailure;
#[cfg(feature = "studio")]
use memory::has_room_for;
use memory::threads_with_room;
use picture_args::UnwrapArgs;
use progress::Progress;
use serde::Serialize;
use serde_json::json;
use std::io::{ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

/// The part passed.
const PASSED: u8 = 0;
/// A negative verdict.
const FAILED: u8 = 1;
/// It could not be done: usage, profile, input or output.
const UNABLE: u8 = 2;

/// Threads of the studio beside those that compute: one that listens, and one for each of a browser's connections.
#[cfg(feature = "studio")]
const STUDIO_THREADS: usize = 8;

/// Runs the program: parses the arguments, does the work, and returns the exit code.
#[must_use]
pub fn run() -> ExitCode {
    let arguments = Arguments::try_parse().unwrap_or_else(|error| unreadable(&error));
    arguments.color.write_global();
    #[cfg(unix)]
    signals::watch();
    let told = || {
        execute(&arguments).unwrap_or_else(|failure| {
            if arguments.format == PrintFormat::Json {
                // (Who cannot read it has the exit code.)
                let _ = print(&failure.json(), arguments.command.takes_stdout());
            }
            complain("error", anstyle::AnsiColor::Red, &failure.to_string());
            UNABLE
        })
    };
    ExitCode::from(parallel::within(threads_with_room(arguments.threads), told))
}

/// Says why the arguments cannot be read, or what help was asked for, and ends the program.
fn unreadable(error: &clap::Error) -> ! {
    let arguments: Vec<String> = std::env::args().collect();
    let as_json = arguments.iter().any(|word| word == "--format=json")
        || arguments.windows(2).any(|words| words == ["--format", "json"]);
    if error.use_stderr() && as_json {
        let _ = print(&CommandFailure::said(error.to_string()).json(), false);
    }
    error.exit()
}

fn execute(arguments: &Arguments) -> Result<u8, CommandFailure> {
    let Arguments { format, verbose, .. } = *arguments;
    let progress = Progress::new(arguments.quiet);
    let to_stderr = arguments.command.takes_stdout();
    let terminal = Terminal { format, verbose, lines: false, to_stderr, progress };
    match &arguments.command {
        CommandArg::Build(args) => {
            let lines = args.profiles.len() > 1;
            Terminal { lines, ..terminal }.build(args)
        }
        CommandArg::Check(args) => terminal.check(&args.profile),
        CommandArg::Verify(args) => {
            let out = args.out.as_deref().unwrap_or(Path::new("out"));
            match args.align || args.out.is_some() {
                true => terminal.publish(&args.command(), &args.profile, out),
                false => terminal.in_memory(&args.command(), &args.profile),
            }
        }
        CommandArg::Render(args) => terminal.publish(&args.options(), &args.profile, &args.out),
        CommandArg::Frame(args) => terminal.publish(&args.options(), &args.profile, &args.out),
        CommandArg::Unwrap(args) => terminal.unwrap(args),
        CommandArg::Table(args) => terminal.publish(&args.options(), &args.profile, &args.out),
        CommandArg::Blur(args) => terminal.publish(&args.options(), &args.profile, &args.out),
        CommandArg::Tolerance(args) => terminal.tolerance(args),
        CommandArg::Machining(args) => terminal.publish(&args.options(), &args.profile, &args.out),
        CommandArg::Program(args) => terminal.publish(&ProgramOptions, &args.profile, &args.out),
        CommandArg::Inspect(args) => terminal.publish(&args.options(), &args.profile, &args.out),
        CommandArg::Drawing(args) => terminal.publish(&DrawingOptions, &args.profile, &args.out),
        CommandArg::Sweep(args) => terminal.sweep(args),
        CommandArg::Bench(args) => terminal.bench(args),
        #[cfg(feature = "studio")]
        CommandArg::Studio(args) => terminal.studio(args),
        CommandArg::Profiles(args) => terminal.profiles(args),
        CommandArg::Schema(args) => terminal.schema(args),
        CommandArg::Completions(args) => {
            print(&shell_help::completions(args.shell), false).map(|()| PASSED)
        }
        CommandArg::Man(args) => {
            print(&shell_help::manual(args.command.as_deref())?, false).map(|()| PASSED)
        }
    }
}

/// Where results and progress go.
struct Terminal {
    format: PrintFormat,
    /// Whether details are shown.
    verbose: bool,
    /// Whether JSON is a line for each of several answers.
    lines: bool,
    /// Whether answers go to stderr.
    to_stderr: bool,
    progress: Progress,
}

impl Terminal {
    /// Runs a command on one profile, with its files below `out`, and prints its report.
    fn publish<C: Command>(
        &self,
        command: &C,
        named: &str,
        out: &Path,
    ) -> Result<u8, CommandFailure>
    where
        C::Report: Answer,
    {
        let profile = load(named)?;
        let report = command.publish(&profile, out, &self.progress)?;
        self.conclude(&report, Some(&out.join(command.folder(&profile))))
    }

    /// Runs a command on one profile that writes no files, and prints its report.
    fn in_memory<C: Command>(&self, command: &C, named: &str) -> Result<u8, CommandFailure>
    where
        C::Report: Answer,
    {
        self.conclude(&command.in_memory(&load(named)?, &self.progress)?.0, None)
    }

    /// Builds every profile; what could not be built is told at the end.
    fn build(&self, args: &BuildArgs) -> Result<u8, CommandFailure> {
        let (mut code, mut failures) = (PASSED, Vec::new());
        for source in &load_all(&args.profiles)? {
            let done = if args.dry_run {
                dry_run(source, &self.progress).map(|forecast| self.conclude(&forecast, None))
            } else {
                let options = args.options();
                let folder = args.out.join(options.folder(source));
                options
                    .publish(source, &args.out, &self.progress)
                    .map(|report| self.conclude(&report, Some(&folder)))
            };
            match done {
                Ok(concluded) => code = code.max(concluded?),
                Err(error) => failures.push(CommandFailure::from(error)),
            }
        }
        CommandFailure::none_of(failures).map(|()| code)
    }

    fn unwrap(&self, args: &UnwrapArgs) -> Result<u8, CommandFailure> {
        if let Some(why) = args.misplaced() {
            return Err(CommandFailure::said(why.into()));
        }
        let out = args.out.as_deref().unwrap_or(Path::new("out"));
        if args.is_stream() {
            let (mut input, mut output) = (byte_streams::input(), byte_streams::output());
            let profile = load(&args.profile)?;
            let report = args.stream().run(&profile, &mut input, &mut output, &self.progress)?;
            return self.conclude(&report, None);
        }
        match args.photo.is_dir() {
            true => self.publish(&args.folder(), &args.profile, out),
            false => self.publish(&args.command(), &args.profile, out),
        }
    }

    fn check(&self, named: &str) -> Result<u8, CommandFailure> {
        let valid = check(&load(named)?);
        self.show(|| valid.laid_out(&self.layout(None)), || line(&valid))?;
        Ok(PASSED)
    }

    fn tolerance(&self, args: &ToleranceArgs) -> Result<u8, CommandFailure> {
        let Some(named) = &args.profile else {
            return self.conclude(&merge(&args.merge, &args.out, &self.progress)?, None);
        };
        match args.replay {
            Some(trial) => self.publish(&args.replay(trial), named, &args.out),
            None if args.part => self.part(args.options(), named, &args.out),
            None => self.publish(&args.options(), named, &args.out),
        }
    }

    fn bench(&self, args: &BenchArgs) -> Result<u8, CommandFailure> {
        let BenchArgs { profiles, quick, suggest, out } = args;
        let options =
            BenchOptions { profiles: profiles.clone(), quick: *quick, suggest_px: *suggest };
        let bench = bench(out, &options, &self.progress)?;
        self.conclude(&bench, None)?;
        let missed = bench.suggestions.iter().any(|found| found.settings.is_none());
        Ok(if missed && !profiles.is_empty() { FAILED } else { PASSED })
    }

    /// Runs the points of a study, or those of one job, or prints the profile of a point.
    fn sweep(&self, args: &SweepArgs) -> Result<u8, CommandFailure> {
        let study = SweepStudy::load(&args.study)?;
        if let Some(point) = args.show {
            let missing = || {
                let last = study.points() - 1;
                CommandFailure::said(format!(
                    "--show must be a point from 0 to {last}, found {point}"
                ))
            };
            print(&study.profile_of(point).ok_or_else(missing)?, false)?;
            return Ok(PASSED);
        }
        if let Some(shard) = args.shard {
            let made = sweep_shard(&study, shard, &args.out, &self.progress)?;
            let ShardReport { journal, points } = &made;
            self.show(|| visible(&format!("{journal}: {points} points\n")), || line(&made))?;
            return Ok(PASSED);
        }
        let report = sweep(&study, &args.out, &self.progress)?;
        self.conclude(&report, Some(&args.out.join(sweep::folder(&study))))?;
        Ok(if report.made == 0 { FAILED } else { PASSED })
    }

    #[cfg(feature = "studio")]
    fn studio(&self, args: &StudioArgs) -> Result<u8, CommandFailure> {
        if !has_room_for(STUDIO_THREADS) {
            return Err(CommandFailure::said("memory is too short for a server's threads".into()));
        }
        let StudioArgs { profile, out, port, no_open } = args;
        let (profile, port, opens) = (profile.as_deref(), *port, !no_open);
        let options = StudioOptions { profile, out, port, opens };
        let mut told = Ok(());
        serve(&options, |address| {
            told = self
                .show(|| visible(&format!("{address}\n")), || line(&json!({ "address": address })));
        })?;
        told.map(|()| PASSED)
    }

    fn profiles(&self, args: &ProfilesArgs) -> Result<u8, CommandFailure> {
        if let Some(name) = &args.show {
            let known = shipped().iter().find(|profile| profile.name == name);
            let missing = || {
                CommandFailure::said(format!(
                    "no profile {name} is shipped; `morion profiles` lists them"
                ))
            };
            print(known.ok_or_else(missing)?.text, false)?;
            return Ok(PASSED);
        }
        for Shipped { name, text } in shipped() {
            let summary = Profile::parse(name, name, text.as_bytes())?.summary;
            let shipped = ShippedProfile { name: (*name).into(), summary };
            self.show(
                || {
                    let columns = columns(&std::io::stdout());
                    let layout = TextLayout { columns, ..TextLayout::default() };
                    layout.lines(&format!("{name:21} "), &shipped.summary, 22)
                },
                || line(&shipped),
            )?;
        }
        Ok(PASSED)
    }

    /// Prints the JSON Schema of an output, or lists the outputs.
    fn schema(&self, args: &SchemaArgs) -> Result<u8, CommandFailure> {
        if let Some(name) = &args.name {
            print(schemas::named(name)?, false)?;
            return Ok(PASSED);
        }
        let columns = columns(&std::io::stdout());
        let layout = TextLayout { columns, ..TextLayout::default() };
        for output in schemas::outputs() {
            let NamedOutput { name, what, from } = output;
            self.show(
                || layout.lines(&format!("{name:18} "), &format!("{what}: {from}"), 19),
                || line(&output),
            )?;
        }
        Ok(PASSED)
    }

    /// Prints an answer, whose files are in `folder`, its warnings to stderr, and turns its verdict into an exit
    /// code.
    fn conclude(&self, answer: &impl Answer, folder: Option<&Path>) -> Result<u8, CommandFailure> {
        let head = answer.head();
        let warn = |warning: &String| complain("warning", anstyle::AnsiColor::Yellow, warning);
        head.warnings.iter().for_each(warn);
        let folder = folder.map(|folder| folder.display().to_string());
        self.show(
            || answer.laid_out(&self.layout(folder.as_deref())),
            || if self.lines { answer.json_line() } else { answer.json() },
        )?;
        Ok(if head.verdict == Some(Verdict::Fail) { FAILED } else { PASSED })
    }

    /// How a summary is laid out; `folder`: where the files are.
    fn layout<'a>(&self, folder: Option<&'a str>) -> TextLayout<'a> {
        TextLayout { columns: columns(&std::io::stdout()), details: self.verbose, folder }
    }

    /// Makes the trials of a part of a run.
    fn part(
        &self,
        options: ToleranceOptions,
        named: &str,
        out: &Path,
    ) -> Result<u8, CommandFailure> {
        let part = TrialsPart(options).publish(&load(named)?, out, &self.progress)?;
        let made = PartTrials { part: part.path.display().to_string(), trials: part.trials };
        let PartTrials { part, trials } = &made;
        self.show(|| visible(&format!("{part}: {trials} trials\n")), || line(&made))?;
        Ok(PASSED)
    }

    /// Prints a result as asked.
    fn show(
        &self,
        text: impl FnOnce() -> String,
        json: impl FnOnce() -> String,
    ) -> Result<(), CommandFailure> {
        let text = match self.format {
            PrintFormat::Text => styles::styled(&text()),
            PrintFormat::Json => json(),
        };
        print(&text, self.to_stderr)
    }
}

/// All profiles, or all their faults; two of one name would overwrite each other.
fn load_all(named: &[String]) -> Result<Vec<Profile>, CommandFailure> {
    let (mut profiles, mut faults) = (Vec::<Profile>::new(), Vec::new());
    for named in named {
        match load(named) {
            Ok(profile) if profiles.iter().any(|other| other.name == profile.name) => {
                let same = format!("{named}: another profile is called {} too", profile.name);
                faults.push(CommandFailure::said(same));
            }
            Ok(profile) => profiles.push(profile),
            Err(fault) => faults.push(fault.into()),
        }
    }
    CommandFailure::none_of(faults).map(|()| profiles)
}

/// Says a message of a kind on stderr; one that nobody can read is not worth failing for. Each line of a message goes on under
/// its own first word.
fn complain(kind: &str, colour: anstyle::AnsiColor, message: &str) {
    let layout = TextLayout { columns: columns(&std::io::stderr()), ..TextLayout::default() };
    let (first, others) = message.split_once('\n').unwrap_or((message, ""));
    let mut lines = layout.lines(&format!("{kind}: "), first, 2);
    for line in others.lines() {
        let margin = line.len() - line.trim_start().len();
        lines += &layout.lines("", line, margin + 2);
    }
    let style = anstyle::Style::new().bold().fg_color(Some(colour.into()));
    let rest = lines.strip_prefix(kind).unwrap_or(&lines);
    let _ = write!(anstream::stderr(), "{style}{kind}{style:#}{rest}");
}

/// Letters in a line of a stream: what COLUMNS says, or else its terminal has; none where it is no terminal.
fn columns(stream: &impl IsTerminal) -> Option<usize> {
    let asked = std::env::var("COLUMNS").ok().and_then(|columns| columns.trim().parse().ok());
    let size = || stream.is_terminal().then(terminal_size::terminal_size).flatten();
    asked.or_else(|| size().map(|(width, _)| width.0.into()))
}

/// A JSON value on a line of its own.
fn line(answer: &impl Serialize) -> String {
    format!("{}\n", json!(answer))
}

/// Prints to stdout, or to stderr where frames take that; a reader that has gone away is no error.
fn print(text: &str, to_stderr: bool) -> Result<(), CommandFailure> {
    if to_stderr {
        // (As of messages.)
        let _ = anstream::stderr().write_all(text.as_bytes());
        return Ok(());
    }
    let mut out = anstream::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(CommandFailure::said(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}
