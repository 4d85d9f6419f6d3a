//! What programs of a mill or a lathe leave, before it is traced.

use crate::report::LeftPicture;
use crate::results::CuttingFault;
use crate::verdict::ProgramCut;

/// The face that a finishing program cuts, or why there is none.
pub(super) struct MadeFace {
    /// The face.
    pub cut: Result<ProgramCut, CuttingFault>,
    /// What its file says of it.
    pub words: String,
}

/// What the page shows of programs.
pub(super) struct PagePictures {
    /// What is left after each, by its name.
    pub left: Vec<(String, LeftPicture)>,
    /// Speeds in equal parts of the time of each that can be read.
    pub speeds_mm_min: Vec<Vec<f64>>,
}

/// A face with what the command says of it.
pub(super) fn noted(
    cut: Result<ProgramCut, CuttingFault>,
) -> (Result<ProgramCut, CuttingFault>, String) {
    let note = match &cut {
        Ok(cut) => format!("{} optical triangles", cut.mesh.triangles.len()),
        Err(fault) => fault.to_string(),
    };
    (cut, note)
}
