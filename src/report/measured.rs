//! What is known of a file of unknown making: its units, where it lay, and its form error.

use super::answer::{AnswerRows, ToRows};
use crate::align::{FormError, FreeMotion};
use crate::results::{AlignmentFacts, UnitFacts, coordinate, digits};

impl ToRows for UnitFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { name, mm_per_unit, chosen } = self;
        let sentence =
            format!("{name} ({chosen}): coordinates times {mm_per_unit} are millimetres");
        rows.terminal("units", sentence);
    }
}

impl ToRows for AlignmentFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let place = |v: [f64; 3]| format!("({})", v.map(|x| coordinate(x, 4)).join(", "));
        let [turn, shift] = [self.turn_deg, self.shift_mm].map(place);
        let over = if self.turned_over { ", its facets turned over" } else { "" };
        rows.terminal("pose", format!("turned by {turn} deg, then shifted by {shift} mm{over}"));
        rows.details(|rows| rows.terminal(
            "",
            format!(
                "{} vertices on {:.1} % of the mirror, {} um rms; {:.1} % outliers; condition {:.1}",
                self.vertices,
                100.0 * self.covered,
                digits(self.rms_um),
                100.0 * self.outliers,
                self.condition
            ),
        ));
        for FreeMotion { direction, through_mm } in &self.free {
            let along = place(direction.to_array());
            let motion = match through_mm {
                Some(at) => format!("a turn about {along} through {} mm", place(at.to_array())),
                None => format!("a shift along {along}"),
            };
            rows.terminal("", format!("the mirror does not show {motion}: it is not fitted"));
        }
    }
}

impl ToRows for FormError {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { all, without_outliers: inner, outliers, .. } = self;
        let [pv, rms, lowest, highest] = [all.pv, all.rms, all.lowest, all.highest].map(digits);
        let mut sentence = format!("{pv} um PV, {rms} um rms ({lowest} to {highest})");
        if *outliers > 0.0 {
            let [pv, rms] = [inner.pv, inner.rms].map(digits);
            sentence += &format!("; {pv} PV, {rms} rms without {:.1} % outliers", 100.0 * outliers);
        }
        rows.terminal("error", sentence);
    }
}
