//! Lines of a tip one after the other: semi-finishing and finishing.

use super::bridge::TipLines;
use super::motions::{MotionList, TipMove};
use super::stock_left::StockLeft;
use super::tip_line::TipLine;
use crate::geom::{Cutter, DVec3};

/// What is to be clear of a tip that comes down fast to a cut's beginning, mm.
const CLEARANCE_MM: f64 = 0.5;
/// A tip goes on from line to line without a hop over so many stepovers, of which lines reach two beyond the mirror: the straight
/// move cuts off less than half of one there.
const DIRECT: f64 = 2.0;
/// Longest hop over the ball's radius; farther the tip is retracted.
const HOP: f64 = 2.0;
/// Height of a hop over its length.
const HOP_HEIGHT: f64 = 0.5;

/// How lines are taken one after the other.
pub(super) struct SurfaceCut<'a> {
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Distance of the lines, mm.
    pub stepover_mm: f64,
    /// What the operations before have left.
    pub stock: &'a StockLeft,
    /// Height of rapid moves, mm.
    pub safe_mm: f64,
}

impl SurfaceCut<'_> {
    /// The moves along all lines, there and back in turn.
    pub(super) fn moves(&self, lines: &TipLines) -> Vec<TipMove> {
        let mut list = MotionList::new(self.safe_mm);
        for (k, line) in lines.across.iter().enumerate() {
            match k % 2 {
                0 => self.follow(&mut list, line),
                _ => self.follow(&mut list, &line.reversed()),
            }
        }
        for line in &lines.ridge {
            list.retract();
            self.follow(&mut list, line);
        }
        list.finish()
    }

    /// From where the tip is to a line, and along it.
    fn follow(&self, list: &mut MotionList, line: &TipLine) {
        let [begin, _] = line.ends();
        let (above, clear) = self.lead_in(line);
        match list.place() {
            Some(at) if (begin - at).truncate().length() <= DIRECT * self.stepover_mm => {}
            Some(at) if (above - at).truncate().length() <= HOP * self.ball_mm => {
                let top = at.z.max(clear) + HOP_HEIGHT * (above - at).truncate().length();
                list.cut([at.with_z(top), above.with_z(top)]);
                list.entry(above.with_z(clear));
                list.entry(begin);
            }
            _ => {
                list.over(above, clear);
                list.entry(begin);
            }
        }
        list.cut(line.places.iter().copied());
    }

    /// The upper end of a ramp to a line's beginning, which lies outside the mirror, a radius long, and its height, above what is left there.
    fn lead_in(&self, line: &TipLine) -> (DVec3, f64) {
        let [begin, _] = line.ends();
        let back = begin - line.directions[0].with_z(0.0).normalize_or_zero() * self.ball_mm;
        let left_mm = self.stock.clear_mm(back.truncate(), Cutter::ball(self.ball_mm));
        (back, left_mm.max(begin.z) + CLEARANCE_MM)
    }
}
