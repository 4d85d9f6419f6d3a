//! A file of the mirror as designed, not of a mesh: how it is written, foreseen, and checked after it was written.

use crate::brep::Body;
use crate::export::Label;
use crate::part::Promise;
use crate::profile::CadFormat;
use crate::results::{DrawingFacts, FileFault, SagFacts, StepFacts};
use std::io::{self, Write};

/// A file of the mirror as designed.
pub(super) trait CadExport: Sync {
    /// Its format.
    fn format(&self) -> CadFormat;

    /// Writes it.
    ///
    /// # Errors
    /// That of `out`.
    fn write(&self, out: &mut dyn Write, label: &Label) -> io::Result<()>;

    /// Foresees its length.
    fn bytes(&self, label: &Label) -> u64;

    /// Reads its bytes and holds them against the design.
    fn check(&self, bytes: &[u8]) -> CadFindings;
}

/// What the bytes of a file of the mirror as designed showed.
pub(super) struct CadFindings {
    /// What the design has against them.
    pub faults: Vec<FileFault>,
    /// Their figures where they can be read.
    pub figures: Option<CadFigures>,
    /// The body that they are of, and the errors that it may have: for the camera's rays.
    pub body: Option<(Body, Promise)>,
}

/// Figures of a file of the mirror as designed.
pub(super) enum CadFigures {
    Sag(SagFacts),
    Step(StepFacts),
    Drawing(Box<DrawingFacts>),
}
