//! What a program of numerical control cuts.

use serde::{Deserialize, Serialize};

/// A program, and the face that a cutter, or a nose on a lathe, leaves along its moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProgramFacts {
    /// Radius of the ball cutter, mm; none of another cutter, and of a lathe.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ball_mm: Option<f64>,
    /// Radius of a cutter with a flat end, mm; none of a ball, and of a lathe.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_mm: Option<f64>,
    /// Radius of the rounded edge of such a cutter, mm: 0 of a flat one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_mm: Option<f64>,
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
    /// What the slopes of the face are those of, by which rays are reflected.
    #[serde(default)]
    pub slopes: SlopeOrigin,
    /// Most material that is left on the mirror, along its normal.
    pub highest: CutDeparture,
    /// Least, which is negative where the program cuts into the mirror.
    pub lowest: CutDeparture,
}

/// What the slopes of a face as cut are those of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SlopeOrigin {
    /// Its facets, which follow the cusps.
    #[default]
    Facets,
    /// The cut itself where a ray meets it: facets are too wide for its cusps.
    Path,
}

impl SlopeOrigin {
    /// Of a face of which is told whether the path tells its slopes.
    #[must_use]
    pub fn of(is_path: bool) -> Self {
        if is_path { Self::Path } else { Self::Facets }
    }
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
