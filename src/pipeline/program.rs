//! `morion program`: programs that mill or turn a profile's mirror, read back, cut and traced.

use super::as_cut::written_as_cut;
use super::made_face::{MadeFace, PagePictures};
use super::mill_program::milled;
use super::page_figures::{ErrorMap, ErrorMapBuilder, MAP_COLUMNS};
use super::run::{Command, Run};
use super::servo_program::servo_cut;
use super::turn_program::turned;
use super::{Error, Stage};
use crate::design::Design;
use crate::profile::{Profile, ProgramSpec};
use crate::raster::{EncodingError, FalseColourMap};
use crate::report::Answer;
use crate::results::{AsCutFacts, CutDeparture, CuttingFault, ProgramReport, Reason, ReasonKind};
use crate::verdict::{self, Findings, HeldTo, ProgramCut};
use std::path::{Path, PathBuf};

/// Writes programs that mill or turn the mirror as `[program]` of the profile asks: `roughing`, `semi-finishing` and `finishing.ngc`, or
/// `.xzc`, `program.json`, `program.html` and `as-cut.stl` into NAME/program.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ProgramOptions;

impl Command for ProgramOptions {
    type Report = ProgramReport;

    fn folder(&self, profile: &Profile) -> PathBuf {
        Path::new(&profile.name).join("program")
    }

    fn run(&self, run: &mut Run) -> Result<ProgramReport, Error> {
        let design = run.design()?;
        let profile = run.profile;
        let (mut report, face, pictures) = match &profile.program {
            ProgramSpec::Mill(spec) => milled(run, spec, &design)?,
            ProgramSpec::Turn(spec, control) => turned(run, (spec, *control), &design)?,
            ProgramSpec::Servo(spec, servo) => servo_cut(run, (spec, servo), &design)?,
        };
        let errors = match face {
            Some(face) => judged(run, &design, face, &mut report)?,
            None => None,
        };
        report.verdict = verdict::of(&report.reasons);
        publish(run, &pictures, errors.as_ref(), &report)?;
        Ok(report)
    }
}

/// Writes the part as cut, reads it back and traces it; the map of its pixel errors.
fn judged(
    run: &mut Run,
    design: &Design,
    MadeFace { cut, words }: MadeFace,
    report: &mut ProgramReport,
) -> Result<Option<FalseColourMap>, Error> {
    let finishing = format!("finishing.{}", report.control.ending());
    let of_program = |fault: CuttingFault| Reason::from(fault).of_file(&finishing);
    let ProgramCut { mesh, facts, faults, slopes } = match cut {
        Ok(cut) => cut,
        Err(fault) => {
            report.reasons.push(of_program(fault));
            return Ok(None);
        }
    };
    let optical_triangles = mesh.triangles.len();
    let polish_um = run.profile.program.polish_um();
    let high = polish_um.filter(|um| facts.highest.off_um > *um).map(|limit_um| {
        let CutDeparture { off_um: found_um, at_mm: [x, y, _], .. } = facts.highest;
        of_program(CuttingFault::Unpolished { found_um, limit_um, at_mm: [x, y] })
    });
    report.reasons.extend(high);
    report.program = Some(facts);
    report.reasons.extend(faults.into_iter().map(of_program));
    let mut errors = ErrorMapBuilder::new(design, MAP_COLUMNS);
    let mut check =
        written_as_cut(run, design, (mesh, slopes), words, &mut |strip| errors.add(strip))?;
    check.held_to = HeldTo::Picture;
    let errors: ErrorMap = errors.finish();
    let Findings { files, trace, frame, accepted, reasons, .. } =
        Findings::new(run.profile, design, vec![check]);
    report.files.extend(files);
    let is_polished_off = |reason: &Reason| {
        polish_um.is_some() && matches!(reason.kind, ReasonKind::Picture(_) | ReasonKind::Rays(_))
    };
    report.reasons.extend(reasons.into_iter().filter(|reason| !is_polished_off(reason)));
    let trace = trace.into_iter().next();
    report.as_cut = trace.map(|trace| AsCutFacts { optical_triangles, trace });
    (report.frame, report.accepted) = (frame, accepted.filter(|_| polish_um.is_none()));
    Ok(errors.drawn(design))
}

fn publish(
    run: &mut Run,
    pictures: &PagePictures,
    errors: Option<&FalseColourMap>,
    report: &ProgramReport,
) -> Result<(), Error> {
    let page = report
        .html(&pictures.left, errors, &pictures.speeds_mm_min)
        .map_err(|error: EncodingError| Error::Picture(error.to_string()))?;
    run.publish(Stage::Report, |files, _| {
        files.add_bytes("program.html", page.as_bytes())?;
        files.add_report("program.json", &report.json())?;
        if report.as_cut.is_none() {
            files.remove(super::as_cut::FILE);
        }
        Ok(())
    })
}
