//! The cutter that roughs: a ball, or a flat or bull-nosed one.

use super::program_table::ProgramTable;
use crate::geom::Cutter;

/// Radius of the smallest cutter, mm.
pub(super) const LEAST_BALL_MM: f64 = 0.05;

impl ProgramTable<'_, '_, '_, '_> {
    /// The cutter that roughs, if it has one of its own.
    pub(super) fn rough_cutter(&mut self) -> Option<Cutter> {
        let hint = "the radius of the ball that roughs, as in rough_ball_mm = 4";
        let ball_mm = self.value("rough_ball_mm", [LEAST_BALL_MM, 1000.0], hint);
        let hint = "the radius of a flat or bull-nosed cutter, as in rough_radius_mm = 4";
        let radius = self.figure("rough_radius_mm", [LEAST_BALL_MM, 1000.0], hint);
        let hint =
            "the radius of its rounded edge, 0 of a flat cutter, as in rough_corner_mm = 0.5";
        let corner = self.figure("rough_corner_mm", [0.0, 1000.0], hint);
        let Some(radius) = radius else {
            if let Some(found) = corner {
                let message =
                    "program.rough_corner_mm must go with program.rough_radius_mm, found it alone";
                let hint =
                    "add rough_radius_mm, the cutter's radius; a ball's edge has the ball's own";
                self.reader.complain(found.at, message.to_owned(), hint);
            }
            return ball_mm.map(Cutter::ball);
        };
        let radius_mm = radius.value;
        if ball_mm.is_some() {
            let message = format!(
                "program.rough_radius_mm must be left out with program.rough_ball_mm, found {radius_mm}"
            );
            let hint = "one cutter roughs: a ball, or a flat or bull-nosed one";
            self.reader.complain(radius.at, message, hint);
        }
        if let Some(found) = corner.filter(|corner| corner.value > radius_mm) {
            let message = format!(
                "program.rough_corner_mm must be no more than the cutter's radius of {radius_mm} mm, found {}",
                found.value
            );
            self.reader.complain(found.at, message, hint);
        }
        Some(Cutter { radius_mm, corner_mm: corner.map_or(0.0, |corner| corner.value) })
    }
}
