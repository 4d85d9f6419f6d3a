//! A hollow part: a cavity under the mirror, as printers of resin and powder want it.

use crate::geom::Drilled;

/// A cavity under the mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellSpec {
    /// Least thickness of what is around the cavity: mirror, walls and base, mm.
    pub wall_mm: f64,
    /// Holes through the base into the cavity; of none are told, two are placed.
    pub drains: Option<Vec<Drilled>>,
}

impl ShellSpec {
    /// Least thickness of walls that printers make, mm.
    pub const LEAST_WALL_MM: f64 = 0.2;
    /// Usual diameter of drains, mm: what resin and powder leave through.
    pub const USUAL_DRAIN_MM: f64 = 4.0;
    /// Least height of the cavity, mm.
    pub const LEAST_HEIGHT_MM: f64 = 0.5;
}
