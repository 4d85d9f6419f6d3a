//! Moves of a cutter's tip, one after the other.

use crate::geom::DVec3;

/// A straight move of a cutter's tip from where the one before has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipMove {
    /// Where it ends, mm.
    pub to: DVec3,
    /// How fast.
    pub pace: Pace,
}

/// How fast a cutter moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// As fast as the machine can, clear of the stock.
    Rapid,
    /// Down towards the stock.
    Entry,
    /// Along a cut.
    Cut,
}

/// Moves in the making: between cuts the tip is at the height of rapid moves.
pub struct MotionList {
    moves: Vec<TipMove>,
    /// Height of rapid moves over the stock, mm.
    safe_mm: f64,
}

impl MotionList {
    /// No move yet.
    #[must_use]
    pub fn new(safe_mm: f64) -> Self {
        Self { moves: Vec::new(), safe_mm }
    }

    /// Where the tip is, if it is in a cut.
    #[must_use]
    pub fn place(&self) -> Option<DVec3> {
        self.moves.last().map(|last| last.to).filter(|at| at.z < self.safe_mm)
    }

    fn add(&mut self, to: DVec3, pace: Pace) {
        if self.moves.last().is_none_or(|last| last.to != to) {
            self.moves.push(TipMove { to, pace });
        }
    }

    /// Goes fast.
    pub fn rapid(&mut self, to: DVec3) {
        self.add(to, Pace::Rapid);
    }

    /// Goes down towards the stock.
    pub fn entry(&mut self, to: DVec3) {
        self.add(to, Pace::Entry);
    }

    /// Cuts from place to place.
    pub fn cut(&mut self, places: impl IntoIterator<Item = DVec3>) {
        places.into_iter().for_each(|to| self.add(to, Pace::Cut));
    }

    /// Up to the height of rapid moves.
    pub fn retract(&mut self) {
        if let Some(at) = self.place() {
            self.rapid(at.with_z(self.safe_mm));
        }
    }

    /// Over a place at the height of rapid moves, whence the tip goes down fast to `clear_mm`.
    pub fn over(&mut self, at: DVec3, clear_mm: f64) {
        self.retract();
        self.rapid(at.with_z(self.safe_mm));
        self.rapid(at.with_z(clear_mm.min(self.safe_mm)));
    }

    /// All moves, with the tip at the height of rapid ones at their end.
    #[must_use]
    pub fn finish(mut self) -> Vec<TipMove> {
        self.retract();
        self.moves
    }
}
