//! Turning: the moves of a tool with a round nose that make a mirror of a bar on a lathe, and the programs that a control reads.
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
//! - A **slow tool servo** is a lathe whose spindle is an axis, C: at each azimuth the nose has another height, so that the mirror need
//!   not be round. The section at that azimuth takes the place of the meridian; X goes inwards evenly, and Z follows. A rectangle is cut as
//!   the disc around it.
//!
//! What is written is proven elsewhere: a reader of its own reads the programs, turns the bar and traces what they leave.

mod bar;
mod cutting_data;
mod disc_sections;
mod facing;
mod meridian;
mod nose_heights;
mod nose_path;
mod operation;
mod point_table;
mod post;
mod servo_post;
mod servo_task;
mod tool_fit;

pub use bar::Bar;
pub use cutting_data::usual_feed_mm;
pub use disc_sections::{DiscPlace, DiscSections};
pub use meridian::{Meridian, MeridianPlace};
pub use operation::{FINE_SLOPE, TurnedOperation, TurningTask};
pub use point_table::{PointTable, ServoLimit};
pub use post::{LatheHeader, lathe_program_text};
pub use servo_post::{ServoHeader, servo_program_text};
pub use servo_task::{ServoOperation, ServoTask};

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
    /// It is no disc or rectangle that a tool can go around.
    #[error(
        "program.machine = \"sts\" is for discs and rectangles about the axis, and {what}; take program.machine = \"mill3\", or \"turn\" where the \
         mirror is round"
    )]
    NoDisc {
        /// What is wrong with it.
        what: &'static str,
    },
    /// A section is not to be followed.
    #[error(
        "at {azimuth_deg:.2} degrees from X, {radius_mm:.3} mm from the axis, nothing of the mirror is found along Z; take \
         program.machine = \"mill3\""
    )]
    NoSection {
        /// Azimuth, degrees.
        azimuth_deg: f64,
        /// Distance from the axis, mm.
        radius_mm: f64,
    },
    /// The flank of the tool would rub on the mirror.
    #[error(
        "{radius_mm:.3} mm from the axis at {azimuth_deg:.2} degrees from X the mirror falls {slope_deg:.2} degrees along the direction of \
         cutting, and the tool's flank, program.clearance_deg, has {clearance_deg} degrees: take a tool with more clearance and write its \
         angle, or a mirror that is less steep there"
    )]
    Flank {
        /// Where, from the axis, mm.
        radius_mm: f64,
        /// Azimuth, degrees.
        azimuth_deg: f64,
        /// How steeply it falls, degrees.
        slope_deg: f64,
        /// Angle of the flank, degrees.
        clearance_deg: f64,
    },
    /// More points of a turn than are chosen among.
    #[error(
        "{what} would take more than {most} points of a turn: take {}",
        remedy.map_or("program.machine = \"mill3\"".to_owned(), |(key, least, unit)| format!("a program.{key} of {least} {unit} or more"))
    )]
    PerTurn {
        /// Which operation.
        what: &'static str,
        /// The most.
        most: usize,
        /// A key, the least value that will do, and its unit; none where no value does.
        remedy: Option<(&'static str, f64, &'static str)>,
    },
    /// More points than a table may have.
    #[error(
        "{what} would take more than {most:.0e} points: take a larger program.chord_um, or a program.{} of {} mm or more",
        feed.0, feed.1
    )]
    Points {
        /// Which operation.
        what: &'static str,
        /// The most.
        most: f64,
        /// The key of its feed and the least that will do, mm.
        feed: (&'static str, f64),
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
    #[error("a {form} is made by its build: leave part.form out to turn the mirror itself")]
    Formed {
        /// Name of the tool.
        form: &'static str,
    },
}
