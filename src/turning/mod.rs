//! Turning: the moves of a tool with a round nose that make a round mirror of a bar on a lathe, and the programs that a control reads.
//!
//! # Definitions
//!
//! - The **spindle** turns the bar about the axis of the part frame, Z. Places of the tool are those of a half-plane: X is the distance
//!   from the axis, Z the part's.
//! - The **nose** is a circle of radius r in that half-plane. What a program moves is its **tool point**, at which the nose is touched
//!   off: r nearer to the axis and r lower than the nose's centre, so that one edge of the nose has its X and another its Z.
//! - The **meridian** is the mirror's section with the half-plane. A nose that is to leave an **allowance** a has its centre r + a from the
//!   meridian along the normal: places of the designed surface, no facets.
//! - **Roughing** faces the bar at levels: at each level the nose goes no lower than that and than its path over the mirror.
//!   **Semi-finishing** and **finishing** follow the path from the rim to the axis, with a third of the allowance and without.
//! - The **feed** is what the tool goes in one turn of the spindle, along its path.
//!
//! What is written is proven elsewhere: a reader of its own reads the programs, turns the bar and traces what they leave.

mod bar;
mod cutting_data;
mod facing;
mod meridian;
mod nose_path;
mod operation;
mod post;

pub use bar::Bar;
pub use cutting_data::usual_feed_mm;
pub use meridian::Meridian;
pub use operation::{TurnedOperation, TurningTask};
pub use post::{LatheHeader, lathe_program_text};

use crate::milling::TravelExceeded;
use thiserror::Error;

/// Why a mirror cannot be turned so.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum TurningError {
    /// It is not round.
    #[error(
        "program.machine = \"turn\" is for what is round about the axis, and {what}; take program.machine = \"mill3\""
    )]
    NotRound {
        /// What is not, and how.
        what: &'static str,
    },
    /// The nose does not fit.
    #[error(
        "{radius_mm:.3} mm from the axis the mirror is hollow with a radius of {hollow_mm:.4} mm, no more than the nose's {nose_mm} mm and \
         program.allowance_mm of {allowance_mm} mm: take a smaller program.nose_mm, or a mirror that is less hollow"
    )]
    Hollow {
        /// Where, from the axis, mm.
        radius_mm: f64,
        /// Radius of the meridian there, mm.
        hollow_mm: f64,
        /// Radius of the nose, mm.
        nose_mm: f64,
        /// What roughing leaves, mm.
        allowance_mm: f64,
    },
    /// A straight edge of the tool would cut into the mirror.
    #[error(
        "{radius_mm:.3} mm from the axis the mirror is {slope_deg:.2} degrees steep, and the tool's edge there, program.{key}, has \
         {edge_deg} degrees: take a slimmer tool and write its angle, or a mirror that is less steep"
    )]
    Steep {
        /// Where, from the axis, mm.
        radius_mm: f64,
        /// How steep it is, degrees.
        slope_deg: f64,
        /// Angle of the edge, degrees.
        edge_deg: f64,
        /// Its key.
        key: &'static str,
    },
    /// The nose's lowest place is below what is around the mirror.
    #[error(
        "at the mirror's rim the nose of {nose_mm} mm reaches {below_mm:.3} mm below the {what} around it; raise part.base_mm by as \
         much{}, or take a smaller program.nose_mm",
        if *has_rim { " with part.rim_mm as it is" } else { "" }
    )]
    Floor {
        /// Radius of the nose, mm.
        nose_mm: f64,
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
    /// The turns are too near each other for facets to follow them.
    #[error(
        "a feed of {feed_mm} mm in a turn takes about {facets:.1e} facets to prove, over {most:.0e}: take a program.feed_mm_rev of \
         {least_mm} mm or more"
    )]
    Fine {
        /// The feed, mm.
        feed_mm: f64,
        /// Facets that it takes.
        facets: f64,
        /// The most.
        most: f64,
        /// The least feed that will do, mm.
        least_mm: f64,
    },
    /// More moves than a program may have.
    #[error(
        "{what} would take more than {most:.0e} moves: take a larger program.chord_um or stepdown_mm"
    )]
    Many {
        /// Which operation.
        what: &'static str,
        /// The most.
        most: f64,
    },
    /// A tool on which a mirror is formed.
    #[error("a {form} is made by its build: leave part.forming out to turn the mirror itself")]
    Formed {
        /// Name of the tool.
        form: &'static str,
    },
}
