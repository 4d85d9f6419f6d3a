//! A build up to the ray trace, in memory: what would be written is read back and traced.

use super::check_file::check_file;
use super::mesh_files::{close, label, meshed};
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::part::{Promise, codec};
use crate::profile::MeshFormat;
use crate::render::TracedMesh;
use crate::trace::FrameFill;

/// The mesh that a build would write first, as it is read back.
pub(crate) struct InMemoryBuild {
    /// The format that it was written in.
    pub format: MeshFormat,
    /// What the frame as a whole sees, if the profile has a projection.
    pub frame: Option<FrameFill>,
    /// The mesh and the witness's rays.
    pub seen: TracedMesh,
}

/// Meshes, closes, writes in memory, reads back and traces the mirror of `design`.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done.
pub(crate) fn build_in_memory(run: &Run, design: &Design) -> Result<InMemoryBuild, Error> {
    let failed = |reason: String| Error::Reread { profile: run.profile.name.clone(), reason };
    let face = run.stage(Stage::Mesh, || meshed(run, design))?;
    let format = face.formats[0];
    let solid = run.stage(Stage::Solid, || close(run, design, &face.made, format))?;
    let label = label(design, Some(&face.made.bound));
    let bytes = run.stage(Stage::Write, || {
        let mut bytes = Vec::new();
        codec(format)
            .write(&mut bytes, &solid, Some((&face.made, design)), &label)
            .map_err(|error| failed(error.to_string()))?;
        let note = format!("{}, {:.1} MB in memory", format.file_name(), bytes.len() as f64 / 1e6);
        Ok((bytes, note))
    })?;
    let promise = Promise::of_face(run.profile, design, &face.made);
    drop((face, solid));
    let found = check_file(run, design, format, bytes, promise);
    match (found.seen, found.unreadable) {
        (Some(seen), _) => Ok(InMemoryBuild { format, frame: found.frame, seen }),
        (None, reason) => {
            Err(failed(reason.map_or("nothing in it".into(), |reason| reason.to_string())))
        }
    }
}
