//! A program of numerical control, from its bytes to a closed part as cut.

use super::made_face::noted;
use super::run::Run;
use super::verify_options::VerifyOptions;
use super::{Error, Stage};
use crate::design::Design;
use crate::export::ImportedMesh;
use crate::geom::{Cutter, Precision};
use crate::profile::ProgramSpec;
use crate::program::{ProgramFault, ToolPath, TurningPath};
use crate::results::{CuttingFault, ProgramFacts};
use crate::solid::Solid;
use crate::turning::{DiscSections, Meridian};
use crate::verdict::{AsCutFace, CheckedMesh, ProgramCut, TurnedShape, axis_faults, turned_cut};

/// What is found of a program beside the picture.
#[derive(Default)]
pub(super) struct CutFindings {
    /// The figures.
    pub program: Option<ProgramFacts>,
    /// Why it does not pass.
    pub faults: Vec<CuttingFault>,
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
    /// A cutter on a mill.
    Cutter(Cutter),
    /// The nose of a tool on a lathe: its radius, mm.
    Nose(f64),
    /// The same along a table of points.
    NoseInTable(f64),
}

/// Reads a program and cuts the mirror of `design` with a tool along its moves.
///
/// # Errors
/// [`Error::FormedProgram`] of a tool on which the mirror is formed, [`Error::Turning`] of a lathe's program for a mirror that is not round, or of one with an axis C for a mirror that is no disc.
pub(super) fn programmed(
    run: &Run,
    design: &Design,
    bytes: &[u8],
    tool: ProgramTool,
) -> Result<Programmed, Error> {
    if let Some(formed) = &run.profile.part.forming {
        let (profile, form) = (run.profile.name.clone(), formed.form.name());
        return Err(Error::FormedProgram { profile, form });
    }
    let cut = match tool {
        ProgramTool::Cutter(cutter) => {
            let path = match read(run, || ToolPath::read(bytes), |path| path) {
                Ok(path) => path,
                Err(fault) => return Ok(Programmed::Unread(fault)),
            };
            run.timer.always(Stage::Cut, || noted(ProgramCut::new(design, &path, cutter)))
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
    let ProgramCut { mesh, facts, faults, slopes } = match cut {
        Ok(cut) => cut,
        Err(fault) => return Ok(Programmed::Faulty(fault)),
    };
    let cut = AsCutFace::new(&design.mirror, &mesh, slopes);
    let solid = Solid::from_face(&mesh.into(), design.features(), Precision::Double);
    let solid = match solid {
        Ok(solid) => solid,
        Err(error) => return Ok(Programmed::Faulty(CuttingFault::Face { why: error.to_string() })),
    };
    let reread = ImportedMesh { mesh: solid.mesh().clone(), normals: None };
    let checked = CheckedMesh::new(design, reread, Some(solid.check().clone()));
    let checked = checked.of_cut(cut);
    let program = Some(facts);
    Ok(Programmed::Cut(Box::new(checked), CutFindings { program, faults }))
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

/// The tool that a program moves, by the options that tell it; none of another file.
///
/// # Errors
/// [`Error::Ball`] of a program without a tool, [`Error::Option`] of options that do not go with the file or each other.
pub(super) fn program_tool(
    name: &str,
    (is_program, is_table): (bool, bool),
    options: &VerifyOptions,
) -> Result<Option<ProgramTool>, Error> {
    let VerifyOptions { align, ball_mm, cutter_mm, corner_mm, nose_mm, .. } = *options;
    let given = [
        ("--ball-mm", ball_mm, "the radius of the ball cutter, positive and finite"),
        ("--cutter-mm", cutter_mm, "the radius of the cutter, positive and finite"),
        ("--nose-mm", nose_mm, "the radius of the tool's nose, positive and finite"),
        ("--corner-mm", corner_mm, "the radius of the cutter's rounded edge, positive and finite"),
    ];
    for (key, mm, radius) in given {
        let Some(mm) = mm else { continue };
        if !is_program {
            let found = format!("{mm} with {name}");
            return refuse(key, "left out but for a program", found);
        }
        if !(mm > 0.0 && mm.is_finite()) {
            return refuse(key, radius, mm.to_string());
        }
    }
    if !is_program {
        return Ok(None);
    }
    if let Some(corner_mm) = corner_mm {
        let found = corner_mm.to_string();
        match cutter_mm {
            None => {
                let must = "left out without --cutter-mm, the radius of a cutter with a flat end";
                return refuse("--corner-mm", must, found);
            }
            Some(mm) if corner_mm > mm => {
                return refuse("--corner-mm", "no more than --cutter-mm", found);
            }
            Some(_) => {}
        }
    }
    let tool = match (ball_mm, cutter_mm, nose_mm) {
        (None, None, None) => return Err(Error::Ball { path: name.to_owned() }),
        (Some(mm), None, None) => ProgramTool::Cutter(Cutter::ball(mm)),
        (None, Some(radius_mm), None) => {
            let corner_mm = corner_mm.unwrap_or(0.0);
            ProgramTool::Cutter(Cutter { radius_mm, corner_mm })
        }
        (None, None, Some(mm)) if is_table => ProgramTool::NoseInTable(mm),
        (None, None, Some(mm)) => ProgramTool::Nose(mm),
        (Some(_), _, Some(_)) | (_, Some(_), Some(_)) => {
            let key = if ball_mm.is_some() { "--ball-mm" } else { "--cutter-mm" };
            let must = "left out with --nose-mm: a program is a mill's or a lathe's";
            return refuse(key, must, "both".to_owned());
        }
        (Some(_), Some(_), None) => {
            let must = "left out with --cutter-mm: a program moves one cutter";
            return refuse("--ball-mm", must, "both".to_owned());
        }
    };
    match tool {
        ProgramTool::Cutter(Cutter { radius_mm, .. }) if is_table => {
            let key = if ball_mm.is_some() { "--ball-mm" } else { "--cutter-mm" };
            let must =
                "left out for a table of points X, Z and C: --nose-mm tells the nose of its tool";
            refuse(key, must, radius_mm.to_string())
        }
        _ if align => {
            let must = "left out for a program, whose places are the part's";
            refuse("--align", must, name.to_owned())
        }
        tool => Ok(Some(tool)),
    }
}

/// The error of an option that does not suit.
fn refuse<T>(option: &'static str, must: &str, found: String) -> Result<T, Error> {
    Err(Error::Option { option, must: must.to_owned(), found })
}
