//! What the programs of a profile will take and leave, by plan and study alone: no file is written.

use super::Error;
use super::mill_program::{direction_of, limits, refused, survey, task};
use crate::design::Design;
use crate::milling::{Operation, TipMove};
use crate::num::stats::Summary;
use crate::profile::{MillSpec, Profile};
use crate::program::ToolMove;

/// What programs take and leave.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ProgramForecast {
    /// Distance of the finishing lines in the plan, mm.
    pub stepover_mm: f64,
    /// Their direction from X towards Y, degrees; none of a spiral.
    pub angle_deg: Option<f64>,
    /// How far scallops displace the pixels, px; none without a projection.
    pub scallops_px: Option<Summary>,
    /// Time of all operations on the machine, minutes.
    pub machine_min: f64,
    /// Moves of all operations.
    pub moves: usize,
}

impl ProgramForecast {
    /// The programs of `profile` for a mill.
    ///
    /// # Errors
    /// [`Error::Milling`] where the mirror cannot be milled so.
    pub(crate) fn new(profile: &Profile, spec: &MillSpec, design: &Design) -> Result<Self, Error> {
        let refused = |why| refused(profile, why);
        let survey = survey(profile, spec, design).map_err(refused)?;
        let operations = task(spec, design, &survey).operations().map_err(refused)?;
        let machine = limits(spec);
        let minutes = |operation| machine.time(&tool_moves(operation)).minutes();
        let found = &survey.found;
        Ok(Self {
            stepover_mm: found.stepover_mm,
            angle_deg: direction_of(spec, found.angle_deg),
            scallops_px: found.scallops.as_ref().and_then(|scallops| scallops.pixel_error_px),
            machine_min: operations.iter().map(minutes).sum(),
            moves: operations.iter().map(|operation| operation.motions.len()).sum(),
        })
    }
}

/// The moves of an operation from its first place on, as they are read back but for the rounding of figures.
fn tool_moves(operation: &Operation) -> Vec<ToolMove> {
    let step = |pair: &[TipMove]| {
        let feed = operation.speeds.feed_of(pair[1].pace);
        ToolMove { from: pair[0].to, to: pair[1].to, feed, line: 0 }
    };
    operation.motions.windows(2).map(step).collect()
}
