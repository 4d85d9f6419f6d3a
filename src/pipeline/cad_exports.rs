//! The files of the mirror as designed that a profile asks for, and what their bytes showed.

use super::cad_export::{CadExport, CadFindings};
use super::drawing_export::DrawingExport;
use super::part_drawing::PartDrawing;
use super::run::Run;
use super::sag_export::SagExport;
use super::step_export::StepExport;
use super::{Error, Stage};
use crate::design::Design;
use crate::export::sag_points;
use crate::mirror::Form;
use crate::part::cad;
use crate::profile::{self, CadFormat, Profile};
use crate::results::{FileFacts, FileFault};

/// The files of the mirror of `design` that the profile asks for, each ready to be written.
///
/// # Errors
/// [`Error::Table`] when a sag table would have too many places, which can depend on the design;
/// [`Error::Step`] when no splines suit the mirror; [`Error::Drawing`] when it cannot be drawn.
pub(super) fn cad_exports<'a>(
    profile: &Profile,
    design: &'a Design,
    form: &'a Form,
) -> Result<Vec<Box<dyn CadExport + 'a>>, Error> {
    let path = profile.sag.scan(profile.part.width_mm);
    let (points, most) = (sag_points(&path, &design.mirror), profile::SagTable::MOST_POINTS);
    if cad(profile).any(|format| format == CadFormat::Csv) && !(points <= most) {
        return Err(Error::Table { profile: profile.name.clone(), points, most });
    }
    let mut drawing = None;
    let mut exports: Vec<Box<dyn CadExport + 'a>> = Vec::new();
    for format in cad(profile) {
        match format {
            CadFormat::Csv => exports.push(Box::new(SagExport { design, form, path })),
            CadFormat::Step => exports.push(Box::new(StepExport::new(profile, design)?)),
            CadFormat::Drawing(format) => {
                let drawing = match &mut drawing {
                    Some(drawing) => drawing,
                    none => none.insert(PartDrawing::new(profile, design, form)?),
                };
                exports.push(Box::new(DrawingExport::new(profile, drawing, format)));
            }
        }
    }
    Ok(exports)
}

/// What the bytes of one such file showed.
pub(super) struct CadCheck {
    /// The file.
    pub file: FileFacts,
    /// What they showed; what is wrong with them without the file's name.
    pub findings: CadFindings,
}

/// Reads the bytes of a file that were written with `sha256`, and holds them against the design.
pub(super) fn check_export(
    run: &Run,
    export: &dyn CadExport,
    bytes: &[u8],
    written_sha256: &str,
) -> CadCheck {
    run.timer.always(Stage::Read, || {
        let format = export.format();
        let file = FileFacts::of(format.file_name(), format.name(), bytes);
        let mut findings = export.check(bytes);
        if file.sha256 != written_sha256 {
            findings.faults.insert(0, FileFault::Altered);
        }
        let note = format!("{}: as designed", file.name);
        let note = findings.faults.first().map_or(note, ToString::to_string);
        (CadCheck { file, findings }, note)
    })
}
