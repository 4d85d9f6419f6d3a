//! How the mirror is milled or turned: `[program]`, with usual values in place of what is absent.

use super::program_words::{FinishingPath, MillControl, StockMaterial, WorkOffset};
use super::servo::ServoSpec;
use super::turning::{LatheControl, TurnSpec};
use crate::geom::Cutter;

/// The machine that makes the mirror, and how: `program.machine`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProgramSpec {
    /// A mill of three axes: `"mill3"`.
    Mill(MillSpec),
    /// A lathe: `"turn"`.
    Turn(TurnSpec, LatheControl),
    /// A lathe whose spindle is an axis, C: `"sts"`.
    Servo(TurnSpec, ServoSpec),
}

impl ProgramSpec {
    /// What mills the mirror; none of a lathe.
    #[must_use]
    pub fn mill(&self) -> Option<&MillSpec> {
        match self {
            Self::Mill(spec) => Some(spec),
            Self::Turn(..) | Self::Servo(..) => None,
        }
    }

    /// The same to change.
    pub fn mill_mut(&mut self) -> Option<&mut MillSpec> {
        match self {
            Self::Mill(spec) => Some(spec),
            Self::Turn(..) | Self::Servo(..) => None,
        }
    }

    /// What is polished off the face, um; none of a mirror that is used as it comes off the machine.
    #[must_use]
    pub fn polish_um(&self) -> Option<f64> {
        match self {
            Self::Mill(spec) => spec.finishing.polish_um,
            Self::Turn(spec, _) | Self::Servo(spec, _) => spec.finishing.polish_um,
        }
    }
}

impl Default for ProgramSpec {
    /// A light mill.
    fn default() -> Self {
        Self::Mill(MillSpec::default())
    }
}

/// How the mirror is milled on three axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MillSpec {
    /// What the stock is of.
    pub material: StockMaterial,
    /// What the control reads.
    pub control: MillControl,
    /// Offset of the zero point that the program calls for.
    pub work_offset: WorkOffset,
    /// What the stock stands over the part on its sides and on top, mm.
    pub stock_mm: f64,
    /// Lines that leave the mirror.
    pub finishing: FinishingSpec,
    /// What comes before them.
    pub roughing: RoughingSpec,
    /// Feeds and speed.
    pub speeds: SpeedsSpec,
    /// What the machine can do.
    pub machine: MachineSpec,
}

/// Lines of the ball that leave the mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishingSpec {
    /// Radius of the ball, mm.
    pub ball_mm: f64,
    /// Straight lines, or turns of a spiral.
    pub path: FinishingPath,
    /// Distance of the lines or turns in the plan, mm; none for the largest that keeps both budgets.
    pub stepover_mm: Option<f64>,
    /// Height that no scallop may exceed, um.
    pub scallop_um: Option<f64>,
    /// Pixel error that 95 % of the face as cut may not exceed; none for the largest that a build is held to.
    pub budget_px: Option<f64>,
    /// Direction of the lines from X towards Y, degrees; none for the best. A spiral has none.
    pub angle_deg: Option<f64>,
    /// What straight moves may be off the path of the ball, um.
    pub chord_um: f64,
    /// What is polished off the milled face, um; none of a mirror that is used as it comes off the machine.
    pub polish_um: Option<f64>,
    /// Lengths of the cutter.
    pub lengths: CutterLengths,
}

/// How far the teeth and the shank of a cutter go; none of what is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CutterLengths {
    /// Length of the teeth from the tip, mm.
    pub flute_mm: Option<f64>,
    /// Diameter of what is above them, mm; none for that of the ball.
    pub shank_diameter_mm: Option<f64>,
    /// Length out of the holder from the tip, mm.
    pub stickout_mm: Option<f64>,
}

/// Levels that take the stock away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughingSpec {
    /// The cutter's end; none for the ball that finishes.
    pub cutter: Option<Cutter>,
    /// What is left on the mirror, mm.
    pub allowance_mm: f64,
    /// From level to level, mm; none for what is usual of the material.
    pub stepdown_mm: Option<f64>,
    /// Lengths of a cutter of its own.
    pub lengths: CutterLengths,
}

/// Feeds and speed; none for what is usual of the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedsSpec {
    /// Teeth of a cutter.
    pub teeth: u32,
    /// Feed of finishing, mm/min.
    pub feed_mm_min: Option<f64>,
    /// Feed of roughing, mm/min.
    pub rough_feed_mm_min: Option<f64>,
    /// Speed of the spindle, 1/min.
    pub spindle_rpm: Option<f64>,
}

/// What a mill can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineSpec {
    /// Speed of rapid moves, mm/min.
    pub rapid_mm_min: f64,
    /// Largest feed, mm/min.
    pub max_feed_mm_min: f64,
    /// Largest speed of the spindle, 1/min.
    pub max_spindle_rpm: f64,
    /// Acceleration, mm/s^2.
    pub acceleration_mm_s2: f64,
    /// Jerk, mm/s^3; none for any.
    pub jerk_mm_s3: Option<f64>,
    /// Travel along X, Y and Z, mm; none for any.
    pub travel_mm: Option<[f64; 3]>,
    /// Height of rapid moves over the stock, mm.
    pub safe_mm: f64,
    /// Diameter of the holder of cutters, mm.
    pub holder_diameter_mm: f64,
}

impl MillSpec {
    /// Lengths of the cutter that roughs, which is the one that finishes where there is no other.
    #[must_use]
    pub fn rough_lengths(&self) -> CutterLengths {
        match self.roughing.cutter {
            Some(_) => self.roughing.lengths,
            None => self.finishing.lengths,
        }
    }
}

impl Default for MillSpec {
    /// A ball of 3 mm radius with two teeth in aluminium, on a light mill.
    fn default() -> Self {
        Self {
            material: StockMaterial::Aluminium,
            control: MillControl::Linuxcnc,
            work_offset: WorkOffset::FIRST,
            stock_mm: 1.0,
            finishing: FinishingSpec {
                ball_mm: 3.0,
                path: FinishingPath::Lines,
                stepover_mm: None,
                scallop_um: None,
                budget_px: None,
                angle_deg: None,
                chord_um: 1.0,
                polish_um: None,
                lengths: CutterLengths::default(),
            },
            roughing: RoughingSpec {
                cutter: None,
                allowance_mm: 0.3,
                stepdown_mm: None,
                lengths: CutterLengths::default(),
            },
            speeds: SpeedsSpec {
                teeth: 2,
                feed_mm_min: None,
                rough_feed_mm_min: None,
                spindle_rpm: None,
            },
            machine: MachineSpec {
                rapid_mm_min: 5000.0,
                max_feed_mm_min: 3000.0,
                max_spindle_rpm: 24_000.0,
                acceleration_mm_s2: 500.0,
                jerk_mm_s3: None,
                travel_mm: None,
                safe_mm: 5.0,
                // The nut of a collet chuck ER 25, a common one of light mills.
                holder_diameter_mm: 42.0,
            },
        }
    }
}
