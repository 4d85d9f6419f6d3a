//! Stage order, files, progress: the one place where everything meets.
//!
//! A build designs, meshes, closes, writes, and then starts again from the bytes on the disk: what
//! was written is read, checked and traced like a stranger's file, and only then published under
//! its own name, with the report beside it.

mod advice;
mod bench;
mod examine;
mod facets;
mod files;
mod foresee;
mod observer;
mod shape;
mod source;
mod verdict;

pub use bench::bench;
pub use files::FileError;
pub use foresee::foresee;
pub use observer::{Observer, Silent, Stage};
pub use source::{Source, SourceError, load};

use crate::design::{Design, DesignError, design};
use crate::export::{Label, write_obj, write_stl};
use crate::geom::Precision;
use crate::mesh::{Face, MeshError};
use crate::profile::{Format, Profile};
use crate::report::{
    FileFacts, Limited, MeshFacts, OverOptimum, ProfileId, Report, SCHEMA, SolidFacts, html,
};
use crate::solid::{Solid, SolidError};
use advice::Advice;
use examine::{Evidence, examine, picture};
use facets::Facets;
use files::{Folder, Staged};
use observer::Clock;
use std::path::Path;
use thiserror::Error;

/// Why a build or a verification could not be done. (A part that turns out bad is no error: that is
/// a verdict.)
#[derive(Debug, Error)]
pub enum Error {
    /// The design has no answer.
    #[error("cannot design {profile}: {source}")]
    Design {
        /// Profile name.
        profile: String,
        /// Why.
        source: DesignError,
    },
    /// No mesh keeps the limits.
    #[error("cannot mesh {profile}: {source}")]
    Mesh {
        /// Profile name.
        profile: String,
        /// Why.
        source: MeshError,
    },
    /// An STL is the only file asked for, and single precision cannot carry the limits.
    #[error("cannot mesh {profile}: {reason}")]
    Single {
        /// Profile name.
        profile: String,
        /// Where, and what it carries.
        reason: String,
    },
    /// The body is not a solid.
    #[error("cannot close {profile} for {format}: {source}")]
    Solid {
        /// Profile name.
        profile: String,
        /// For which format.
        format: Format,
        /// Why.
        source: SolidError,
    },
    /// The disk refuses.
    #[error(transparent)]
    File(#[from] FileError),
    /// The picture cannot be encoded.
    #[error("cannot encode the picture: {0}")]
    Picture(String),
    /// The benchmark cannot run or be drawn.
    #[error("cannot benchmark: {0}")]
    Bench(String),
    /// A file to be verified is of no known format.
    #[error("{path}: the name must end in .stl or .obj")]
    Format {
        /// The file.
        path: String,
    },
}

/// Builds the profile of `source` into `out`/NAME: every stage, every file, and the report that is returned.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done; then nothing under `out` has changed but for new, empty
/// folders.
pub fn build(source: &Source, out: &Path, observer: &dyn Observer) -> Result<Report, Error> {
    let profile = &source.profile;
    let clock = Clock::new(observer);
    let folder = Folder::create(&out.join(&profile.name))?;

    let design = clock.stage(Stage::Design, || designed(source))?;
    let facets = clock.stage(Stage::Mesh, || meshed(profile, &design))?;
    let face = &facets.made;
    let solids = clock.stage(Stage::Solid, || closed(profile, &design, &facets))?;
    let label = Label {
        profile: profile.name.clone(),
        sha256: profile.sha256.clone(),
        tolerances: tolerances(profile, &design, face),
    };

    let staged = clock.stage(Stage::Write, || {
        let write = |(format, solid): &(Format, Solid)| {
            let staged = folder.stage(&format!("mirror.{format}"), |mut out| match format {
                Format::Stl => write_stl(&mut out, solid, &label),
                Format::Obj => write_obj(&mut out, solid, &design.mirror, face.designed, &label),
            })?;
            observer.written(staged.path());
            Ok((*format, staged))
        };
        let staged: Vec<(Format, Staged)> =
            solids.iter().map(write).collect::<Result<_, FileError>>()?;
        let note = format!("{} files", staged.len());
        Ok::<_, Error>((staged, note))
    })?;

    let mut evidence = Vec::new();
    for (format, staged) in &staged {
        let bytes = staged.read()?;
        let mut found = examine(&clock, profile, &design, *format, &bytes);
        found.altered = found.file.sha256 != staged.sha256();
        evidence.push(found);
    }

    let picture = clock.stage(Stage::Picture, || {
        let seen = evidence.iter().find_map(|e| e.seen.as_ref());
        let png = picture(&design, seen).map_err(|e| Error::Picture(e.to_string()))?;
        let note = format!("{} kB", png.len() / 1000);
        Ok::<_, Error>((png, note))
    })?;

    let mesh = mesh_facts(profile, &design, face, &solids[0].1);
    let solid = SolidFacts::new(solids[0].1.check(), design.volume());
    let mut report = assemble(profile, &design, Some((mesh, solid)), evidence, face.bound.chord_mm);
    if let Some(reason) = facets.refused.clone() {
        report.reasons.insert(0, reason);
        report.verdict = verdict::of(&report.reasons);
    }
    let advice = Advice { profile, design: &design, precision: facets.precision };
    let files: Vec<(&str, u64)> = report.files.iter().map(|f| (&*f.name, f.bytes)).collect();
    report.warnings = advice.on(mesh.triangles, &files);
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
        for format in Format::ALL.iter().filter(|format| !facets.formats.contains(format)) {
            folder.remove(&format!("mirror.{format}"))?;
        }
        // The report last: where it is new, everything it speaks of is.
        for staged in staged.into_iter().map(|(_, staged)| staged).chain(pages) {
            staged.publish()?;
        }
        Ok::<_, Error>(((), folder.path().display().to_string()))
    })?;
    Ok(report)
}

/// Reads an STL or OBJ of any making, checks it and traces it against what the profile of `source`
/// asks for.
///
/// # Errors
/// [`enum@Error`] when the file cannot be opened or named, or the profile cannot be designed. (A file
/// that opens but holds no sound mesh is a negative verdict.)
pub fn verify(source: &Source, path: &Path, observer: &dyn Observer) -> Result<Report, Error> {
    let profile = &source.profile;
    let clock = Clock::new(observer);
    let name = path.display().to_string();
    let format = match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("stl") => Format::Stl,
        Some("obj") => Format::Obj,
        _ => return Err(Error::Format { path: name }),
    };
    let bytes = files::read(path)?;
    let design = clock.stage(Stage::Design, || designed(source))?;
    let mut evidence = examine(&clock, profile, &design, format, &bytes);
    evidence.rename(name);
    // A file of unknown making has no proven bound; its shape is held to the profile's limit.
    const USUAL_CHORD_UM: f64 = 10.0;
    let chord_mm = 1e-3 * profile.mesh.chord_um.unwrap_or(USUAL_CHORD_UM);
    Ok(assemble(profile, &design, None, vec![evidence], chord_mm))
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

/// One checked solid for each format, with the digits that the format carries.
fn closed(
    profile: &Profile,
    design: &Design,
    facets: &Facets<Face>,
) -> Result<(Vec<(Format, Solid)>, String), Error> {
    let close = |&format: &Format| {
        let precision = match format {
            Format::Stl => Precision::Single,
            Format::Obj => Precision::Double,
        };
        let solid = Solid::from_face(&facets.made.mesh, design.stock.as_ref(), precision)
            .map_err(|source| Error::Solid { profile: profile.name.clone(), format, source })?;
        Ok((format, solid))
    };
    let solids: Vec<_> = facets.formats.iter().map(close).collect::<Result<_, Error>>()?;
    let note = format!("{} triangles, closed", solids[0].1.mesh().triangles.len());
    Ok((solids, note))
}

/// Tolerances asked and reached, for the files' headers.
fn tolerances(profile: &Profile, design: &Design, face: &Face) -> String {
    let limit = |limit: Option<f64>| limit.map_or("-".into(), |limit| limit.to_string());
    format!(
        "chord um {}:{:.3} facet px {}:{:.3}",
        limit(profile.mesh.chord_um),
        face.bound.chord_mm * 1e3,
        limit(profile.mesh.facet_px),
        face.bound.facet_mm / design.camera.pixel_mm,
    )
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
        mesh,
        solid,
        files,
        trace: trace.into_iter().flatten().collect(),
        frame,
        verdict: verdict::of(&reasons),
        reasons,
        warnings: Vec::new(),
    }
}
