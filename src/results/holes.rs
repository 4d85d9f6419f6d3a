//! Holes of the part, as a shop reads of them.

use crate::geom::PartFeatures;
use serde::{Deserialize, Serialize};

/// A hole of the part, or of the forming tool that is made in its place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct HoleFacts {
    /// Its number in datum features and in STEP, from 1.
    pub number: usize,
    /// X and Y of its axis, mm.
    pub at_mm: [f64; 2],
    /// Diameter of its cylinder, of a threaded one the pilot's, mm.
    pub diameter_mm: f64,
    /// Depth of its cylinder from the base, mm; absent of a through hole.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<f64>,
    /// What a drawing says of it, in mm.
    pub words: String,
}

impl HoleFacts {
    /// Those of all holes of a part, in the order of their numbers.
    pub(crate) fn of(features: PartFeatures) -> Vec<Self> {
        let facts = |hole: crate::geom::NumberedHole| Self {
            number: hole.number,
            at_mm: hole.at().to_array(),
            diameter_mm: hole.hole.diameter_mm,
            depth_mm: hole.blind.map(|(depth_mm, _)| depth_mm),
            words: hole.words(),
        };
        features.holes().map(facts).collect()
    }
}
