//! What is known of a file of unknown making: its units, where it lay, and its form error.

use super::answer::{AnswerRows, ToRows};
use super::wording::{coordinate, digits};
use crate::align::{Alignment, FormError, FreeMotion, LengthUnit};
use crate::num::degrees;
use serde::Serialize;

/// The unit of a file's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UnitFacts {
    /// Its symbol.
    pub name: &'static str,
    /// How many mm it has.
    pub mm_per_unit: f64,
    /// `declared` by the file, `asked`, `by size`, or `assumed` where no unit makes the file as large as
    /// the part.
    pub chosen: &'static str,
}

impl UnitFacts {
    /// `unit`, and how it was chosen.
    #[must_use]
    pub fn new(unit: LengthUnit, chosen: &'static str) -> Self {
        Self { name: unit.name(), mm_per_unit: unit.mm(), chosen }
    }
}

impl ToRows for UnitFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let Self { name, mm_per_unit, chosen } = self;
        let sentence =
            format!("{name} ({chosen}): coordinates times {mm_per_unit} are millimetres");
        rows.terminal("units", sentence);
    }
}

/// How a file was brought into the part frame: place in mm -> turned about the origin -> shifted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AlignmentFacts {
    /// Axis of the turn times its angle, degrees.
    pub turn_deg: [f64; 3],
    /// The same turn as a unit quaternion.
    pub quaternion_xyzw: [f64; 4],
    /// mm.
    pub shift_mm: [f64; 3],
    /// Whether the facets showed the camera their backs.
    pub turned_over: bool,
    /// RMS distance of the vertices from the mirror, outliers left out, um.
    pub rms_um: f64,
    /// Share of the face around vertices that are outliers.
    pub outliers: f64,
    /// Share of the mirror that the others stand for.
    pub covered: f64,
    /// Vertices that the pose rests on.
    pub vertices: usize,
    /// Steps of the fit.
    pub steps: usize,
    /// How much worse the worst direction is determined than the best.
    pub condition: f64,
    /// Motions that move the mirror along itself; in these the file was left as it was.
    pub free: Vec<FreeMotion>,
}

impl AlignmentFacts {
    /// The facts of `alignment`.
    #[must_use]
    pub fn new(alignment: &Alignment) -> Self {
        let pose = &alignment.pose;
        Self {
            turn_deg: pose.rotation_vector().to_array().map(degrees),
            quaternion_xyzw: pose.rotation.to_array(),
            shift_mm: pose.shift.to_array(),
            turned_over: alignment.turned_over,
            rms_um: alignment.rms_mm * 1e3,
            outliers: alignment.outliers,
            covered: alignment.covered,
            vertices: alignment.vertices,
            steps: alignment.steps,
            condition: alignment.condition,
            free: alignment.free.clone(),
        }
    }
}

impl ToRows for AlignmentFacts {
    fn add_to(&self, rows: &mut AnswerRows) {
        let place = |v: [f64; 3]| format!("({})", v.map(|x| coordinate(x, 4)).join(", "));
        let [turn, shift] = [self.turn_deg, self.shift_mm].map(place);
        let over = if self.turned_over { ", its facets turned over" } else { "" };
        rows.terminal("pose", format!("turned by {turn} deg, then shifted by {shift} mm{over}"));
        rows.terminal(
            "",
            format!(
                "{} vertices on {:.1} % of the mirror, {} um rms; {:.1} % outliers; condition {:.1}",
                self.vertices,
                100.0 * self.covered,
                digits(self.rms_um),
                100.0 * self.outliers,
                self.condition
            ),
        );
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
