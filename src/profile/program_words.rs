//! What programs of all machines choose among: material, control, offset of the zero point.

use serde::{Deserialize, Serialize};

/// What the stock is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum StockMaterial {
    /// Wrought alloys.
    Aluminium,
    /// Free-cutting brass.
    Brass,
    /// Cast acrylic.
    Pmma,
    /// Machining wax.
    Wax,
}

/// What the control of a mill reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MillControl {
    /// LinuxCNC.
    Linuxcnc,
    /// Grbl and its relatives.
    Grbl,
    /// Fanuc and what reads its programs.
    Fanuc,
}

/// What a control reads, of any machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ProgramControl {
    /// LinuxCNC.
    Linuxcnc,
    /// Grbl and its relatives.
    Grbl,
    /// Fanuc and what reads its programs.
    Fanuc,
    /// A table of points.
    Xzc,
}

/// Path of the cutter over the mirror in finishing and semi-finishing on a mill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FinishingPath {
    /// Straight lines of the plan, one after the other.
    Lines,
    /// Turns of one spiral about the axis, from the rim inwards.
    Spiral,
}

/// Offset of a zero point: the number of its word, G54 to G59.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkOffset(u8);

impl WorkOffset {
    /// The first, which controls begin with.
    pub const FIRST: Self = Self(54);
    /// All, in the order of their numbers.
    pub const ALL: [Self; 6] = [Self(54), Self(55), Self(56), Self(57), Self(58), Self(59)];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            54 => "G54",
            55 => "G55",
            56 => "G56",
            57 => "G57",
            58 => "G58",
            _ => "G59",
        }
    }
}

impl FinishingPath {
    /// All.
    pub const ALL: [Self; 2] = [Self::Lines, Self::Spiral];

    /// Its name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Lines => "lines",
            Self::Spiral => "spiral",
        }
    }
}

impl StockMaterial {
    /// All.
    pub const ALL: [Self; 4] = [Self::Aluminium, Self::Brass, Self::Pmma, Self::Wax];

    /// Its name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Aluminium => "aluminium",
            Self::Brass => "brass",
            Self::Pmma => "pmma",
            Self::Wax => "wax",
        }
    }
}

impl MillControl {
    /// All.
    pub const ALL: [Self; 3] = [Self::Linuxcnc, Self::Grbl, Self::Fanuc];

    /// Itself among the controls of all machines.
    #[must_use]
    pub fn control(self) -> ProgramControl {
        match self {
            Self::Linuxcnc => ProgramControl::Linuxcnc,
            Self::Grbl => ProgramControl::Grbl,
            Self::Fanuc => ProgramControl::Fanuc,
        }
    }

    /// Its name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.control().name()
    }
}

impl ProgramControl {
    /// Its name in a profile.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Linuxcnc => "linuxcnc",
            Self::Grbl => "grbl",
            Self::Fanuc => "fanuc",
            Self::Xzc => "xzc",
        }
    }

    /// Ending of its programs' names, which is that of their format.
    #[must_use]
    pub fn ending(self) -> &'static str {
        match self {
            Self::Linuxcnc | Self::Grbl | Self::Fanuc => "ngc",
            Self::Xzc => "xzc",
        }
    }
}
