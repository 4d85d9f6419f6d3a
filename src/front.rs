//! The commands as functions with their usual options. Options of one's own, an observer of the stages, and
//! files in memory instead of a folder: [`Command`], which every options struct is.
//!
//! Their examples share a profile, `examples/small.toml`, and write into a temporary folder.

use crate::pipeline::{
    BlurOptions, BuildOptions, Command, DrawingOptions, Error, FrameOptions, InspectOptions,
    MachiningOptions, ProgramOptions, RenderOptions, ReplayOptions, Silent, TableOptions,
    ToleranceOptions, Unwrap, UnwrapOptions, Verify, VerifyOptions, dry_run,
};
use crate::profile::Profile;
use crate::results::{
    BlurReport, BuildForecast, BuildReport, DrawingReport, FrameReport, InspectionReport,
    MachiningReport, ProgramReport, RenderReport, ReplayReport, SweepReport, TableReport,
    ToleranceReport, UnwrapReport, VerifyReport,
};
use crate::sweep::{self, SweepStudy};
use std::path::Path;

/// Builds the part into `out/NAME`, reads each file back, traces it, and says whether it does its job.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::build(&profile, &out)?;
/// assert_eq!(report.verdict, morion::Verdict::Pass);
/// assert!(out.path().join("small/mirror.stl").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] when the folder cannot be written to or a stage cannot be done. (A part that fails its
/// limits is a report with a negative verdict.)
pub fn build(profile: &Profile, out: impl AsRef<Path>) -> Result<BuildReport, Error> {
    BuildOptions::default().publish(profile, out.as_ref(), &Silent)
}

/// Foresees a build: sizes, triangles and files, without meshing.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// let forecast = morion::forecast(&profile)?;
/// println!("{forecast:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] when the mirror cannot be designed.
pub fn forecast(profile: &Profile) -> Result<BuildForecast, Error> {
    dry_run(profile, &Silent)
}

/// Traces a mesh file of any making, as a part of `profile` in the part's frame.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// # morion::build(&profile, &out)?;
/// let report = morion::verify(&profile, out.path().join("small/mirror.stl"))?;
/// assert_eq!(report.verdict, morion::Verdict::Pass);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] when the file cannot be opened or named, or the mirror cannot be designed. (A file without a
/// sound mesh is a report with a negative verdict.)
pub fn verify(profile: &Profile, path: impl AsRef<Path>) -> Result<VerifyReport, Error> {
    let verify = Verify { path: path.as_ref(), options: VerifyOptions::default() };
    Ok(verify.in_memory(profile, &Silent)?.0)
}

/// Plans the points at which a measuring machine touches the part, into `out/NAME`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let plan = morion::inspect(&profile, &out)?;
/// assert!(plan.points > 40 && out.path().join("small/inspection.dmi").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`].
pub fn inspect(profile: &Profile, out: impl AsRef<Path>) -> Result<InspectionReport, Error> {
    InspectOptions::default().publish(profile, out.as_ref(), &Silent)
}

/// Draws the part for a shop to sign, into `out/NAME`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::drawing(&profile, &out)?;
/// assert!(report.drawing.slope_error_mrad.is_some() && out.path().join("small/drawing.pdf").exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`].
pub fn drawing(profile: &Profile, out: impl AsRef<Path>) -> Result<DrawingReport, Error> {
    DrawingOptions.publish(profile, out.as_ref(), &Silent)
}

/// Checks how well the sensor is filled, into `out/NAME`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::frame(&profile, &out)?;
/// assert!(report.frame.filled > 0.2 && report.frame.filled < 0.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and for a profile without a projection.
pub fn frame(profile: &Profile, out: impl AsRef<Path>) -> Result<FrameReport, Error> {
    FrameOptions::default().publish(profile, out.as_ref(), &Silent)
}

/// Computes the blur of each pixel by the profile's aperture, into `out/NAME`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::blur(&profile, &out)?;
/// println!("{report:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and for a camera without an aperture.
pub fn blur(profile: &Profile, out: impl AsRef<Path>) -> Result<BlurReport, Error> {
    BlurOptions::default().publish(profile, out.as_ref(), &Silent)
}

/// Renders what the camera sees in a scene, by its name or a file, into `out/NAME`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let picture = morion::render(&profile, "grid", &out)?;
/// assert_eq!(picture.pixels, [160, 120]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and for a scene that is none.
pub fn render(
    profile: &Profile,
    scene: &str,
    out: impl AsRef<Path>,
) -> Result<RenderReport, Error> {
    RenderOptions { scene, ..RenderOptions::default() }.publish(profile, out.as_ref(), &Silent)
}

/// Unwraps a photo taken through the mirror to a panorama, into `out/NAME`. Perspective views and plans of a floor, and the part as it is
/// mounted: [`Unwrap`] with [`UnwrapOptions::Remap`].
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// # let picture = morion::render(&profile, "grid", &out)?;
/// let photo = out.path().join("small").join(&picture.file);
/// let unwrapped = morion::unwrap(&profile, &photo, &out)?;
/// println!("{unwrapped:?}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and for a photo that is none or does not fit the frame.
pub fn unwrap(
    profile: &Profile,
    photo: impl AsRef<Path>,
    out: impl AsRef<Path>,
) -> Result<UnwrapReport, Error> {
    let unwrap = Unwrap { photo: photo.as_ref(), options: UnwrapOptions::default() };
    unwrap.publish(profile, out.as_ref(), &Silent)
}

/// Tables of what each pixel looks at, for other programs: directions, and back, into `out/NAME/table`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let tables = morion::table(&profile, &out)?;
/// println!("read between its nodes, table.h is off by {:?} px", tables.directions.off_px);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and for a profile without a projection.
pub fn table(profile: &Profile, out: impl AsRef<Path>) -> Result<TableReport, Error> {
    TableOptions::default().publish(profile, out.as_ref(), &Silent)
}

/// Surveys the cut by a ball cutter of 3 mm, at the stepover and in the direction that suit the pixels, and makes the
/// as-cut part, into `out/NAME`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::machining(&profile, &out)?;
/// assert_eq!(report.ball_mm, 3.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and where no raster keeps the budget.
pub fn machining(profile: &Profile, out: impl AsRef<Path>) -> Result<MachiningReport, Error> {
    MachiningOptions::default().publish(profile, out.as_ref(), &Silent)
}

/// Writes the programs that mill or turn the mirror as `[program]` of the profile asks, reads them back, cuts the stock with them and traces
/// what the last of them leaves, into `out/NAME/program`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::program(&profile, &out)?;
/// println!("{:.0} minutes on the machine", report.machine_min);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and where the ball does not fit.
pub fn program(profile: &Profile, out: impl AsRef<Path>) -> Result<ProgramReport, Error> {
    ProgramOptions.publish(profile, out.as_ref(), &Silent)
}

/// Studies the tolerances that the profile names by 2000 trials, into `out/NAME`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::tolerance(&profile, &out)?;
/// println!("{:.1} % of the parts keep the budget", 100.0 * report.study.yields.share);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`build`], and for errors that the mirror cannot have.
pub fn tolerance(profile: &Profile, out: impl AsRef<Path>) -> Result<ToleranceReport, Error> {
    ToleranceOptions::default().publish(profile, out.as_ref(), &Silent)
}

/// Makes the imperfect part of a trial of [`tolerance`], and traces it, into `out/NAME/replay-TRIAL`.
///
/// ```
/// # let profile = morion::Profile::parse("small", "small.toml", include_bytes!("../examples/small.toml"))?;
/// # let out = tempfile::tempdir()?;
/// let report = morion::replay(&profile, 7, &out)?;
/// assert_eq!((report.trial, report.seed), (7, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] as of [`tolerance`].
pub fn replay(profile: &Profile, trial: u64, out: impl AsRef<Path>) -> Result<ReplayReport, Error> {
    let seed = ToleranceOptions::default().seed;
    let options = ReplayOptions { trial, seed, ..ReplayOptions::default() };
    options.publish(profile, out.as_ref(), &Silent)
}

/// Runs the points of the study in the file `study` that no earlier run has made, and writes their rows into
/// `out/sweep/NAME`.
///
/// ```
/// # let out = tempfile::tempdir()?;
/// # std::fs::write(out.path().join("small.toml"), include_bytes!("../examples/small.toml"))?;
/// let study = out.path().join("study.toml");
/// std::fs::write(
///     &study,
///     "profile = 'small.toml'\n[[axis]]\nkey = 'part.base_mm'\nvalues = [4, 5]\n\
///      [[column]]\nkey = 'design.pixel_error_px.rms'\ngoal = 'least'\n",
/// )?;
/// let report = morion::sweep(&study, &out)?;
/// assert_eq!((report.points, report.made), (2, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`enum@Error`] when study or profile has a fault, or the folder cannot be written to. (A point without an answer is a
/// row.)
pub fn sweep(study: impl AsRef<Path>, out: impl AsRef<Path>) -> Result<SweepReport, Error> {
    sweep::sweep(&SweepStudy::load(study.as_ref())?, out.as_ref(), &Silent)
}
