//! What programs travel, as they are read back.

use crate::milling::TravelExceeded;
use crate::program::ToolMove;
use crate::results::ProgramReport;

/// Puts into `report` what `moves` travel along each axis and how deep they go below `top_mm`, mm.
///
/// # Errors
/// [`TravelExceeded`] along the first axis of which the machine has less, mm.
pub(super) fn travelled<'m>(
    report: &mut ProgramReport,
    moves: impl Iterator<Item = &'m ToolMove>,
    top_mm: f64,
    machine_mm: [f64; 3],
) -> Result<(), TravelExceeded> {
    let mut ends = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for place in moves.flat_map(|step| [step.from, step.to]) {
        for ([low, high], at) in ends.iter_mut().zip(place.to_array()) {
            (*low, *high) = (low.min(at), high.max(at));
        }
    }
    report.travel_mm = ends.map(|[low, high]| (high - low).max(0.0));
    report.reach_mm = (top_mm - ends[2][0]).max(0.0);
    let axes = ["X", "Y", "Z"].into_iter().zip(report.travel_mm).zip(machine_mm);
    for ((axis, needed_mm), travel_mm) in axes {
        if needed_mm > travel_mm {
            return Err(TravelExceeded { axis, needed_mm, travel_mm });
        }
    }
    Ok(())
}
