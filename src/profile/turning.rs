//! How the mirror is turned: `[program]` with `machine = "turn"`, and of a slow tool servo what it has in common with that.

use super::program_words::{ProgramControl, StockMaterial, WorkOffset};

/// How a mirror is faced on a lathe, whose spindle is the mirror's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnSpec {
    /// What the stock is of.
    pub material: StockMaterial,
    /// Offset of the zero point that the program calls for.
    pub work_offset: WorkOffset,
    /// What the bar stands over the part around it and on top, mm.
    pub stock_mm: f64,
    /// The tool.
    pub nose: NoseSpec,
    /// Turns that leave the mirror.
    pub finishing: TurnedFinishSpec,
    /// What comes before them.
    pub roughing: TurnedRoughSpec,
    /// Speed of the spindle, 1/min; none for what is usual of the material.
    pub spindle_rpm: Option<f64>,
    /// What the machine can do.
    pub machine: LatheSpec,
}

/// A tool with a round nose between two straight edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoseSpec {
    /// Radius of the nose, mm.
    pub radius_mm: f64,
    /// Angle of the straight edge on the axis' side from the plane across the spindle, degrees: no place that falls away from the
    /// axis more steeply is reached.
    pub inner_edge_deg: f64,
    /// The same on the rim's side: no place that rises away from the axis more steeply is reached.
    pub outer_edge_deg: f64,
}

/// Turns of the nose that leave the mirror.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnedFinishSpec {
    /// Feed in a turn of the spindle, mm; none for the largest that keeps both budgets.
    pub feed_mm_rev: Option<f64>,
    /// Height that no cusp may exceed, um.
    pub scallop_um: Option<f64>,
    /// Pixel error that 95 % of the face as cut may not exceed; none for the limits that a build is held to.
    pub budget_px: Option<f64>,
    /// What straight moves may be off the path of the nose, um.
    pub chord_um: f64,
    /// What is polished off the turned face, um; none of a mirror that is used as it comes off the machine.
    pub polish_um: Option<f64>,
}

/// Levels that take the stock away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnedRoughSpec {
    /// What is left on the mirror, mm.
    pub allowance_mm: f64,
    /// From level to level, mm; none for what is usual of the material.
    pub stepdown_mm: Option<f64>,
    /// Feed in a turn of the spindle, mm; none for what is usual of the material.
    pub feed_mm_rev: Option<f64>,
}

/// What a lathe can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatheSpec {
    /// Speed of rapid moves, mm/min.
    pub rapid_mm_min: f64,
    /// Largest speed of the spindle, 1/min.
    pub max_spindle_rpm: f64,
    /// Acceleration, mm/s^2.
    pub acceleration_mm_s2: f64,
    /// Jerk, mm/s^3; none for any.
    pub jerk_mm_s3: Option<f64>,
    /// Travel of the slides along X and Z, mm; none for any.
    pub travel_mm: Option<[f64; 2]>,
    /// Height of rapid moves over the stock, mm.
    pub safe_mm: f64,
}

/// What the control of a lathe reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatheControl {
    /// LinuxCNC: X as a diameter (G7), G95.
    Linuxcnc,
    /// Fanuc, G-code system A: X as a diameter, G99.
    Fanuc,
}

impl LatheControl {
    /// All.
    pub const ALL: [Self; 2] = [Self::Linuxcnc, Self::Fanuc];

    /// Itself among the controls of all machines.
    #[must_use]
    pub fn control(self) -> ProgramControl {
        match self {
            Self::Linuxcnc => ProgramControl::Linuxcnc,
            Self::Fanuc => ProgramControl::Fanuc,
        }
    }
}

impl Default for TurnSpec {
    /// An insert of 0.8 mm in aluminium, on a light lathe.
    fn default() -> Self {
        Self {
            material: StockMaterial::Aluminium,
            work_offset: WorkOffset::FIRST,
            stock_mm: 1.0,
            // An insert of 35 degrees (ISO 1832: V) that stands straight, as in a holder of the form SVVCN.
            nose: NoseSpec { radius_mm: 0.8, inner_edge_deg: 72.5, outer_edge_deg: 72.5 },
            finishing: TurnedFinishSpec {
                feed_mm_rev: None,
                scallop_um: None,
                budget_px: None,
                chord_um: 1.0,
                polish_um: None,
            },
            roughing: TurnedRoughSpec { allowance_mm: 0.3, stepdown_mm: None, feed_mm_rev: None },
            spindle_rpm: None,
            machine: LatheSpec {
                rapid_mm_min: 5000.0,
                max_spindle_rpm: 3000.0,
                acceleration_mm_s2: 500.0,
                jerk_mm_s3: None,
                travel_mm: None,
                safe_mm: 5.0,
            },
        }
    }
}
