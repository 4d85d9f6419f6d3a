//! A build up to the ray trace, in memory: what would be written is read back and traced.

use super::check_file::{MeshSource, check_file};
use super::mesh_files::{close, label, meshed};
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::num::stats::Summary;
use crate::part::{Promise, codec};
use crate::profile::MeshFormat;
use crate::trace::{FrameFill, Scene};
use crate::verdict::EachStrip;

/// The mesh that a build would write first, as it is read back.
pub(crate) struct InMemoryBuild {
    /// The format that it was written in.
    pub format: MeshFormat,
    /// Error of the picture against the projection, px.
    pub pixel_error_px: Option<Summary>,
    /// What the frame as a whole sees, if the profile has a projection.
    pub frame: Option<FrameFill>,
    /// The mesh.
    pub scene: Scene,
}

/// Meshes, closes, writes in memory, reads back and traces the mirror of `design`; `each` is called with every
/// strip of the frame.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done.
pub(crate) fn build_in_memory(
    run: &Run,
    design: &Design,
    each: EachStrip,
) -> Result<InMemoryBuild, Error> {
    let failed = |reason: String| Error::Reread { profile: run.profile.name.clone(), reason };
    let face = run.stage(Stage::Mesh, || meshed(run, design))?;
    let format = face.formats[0];
    let solid = run.stage(Stage::Solid, || close(run, design, &face.made, format))?;
    let label = label(design, Some(&face.made.bound));
    let bytes = run.stage(Stage::Write, || {
        let mut bytes = Vec::new();
        let made = design.tool.is_none().then_some((&face.made, design));
        codec(format)
            .write(&mut bytes, &solid, made, &label)
            .map_err(|error| failed(error.to_string()))?;
        let note = format!("{}, {:.1} MB in memory", format.file_name(), bytes.len() as f64 / 1e6);
        Ok((bytes, note))
    })?;
    let promise = Promise::of_face(run.profile, design, &face.made);
    drop((face, solid));
    let found = check_file(run, design, format, MeshSource::Bytes(bytes), promise, each)?;
    match (found.scene, found.unreadable) {
        (Some(scene), _) => {
            let pixel_error_px = found.trace.and_then(|trace| trace.errors.pixel_error_px);
            Ok(InMemoryBuild { format, pixel_error_px, frame: found.frame, scene })
        }
        (None, reason) => {
            Err(failed(reason.map_or("nothing in it".into(), |reason| reason.to_string())))
        }
    }
}
