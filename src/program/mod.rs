//! Numerical control: programs of any making, read and cut.
//!
//! - [`ToolPath::read`] reads the RS-274 text (G code): modal words to straight moves of the tool's tip, arcs as chords.
//!   What it does not know it refuses by line and name: nothing is skipped.
//! - [`TurningPath::read`] reads that of lathes: moves in a half-plane, and the turns of the spindle meanwhile.
//! - [`TurningPath::read_table`] reads tables of points X, Z and C, the axis that the spindle of a slow tool servo is.
//! - [`SweptCutter`] is what a cutter along those moves leaves: the lowest of all its places over each place of the plan.
//! - [`StockMap`] is a block that is cut move by move: rapid moves that meet what is left are found, and what is highest beside the
//!   cutter, of which its shank and its holder are to stay clear.
//! - [`TurnedSurface`] is what a nose leaves on a lathe at each azimuth, [`TurnedSlopes`] how that slopes at any place, and
//!   [`TurnedBar`] a bar that is turned move by move.
//! - [`MachineLimits`] tells the time of moves with their starts, stops and corners.
//!
//! The room knows no mirror and no profile, so what it finds of a program is of the program alone.

mod arc;
mod axis_rates;
mod azimuth_bins;
mod band_heights;
mod commanded;
mod coverage;
mod cutter_move;
mod lathe;
mod lathe_words;
mod lines;
mod machine_time;
mod modal;
mod reader;
mod stock_beside;
mod stock_map;
mod swept_cutter;
mod turn_coverage;
mod turned_bar;
mod turned_section;
mod turned_slopes;
mod turned_surface;
mod words;
mod xzc_table;

pub use axis_rates::{AxisRate, AxisRates};
pub use commanded::SpindleTurn;
pub use coverage::PathCoverage;
pub use lathe::TurningPath;
pub use machine_time::{MachineLimits, MachineTime};
pub use stock_beside::StockBeside;
pub use stock_map::{HeldCutter, MovedInto, StockMap, StockMoves};
pub use swept_cutter::{SweptCutter, SweptPlace};
pub use turn_coverage::TurnCoverage;
pub use turned_bar::{BarMoves, TurnedBar, nose_below};
pub use turned_section::{SectionPlace, TurnedSection};
pub use turned_slopes::TurnedSlopes;
pub use turned_surface::TurnedSurface;

use crate::geom::DVec3;
use thiserror::Error;

/// A straight move of a tool's tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolMove {
    /// Where it begins, mm.
    pub from: DVec3,
    /// Where it ends, mm.
    pub to: DVec3,
    /// Feed, mm/min; none of a rapid move.
    pub feed: Option<f64>,
    /// Line of the program, from 1.
    pub line: u32,
}

/// The moves of a program.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ToolPath {
    /// In their order; moves to and from places of the machine, which a program does not tell, are left out.
    pub moves: Vec<ToolMove>,
    /// Lines of the program.
    pub lines: u32,
}

impl ToolPath {
    /// Length of the cutting moves and of the rapid ones, mm.
    #[must_use]
    pub fn lengths_mm(&self) -> [f64; 2] {
        let length = |is_rapid: bool| {
            let moves = self.moves.iter().filter(|step| step.feed.is_none() == is_rapid);
            moves.map(|step| step.from.distance(step.to)).sum()
        };
        [length(false), length(true)]
    }

    /// The first of the moves that end lowest.
    #[must_use]
    pub fn lowest(&self) -> Option<&ToolMove> {
        let lower = |a: &&ToolMove, b: &&ToolMove| a.to.z.total_cmp(&b.to.z);
        self.moves.iter().min_by(lower)
    }

    /// Time of the cutting moves at their feeds, minutes; starts and stops take longer.
    #[must_use]
    pub fn cutting_min(&self) -> f64 {
        let time = |step: &ToolMove| Some(step.from.distance(step.to) / step.feed?);
        self.moves.iter().filter_map(time).sum()
    }
}

/// Reason why a program is not read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProgramFault {
    /// Something that is no word of a letter and a number.
    #[error("line {line}: {found}; decimal numbers alone are read")]
    Syntax {
        /// Line, from 1.
        line: u32,
        /// What.
        found: String,
    },
    /// A line longer than controls take.
    #[error("line {line} is longer than {most} bytes, more than controls take")]
    Long {
        /// Line, from 1.
        line: u32,
        /// Most bytes.
        most: usize,
    },
    /// A word that is not known.
    #[error("line {line}: {word} is no word that is known here")]
    Word {
        /// Line, from 1.
        line: u32,
        /// The word.
        word: String,
    },
    /// Words that contradict each other, or lack another.
    #[error("line {line}: {reason}")]
    Line {
        /// Line, from 1.
        line: u32,
        /// What is wrong.
        reason: String,
    },
    /// More moves than are kept.
    #[error("line {line}: more than {most} moves, of which arcs take many")]
    Many {
        /// Line, from 1.
        line: u32,
        /// Most moves.
        most: usize,
    },
    /// No text.
    #[error("it is no text: byte {byte} is none of UTF-8")]
    Text {
        /// Offset of the first such byte.
        byte: usize,
    },
    /// A program without a cut.
    #[error("it has no feed move")]
    Empty,
}
