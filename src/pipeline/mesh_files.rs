//! Mesh files of a build: the face closed with the digits that each format carries, and written.

use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::export::Label;
use crate::geom::Precision;
use crate::mesh::{ErrorBound, Face, Limits};
use crate::num::units::{Mm, Um};
use crate::part::{AtPrecision, Promise, closed as closed_body, codec, face, limits};
use crate::profile::{MeshFormat, Profile};
use crate::results::{Limited, MeshFacts, OverOptimum, Refusal, SolidFacts};
use crate::solid::Solid;

/// What the stage that closes bodies counts, and why not every file needs one of its own.
const CLOSED: &str = "bodies closed and checked";
const SHARED: &str = "files with as many digits share one";

/// Mesh files, written but not published.
pub(super) struct MeshFiles {
    /// Figures of the mesh and the first solid.
    pub facts: Option<(MeshFacts, SolidFacts)>,
    /// [`Face::next_finer`].
    pub next_finer: Option<usize>,
    /// The errors that they may have.
    pub promise: Promise,
    /// Their digits.
    pub precision: Precision,
    /// Their formats.
    pub formats: Vec<MeshFormat>,
    /// Why others are not written.
    pub refused: Option<Refusal>,
    /// The solid that the file in the format [`GUESSED`] was written of, until that is read.
    written: Option<Solid>,
}

/// The format that is read in less time where its solid is at hand.
const GUESSED: MeshFormat = MeshFormat::Stl;

impl MeshFiles {
    /// Takes the solid that the file in a format was written of, if it is at hand.
    pub(super) fn take_written(&mut self, format: MeshFormat) -> Option<Solid> {
        self.written.take_if(|_| format == GUESSED)
    }
}

/// Closes the face and writes a file in each of its formats: with one solid in memory at a time.
///
/// # Errors
/// [`Error::Solid`] when the face cannot be closed, [`Error::File`] when the disk refuses.
pub(super) fn write_meshes(
    run: &mut Run,
    design: &Design,
    face: AtPrecision<Face>,
    label: &Label,
) -> Result<MeshFiles, Error> {
    let mut closed: Option<(Precision, Solid)> = None;
    let mut facts = None;
    for &format in &face.formats {
        let solid = match closed.take() {
            Some((shared, solid)) if shared == codec(format).precision() => {
                run.timer.worked(Stage::Solid, CLOSED, [0, 1], SHARED);
                solid
            }
            before => {
                drop(before);
                run.timer.worked(Stage::Solid, CLOSED, [1, 0], SHARED);
                run.stage(Stage::Solid, || close(run, design, &face.made, format))?
            }
        };
        facts.get_or_insert_with(|| {
            let mesh = mesh_facts(run.profile, design, &face.made, &solid);
            (mesh, SolidFacts::new(solid.check(), design.made_body().1))
        });
        // A tool's normals are not the mirror's.
        let made = design.tool.is_none().then_some((&face.made, design));
        run.write(format.file_name(), |out| codec(format).write(out, &solid, made, label))?;
        closed = Some((codec(format).precision(), solid));
    }
    let promise = Promise::of_face(run.profile, design, &face.made);
    let next_finer = face.made.next_finer;
    let AtPrecision { precision, formats, refused, .. } = face;
    // (The last solid alone: there is never more than one in memory.)
    let is_guessed = |(digits, _): &(Precision, Solid)| {
        formats.contains(&GUESSED) && *digits == codec(GUESSED).precision()
    };
    let written = closed.filter(is_guessed).map(|(_, solid)| solid);
    Ok(MeshFiles { facts, next_finer, promise, precision, formats, refused, written })
}

/// The face that the profile asks for, with a note for the observer. Unless shortcuts are allowed, every
/// copy of a symmetric mirror is meshed by itself and compared.
///
/// # Errors
/// [`Error::Mesh`], and [`Error::Uneven`] when a copy differs.
pub(crate) fn meshed(run: &Run, design: &Design) -> Result<(AtPrecision<Face>, String), Error> {
    let profile = run.profile;
    let face = |design: &Design| face(profile, design).map_err(|error| Error::face(profile, error));
    let found = face(design)?;
    let mirror = &design.mirror;
    let all = found.made.mesh.triangles.len();
    let reflections = mirror.reflections();
    let part = all / (reflections.len() + 1) / if mirror.folded { 2 } else { 1 };
    let mut done = part;
    if !run.timer.shortcuts() {
        for reflected in reflections {
            let reflected = Design { mirror: reflected, ..design.clone() };
            let again = face(&reflected)?.made;
            if again.mesh != found.made.mesh || again.bound != found.made.bound {
                return Err(Error::Uneven { profile: profile.name.clone() });
            }
            done += part;
        }
    }
    run.timer.worked(Stage::Mesh, "facets meshed and proven", [done, all - done], "symmetry");
    let note = format!("{all} optical triangles");
    Ok((found, note))
}

/// Closes a face with the digits of a format; with a note for the observer.
///
/// # Errors
/// [`Error::Solid`] when it cannot be closed.
pub(super) fn close(
    run: &Run,
    design: &Design,
    face: &Face,
    format: MeshFormat,
) -> Result<(Solid, String), Error> {
    let solid = closed_body(design, &face.mesh, codec(format).precision())
        .map_err(|source| Error::Solid { profile: run.profile.name.clone(), format, source })?;
    let note = format!("{} triangles, closed", solid.mesh().triangles.len());
    Ok((solid, note))
}

/// The words of every file of a build on its mirror: tolerances asked and reached, too.
pub(crate) fn label(design: &Design, bound: Option<&ErrorBound>) -> Label {
    let mesh = design.profile.mesh;
    let limit = |limit: Option<f64>| limit.map_or("-".into(), |limit| limit.to_string());
    let reached =
        |of: &dyn Fn(&ErrorBound) -> f64| bound.map_or("-".into(), |b| format!("{:.3}", of(b)));
    let tolerances = format!(
        "chord um {}:{} facet px {}:{}",
        limit(mesh.chord_um()),
        reached(&|bound| Um::from(Mm(bound.chord_mm)).0),
        limit(mesh.facet_px()),
        reached(&|bound| design.camera.to_px(Mm(bound.facet_mm)).0),
    );
    labelled(design, tolerances)
}

/// The words of a file on the mirror of `design`, with what it keeps to.
pub(super) fn labelled(design: &Design, tolerances: String) -> Label {
    let Profile { name, sha256, .. } = &*design.profile;
    let mounting = design.mounting.statements();
    Label { profile: name.clone(), sha256: sha256.clone(), tolerances, mounting }
}

fn mesh_facts(profile: &Profile, design: &Design, face: &Face, solid: &Solid) -> MeshFacts {
    let camera = &design.camera;
    let px = |mm: f64| camera.to_px(Mm(mm)).0;
    let goal = profile.mesh;
    let optical_triangles = face.mesh.triangles.len();
    let over = |least: Option<f64>| least.map(|least| optical_triangles as f64 / least);
    let Limits { chord_mm, facet_mm, .. } = limits(profile, design, Precision::Double);
    MeshFacts {
        optical_triangles,
        triangles: solid.mesh().triangles.len(),
        max_triangles: goal.max_triangles(),
        vertices: solid.mesh().vertices.len(),
        chord_um: Limited { limit: goal.chord_um(), bound: Um::from(Mm(face.bound.chord_mm)).0 },
        facet_px: Limited { limit: goal.facet_px(), bound: px(face.bound.facet_mm) },
        rounding_px: px(face.bound.rounding_mm),
        over_optimum: OverOptimum {
            chord: chord_mm.and_then(|mm| over(face.optimum.chord(mm))),
            facet: facet_mm.and_then(|mm| over(face.optimum.facet(mm))),
        },
    }
}
