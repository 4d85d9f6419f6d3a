//! `morion drawing`: the sheet that a shop signs, without the part's files.

use super::part_drawing::PartDrawing;
use super::run::{Command, Run};
use super::{Error, Stage};
use crate::mirror::Form;
use crate::profile::{CadFormat, DrawingFormat};
use crate::report::Answer;
use crate::results::{DrawingReport, FileFacts, SCHEMA};

/// A drawing of the part: writes `drawing.pdf`, `drawing.dxf` and `drawing.json` into NAME.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DrawingOptions;

impl Command for DrawingOptions {
    type Report = DrawingReport;

    fn run(&self, run: &mut Run) -> Result<DrawingReport, Error> {
        let design = run.design()?;
        let profile = run.profile;
        let drawing = run.stage(Stage::Draw, || {
            let drawing = PartDrawing::new(profile, &design, &Form::of(&design.mirror))?;
            let note = format!("{}, {}", drawing.facts.paper, drawing.facts.scale);
            Ok((drawing, note))
        })?;
        let files = [DrawingFormat::Pdf, DrawingFormat::Dxf]
            .map(|format| (CadFormat::Drawing(format), drawing.file(profile, format)));
        let facts = |(format, bytes): &(CadFormat, Vec<u8>)| {
            FileFacts::of(format.file_name(), format.name(), bytes)
        };
        let report = DrawingReport {
            schema: SCHEMA,
            profile: profile.into(),
            files: files.iter().map(facts).collect(),
            drawing: drawing.facts,
        };
        run.publish(Stage::Report, |staged, _| {
            for (format, bytes) in &files {
                staged.add_bytes(format.file_name(), bytes)?;
            }
            staged.add_report("drawing.json", &report.json())?;
            Ok(())
        })?;
        Ok(report)
    }
}
