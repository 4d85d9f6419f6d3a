//! A program of numerical control, from its bytes to a closed part as cut.

use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::export::ImportedMesh;
use crate::geom::Precision;
use crate::program::{ProgramFault, ToolPath};
use crate::results::{CuttingFault, ProgramFacts};
use crate::solid::Solid;
use crate::verdict::{CheckedMesh, ProgramCut};

/// What is found of a program beside the picture.
#[derive(Default)]
pub(super) struct CutFindings {
    /// The figures.
    pub program: Option<ProgramFacts>,
    /// Why it does not pass.
    pub faults: Vec<CuttingFault>,
    /// What is less certain than the figures say.
    pub warning: Option<String>,
}

/// What becomes of a program.
pub(super) enum Programmed {
    /// A part with the face that it cuts.
    Cut(Box<CheckedMesh>, CutFindings),
    /// It could not be read.
    Unread(ProgramFault),
    /// It cuts no face.
    Faulty(CuttingFault),
}

/// Reads a program and cuts the mirror of `design` with a ball along its moves.
///
/// # Errors
/// [`Error::Solid`] when the face as cut cannot be closed.
pub(super) fn programmed(
    run: &Run,
    design: &Design,
    bytes: &[u8],
    ball_mm: f64,
) -> Result<Programmed, Error> {
    let read = run.timer.always(Stage::Read, || {
        let path = ToolPath::read(bytes);
        let note = match &path {
            Ok(path) => format!("{} moves in {} lines", path.moves.len(), path.lines),
            Err(error) => error.to_string(),
        };
        (path, note)
    });
    let path = match read {
        Ok(path) => path,
        Err(fault) => return Ok(Programmed::Unread(fault)),
    };
    let cut = run.timer.always(Stage::Cut, || {
        let cut = ProgramCut::new(design, &path, ball_mm);
        let note = match &cut {
            Ok(cut) => format!("{} optical triangles", cut.mesh.triangles.len()),
            Err(fault) => fault.to_string(),
        };
        (cut, note)
    });
    let ProgramCut { mesh, facts, faults, warning } = match cut {
        Ok(cut) => cut,
        Err(fault) => return Ok(Programmed::Faulty(fault)),
    };
    let solid = Solid::from_face(&mesh.into(), design.features(), Precision::Double);
    let solid = match solid {
        Ok(solid) => solid,
        Err(error) => return Ok(Programmed::Faulty(CuttingFault::Face { why: error.to_string() })),
    };
    let reread = ImportedMesh { mesh: solid.mesh().clone(), normals: None };
    let checked = CheckedMesh::new(design, reread, Some(solid.check().clone()));
    let program = Some(facts);
    Ok(Programmed::Cut(Box::new(checked), CutFindings { program, faults, warning }))
}

/// Holds the options of programs to what the file is.
///
/// # Errors
/// [`Error::Ball`] of a program without a ball, [`Error::Option`] of options that do not go with the file.
pub(super) fn program_options(
    name: &str,
    is_program: bool,
    (align, ball_mm): (bool, Option<f64>),
) -> Result<(), Error> {
    let option = |option, must: &str, found: String| {
        Err(Error::Option { option, must: must.to_owned(), found })
    };
    match ball_mm {
        None if is_program => Err(Error::Ball { path: name.to_owned() }),
        Some(mm) if !is_program => {
            option("--ball-mm", "left out but for a program", format!("{mm} with {name}"))
        }
        Some(mm) if !(mm > 0.0 && mm.is_finite()) => option(
            "--ball-mm",
            "the radius of the ball cutter, positive and finite",
            mm.to_string(),
        ),
        _ if is_program && align => option(
            "--align",
            "left out for a program, whose places are the part's",
            name.to_owned(),
        ),
        _ => Ok(()),
    }
}
