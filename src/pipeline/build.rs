//! A build: every stage, every file, and back from the bytes on the disk.

use super::build_cache::{self, BuildRecord, Output};
use super::cad_exports::{CadCheck, CadExports, check_table, fitted};
use super::camera_view::{CameraView, Distance, picture};
use super::check_file::check_file;
use super::dry_run::{check_room, least_bytes};
use super::face::{AtPrecision, left_out};
use super::files::{Folder, Staged};
use super::formats::{self, drawings, write_mesh};
use super::observer::{Observer, Stage, StageTimer};
use super::size_warnings::SizeWarnings;
use super::source::Source;
use super::verdict::Findings;
use super::{Error, close, designed, label, meshed, verdict, write};
use crate::design::Design;
use crate::export::Label;
use crate::export::step::FittedMirror;
use crate::geom::Precision;
use crate::mesh::Face;
use crate::mirror::{Form, Surface};
use crate::profile::{Format, Profile};
use crate::render::{TestWorld, World};
use crate::report::{
    BuildReport, Limited, MeshFacts, OverOptimum, ProfileId, Reason, SCHEMA, SharpnessFacts,
    SolidFacts, StepFacts,
};
use crate::solid::Solid;
use std::path::Path;

/// Builds the profile of `source` into `out`/NAME: every stage, every file, and the report that is returned.
///
/// Where the files of the last build are still there and would come out the same, it does nothing more.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done; then nothing under `out` has changed but for new, empty
/// folders.
pub fn build(source: &Source, out: &Path, observer: &dyn Observer) -> Result<BuildReport, Error> {
    build_with(source, out, Effort::Least, observer)
}

/// How much of the work that changes no result is done all the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// None.
    Least,
    /// What the last build in the folder has done already.
    Afresh,
    /// All of it: every copy of a symmetric mirror is meshed by itself and compared, and every ray is
    /// searched for and followed.
    Most,
}

/// [`build`] with more or less effort.
///
/// # Errors
/// As [`build`]; and with [`Effort::Most`] when a shortcut would have changed the result.
pub fn build_with(
    source: &Source,
    out: &Path,
    effort: Effort,
    observer: &dyn Observer,
) -> Result<BuildReport, Error> {
    let profile = &source.profile;
    let clock = StageTimer::new(observer);
    let clock = if effort == Effort::Most { clock.without_shortcuts() } else { clock };
    let asked = |format: &Format| profile.formats.contains(format);
    let inputs = build_cache::inputs(source);
    if effort == Effort::Least {
        let folder = out.join(&profile.name);
        if let Some((report, record)) = build_cache::unchanged(&folder, &inputs) {
            let folder = Folder::create(&folder)?;
            let timings = record.json(&clock);
            folder.stage("timings.json", |out| out.write_all(timings.as_bytes()))?.publish()?;
            observer.unchanged(folder.path());
            return Ok(report);
        }
    }
    let folder = Folder::create(&out.join(&profile.name))?;
    folder.ensure_space(least_bytes(profile))?;

    let design = clock.stage(Stage::Design, || designed(source))?;
    count_unknowns(&clock, &design);
    check_table(profile, &design)?;
    let fit = fitted(profile, &design)?;
    check_room(&folder, profile, &design, fit.as_ref())?;
    let facets = match clock.stage(Stage::Mesh, || meshed(&clock, profile, &design)) {
        Ok(facets) => Ok(facets),
        Err(error) => Err(left_out(profile, error)?),
    };
    let form = Form::of(&design.mirror);
    let precision = facets.as_ref().map_or(Precision::Double, |facets| facets.precision);
    let label = label(profile, &design, facets.as_ref().ok().map(|facets| &facets.made.bound));
    let drawing =
        CadExports { profile, design: &design, form: &form, fit: fit.as_ref(), label: &label };
    let meshes = match facets {
        Ok(facets) => write_meshes(profile, &clock, &folder, &design, facets, &label)?,
        Err(refused) => Meshes { refused: Some(refused), ..Meshes::default() },
    };
    let Meshes { mut staged, facts, chord_mm, formats, refused } = meshes;
    for format in drawings(profile) {
        staged.push((format, write(&clock, &folder, format, |out| drawing.write(format, out))?));
    }

    // One file at a time, so that memory does not grow with their number.
    let (mut evidence, mut checked, mut picture) = (Vec::new(), Vec::new(), None);
    for (format, staged) in &staged {
        let bytes = staged.read()?;
        if !format.is_mesh() {
            checked.push(check(&clock, &drawing, *format, staged, bytes));
            continue;
        }
        let mut found = check_file(&clock, profile, &design, *format, bytes, chord_mm);
        found.altered = found.file.sha256 != staged.sha256();
        // A mesh that is made for the rays alone is no file.
        if !asked(format) {
            found.rename(UNKEPT.to_owned());
        }
        let seen = found.seen.take();
        if let (None, Some(seen)) = (&picture, &seen) {
            picture = Some(painted(&clock, &design, CameraView::Mesh(seen))?);
        }
        evidence.push(found);
    }
    let picture = match picture {
        Some(picture) => picture,
        // Without a mesh file the designed mirror is what there is to see.
        None if evidence.is_empty() => painted(&clock, &design, CameraView::Smooth)?,
        None => painted(&clock, &design, CameraView::Shut)?,
    };

    // What the disk made of the bytes may be otherwise the next time.
    let altered = evidence.iter().any(|found| found.altered);
    let inputs = if altered { String::new() } else { inputs };
    let (mesh, solid) = facts.unzip();
    // A number of triangles sets no limit; what was proven of them is to be seen.
    let budget = mesh.filter(|mesh| mesh.max_triangles.is_some() && design.view.is_some());
    let proven_px = budget.map(|mesh| mesh.facet_px.bound);
    let mut findings = Findings::new(profile, &design, evidence, chord_mm, proven_px);
    let mut reasons: Vec<Reason> = refused.into_iter().chain(findings.reasons).collect();
    let mut sag = None;
    for CadCheck { file, reasons: faults, sag: found } in checked {
        reasons.extend(faults.into_iter().map(|reason| reason.of_file(&file.name)));
        findings.files.push(file);
        sag = sag.or(found);
    }
    let mut files = findings.files;
    // What was made for the rays alone stays nowhere.
    files.retain(|file| profile.formats.iter().any(|format| format.name() == file.format));
    let size = SizeWarnings { profile, design: &design, precision };
    let lengths: Vec<(&str, u64)> = files.iter().map(|f| (&*f.name, f.bytes)).collect();
    let mut warnings = size.on(mesh.map_or(0, |mesh| mesh.triangles), &lengths);
    warnings.extend(mesh.as_ref().and_then(|mesh| size.unspent(mesh)));
    let blurred = findings.sharpness.as_ref().and_then(SharpnessFacts::warning);
    warnings.extend(blurred.map(|warning| format!("{}: {warning}", profile.name)));
    let report = BuildReport {
        schema: SCHEMA,
        profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
        layout: Some(design.mounting),
        design: design.facts.clone(),
        form,
        mesh,
        solid,
        files,
        trace: findings.trace,
        sag,
        step: fit.as_ref().map(step_facts),
        frame: findings.frame,
        sharpness: findings.sharpness,
        accepted: findings.accepted,
        verdict: verdict::of(&reasons),
        reasons,
        warnings,
    };
    clock.stage(Stage::Report, || {
        let text =
            |name: &str, text: &str| folder.stage(name, |out| out.write_all(text.as_bytes()));
        let pages = [
            folder.stage("preview.png", |out| out.write_all(&picture))?,
            text("report.html", &report.html(&profile.summary, "preview.png"))?,
        ];
        let last = text("report.json", &report.json())?;
        // A file of a format that is not written now would be another profile's.
        let made =
            |format: &Format| asked(format) && (!format.is_mesh() || formats.contains(format));
        let old: Vec<&str> =
            Format::ALL.iter().filter(|format| !made(format)).map(|f| f.file_name()).collect();
        let files = staged.into_iter().filter(|(format, _)| asked(format)).map(|(_, file)| file);
        let files: Vec<Staged> = files.chain(pages).collect();
        let unasked = Format::ALL.len() - profile.formats.len();
        clock.worked(Stage::Write, "files", [files.len() + 1, unasked], "not asked for");
        let output = |file: &Staged| Output::of(file.path(), file.name());
        let outputs = files.iter().chain([&last]).filter_map(output).collect();
        let record = BuildRecord { inputs, outputs, work: clock.work() };
        let timings = text("timings.json", &record.json(&clock))?;
        // The report last: where it is new, all that it speaks of is, and before it is the record
        // matches nothing.
        folder.replace(files.into_iter().chain([timings, last]).collect(), &old)?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(report)
}

/// How a mesh is called that was made for the rays alone.
const UNKEPT: &str = "a mesh that was not kept";
/// What the stage that closes bodies counts, and why not every file needs one of its own.
const CLOSED: &str = "bodies closed and checked";
const SHARED: &str = "files with as many digits share one";

/// Mesh files under temporary names.
#[derive(Default)]
struct Meshes {
    staged: Vec<(Format, Staged)>,
    /// Of the first one.
    facts: Option<(MeshFacts, SolidFacts)>,
    /// Chord that was proven of the face.
    chord_mm: f64,
    /// The formats that are written.
    formats: Vec<Format>,
    /// Why others are not.
    refused: Option<Reason>,
}

/// Closes the face with the digits that each mesh format carries, and writes the files: with one
/// solid in memory at a time.
fn write_meshes(
    profile: &Profile,
    clock: &StageTimer,
    folder: &Folder,
    design: &Design,
    facets: AtPrecision<Face>,
    label: &Label,
) -> Result<Meshes, Error> {
    let (mut staged, mut facts) = (Vec::new(), None);
    let mut closed: Option<(Precision, Solid)> = None;
    for &format in &facets.formats {
        let solid = match closed.take() {
            Some((precision, solid)) if precision == formats::precision(format) => {
                clock.worked(Stage::Solid, CLOSED, [0, 1], SHARED);
                solid
            }
            before => {
                drop(before);
                clock.worked(Stage::Solid, CLOSED, [1, 0], SHARED);
                clock.stage(Stage::Solid, || close(profile, design, &facets.made, format))?
            }
        };
        facts.get_or_insert_with(|| {
            let mesh = mesh_facts(profile, design, &facets.made, &solid);
            (mesh, SolidFacts::new(solid.check(), design.volume()))
        });
        let made = (&facets.made, design);
        let file = write(clock, folder, format, |out| write_mesh(out, format, &solid, made, label));
        staged.push((format, file?));
        closed = Some((formats::precision(format), solid));
    }
    let AtPrecision { made, formats, refused, .. } = facets;
    Ok(Meshes { staged, facts, chord_mm: made.bound.chord_mm, formats, refused })
}

/// Reads a file that is no mesh.
fn check(
    clock: &StageTimer,
    drawing: &CadExports,
    format: Format,
    staged: &Staged,
    bytes: Vec<u8>,
) -> CadCheck {
    clock.always(Stage::Read, || {
        let mut checked = drawing.check(format, &bytes);
        if checked.file.sha256 != staged.sha256() {
            checked.reasons.insert(0, verdict::altered());
        }
        let note = format!("{}: as designed", checked.file.name);
        let note = checked.reasons.first().map_or(note, ToString::to_string);
        (checked, note)
    })
}

/// What the camera sees of the test world, as PNG.
fn painted(clock: &StageTimer, design: &Design, eye: CameraView) -> Result<Vec<u8>, Error> {
    clock.stage(Stage::Picture, || {
        let world = (&TestWorld::new() as &dyn World, Distance::Target);
        let png = picture(design, eye, world, 2).to_png();
        let png = png.map_err(|e| Error::Picture(e.to_string()))?;
        let note = format!("{} kB", png.len() / 1000);
        Ok((png, note))
    })
}

/// Counts what the design's symmetry saved.
fn count_unknowns(clock: &StageTimer, design: &Design) {
    if let (Surface::Tensor(sheet), unknowns @ 1..) =
        (&design.mirror.surface, design.facts.unknowns)
    {
        let (rows, columns) = sheet.series.shape();
        // The constant is no unknown.
        let odd = (rows * columns - 1).saturating_sub(unknowns);
        clock.worked(Stage::Design, "coefficients solved for", [unknowns, odd], "symmetry");
    }
}

fn step_facts(fit: &FittedMirror) -> StepFacts {
    StepFacts { fit_error_nm: fit.error_mm * 1e6, control_points: fit.size() }
}

fn mesh_facts(profile: &Profile, design: &Design, face: &Face, solid: &Solid) -> MeshFacts {
    let pixel = design.camera.pixel_mm;
    let optical_triangles = face.mesh.triangles.len();
    let over = |least: Option<f64>| least.map(|least| optical_triangles as f64 / least);
    MeshFacts {
        optical_triangles,
        triangles: solid.mesh().triangles.len(),
        max_triangles: profile.mesh.max_triangles,
        vertices: solid.mesh().vertices.len(),
        chord_um: Limited { limit: profile.mesh.chord_um, bound: face.bound.chord_mm * 1e3 },
        facet_px: Limited { limit: profile.mesh.facet_px, bound: face.bound.facet_mm / pixel },
        rounding_px: face.bound.rounding_mm / pixel,
        over_optimum: OverOptimum {
            chord: profile.mesh.chord_um.and_then(|um| over(face.optimum.chord(um * 1e-3))),
            facet: profile.mesh.facet_px.and_then(|px| over(face.optimum.facet(px * pixel))),
        },
    }
}
