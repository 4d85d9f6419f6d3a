//! Faults of what a cutter leaves, of a study of tolerances and of a replayed trial, with their figures, and how
//! each is said.

use super::{digits, percent};
use crate::machining::FLOOR_MM;
use crate::num::rounding::floor_four_digits;
use thiserror::Error;

/// What is wrong with a face as a ball cutter leaves it.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CuttingFault {
    /// Its scallops displace the picture.
    #[error(
        "the unpolished face has a pixel error of {found_px:.3} px (95 % of it), over {limit_px} px; a \
         stepover of {} keeps it", stepover(*keeps_mm)
    )]
    PixelError {
        /// P95 of the pixel error, px.
        found_px: f64,
        /// The limit, px.
        limit_px: f64,
        /// The stepover that keeps it, mm, if there is one.
        keeps_mm: Option<f64>,
    },
    /// Its scallops are high.
    #[error(
        "scallops are up to {found_um:.3} um high, over {limit_um} um; a stepover of {} keeps it",
        stepover(*keeps_mm)
    )]
    Scallops {
        /// The highest, um.
        found_um: f64,
        /// The limit, um.
        limit_um: f64,
        /// The stepover that keeps it, mm, if there is one.
        keeps_mm: Option<f64>,
    },
    /// The valley is filled.
    #[error(
        "the ball leaves a fillet of {width_mm:.3} mm width in the valley, which takes {pixels:.0} pixels"
    )]
    Fillet {
        /// Largest width, mm.
        width_mm: f64,
        /// Pixels that see it.
        pixels: f64,
    },
    /// There is no place for the ball.
    #[error("the ball of {ball_mm} mm fits nowhere on the mirror")]
    NoPlace {
        /// Its diameter, mm.
        ball_mm: f64,
    },
    /// The ball does not reach all of the face.
    #[error("{}", unreached(*ball_mm, *nowhere, *at_mm, *hollow_mm, (*left_mm, *share)))]
    Unreached {
        /// Its diameter, mm.
        ball_mm: f64,
        /// Whether it fits nowhere.
        nowhere: bool,
        /// X and Y of the tightest hollow or else of what is left most, mm.
        at_mm: [f64; 2],
        /// Radius of the hollow, if it is tighter than the ball, mm.
        hollow_mm: Option<f64>,
        /// Height of what is left at most, mm.
        left_mm: f64,
        /// Share of the face on which something is left, 0 to 1.
        share: f64,
    },
    /// A rapid move goes through the part.
    #[error("the rapid move of line {line} cuts the mirror at X {:.3}, Y {:.3} mm", at_mm[0], at_mm[1])]
    Rapid {
        /// Line of the program.
        line: u32,
        /// X and Y of a place that it cuts, mm.
        at_mm: [f64; 2],
    },
    /// No move of a program cuts a place of the mirror.
    #[error(
        "no move of the program cuts the mirror at X {:.3}, Y {:.3} mm; the origin of its places must be on the part's base, \
         below the camera's axis", at_mm[0], at_mm[1]
    )]
    Uncut {
        /// X and Y, mm.
        at_mm: [f64; 2],
    },
    /// No cutting move of a program is over the mirror.
    #[error(
        "no cutting move of the program is over the mirror; the origin of its places must be on the part's base, below the \
         camera's axis"
    )]
    Elsewhere,
    /// A move meets the stock as it should not.
    #[error(
        "the {} {depth_mm:.3} mm {} the stock at X {:.3}, Y {:.3} mm", meeting.words(*line)[0], meeting.words(*line)[1], at_mm[0],
        at_mm[1]
    )]
    IntoStock {
        /// How.
        meeting: StockMeeting,
        /// Line of the program.
        line: u32,
        /// X and Y of a place that it meets, mm.
        at_mm: [f64; 2],
        /// How deep it goes there, mm.
        depth_mm: f64,
    },
    /// Other parts of a cutter than its teeth meet the stock.
    #[error(
        "the {} meets the stock at X {:.3}, Y {:.3} mm, which stands {least_mm:.3} mm over the tip in line {line}, and {} \
         {given_mm} mm; {}", part.words()[0], at_mm[0], at_mm[1], part.words()[1], part.words()[2]
    )]
    Short {
        /// Which.
        part: CutterPart,
        /// Line of the program.
        line: u32,
        /// X and Y of the place, mm.
        at_mm: [f64; 2],
        /// How high the stock stands over the tip there, mm.
        least_mm: f64,
        /// How far above the tip the part begins, mm.
        given_mm: f64,
    },
    /// More is taken away than should be.
    #[error(
        "{left_um:.2} um are left at X {:.3}, Y {:.3} mm where {asked_um} um should be", at_mm[0], at_mm[1]
    )]
    TooDeep {
        /// What is left there, um.
        left_um: f64,
        /// What should be, um.
        asked_um: f64,
        /// X and Y, mm.
        at_mm: [f64; 2],
    },
    /// More is left than is polished off.
    #[error(
        "{found_um:.2} um are left at X {:.3}, Y {:.3} mm, over the {limit_um} um of program.polish_um; take a smaller stepover or feed, \
         or a larger ball or nose", at_mm[0], at_mm[1]
    )]
    Unpolished {
        /// What is left, um.
        found_um: f64,
        /// What is polished off, um.
        limit_um: f64,
        /// X and Y, mm.
        at_mm: [f64; 2],
    },
    /// An axis is to change its speed faster than the machine can.
    #[error(
        "the move of line {line} asks for {found_mm_s2:.0} mm/s^2 of X or Z, over the machine's {limit_mm_s2} mm/s^2, \
         program.acceleration_mm_s2"
    )]
    Acceleration {
        /// Line of the program.
        line: u32,
        /// The acceleration, mm/s^2.
        found_mm_s2: f64,
        /// The machine's, mm/s^2.
        limit_mm_s2: f64,
    },
    /// An axis is to go faster than the machine can.
    #[error(
        "the move of line {line} asks for {found_mm_min:.0} mm/min of X or Z, over the machine's {limit_mm_min} mm/min, \
         program.rapid_mm_min"
    )]
    AxisSpeed {
        /// Line of the program.
        line: u32,
        /// The speed, mm/min.
        found_mm_min: f64,
        /// The machine's, mm/min.
        limit_mm_min: f64,
    },
    /// A move goes below the part's base.
    #[error(
        "the move of line {line} goes to Z {z_mm:.3} mm, below the part's base, on which it is clamped"
    )]
    BelowBase {
        /// Line of the program.
        line: u32,
        /// The lowest place of its tip, mm.
        z_mm: f64,
    },
    /// The face as cut has no facets.
    #[error("the face as cut: {why}")]
    Face {
        /// Why.
        why: String,
    },
}

/// How a move meets the stock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StockMeeting {
    /// By a rapid move.
    Rapid,
    /// Straight down by a feed move.
    Plunge,
}

impl StockMeeting {
    fn words(self, line: u32) -> [String; 2] {
        match self {
            Self::Rapid => [format!("rapid move of line {line} goes"), "deep into".to_owned()],
            Self::Plunge => [format!("move of line {line} goes straight down,"), "into".to_owned()],
        }
    }
}

/// A part of a cutter that is not to meet the stock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutterPart {
    /// What is above the teeth.
    Shank,
    /// The holder, with its nut.
    Holder,
}

impl CutterPart {
    /// The part, where it begins, and what helps.
    fn words(self) -> [&'static str; 3] {
        match self {
            Self::Shank => [
                "cutter's shank",
                "its teeth are as long as",
                "take a cutter of longer teeth, or smaller levels by program.stepdown_mm",
            ],
            Self::Holder => [
                "holder",
                "the cutter stands out of it by",
                "clamp it farther out, take a longer cutter, or a holder of less program.holder_diameter_mm",
            ],
        }
    }
}

fn stepover(mm: Option<f64>) -> String {
    mm.map_or("none".to_owned(), |mm| format!("{} mm", floor_four_digits(mm)))
}

fn unreached(
    ball_mm: f64,
    nowhere: bool,
    [x, y]: [f64; 2],
    hollow_mm: Option<f64>,
    (left_mm, share): (f64, f64),
) -> String {
    let fits = if nowhere { "fits nowhere on the mirror" } else { "does not fit" };
    let left = if left_mm > FLOOR_MM {
        format!("up to {:.3} um", 1e3 * left_mm)
    } else {
        format!("less than {} um", 1e3 * FLOOR_MM)
    };
    let why = match hollow_mm {
        Some(radius) => format!("the mirror is hollow with a radius of {radius:.4} mm; it"),
        None => "other ground is in its way, and it".to_owned(),
    };
    let percent = 100.0 * share;
    format!(
        "the ball of {ball_mm} mm {fits}: at X {x:.3} mm, Y {y:.3} mm {why} leaves {left}, and something on \
         {percent:.2} % of the face"
    )
}

/// Why a study of tolerances is not met.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum StudyFault {
    /// Too few parts are good.
    #[error(
        "{:.2} % of the parts stay within {budget_px} px, below the {} % of tolerance.target_yield",
        100.0 * share, percent(*target)
    )]
    Yield {
        /// The share that is good, 0 to 1.
        share: f64,
        /// The budget that they keep, px.
        budget_px: f64,
        /// The share that is to be good, 0 to 1.
        target: f64,
    },
    /// Textures blur the picture.
    #[error(
        "textures blur each pixel by {} px, over the {budget_px} px of tolerance.budget_blur_px; most of it by \
         {worst}", digits(*blur_px)
    )]
    Blur {
        /// The blur, px.
        blur_px: f64,
        /// The budget, px.
        budget_px: f64,
        /// The source that adds most.
        worst: String,
    },
}

/// Why a file of a replayed trial does not show the made surface.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ReplayFault {
    /// The trial has no picture.
    #[error("the trial is lost: rays do not meet the made surface")]
    Lost,
    /// A vertex is off the made surface.
    #[error(
        "a vertex lies {off_mm:.2e} mm off the made surface, over the {rounding_mm:.2e} mm of rounding"
    )]
    OffSurface {
        /// Its distance along Z, mm.
        off_mm: f64,
        /// What rounding explains, mm.
        rounding_mm: f64,
    },
    /// Rays go elsewhere.
    #[error("{lost} of {rays} rays are not reflected where the made surface is")]
    Unreflected {
        /// How many do.
        lost: usize,
        /// Of how many.
        rays: usize,
    },
    /// The displacement is another.
    #[error(
        "{state} it shows {shown_px:.6} px where the made surface has {smooth_px:.6} px, off by more than its \
         facet error of {facets_px:.6} px"
    )]
    Displacement {
        /// As made, or adjusted.
        state: &'static str,
        /// Of the file, px.
        shown_px: f64,
        /// Of the made surface, px.
        smooth_px: f64,
        /// What facets explain, px.
        facets_px: f64,
    },
}
