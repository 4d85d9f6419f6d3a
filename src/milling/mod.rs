//! Milling: the moves of cutters that make a mirror of a block, and the programs that a control reads.
//!
//! # Definitions
//!
//! - An **operation** is what one cutter does in one program: roughing, semi-finishing or finishing. Its **moves** are those of
//!   the cutter's **tip**, the lowest place of its end on its axis, in the part frame.
//! - A **tip line** follows one line of a raster over the whole mirror ([`Passes`](crate::machining::Passes)), from beyond one
//!   side of it to beyond the other: places of the designed surface, no facets. A ball of radius R that is to leave an **allowance** a
//!   follows the centres of a ball of radius R + a.
//! - A **flat** or a **bull-nosed** cutter that roughs goes along lines of its axis, at the heights where it rests on the mirror with the allowance.
//! - **Roughing** takes the lines at levels: at each level the tip goes no lower than that and than its line. **Semi-finishing** and
//!   **finishing** take them as they are, with the allowance and without.
//! - A **spiral** takes the place of the lines of semi-finishing and finishing on a round mirror: one tip line from rim to axis.
//! - Lines over a **crest** go on straight from both sides until they meet above it, so that the crest stays sharp.
//!
//! What is written is proven elsewhere: a reader of its own reads the programs, cuts them and traces what they leave.

mod bridge;
mod cutting_data;
mod levels;
mod motions;
mod operation;
mod post;
mod rest_heights;
mod rest_lines;
mod spiral;
mod stock_block;
mod stock_left;
mod surface_lines;
mod tip_line;
mod travel;

pub use cutting_data::Speeds;
pub use levels::level_cuts;
pub use motions::{MotionList, Pace, TipMove};
pub use operation::{MillingTask, Operation, OperationKind};
pub use post::{Header, blending, program_comment, program_number, program_text, rounded_number};
pub use stock_block::StockBlock;
pub use tip_line::{distance_from_move, thinned};
pub use travel::TravelExceeded;

use crate::geom::DVec2;
use crate::machining::MachiningError;
use thiserror::Error;

/// Why a mirror cannot be milled so.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MillingError {
    /// The lines cannot be worked out.
    #[error(transparent)]
    Lines(#[from] MachiningError),
    /// A cutter that does not fit.
    #[error(
        "{why}; {what} with such a ball would cut into the mirror: take a smaller {key}, or a mirror that is less hollow"
    )]
    Unreached {
        /// What the survey of the cutter says.
        why: String,
        /// Which operation.
        what: &'static str,
        /// The key of its radius.
        key: &'static str,
    },
    /// The ball's lowest place is below what is around the mirror.
    #[error(
        "at the mirror's rim at X {:.3} mm, Y {:.3} mm a ball of {ball_mm} mm radius reaches {below_mm:.3} mm below the {what} \
         around it; raise part.base_mm by as much{}, or take a smaller program.ball_mm",
        at.x, at.y,
        if *has_rim { " with part.rim_mm as it is" } else { "" }
    )]
    Floor {
        /// Where.
        at: DVec2,
        /// Radius of the ball, mm.
        ball_mm: f64,
        /// By how much, mm.
        below_mm: f64,
        /// What is there.
        what: &'static str,
        /// Whether it is a flat rim.
        has_rim: bool,
    },
    /// The machine is too small.
    #[error(transparent)]
    Travel(#[from] TravelExceeded),
    /// More moves than a program may have.
    #[error(
        "{what} would take about {count:.1e} moves, over {most:.0e}: take a larger program.{key}"
    )]
    Many {
        /// Which operation.
        what: &'static str,
        /// How many moves.
        count: f64,
        /// The most.
        most: f64,
        /// The key that makes them fewer.
        key: &'static str,
    },
}
