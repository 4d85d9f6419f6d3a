//! Stage order, files, progress: the one place where everything meets.
//!
//! A build designs, meshes, closes, writes, and then starts again from the bytes on the disk: what
//! was written is read, checked and traced like a stranger's file, and only then published under
//! its own name, with the report beside it.

mod advice;
mod bench;
mod blur;
mod drawings;
mod error;
mod examine;
mod facets;
mod files;
mod foresee;
mod formats;
mod frame;
mod machining;
mod observer;
mod render;
mod replay;
mod reread;
mod scenery;
mod shape;
mod sight;
mod source;
mod tolerance;
mod unwrap;
mod verdict;
mod verify;

pub use crate::align::Unit;
pub use bench::bench;
pub use blur::blur;
pub use error::Error;
pub use files::FileError;
pub use foresee::foresee;
pub use frame::frame;
pub use machining::{Cutting, machining};
pub use observer::{Observer, Silent, Stage};
pub use render::render;
pub use replay::{Replayed, replay};
pub use scenery::{SceneError, Wanted};
pub use source::{Source, SourceError, load};
pub use tolerance::{Part, Trials, tolerance, tolerance_merged, tolerance_part};
pub use unwrap::{MapFormat, PhotoError, Rows, Way, unwrap};
pub use verify::{Inspection, inspect, verify};

use crate::design::{Design, design};
use crate::export::Label;
use crate::export::step::Fit;
use crate::geom::Precision;
use crate::mesh::Face;
use crate::mirror::Form;
use crate::profile::{Format, Profile};
use crate::render::{TestWorld, World};
use crate::report::{
    FileFacts, Limited, MeshFacts, OverOptimum, ProfileId, Report, SCHEMA, SolidFacts, StepFacts,
    html,
};
use crate::solid::Solid;
use advice::Advice;
use drawings::{Checked, Drawing, check_table, fitted};
use examine::{Evidence, examine};
use facets::Facets;
use files::{Folder, Staged};
use foresee::{check_room, least_bytes};
use formats::{drawings, write_mesh};
use observer::Clock;
use sight::{Distance, Eye, picture};
use std::io::{self, Write};
use std::path::Path;

/// Builds the profile of `source` into `out`/NAME: every stage, every file, and the report that is returned.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done; then nothing under `out` has changed but for new, empty
/// folders.
pub fn build(source: &Source, out: &Path, observer: &dyn Observer) -> Result<Report, Error> {
    let profile = &source.profile;
    let clock = Clock::new(observer);
    let folder = Folder::create(&out.join(&profile.name))?;
    folder.holds(least_bytes(profile))?;

    let design = clock.stage(Stage::Design, || designed(source))?;
    check_table(profile, &design)?;
    let fit = fitted(profile, &design)?;
    check_room(&folder, profile, &design, fit.as_ref())?;
    let facets = clock.stage(Stage::Mesh, || meshed(profile, &design))?;
    let form = Form::of(&design.mirror);
    let label = label(profile, &design, &facets.made);
    let drawing =
        Drawing { profile, design: &design, form: &form, fit: fit.as_ref(), label: &label };
    let Meshes { mut staged, facts } =
        write_meshes(profile, &clock, &folder, &design, &facets, &label)?;
    for format in drawings(profile) {
        staged.push((format, write(&clock, &folder, format, |out| drawing.write(format, out))?));
    }
    let Facets { made, precision, formats, refused } = facets;
    let chord_mm = made.bound.chord_mm;
    drop(made);

    // One file at a time, so that memory does not grow with their number.
    let (mut evidence, mut checked, mut picture) = (Vec::new(), Vec::new(), None);
    for (format, staged) in &staged {
        let bytes = staged.read()?;
        if !format.is_mesh() {
            checked.push(check(&clock, &drawing, *format, staged, bytes));
            continue;
        }
        let mut found = examine(&clock, profile, &design, *format, bytes);
        found.altered = found.file.sha256 != staged.sha256();
        let seen = found.seen.take();
        if let (None, Some(seen)) = (&picture, &seen) {
            picture = Some(painted(&clock, &design, Eye::Mesh(seen))?);
        }
        evidence.push(found);
    }
    let picture = match picture {
        Some(picture) => picture,
        None => painted(&clock, &design, Eye::Shut)?,
    };

    let mut report = assemble(profile, &design, form, Some(facts), evidence, chord_mm);
    let mut all: Vec<String> = refused.into_iter().chain(report.reasons).collect();
    for Checked { file, reasons, sag } in checked {
        all.extend(reasons.into_iter().map(|reason| format!("{}: {reason}", file.name)));
        report.files.push(file);
        report.sag = report.sag.or(sag);
    }
    report.step = fit.as_ref().map(step_facts);
    report.verdict = verdict::of(&all);
    report.reasons = all;
    // What was made for the rays alone stays nowhere.
    let asked = |format: &Format| profile.formats.contains(format);
    report.files.retain(|file| profile.formats.iter().any(|format| format.name() == file.format));
    let advice = Advice { profile, design: &design, precision };
    let files: Vec<(&str, u64)> = report.files.iter().map(|f| (&*f.name, f.bytes)).collect();
    report.warnings = advice.on(report.mesh.map_or(0, |mesh| mesh.triangles), &files);
    clock.stage(Stage::Report, || {
        let text =
            |name: &str, text: &str| folder.stage(name, |out| out.write_all(text.as_bytes()));
        let pages = [
            folder.stage("preview.png", |out| out.write_all(&picture))?,
            text("report.html", &html(&report, &profile.summary, "preview.png"))?,
            text("timings.json", &clock.json())?,
            text("report.json", &report.json())?,
        ];
        // A file of a format that is not written now would be another profile's.
        let made =
            |format: &Format| asked(format) && (!format.is_mesh() || formats.contains(format));
        let old: Vec<&str> =
            Format::ALL.iter().filter(|format| !made(format)).map(|f| f.file_name()).collect();
        old.iter().try_for_each(|name| folder.clears(name))?;
        let files = staged.into_iter().filter(|(format, _)| asked(format)).map(|(_, file)| file);
        // The report last: where it is new, everything it speaks of is.
        for staged in files.chain(pages) {
            staged.publish()?;
        }
        old.iter().try_for_each(|name| folder.remove(name))?;
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(report)
}

/// Mesh files under temporary names.
struct Meshes {
    staged: Vec<(Format, Staged)>,
    /// Of the first one.
    facts: (MeshFacts, SolidFacts),
}

/// Closes the face with the digits that each mesh format carries, and writes the files: with one
/// solid in memory at a time.
fn write_meshes(
    profile: &Profile,
    clock: &Clock,
    folder: &Folder,
    design: &Design,
    facets: &Facets<Face>,
    label: &Label,
) -> Result<Meshes, Error> {
    let (mut staged, mut facts) = (Vec::new(), None);
    let mut closed: Option<(Precision, Solid)> = None;
    for &format in &facets.formats {
        let solid = match closed.take() {
            Some((precision, solid)) if precision == formats::precision(format) => solid,
            before => {
                drop(before);
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
    Ok(Meshes { staged, facts: facts.expect("every build has a mesh format") })
}

fn close(
    profile: &Profile,
    design: &Design,
    face: &Face,
    format: Format,
) -> Result<(Solid, String), Error> {
    let solid = Solid::from_face(&face.mesh, design.stock.as_ref(), formats::precision(format))
        .map_err(|source| Error::Solid { profile: profile.name.clone(), format, source })?;
    let note = format!("{} triangles, closed", solid.mesh().triangles.len());
    Ok((solid, note))
}

/// Writes one file under a temporary name.
fn write(
    clock: &Clock,
    folder: &Folder,
    format: Format,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<Staged, Error> {
    clock.stage(Stage::Write, || {
        let staged = folder.stage(format.file_name(), write)?;
        clock.written(staged.path());
        Ok((staged, format.file_name().to_owned()))
    })
}

/// Reads a file that is no mesh.
fn check(
    clock: &Clock,
    drawing: &Drawing,
    format: Format,
    staged: &Staged,
    bytes: Vec<u8>,
) -> Checked {
    clock.always(Stage::Read, || {
        let mut checked = drawing.check(format, &bytes);
        if checked.file.sha256 != staged.sha256() {
            checked.reasons.insert(0, verdict::ALTERED.to_owned());
        }
        let note = format!("{}: as designed", checked.file.name);
        let note = checked.reasons.first().cloned().unwrap_or(note);
        (checked, note)
    })
}

/// What the camera sees of the test world, as PNG.
fn painted(clock: &Clock, design: &Design, eye: Eye) -> Result<Vec<u8>, Error> {
    clock.stage(Stage::Picture, || {
        let world = (&TestWorld::new() as &dyn World, Distance::Target);
        let png = picture(design, eye, world, 2).to_png();
        let png = png.map_err(|e| Error::Picture(e.to_string()))?;
        let note = format!("{} kB", png.len() / 1000);
        Ok((png, note))
    })
}

fn designed(from: &Source) -> Result<(Design, String), Error> {
    let design = design(&from.profile, from.sag.as_ref())
        .map_err(|source| Error::Design { profile: from.profile.name.clone(), source })?;
    let note = design.facts.method.to_owned();
    Ok((design, note))
}

fn meshed(profile: &Profile, design: &Design) -> Result<(Facets<Face>, String), Error> {
    let facets = facets::face(profile, design)?;
    let note = format!("{} optical triangles", facets.made.mesh.triangles.len());
    Ok((facets, note))
}

/// What every file says about itself: tolerances asked and reached, too.
fn label(profile: &Profile, design: &Design, face: &Face) -> Label {
    let limit = |limit: Option<f64>| limit.map_or("-".into(), |limit| limit.to_string());
    let tolerances = format!(
        "chord um {}:{:.3} facet px {}:{:.3}",
        limit(profile.mesh.chord_um),
        face.bound.chord_mm * 1e3,
        limit(profile.mesh.facet_px),
        face.bound.facet_mm / design.camera.pixel_mm,
    );
    Label { profile: profile.name.clone(), sha256: profile.sha256.clone(), tolerances }
}

fn step_facts(fit: &Fit) -> StepFacts {
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

fn assemble(
    profile: &Profile,
    design: &Design,
    form: Form,
    made: Option<(MeshFacts, SolidFacts)>,
    evidence: Vec<Evidence>,
    chord_mm: f64,
) -> Report {
    let (mesh, solid) = made.unzip();
    // A number of triangles sets no limit; what was proven of them is to be seen.
    let budget = mesh.filter(|mesh| mesh.max_triangles.is_some() && design.view.is_some());
    let proven_px = budget.map(|mesh| mesh.facet_px.bound);
    let reasons = verdict::reasons(profile, design, &evidence, chord_mm, proven_px);
    let frame = evidence.iter().find_map(|e| e.frame.clone());
    let (files, trace): (Vec<FileFacts>, Vec<_>) =
        evidence.into_iter().map(|e| (e.file, e.trace)).unzip();
    Report {
        schema: SCHEMA,
        profile: ProfileId { name: profile.name.clone(), sha256: profile.sha256.clone() },
        design: design.facts.clone(),
        form,
        mesh,
        solid,
        files,
        trace: trace.into_iter().flatten().collect(),
        sag: None,
        step: None,
        units: None,
        alignment: None,
        form_error_um: None,
        frame,
        verdict: verdict::of(&reasons),
        reasons,
        warnings: Vec::new(),
    }
}
