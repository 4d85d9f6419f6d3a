//! A file of the mirror as designed, not of a mesh: how it is written, foreseen, and checked after it was written.

use crate::export::Label;
use crate::profile::CadFormat;
use crate::results::{FileFault, SagFacts, StepFacts};
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

    /// What the design has against its bytes, and their figures where they can be read.
    fn check(&self, bytes: &[u8]) -> (Vec<FileFault>, Option<CadFigures>);
}

/// Figures of a file of the mirror as designed.
pub(super) enum CadFigures {
    Sag(SagFacts),
    Step(StepFacts),
}
