//! The parts of a body that its faces bound.

use crate::geom::{HoleKind, NumberedHole};
use std::fmt::{self, Display};

/// The part of the body that a face bounds: its name in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a body has some hundred faces at the most")]
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
    /// A chamfer of an outer edge of the border.
    Chamfer,
    /// The bottom.
    Base,
    /// A hole.
    Hole(NumberedHole),
    /// A mark, counted from 1.
    Mark(usize),
    /// The roof, a wall or the floor of a cavity.
    Cavity,
    /// A drain of a cavity, counted from 1.
    Drain(usize),
}

impl FaceRole {
    /// Its colour in the file, red, green and blue from 0 to 1: one for what a shop makes with the same tool and care.
    pub(super) fn colour(&self) -> &'static str {
        match self {
            Self::Optical => "0.55,0.75,0.95",
            Self::Base => "0.5,0.75,0.5",
            Self::Hole(NumberedHole { hole, .. }) => match hole.kind {
                HoleKind::Thread { .. } => "0.95,0.6,0.25",
                HoleKind::Dowel => "0.85,0.3,0.3",
                HoleKind::Plain | HoleKind::Screw(_) => "0.9,0.85,0.4",
            },
            Self::Mark(_) => "0.7,0.5,0.8",
            Self::Cavity | Self::Drain(_) => "0.55,0.55,0.5",
            Self::Chamfer => "0.6,0.65,0.65",
            Self::Land | Self::Wall | Self::Rim | Self::Side => "0.8,0.8,0.8",
        }
    }
}

impl Display for FaceRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Optical => f.write_str("OPTICAL"),
            Self::Land => f.write_str("LAND"),
            Self::Wall => f.write_str("WALL"),
            Self::Rim => f.write_str("RIM"),
            Self::Side => f.write_str("SIDE"),
            Self::Chamfer => f.write_str("CHAMFER"),
            Self::Base => f.write_str("BASE"),
            Self::Hole(hole) if hole.is_plain() => write!(f, "HOLE_{}", hole.number),
            Self::Hole(hole) => write!(f, "HOLE_{} {}", hole.number, hole.words()),
            Self::Mark(k) => write!(f, "MARK_{k}"),
            Self::Cavity => f.write_str("CAVITY"),
            Self::Drain(k) => write!(f, "DRAIN_{k}"),
        }
    }
}
