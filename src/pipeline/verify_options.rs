//! How a file of unknown making is looked at.

use crate::align::LengthUnit;

/// How a file of unknown making is looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct VerifyOptions {
    /// The unit of its coordinates; none: by its size.
    pub units: Option<LengthUnit>,
    /// Fit its pose first, and judge it as a measured part: its files have the form error's map too.
    pub align: bool,
    /// Radius of the ball whose centres a list of points holds, mm; none: points on the part.
    pub probe_mm: Option<f64>,
    /// Radius of the ball cutter that a program moves, mm; none of other files.
    pub ball_mm: Option<f64>,
    /// Radius of the flat or bull-nosed cutter that a program moves, mm; none of a ball, and of other files.
    pub cutter_mm: Option<f64>,
    /// Radius of that cutter's rounded edge, mm; none of a flat one.
    pub corner_mm: Option<f64>,
    /// Radius of the nose of the tool that a program of a lathe moves, mm; none of other files.
    pub nose_mm: Option<f64>,
}
