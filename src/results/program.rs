//! What a program of numerical control cuts.

use serde::{Deserialize, Serialize};

/// A program, and the face that a ball cutter, or a nose on a lathe, leaves along its moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProgramFacts {
    /// Radius of the ball cutter, mm; none of a lathe.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ball_mm: Option<f64>,
    /// Radius of the tool's nose on a lathe, mm; none of a mill.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nose_mm: Option<f64>,
    /// Lines of the program.
    pub lines: u32,
    /// Straight moves, with the chords of its arcs.
    pub moves: usize,
    /// Length of the cutting moves, mm.
    pub cutting_mm: f64,
    /// Length of the rapid moves, mm.
    pub rapid_mm: f64,
    /// Time of the cutting moves at their feeds without starts and stops, minutes.
    pub cutting_min: f64,
    /// Distance from line to line over the face in the plan, mm: that of even lines, else the mean one; of turns about the axis
    /// the mean distance.
    pub apart_mm: f64,
    /// Direction of most lines from X towards Y, degrees; none of a lathe and of turns about the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// How much the lines agree in it: 1 where all are parallel; none of a lathe and of turns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parallel: Option<f64>,
    /// Facets of the face as cut.
    pub optical_triangles: usize,
    /// Most material that is left on the mirror, along its normal.
    pub highest: CutDeparture,
    /// Least, which is negative where the program cuts into the mirror.
    pub lowest: CutDeparture,
}

/// Distance of a cut from the mirror.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct CutDeparture {
    /// Distance of the cut from the mirror along its normal, um: positive where material is left.
    pub off_um: f64,
    /// The place, mm.
    pub at_mm: [f64; 3],
    /// Line of the program that cuts there.
    pub line: u32,
}
