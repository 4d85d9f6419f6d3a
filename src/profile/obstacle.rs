//! Obstacles and the camera's body as a profile has them.

use crate::geom::Obstacle;

/// An obstacle, and where the profile has it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleSpec {
    /// The obstacle, mm from the middle of the mirror.
    pub obstacle: Obstacle,
    /// The mesh file that it comes from, if it comes from one.
    pub file: Option<String>,
    /// Line and column of its table, from 1.
    pub place: (usize, usize),
}

/// The camera's body: a box behind its entrance pupil, whose front face goes through that.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraBody {
    /// Width and height along the picture's sides and depth along the camera's axis, mm.
    pub size_mm: [f64; 3],
    /// Line and column of the key, from 1.
    pub place: (usize, usize),
}
