//! A build up to the ray trace, in memory: what would be written is read back and traced.

use super::camera_view::TracedMesh;
use super::check_file::check_file;
use super::formats::write_mesh;
use super::observer::{Stage, StageTimer};
use super::{Error, close, label, meshed};
use crate::design::Design;
use crate::profile::{Format, Profile};
use crate::trace::FrameFill;

/// The mesh that a build would write first, as it is read back.
pub struct InMemoryBuild {
    /// The format that it was written in.
    pub format: Format,
    /// What the frame as a whole sees, if the profile has a projection.
    pub frame: Option<FrameFill>,
    /// The mesh and the witness's rays.
    pub seen: TracedMesh,
}

/// Meshes, closes, writes in memory, reads back and traces the mirror of `design`.
///
/// # Errors
/// [`enum@Error`] when a stage cannot be done.
pub fn build_in_memory(
    clock: &StageTimer,
    profile: &Profile,
    design: &Design,
) -> Result<InMemoryBuild, Error> {
    let facets = clock.stage(Stage::Mesh, || meshed(clock, profile, design))?;
    let format = facets.formats[0];
    let solid = clock.stage(Stage::Solid, || close(profile, design, &facets.made, format))?;
    let failed = |reason: String| Error::Reread { profile: profile.name.clone(), reason };
    let label = label(profile, design, Some(&facets.made.bound));
    let bytes = clock.stage(Stage::Write, || {
        let mut bytes = Vec::new();
        write_mesh(&mut bytes, format, &solid, (&facets.made, design), &label)
            .map_err(|error| failed(error.to_string()))?;
        let note = format!("{}, {:.1} MB in memory", format.file_name(), bytes.len() as f64 / 1e6);
        Ok::<_, Error>((bytes, note))
    })?;
    let chord_mm = facets.made.bound.chord_mm;
    drop((facets, solid));
    let evidence = check_file(clock, profile, design, format, bytes, chord_mm);
    match (evidence.seen, evidence.unreadable) {
        (Some(seen), _) => Ok(InMemoryBuild { format, frame: evidence.frame, seen }),
        (None, reason) => {
            let reason = reason.map_or("nothing in it".into(), |reason| reason.to_string());
            Err(failed(reason))
        }
    }
}
