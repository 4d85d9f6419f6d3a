//! The command line.

use super::number_args::{aperture, finite, percent, pixels, positive, shard, threads, trials};
use super::picture_args::{FrameArgs, RenderArgs, TableArgs, UnwrapArgs};
use crate::pipeline::LengthUnit;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::ops::Range;
use std::path::PathBuf;

/// Design freeform panoramic mirrors, write solids a machine shop can cut, and prove the files by
/// tracing rays.
#[derive(Debug, Parser)]
#[command(name = "morion", version, max_term_width = 100)]
#[command(after_help = "Exit code: 0 passed, 1 a negative verdict, 2 could not do it.")]
pub(super) struct Arguments {
    #[command(subcommand)]
    pub command: CommandArg,
    /// How results are printed
    #[arg(long, global = true, value_enum, default_value_t = PrintFormat::Text)]
    pub format: PrintFormat,
    /// No progress on stderr; warnings and errors stay
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Details that few ask for
    #[arg(long, short, global = true)]
    pub verbose: bool,
    /// Number of threads [default: one per core]; results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// When to colour; overrides NO_COLOR
    #[arg(long, global = true, value_enum, default_value_t = Colour::Auto, value_name = "WHEN")]
    pub color: Colour,
}

#[derive(Debug, Subcommand)]
pub(super) enum CommandArg {
    /// Design, mesh, write, read back, trace: every stage, into DIR/NAME/
    Build(BuildArgs),
    /// Validate a profile, and nothing else
    Check(CheckArgs),
    /// Check and ray-trace a file of any making, or measured points, against a profile
    Verify(VerifyArgs),
    /// A picture of a scene in the mirror, or of the mirror itself, into DIR/NAME/render-SCENE.png
    Render(RenderArgs),
    /// Check how the mirror fills the camera's frame; pictures and figures into DIR/NAME/
    Frame(FrameArgs),
    /// Turn a photo, or a video's frames, through the mirror into a panorama, a perspective view or a plan of the floor, into DIR/NAME/
    Unwrap(UnwrapArgs),
    /// Tables of what each pixel looks at, for other programs: directions and a floor, and back; into DIR/NAME/table/
    Table(TableArgs),
    /// Work out the spot that each pixel sees through an open lens; picture and figures into DIR/NAME/
    Blur(BlurArgs),
    /// How well it must be made and mounted, and what share of parts will be good, into DIR/NAME/
    Tolerance(ToleranceArgs),
    /// What a ball cutter makes of the mirror: fit, scallops, pixels, and the as-cut part, into DIR/NAME/
    Machining(MachiningArgs),
    /// Programs that mill or turn the mirror, read back, cut and traced: what comes off the machine, into DIR/NAME/program/
    Program(ProgramArgs),
    /// Plan the points of a coordinate measuring machine: a table and a program, into DIR/NAME/
    Inspect(InspectArgs),
    /// The drawing of the part that a shop signs, as PDF and DXF, into DIR/NAME/
    Drawing(DrawingArgs),
    /// Sweep keys of a profile as a study says: a row for each point, and the best of them, into DIR/sweep/NAME/
    Sweep(SweepArgs),
    /// Run time against error of design, mesh, witness, trials and programs, into DIR/bench/
    Bench(BenchArgs),
    /// A page on this machine in which a profile is changed and seen, until Ctrl-C; builds go into DIR/studio/
    #[cfg(feature = "studio")]
    Studio(StudioArgs),
    /// List the shipped profiles
    Profiles(ProfilesArgs),
    /// List the JSON outputs, or print the JSON Schema of one
    Schema(SchemaArgs),
    /// Print the script with which a shell completes commands and options
    Completions(CompletionsArgs),
    /// Print the manual page of the program, or of one command
    Man(ManArgs),
}

impl CommandArg {
    /// Whether standard output is taken by frames, so that everything else goes to stderr.
    pub(super) fn takes_stdout(&self) -> bool {
        matches!(self, Self::Unwrap(args) if args.is_stream())
    }
}

// Arguments of `morion build`.
#[derive(Debug, Args)]
pub(super) struct BuildArgs {
    /// Profile files, or names of shipped profiles
    #[arg(required = true, value_name = "PROFILE")]
    pub profiles: Vec<String>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Foresee the numbers of triangles and the sizes of the files, and write nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Build again even what the last build in the folder has left unchanged
    #[arg(long, conflicts_with = "dry_run")]
    pub force: bool,
    /// Do all that could be left undone without changing a byte
    #[arg(long, hide = true, conflicts_with = "dry_run")]
    pub no_skip: bool,
}

// Arguments of `morion check`.
#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
}

// Arguments of `morion verify`.
#[derive(Debug, Args)]
pub(super) struct VerifyArgs {
    /// The file: STL, OBJ, 3MF, GLB or STEP, in the part frame of the profile unless --align is given; with --align
    /// also measured points: CSV or XYZ (lines of X, Y, Z) or PLY; with --ball-mm or --nose-mm a program: NGC, NC, TAP, CNC, GCODE or XZC
    pub file: PathBuf,
    /// Profile file, or name of a shipped profile
    #[arg(long)]
    pub profile: String,
    /// Find the pose first (within 20 degrees and a fifth of the width), report the form error,
    /// and judge the file as a measured part: by what it shows, not as a solid
    #[arg(long)]
    pub align: bool,
    /// Unit of the file's coordinates [default: by its size]
    #[arg(long, value_enum, value_name = "UNIT")]
    pub units: Option<UnitArg>,
    /// Points are centres of the probe's ball of this radius [default: points on the part]
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub probe_mm: Option<f64>,
    /// Radius of the ball cutter whose tip a program moves, its origin on the part's base below the camera's axis
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub ball_mm: Option<f64>,
    /// Radius of the flat cutter whose tip a program moves; with --corner-mm it is bull-nosed
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub cutter_mm: Option<f64>,
    /// Radius of the rounded edge of the cutter of --cutter-mm [default: none]
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub corner_mm: Option<f64>,
    /// Radius of the nose of the tool that a program of a lathe moves, by the point at which it is touched off
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub nose_mm: Option<f64>,
    /// Folder for the report and its page, in DIR/NAME-verify/; with --align also for the form error's map
    /// [default: none; with --align: out]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

// Arguments of `morion blur`.
#[derive(Debug, Args)]
pub(super) struct BlurArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
    /// Diameter of a pinhole camera's entrance pupil [default: the profile's]
    #[arg(long, value_name = "MM", value_parser = positive)]
    #[arg(conflicts_with = "na")]
    pub pupil_mm: Option<f64>,
    /// Numerical aperture of a telecentric lens on the mirror's side [default: the profile's]
    #[arg(long, value_name = "NA", value_parser = aperture)]
    pub na: Option<f64>,
    /// Plane in focus: its distance from the entrance pupil, of a telecentric lens its height Z
    /// over the part's base [default: the focus that makes most spots small]
    #[arg(long, value_name = "MM", value_parser = finite, allow_negative_numbers = true)]
    pub focus_mm: Option<f64>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion tolerance`.
#[derive(Debug, Args)]
pub(super) struct ToleranceArgs {
    /// Profile file, or name of a shipped profile
    #[arg(required_unless_present = "merge")]
    pub profile: Option<String>,
    /// Number of trials, or the numbers of the first and of the one after the last: A..B
    #[arg(long, value_name = "N|A..B", default_value = "2000", value_parser = trials)]
    pub trials: Range<u64>,
    /// What the trials are drawn from
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// End early when the 95 % interval of the yield is no wider than this
    #[arg(long, value_name = "P%", value_parser = percent, conflicts_with = "part")]
    pub until: Option<f64>,
    /// Only make these trials, into DIR/NAME/trials-A-B.csv, for --merge
    #[arg(long)]
    pub part: bool,
    /// Make trial K's imperfect part, with its pose, into DIR/NAME/replay-K/, and trace it
    #[arg(long, value_name = "K", conflicts_with_all = ["trials", "until", "part"])]
    pub replay: Option<u64>,
    /// Leave this error out of the replayed part, such as stepover_mm
    #[arg(long, value_name = "SOURCE", requires = "replay")]
    pub without: Vec<String>,
    /// Answer by the trials of these parts, as if they had been made at once
    #[arg(
        long,
        value_name = "PART",
        num_args = 1..,
        conflicts_with_all = ["profile", "trials", "seed", "until", "part", "replay"]
    )]
    pub merge: Vec<PathBuf>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion inspect`.
#[derive(Debug, Args)]
pub(super) struct InspectArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
    /// Degree of the form that the points are enough for: three points to a degree across the mirror, 1 to 40
    #[arg(long, value_name = "D", default_value_t = 4)]
    pub degree: usize,
    /// Least distance of a point from rims, ridges and steps [default: 2 % of the width, 0.5 at least]
    #[arg(long, value_name = "MM")]
    pub margin_mm: Option<f64>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion drawing`.
#[derive(Debug, Args)]
pub(super) struct DrawingArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion program`.
#[derive(Debug, Args)]
pub(super) struct ProgramArgs {
    /// Profile file, or name of a shipped profile; its [program] tells stock, cutters and machine
    pub profile: String,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion machining`.
#[derive(Debug, Args)]
pub(super) struct MachiningArgs {
    /// Profile file, or name of a shipped profile
    pub profile: String,
    /// Radius of the ball
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub ball_mm: f64,
    /// Distance of the raster's lines in the plan (X, Y) [default: the largest that keeps --budget-px
    /// and --scallop-um]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub stepover_mm: Option<f64>,
    /// Direction of the lines from X towards Y [default: the one that is best for the pixels]
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub angle_deg: Option<f64>,
    /// Find the stepover at which 95 % of the unpolished face is within this pixel error, and hold
    /// W to it [default: the largest pixel error that a build is held to]
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pub budget_px: Option<f64>,
    /// Find the stepover at which no scallop is higher, and hold W to it
    #[arg(long, value_name = "UM", allow_negative_numbers = true)]
    pub scallop_um: Option<f64>,
    /// What the stock stands over the part on its four sides and on top
    #[arg(long, value_name = "MM", default_value_t = 0.0, allow_negative_numbers = true)]
    pub allowance_mm: f64,
    /// Leave out the as-cut part
    #[arg(long)]
    pub no_as_cut: bool,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion sweep`.
#[derive(Debug, Args)]
pub(super) struct SweepArgs {
    /// The study: a TOML file with a profile, axes and columns
    pub study: PathBuf,
    /// Only run the points of job K of N, into a journal of its own; a run without it takes what all jobs have made
    #[arg(long, value_name = "K/N", value_parser = shard)]
    pub shard: Option<[usize; 2]>,
    /// Print the profile of this point, and run nothing
    #[arg(long, value_name = "POINT", conflicts_with = "shard")]
    pub show: Option<usize>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion bench`.
#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    /// Profile files, or names of shipped profiles [default: all shipped ones]
    #[arg(value_name = "PROFILE")]
    pub profiles: Vec<String>,
    /// Few settings, one run of each
    #[arg(long)]
    pub quick: bool,
    /// Name the cheapest settings with this RMS pixel error, and write profiles that have them into
    /// DIR/bench/; exit code 1 where a named profile cannot reach it
    #[arg(long, value_name = "PX", value_parser = pixels)]
    pub suggest: Option<f64>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

// Arguments of `morion studio`.
#[cfg(feature = "studio")]
#[derive(Debug, Args)]
pub(super) struct StudioArgs {
    /// Profile file, or name of a shipped profile [default: conquistador]
    pub profile: Option<String>,
    /// Folder for results
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Port of 127.0.0.1 to listen on [default: one that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Only print the address
    #[arg(long)]
    pub no_open: bool,
}

// Arguments of `morion profiles`.
#[derive(Debug, Args)]
pub(super) struct ProfilesArgs {
    /// Print this one, to start from
    #[arg(long, value_name = "NAME")]
    pub show: Option<String>,
}

// Arguments of `morion schema`.
#[derive(Debug, Args)]
pub(super) struct SchemaArgs {
    /// Print the JSON Schema (draft 2020-12) of this output
    pub name: Option<String>,
}

// Arguments of `morion completions`.
#[derive(Debug, Args)]
pub(super) struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    pub shell: ShellArg,
}

/// A shell that completes what is typed.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum ShellArg {
    Bash,
    Zsh,
    Fish,
}

// Arguments of `morion man`.
#[derive(Debug, Args)]
pub(super) struct ManArgs {
    /// A command [default: the program]
    pub command: Option<String>,
}

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum PrintFormat {
    /// A readable summary
    Text,
    /// The report as JSON
    Json,
}

/// Unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum UnitArg {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Inches
    In,
    /// Micrometres
    Um,
}

impl From<UnitArg> for LengthUnit {
    fn from(units: UnitArg) -> Self {
        match units {
            UnitArg::Mm => Self::Mm,
            UnitArg::Cm => Self::Cm,
            UnitArg::M => Self::M,
            UnitArg::In => Self::In,
            UnitArg::Um => Self::Um,
        }
    }
}

/// When output is coloured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Colour {
    /// On terminals, unless NO_COLOR is set
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

impl Colour {
    /// Makes it hold for all later output.
    pub(super) fn write_global(self) {
        let choice = match self {
            Self::Auto => anstream::ColorChoice::Auto,
            Self::Always => anstream::ColorChoice::Always,
            Self::Never => anstream::ColorChoice::Never,
        };
        choice.write_global();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }

    #[test]
    fn trials_are_a_number_or_a_range() {
        assert_eq!(trials("2000"), Ok(0..2000));
        assert_eq!(trials("50_000..60000"), Ok(50_000..60_000));
        for wrong in ["", "0", "5..5", "7..3", "-1", "1e4", "0..20000000", "..", "3.5"] {
            assert!(trials(wrong).is_err(), "{wrong}");
        }
        assert_eq!((shard("1/1"), shard("3 / 8")), (Ok([1, 1]), Ok([3, 8])));
        assert!(
            ["", "0/2", "3/2", "1", "1/x", "1/9999999", "-1/2"]
                .iter()
                .all(|wrong| shard(wrong).is_err())
        );
        assert_eq!((percent("0.5%"), percent("2")), (Ok(0.005), Ok(0.02)));
        assert!(["0", "-1%", "101", "half", "nan"].iter().all(|wrong| percent(wrong).is_err()));
    }
}
