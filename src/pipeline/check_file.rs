//! The second half of a build, which starts from bytes: read, check, trace.

use super::observer::Stage;
use super::run::Run;
use crate::brep::Body;
use crate::design::Design;
use crate::export::{ImportedMesh, ReadError, StlComparison};
use crate::geom::TriMesh;
use crate::parallel;
use crate::part::{Promise, codec};
use crate::profile::MeshFormat;
use crate::publish::{FileError, StagedFile, hash_pieces, sha256};
use crate::results::FileFacts;
use crate::solid::{Solid, SolidCheck};
use crate::trace::TraceCounts;
use crate::verdict::{CheckedMesh, EachStrip, FileCheck};

/// A mesh file to be read.
pub(super) enum MeshSource<'a> {
    /// Its bytes.
    Bytes(Vec<u8>),
    /// A file as it is on the disk, and the solid that it was written of, if that is at hand: where the bytes show
    /// just that, what they would be found to be is known.
    Staged(&'a StagedFile, Option<Solid>),
}

/// Reads, checks and traces a mesh file against `design`, to which its facets keep as promised; `each` is called
/// with every strip of the frame.
///
/// # Errors
/// [`FileError`] when the disk does not give the file back.
pub(super) fn check_file(
    run: &Run,
    design: &Design,
    format: MeshFormat,
    source: MeshSource,
    promise: Promise,
    each: EachStrip,
) -> Result<FileCheck, FileError> {
    let check = |reread, proven| CheckedMesh::new(design, reread, proven);
    let opened = open_source(run, format, source, check)?;
    Ok(witness_opened(run, design, format, opened, promise, each))
}

/// Traces a mesh that was read and checked, if it could be read; `each` is called with every strip of the frame.
pub(super) fn witness_opened(
    run: &Run,
    design: &Design,
    format: MeshFormat,
    (file, read): Opened<CheckedMesh>,
    promise: Promise,
    each: EachStrip,
) -> FileCheck {
    match read {
        Ok(checked) => witness(run, design, (file, format), checked, promise, each),
        Err(error) => FileCheck::unreadable(file, format, promise, &error),
    }
}

/// A file and what was made of its mesh, or why it could not be read.
pub(super) type Opened<T> = (FileFacts, Result<T, ReadError>);

/// Reads the bytes of a mesh file, and does something with what is in it.
///
/// # Errors
/// None: the bytes are there.
pub(super) fn open<T: Send>(
    run: &Run,
    format: MeshFormat,
    bytes: Vec<u8>,
    then: impl FnOnce(ImportedMesh) -> T + Send,
) -> Result<Opened<T>, FileError> {
    open_source(run, format, MeshSource::Bytes(bytes), |reread, _| then(reread))
}

/// The same of any source; of a file that was compared with its solid with the solid's check.
fn open_source<T: Send>(
    run: &Run,
    format: MeshFormat,
    source: MeshSource,
    then: impl FnOnce(ImportedMesh, Option<SolidCheck>) -> T + Send,
) -> Result<Opened<T>, FileError> {
    run.timer.always(Stage::Read, || {
        let opened = opened(run, format, source, then);
        let note = match &opened {
            Ok((_, _, note)) => note.clone(),
            Err(error) => error.to_string(),
        };
        (opened.map(|(file, read, _)| (file, read)), note)
    })
}

fn opened<T: Send>(
    run: &Run,
    format: MeshFormat,
    source: MeshSource,
    then: impl FnOnce(ImportedMesh, Option<SolidCheck>) -> T + Send,
) -> Result<(FileFacts, Result<T, ReadError>, String), FileError> {
    let name = format.file_name().to_owned();
    let facts = |bytes: u64, sha256: String| FileFacts {
        name: name.clone(),
        format: format.name().into(),
        bytes,
        sha256,
    };
    let note = |mesh: &TriMesh| format!("{name}: {} triangles", mesh.triangles.len());
    let bytes = match source {
        MeshSource::Bytes(bytes) => bytes,
        MeshSource::Staged(staged, written) => {
            let written = written.filter(|_| run.timer.shortcuts());
            if let Some((length, sha256, reread, check)) = compared(format, staged, written)? {
                let note = note(&reread.mesh);
                return Ok((facts(length, sha256), Ok(then(reread, Some(check))), note));
            }
            staged.read()?
        }
    };
    let read = || {
        let reread = codec(format).read(&bytes);
        let note = match &reread {
            Ok(reread) => note(&reread.mesh),
            Err(error) => format!("{name}: {error}"),
        };
        (reread.map(|reread| then(reread, None)), note)
    };
    let ((reread, note), sha256) = parallel::join(read, || sha256(&bytes));
    Ok((facts(bytes.len() as u64, sha256), reread, note))
}

/// Length, SHA-256, mesh and check of a file that was written of a solid, if its bytes show just that.
///
/// # Errors
/// [`FileError`] when the disk does not give the file back.
fn compared(
    format: MeshFormat,
    staged: &StagedFile,
    written: Option<Solid>,
) -> Result<Option<(u64, String, ImportedMesh, SolidCheck)>, FileError> {
    let Some(solid) = written else { return Ok(None) };
    let Some(mut comparison) = codec(format).comparison(solid.mesh()) else { return Ok(None) };
    let mut file = staged.open()?;
    let (hashed, mesh) = parallel::join(
        || hash_pieces(&mut *file, StlComparison::PIECES, |piece| comparison.add(piece)),
        || solid.mesh().as_welded(),
    );
    let (length, sha256) = hashed.map_err(|error| staged.unreadable(error))?;
    let known = mesh
        .filter(|_| comparison.is_equal())
        .map(|mesh| (length, sha256, ImportedMesh { mesh, normals: None }, solid.check().clone()));
    Ok(known)
}

/// Traces a mesh whose facets keep to the design as promised; `each` is called with every strip of the frame.
pub(super) fn witness(
    run: &Run,
    design: &Design,
    file: (FileFacts, MeshFormat),
    checked: CheckedMesh,
    promise: Promise,
    each: EachStrip,
) -> FileCheck {
    let of = (run.profile, design);
    traced(run, |shortcuts| FileCheck::traced(of, file, checked, (promise, shortcuts), each))
}

/// Traces a body of curved faces that are off the design as promised; `each` is called with every strip of the frame.
pub(super) fn witness_body(
    run: &Run,
    design: &Design,
    (file, body): (FileFacts, Body),
    promise: Promise,
    each: EachStrip,
) -> FileCheck {
    let of = (run.profile, design);
    traced(run, |shortcuts| FileCheck::traced_body(of, file, body, (promise, shortcuts), each))
}

/// Traces a file, with shortcuts or without, and counts how its rays were traced.
fn traced(run: &Run, trace: impl FnOnce(bool) -> (FileCheck, TraceCounts)) -> FileCheck {
    run.timer.always(Stage::Trace, || {
        let (check, counts) = trace(run.timer.shortcuts());
        run.timer.traced(counts);
        let rays = check.trace.as_ref().map_or(0, |trace| trace.rays);
        let note = format!("{}: {rays} rays aimed at the mirror", check.file.name);
        (check, note)
    })
}
