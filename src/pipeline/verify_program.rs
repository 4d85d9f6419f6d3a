//! A program of numerical control, from its bytes to a closed part as cut.

use super::made_face::noted;
use super::run::Run;
use super::{Error, Stage};
use crate::design::Design;
use crate::export::ImportedMesh;
use crate::geom::Precision;
use crate::profile::ProgramSpec;
use crate::program::{ProgramFault, ToolPath, TurningPath};
use crate::results::{CuttingFault, ProgramFacts};
use crate::solid::Solid;
use crate::turning::{DiscSections, Meridian};
use crate::verdict::{CheckedMesh, ProgramCut, TurnedShape, axis_faults, turned_cut};

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

/// The tool that a program moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ProgramTool {
    /// A ball cutter on a mill: its radius, mm.
    Ball(f64),
    /// The nose of a tool on a lathe: its radius, mm.
    Nose(f64),
    /// The same along a table of points.
    NoseInTable(f64),
}

/// Reads a program and cuts the mirror of `design` with a tool along its moves.
///
/// # Errors
/// [`Error::Turning`] of a lathe's program for a mirror that is not round, or of one with an axis C for a mirror that is no disc.
pub(super) fn programmed(
    run: &Run,
    design: &Design,
    bytes: &[u8],
    tool: ProgramTool,
) -> Result<Programmed, Error> {
    let cut = match tool {
        ProgramTool::Ball(ball_mm) => {
            let path = match read(run, || ToolPath::read(bytes), |path| path) {
                Ok(path) => path,
                Err(fault) => return Ok(Programmed::Unread(fault)),
            };
            run.timer.always(Stage::Cut, || noted(ProgramCut::new(design, &path, ball_mm)))
        }
        ProgramTool::Nose(nose_mm) | ProgramTool::NoseInTable(nose_mm) => {
            let is_table = matches!(tool, ProgramTool::NoseInTable(_));
            let parse = || match is_table {
                true => TurningPath::read_table(bytes),
                false => TurningPath::read(bytes),
            };
            match read(run, parse, |path| &path.tool) {
                Ok(path) => turned(run, design, &path, nose_mm)?,
                Err(fault) => return Ok(Programmed::Unread(fault)),
            }
        }
    };
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

/// Turns the mirror of `design` with a nose along a path; of a slow tool servo's profile what the path asks of its axes counts too.
fn turned(
    run: &Run,
    design: &Design,
    path: &TurningPath,
    nose_mm: f64,
) -> Result<Result<ProgramCut, CuttingFault>, Error> {
    let refused = |source| Error::Turning { profile: run.profile.name.clone(), source };
    let cut = |shape: &TurnedShape| {
        run.timer.always(Stage::Cut, || noted(turned_cut(design, shape, path, nose_mm)))
    };
    if !path.is_commanded() {
        let meridian = Meridian::new(&design.mirror).map_err(refused)?;
        return Ok(cut(&TurnedShape::round(&meridian)));
    }
    let sections = DiscSections::new(&design.mirror).map_err(refused)?;
    let mut found = cut(&TurnedShape::disc(&sections));
    if let (Ok(cut), ProgramSpec::Servo(spec, _)) = (&mut found, &run.profile.program) {
        cut.faults.extend(axis_faults(&spec.machine, path));
    }
    Ok(found)
}

/// Reads a program, whose moves are told.
fn read<P>(
    run: &Run,
    read: impl FnOnce() -> Result<P, ProgramFault>,
    moves: impl FnOnce(&P) -> &ToolPath,
) -> Result<P, ProgramFault> {
    run.timer.always(Stage::Read, || {
        let path = read();
        let note = match &path {
            Ok(path) => {
                let ToolPath { moves, lines } = moves(path);
                format!("{} moves in {lines} lines", moves.len())
            }
            Err(error) => error.to_string(),
        };
        (path, note)
    })
}

/// Holds the options of programs to what the file is.
///
/// # Errors
/// [`Error::Ball`] of a program without a tool, [`Error::Option`] of options that do not go with the file.
pub(super) fn program_options(
    name: &str,
    (is_program, is_table): (bool, bool),
    (align, [ball_mm, nose_mm]): (bool, [Option<f64>; 2]),
) -> Result<(), Error> {
    let option = |option, must: &str, found: String| {
        Err(Error::Option { option, must: must.to_owned(), found })
    };
    let (key, radius, tool_mm) = match nose_mm {
        Some(_) => ("--nose-mm", "the radius of the tool's nose, positive and finite", nose_mm),
        None => ("--ball-mm", "the radius of the ball cutter, positive and finite", ball_mm),
    };
    match tool_mm {
        None if is_program => Err(Error::Ball { path: name.to_owned() }),
        Some(mm) if !is_program => {
            option(key, "left out but for a program", format!("{mm} with {name}"))
        }
        Some(mm) if !(mm > 0.0 && mm.is_finite()) => option(key, radius, mm.to_string()),
        Some(mm) if is_table && nose_mm.is_none() => option(
            "--ball-mm",
            "left out for a table of points X, Z and C: --nose-mm tells the nose of its tool",
            mm.to_string(),
        ),
        Some(_) if ball_mm.is_some() && nose_mm.is_some() => option(
            "--ball-mm",
            "left out with --nose-mm: a program is a mill's or a lathe's",
            "both".to_owned(),
        ),
        _ if is_program && align => option(
            "--align",
            "left out for a program, whose places are the part's",
            name.to_owned(),
        ),
        _ => Ok(()),
    }
}
