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
        let place = list.place();
        let is_next = |at: DVec3| (begin - at).truncate().length() <= DIRECT * self.stepover_mm;
        if !place.is_some_and(is_next) {
            match place.and_then(|at| self.hop(at, above, clear)) {
                Some(hop) => {
                    list.cut(hop);
                    list.entry(above.with_z(clear));
                }
                None => list.over(above, clear),
            }
            list.entry(begin);
        }
        list.cut(line.places.iter().copied());
    }

    /// The upper corners of a hop from `at` to where the tip comes down to `clear`; none where a retract is shorter or no higher.
    fn hop(&self, at: DVec3, above: DVec3, clear: f64) -> Option<[DVec3; 2]> {
        let way = (above - at).truncate().length();
        let top = at.z.max(clear) + HOP_HEIGHT * way;
        let is_short = way <= HOP * self.ball_mm && top < self.safe_mm;
        is_short.then(|| [at.with_z(top), above.with_z(top)])
    }

    /// The upper end of a ramp to a line's beginning, which lies outside the mirror, a radius long, and its height, above what is left there.
    fn lead_in(&self, line: &TipLine) -> (DVec3, f64) {
        let [begin, _] = line.ends();
        let back = begin - line.directions[0].with_z(0.0).normalize_or_zero() * self.ball_mm;
        let left_mm = self.stock.clear_mm(back.truncate(), Cutter::ball(self.ball_mm));
        (back, left_mm.max(begin.z) + CLEARANCE_MM)
    }
}
