//! How the mirror is cut by a slow tool servo: `[program]` with `machine = "sts"`.

use super::program_words::ProgramControl;
use super::turning::{LatheSpec, TurnSpec};

/// What a slow tool servo has beside a lathe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoSpec {
    /// What the control reads.
    pub control: ServoControl,
    /// Angle of the flank below the nose's edge from the direction of cutting, degrees: no place that falls along it more steeply is
    /// reached.
    pub clearance_deg: f64,
}

/// What the control of a slow tool servo reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ServoControl {
    /// LinuxCNC: X as a radius, C in degrees, times of moves (G93).
    Linuxcnc,
    /// A table of points X, Z and C at an even speed of C.
    Xzc,
}

/// Speed at which an axis that is turned to commanded places goes at the most, 1/min: machines have 100 to 1000.
const MAX_RPM: f64 = 300.0;

impl ServoControl {
    /// All.
    pub const ALL: [Self; 2] = [Self::Linuxcnc, Self::Xzc];

    /// Itself among the controls of all machines.
    #[must_use]
    pub fn control(self) -> ProgramControl {
        match self {
            Self::Linuxcnc => ProgramControl::Linuxcnc,
            Self::Xzc => ProgramControl::Xzc,
        }
    }
}

impl ServoSpec {
    /// A lathe whose spindle is an axis.
    #[must_use]
    pub fn lathe() -> TurnSpec {
        let usual = TurnSpec::default();
        TurnSpec { machine: LatheSpec { max_spindle_rpm: MAX_RPM, ..usual.machine }, ..usual }
    }
}

impl Default for ServoSpec {
    /// A carbide or diamond tool with a flank of 10 degrees.
    fn default() -> Self {
        Self { control: ServoControl::Linuxcnc, clearance_deg: 10.0 }
    }
}
