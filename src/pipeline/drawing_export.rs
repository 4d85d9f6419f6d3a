//! A file of the part's drawing.

use super::cad_export::{CadExport, CadFigures, CadFindings};
use super::part_drawing::PartDrawing;
use crate::export::Label;
use crate::profile::{CadFormat, DrawingFormat, Profile};
use crate::results::{DrawingFacts, FileFault};
use std::io::{self, Write};

/// A file of the part's drawing.
pub(super) struct DrawingExport {
    format: DrawingFormat,
    bytes: Vec<u8>,
    facts: DrawingFacts,
}

impl DrawingExport {
    /// The file of a drawing in a format.
    pub(super) fn new(profile: &Profile, drawing: &PartDrawing, format: DrawingFormat) -> Self {
        let bytes = drawing.file(profile, format);
        Self { format, bytes, facts: drawing.facts.clone() }
    }
}

impl CadExport for DrawingExport {
    fn format(&self) -> CadFormat {
        CadFormat::Drawing(self.format)
    }

    fn write(&self, out: &mut dyn Write, _label: &Label) -> io::Result<()> {
        out.write_all(&self.bytes)
    }

    fn bytes(&self, _label: &Label) -> u64 {
        self.bytes.len() as u64
    }

    fn check(&self, bytes: &[u8]) -> CadFindings {
        let faults = if bytes == self.bytes { Vec::new() } else { vec![FileFault::Altered] };
        let figures = Some(CadFigures::Drawing(Box::new(self.facts.clone())));
        CadFindings { faults, figures, body: None }
    }
}
