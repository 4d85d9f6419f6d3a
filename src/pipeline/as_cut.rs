//! The part as cut: its face closed, written, read back and traced.

use super::check_file::{open, witness_opened};
use super::mesh_files::labelled;
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::export::stl_bytes;
use crate::geom::TriMesh;
use crate::part::{Promise, codec};
use crate::profile::{MeshFormat, Profile};
use crate::solid::Solid;
use crate::verdict::{AsCutFace, CheckedMesh, CutSlopes, EachStrip, FileCheck};

/// The file of a part as cut, and its format.
pub(super) const FILE: &str = "as-cut.stl";
const FORMAT: MeshFormat = MeshFormat::Stl;

/// Closes the face as cut, writes it with these words, reads it back and traces it, by these slopes where its facets have not got them;
/// `each` is called with every strip of the frame.
///
/// # Errors
/// [`Error::Solid`] when it cannot be closed, [`Error::File`] when the disk refuses.
pub(super) fn written_as_cut(
    run: &mut Run,
    design: &Design,
    (mesh, slopes): (TriMesh, Option<CutSlopes>),
    words: String,
    each: EachStrip,
) -> Result<FileCheck, Error> {
    let cut = AsCutFace::new(&design.mirror, &mesh, slopes);
    let solid = run.stage(Stage::Solid, || close(run.profile, design, mesh))?;
    run.files.ensure_space(stl_bytes(solid.mesh().triangles.len()))?;
    let label = labelled(design, words);
    run.write(FILE, |out| codec(FORMAT).write(out, &solid, None, &label))?;
    drop(solid);
    let staged = run.files.staged(FILE)?;
    let checked = |reread| CheckedMesh::new(design, reread, None).of_cut(cut);
    let opened = open(run, FORMAT, staged.read()?, checked)?;
    let mut check = witness_opened(run, design, FORMAT, opened, Promise::exact(), each);
    check.rename(FILE.to_owned());
    check.altered = check.file.sha256 != staged.sha256();
    Ok(check)
}

fn close(profile: &Profile, design: &Design, mesh: TriMesh) -> Result<(Solid, String), Error> {
    let solid = Solid::from_face(&mesh.into(), design.features(), codec(FORMAT).precision())
        .map_err(|source| Error::Solid { profile: profile.name.clone(), format: FORMAT, source })?;
    let note = format!("{} triangles, closed", solid.mesh().triangles.len());
    Ok((solid, note))
}
