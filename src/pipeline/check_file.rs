//! The second half of a build, which starts from bytes: read, check, trace.

use super::observer::Stage;
use super::run::Run;
use crate::design::Design;
use crate::export::{ImportedMesh, ReadError};
use crate::parallel;
use crate::part::{Promise, codec};
use crate::profile::MeshFormat;
use crate::publish::sha256;
use crate::results::FileFacts;
use crate::trace::{PixelClass, TraceStrip};
use crate::verdict::{CheckedMesh, FileCheck};

/// Reads, checks and traces the bytes of a mesh file against `design`, to which its facets keep as
/// promised; `each` is called with every strip of the frame.
pub(super) fn check_file(
    run: &Run,
    design: &Design,
    format: MeshFormat,
    bytes: Vec<u8>,
    promise: Promise,
    each: &mut dyn FnMut(&TraceStrip, &[PixelClass]),
) -> FileCheck {
    let (file, read) = open(run, format, bytes, |reread| CheckedMesh::new(design, reread));
    match read {
        Ok(checked) => witness(run, design, (file, format), checked, promise, each),
        Err(error) => FileCheck::unreadable(file, format, promise, error),
    }
}

/// Reads the bytes of a mesh file, and does something with what is in it.
pub(super) fn open<T: Send>(
    run: &Run,
    format: MeshFormat,
    bytes: Vec<u8>,
    then: impl FnOnce(ImportedMesh) -> T + Send,
) -> (FileFacts, Result<T, ReadError>) {
    let name = format.file_name().to_owned();
    let length = bytes.len() as u64;
    let read = || {
        let reread = codec(format).read(&bytes);
        let note = match &reread {
            Ok(reread) => format!("{name}: {} triangles", reread.mesh.triangles.len()),
            Err(error) => format!("{name}: {error}"),
        };
        (reread.map(then), note)
    };
    let (reread, sha256) = run.timer.always(Stage::Read, || {
        let ((reread, note), sha256) = parallel::join(read, || sha256(&bytes));
        ((reread, sha256), note)
    });
    // The rays need the mesh alone.
    drop(bytes);
    (FileFacts { name, format: format.name().into(), bytes: length, sha256 }, reread)
}

/// Traces a mesh whose facets keep to the design as promised; `each` is called with every strip of the frame.
pub(super) fn witness(
    run: &Run,
    design: &Design,
    file: (FileFacts, MeshFormat),
    checked: CheckedMesh,
    promise: Promise,
    each: &mut dyn FnMut(&TraceStrip, &[PixelClass]),
) -> FileCheck {
    run.timer.always(Stage::Trace, || {
        let promised = (promise, run.timer.shortcuts());
        let (check, counts) = FileCheck::traced(run.profile, design, file, checked, promised, each);
        run.timer.traced(counts);
        let rays = check.trace.as_ref().map_or(0, |trace| trace.rays);
        let note = format!("{}: {rays} rays aimed at the mirror", check.file.name);
        (check, note)
    })
}
