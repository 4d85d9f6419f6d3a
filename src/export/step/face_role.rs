//! The parts of a body that its faces bound.

use std::fmt::{self, Display};

/// The part of the body that a face bounds: its name in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceRole {
    /// The mirror.
    Optical,
    /// The flat land or the middle inside a round mirror.
    Land,
    /// A wall from the mirror's edge down to the base or to the rim.
    Wall,
    /// The flat top of the border.
    Rim,
    /// An outer wall of the border.
    Side,
    /// The bottom.
    Base,
    /// A hole, counted from 1.
    Hole(usize),
    /// A mark, counted from 1.
    Mark(usize),
}

impl Display for FaceRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Optical => f.write_str("OPTICAL"),
            Self::Land => f.write_str("LAND"),
            Self::Wall => f.write_str("WALL"),
            Self::Rim => f.write_str("RIM"),
            Self::Side => f.write_str("SIDE"),
            Self::Base => f.write_str("BASE"),
            Self::Hole(k) => write!(f, "HOLE_{k}"),
            Self::Mark(k) => write!(f, "MARK_{k}"),
        }
    }
}
