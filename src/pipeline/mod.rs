//! Stage order, files, progress: the one place where everything meets.
//!
//! A build designs, meshes, closes, writes, and then starts again from the bytes on the disk: what
//! was written is read, checked and traced like a stranger's file, and only then published under
//! its own name, with the report beside it.

mod blur;
mod build;
mod build_cache;
mod cad_exports;
mod camera_view;
mod check_file;
mod dry_run;
mod error;
mod face;
mod files;
mod formats;
mod frame;
mod in_memory_build;
mod machining;
mod observer;
mod remedy;
mod render;
mod replay;
mod scenery;
mod sharpness;
mod size_warnings;
mod source;
mod tolerance;
mod tolerance_spec;
mod unwrap;
mod verdict;
mod verify;
mod vertex_check;

pub use crate::align::LengthUnit;
pub use blur::blur;
pub use build::{Effort, build, build_with};
pub use dry_run::dry_run;
pub use error::Error;
pub use files::{FileError, abandon};
pub use frame::frame;
pub use machining::{MachiningOptions, machining};
pub use observer::{Observer, Silent, Stage, Work};
pub use render::render;
pub use replay::{ReplayOptions, replay};
pub use scenery::{RenderOptions, SceneError};
pub use source::{Source, SourceError, load};
pub use tolerance::{Trials, TrialsFile, tolerance, tolerance_merged, tolerance_part};
pub use unwrap::{MapFormat, PhotoError, Rows, Way, unwrap};
pub use verify::{VerifyOptions, inspect, verify};

/// What the benchmark times and writes, stage by stage.
pub(crate) use {
    camera_view::above,
    check_file::expected_rays,
    files::{Folder, Staged, read as read_file},
    in_memory_build::build_in_memory,
    observer::StageTimer,
    tolerance_spec::{PreparedStudy, prepared},
};

use crate::design::{Design, design};
use crate::export::Label;
use crate::mesh::{ErrorBound, Face};
use crate::profile::{Format, Profile};
use crate::solid::Solid;
use face::AtPrecision;
use std::io::{self, Write};

pub(crate) fn designed(from: &Source) -> Result<(Design, String), Error> {
    let design = design(&from.profile, from.sag.as_ref())
        .map_err(|source| Error::Design { profile: from.profile.name.clone(), source })?;
    let note = design.facts.method.to_owned();
    Ok((design, note))
}

pub(crate) fn meshed(
    clock: &StageTimer,
    profile: &Profile,
    design: &Design,
) -> Result<(AtPrecision<Face>, String), Error> {
    let facets = face::face(profile, design)?;
    let mirror = &design.mirror;
    let all = facets.made.mesh.triangles.len();
    let reflections = mirror.reflections();
    let part = all / (reflections.len() + 1) / if mirror.folded { 2 } else { 1 };
    let mut done = part;
    if !clock.shortcuts() {
        for reflected in reflections {
            let reflected = Design { mirror: reflected, ..design.clone() };
            let again = face::face(profile, &reflected)?.made;
            if again.mesh != facets.made.mesh || again.bound != facets.made.bound {
                return Err(Error::Uneven { profile: profile.name.clone() });
            }
            done += part;
        }
    }
    clock.worked(Stage::Mesh, "facets meshed and proven", [done, all - done], "symmetry");
    let note = format!("{} optical triangles", facets.made.mesh.triangles.len());
    Ok((facets, note))
}

/// Writes one file under a temporary name.
fn write(
    clock: &StageTimer,
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

/// What every file says about itself: tolerances asked and reached, too.
fn label(profile: &Profile, design: &Design, bound: Option<&ErrorBound>) -> Label {
    let limit = |limit: Option<f64>| limit.map_or("-".into(), |limit| limit.to_string());
    let reached =
        |of: &dyn Fn(&ErrorBound) -> f64| bound.map_or("-".into(), |b| format!("{:.3}", of(b)));
    let tolerances = format!(
        "chord um {}:{} facet px {}:{}",
        limit(profile.mesh.chord_um),
        reached(&|bound| bound.chord_mm * 1e3),
        limit(profile.mesh.facet_px),
        reached(&|bound| bound.facet_mm / design.camera.pixel_mm),
    );
    labelled(profile, design, tolerances)
}

/// What a file says about itself, with what its mesh keeps to.
fn labelled(profile: &Profile, design: &Design, tolerances: String) -> Label {
    Label {
        profile: profile.name.clone(),
        sha256: profile.sha256.clone(),
        tolerances,
        mounting: design.mounting.statements(),
    }
}

fn close(
    profile: &Profile,
    design: &Design,
    face: &Face,
    format: Format,
) -> Result<(Solid, String), Error> {
    let solid = Solid::from_face(&face.mesh, design.border.as_ref(), formats::precision(format))
        .map_err(|source| Error::Solid { profile: profile.name.clone(), format, source })?;
    let note = format!("{} triangles, closed", solid.mesh().triangles.len());
    Ok((solid, note))
}
