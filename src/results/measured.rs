//! What is known of a file of unknown making: its units, and where it lay.

use crate::align::{Alignment, FreeMotion, LengthUnit};
use crate::num::degrees;
use serde::Serialize;

/// The unit of a file's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct UnitFacts {
    /// Symbol of the unit.
    pub name: &'static str,
    /// Length of the unit, mm.
    pub mm_per_unit: f64,
    /// `declared` by the file, `asked`, `by size`, or `assumed` where no unit makes the file as large as
    /// the part.
    pub chosen: &'static str,
}

impl UnitFacts {
    /// `unit`, and how it was chosen.
    #[must_use]
    pub fn new(unit: LengthUnit, chosen: &'static str) -> Self {
        Self { name: unit.name(), mm_per_unit: unit.mm(), chosen }
    }
}

/// How a file was brought into the part frame: place in mm -> turned about the origin -> shifted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AlignmentFacts {
    /// Axis of the turn times its angle, degrees.
    pub turn_deg: [f64; 3],
    /// The same turn as a unit quaternion.
    pub quaternion_xyzw: [f64; 4],
    /// Shift after the turn, mm.
    pub shift_mm: [f64; 3],
    /// Whether the facets showed the camera their backs.
    pub turned_over: bool,
    /// RMS distance of the vertices from the mirror, outliers left out, um.
    pub rms_um: f64,
    /// Share of the face around vertices that are outliers.
    pub outliers: f64,
    /// Share of the mirror that the others stand for.
    pub covered: f64,
    /// Vertices that the pose rests on.
    pub vertices: usize,
    /// Steps of the fit.
    pub steps: usize,
    /// How much worse the worst direction is determined than the best.
    pub condition: f64,
    /// Motions that move the mirror along itself; in these the file was left as it was.
    pub free: Vec<FreeMotion>,
}

impl AlignmentFacts {
    /// The facts of `alignment`.
    #[must_use]
    pub fn new(alignment: &Alignment) -> Self {
        let pose = &alignment.pose;
        Self {
            turn_deg: pose.rotation_vector().to_array().map(degrees),
            quaternion_xyzw: pose.rotation.to_array(),
            shift_mm: pose.shift.to_array(),
            turned_over: alignment.turned_over,
            rms_um: alignment.rms_mm * 1e3,
            outliers: alignment.outliers,
            covered: alignment.covered,
            vertices: alignment.vertices,
            steps: alignment.steps,
            condition: alignment.condition,
            free: alignment.free.clone(),
        }
    }
}
