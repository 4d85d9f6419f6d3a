//! Programs that mill or turn a mirror, and what they leave.

use super::{AsCutFacts, FileFacts, ProfileId, ProgramFacts, Reason, StockFacts, Verdict};
use crate::milling::{OperationKind, Speeds};
use crate::num::stats::{Summary, or_null};
use crate::profile::{AcceptanceLimits, ProgramControl, StockMaterial};
use crate::program::{MachineTime, ToolPath};
use crate::trace::FrameFill;
use crate::turning::ServoLimit;
use serde::Serialize;

/// Programs that mill or turn a mirror: `program.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProgramReport {
    /// The version of the report's schema, whose rules hold for these keys too.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// What the stock is of.
    pub material: StockMaterial,
    /// What the control reads.
    pub control: ProgramControl,
    /// The offset whose zero is on the part's base, below the camera's axis.
    pub work_offset: String,
    /// The block, or the box around the bar.
    pub stock: StockFacts,
    /// Direction of the lines from X towards Y, degrees; none of a spiral and of a lathe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// The operations, in their order, each a program.
    pub operations: Vec<OperationFacts>,
    /// Time of all programs on the machine, minutes.
    pub machine_min: f64,
    /// Least length of a cutter out of its holder, mm: the depth from the stock's top to the lowest place of a tip.
    pub reach_mm: f64,
    /// Diameter of the holder, mm; none of a lathe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holder_diameter_mm: Option<f64>,
    /// What the programs travel along X, Y and Z, mm; on a lathe X is the distance from the axis, and Y is 0.
    pub travel_mm: [f64; 3],
    /// What the study of the finishing raster foresees of its scallops, pixels.
    #[serde(serialize_with = "or_null")]
    #[cfg_attr(test, schemars(with = "Summary"))]
    pub foreseen_px: Option<Summary>,
    /// What the finishing program cuts, read back; none where it could not be.
    pub program: Option<ProgramFacts>,
    /// The part as cut, as the witness saw it; none where there is none.
    pub as_cut: Option<AsCutFacts>,
    /// How well the frame is filled by the part as cut.
    pub frame: Option<FrameFill>,
    /// The limits that the part as cut was held to.
    pub accepted: Option<AcceptanceLimits>,
    /// The files written but for this one.
    pub files: Vec<FileFacts>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Reasons of a fail, each with figures; empty for a pass.
    pub reasons: Vec<Reason>,
    /// Other remarks; no part of the verdict.
    pub warnings: Vec<String>,
}

/// An operation, as its program was read back.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct OperationFacts {
    /// What it is.
    pub operation: OperationKind,
    /// Its program.
    pub file: String,
    /// Radius of the ball, mm; none of another cutter and of a lathe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball_mm: Option<f64>,
    /// Radius of a flat or a bull-nosed cutter, mm; none of a ball and of a lathe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Radius of its rounded edge, 0 of a flat one, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corner_mm: Option<f64>,
    /// Distance of its lines or turns in the plan, mm; none of a lathe.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stepover_mm: Option<f64>,
    /// Radius of the tool's nose, mm; none of a mill.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nose_mm: Option<f64>,
    /// Feed in a turn of the spindle, mm; none of a mill.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub feed_mm_rev: Option<f64>,
    /// What the axes of a slow tool servo do; none of other machines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub servo: Option<ServoFacts>,
    /// Levels; 1 of what follows the surface.
    pub levels: usize,
    /// What it is to leave on the mirror, mm.
    pub allowance_mm: f64,
    /// Speed and feeds.
    #[serde(flatten)]
    pub speeds: Speeds,
    /// Lines of the program.
    pub lines: u32,
    /// Its moves.
    pub moves: usize,
    /// Length of the cutting moves, mm.
    pub cutting_mm: f64,
    /// Length of the rapid moves, mm.
    pub rapid_mm: f64,
    /// Its time on the machine, with starts, stops and corners, minutes.
    pub machine_min: f64,
    /// Of that at the feeds, minutes.
    pub at_feed_min: f64,
    /// Of that speeding up, slowing down and in corners of cutting moves, minutes.
    pub changing_min: f64,
    /// Of that in rapid moves with their starts and stops, minutes.
    pub rapid_min: f64,
    /// What is left on the mirror after it, over a grid of places; none where no place of it is over the mirror.
    pub left: Option<LeftFacts>,
    /// Length of the cutter's teeth; none where nothing is in the way of its shank.
    pub flute: Option<LengthFacts>,
    /// Length of the cutter out of its holder; none where nothing is in the way of that.
    pub stickout: Option<LengthFacts>,
}

impl OperationFacts {
    /// What a program tells of itself as it was read back, and the time that it takes: nothing yet of its tool and of what it leaves.
    #[must_use]
    pub fn of_path(
        (operation, file): (OperationKind, String),
        (levels, allowance_mm, speeds): (usize, f64, Speeds),
        path: &ToolPath,
        time: &MachineTime,
    ) -> Self {
        let [cutting_mm, rapid_mm] = path.lengths_mm();
        Self {
            operation,
            file,
            ball_mm: None,
            radius_mm: None,
            corner_mm: None,
            stepover_mm: None,
            nose_mm: None,
            feed_mm_rev: None,
            servo: None,
            levels,
            allowance_mm,
            speeds,
            lines: path.lines,
            moves: path.moves.len(),
            cutting_mm,
            rapid_mm,
            machine_min: time.minutes(),
            at_feed_min: time.at_feed_min,
            changing_min: time.changing_min,
            rapid_min: time.rapid_min,
            left: None,
            flute: None,
            stickout: None,
        }
    }
}

/// What the axes of a slow tool servo do in a program, as it was read back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ServoFacts {
    /// Points of a turn of C.
    pub points_rev: usize,
    /// Largest acceleration of X or Z, mm/s^2.
    pub acceleration_mm_s2: f64,
    /// Largest speed of X or Z, mm/min.
    pub speed_mm_min: f64,
    /// What holds the speed of C down.
    pub limited_by: ServoLimit,
}

/// Length of a part of a cutter from its tip up, beyond which it must be to stay clear of the stock.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LengthFacts {
    /// The least: how high the stock stands over the tip at most, over a grid of places, mm.
    pub least_mm: f64,
    /// What the profile has, mm; none where it names none.
    pub given_mm: Option<f64>,
    /// Line of the program.
    pub line: u32,
    /// X and Y of the place, mm.
    pub at_mm: [f64; 2],
}

/// What is left on a mirror, along its normal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LeftFacts {
    /// The least, um; negative where the mirror is cut into.
    pub least_um: f64,
    /// X and Y of the place, mm.
    pub least_at_mm: [f64; 2],
    /// The most, um.
    pub most_um: f64,
    /// X and Y of the place, mm.
    pub most_at_mm: [f64; 2],
}
