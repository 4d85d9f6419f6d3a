//! What the frame-fill check found.

use super::{ProfileId, Reason, Verdict};
use crate::trace::{Coverage, FrameFill, MinMeanMax, Obstruction};
use serde::Serialize;

/// Filling of the frame by a mirror: `frame.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FrameReport {
    /// Version of these keys.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// The witness's count, as in `report.json`.
    pub frame: FrameFill,
    /// What the filled pixels cover of the world.
    pub coverage: Coverage,
    /// What each obstacle hides, in the order of the profile, the camera's body last; left out without obstacles.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstruction>,
    /// The solid angle of a pixel of the designed mirror.
    pub resolution: PixelSolidAngle,
    /// The shipped round mirrors, inscribed in the same sensor.
    pub round_mirrors: Vec<RoundMirror>,
    /// Least share of the pixels that must be filled.
    pub min: f64,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Reasons of a fail, each with figures; empty for a pass.
    pub reasons: Vec<Reason>,
}

/// How evenly a mirror spends its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PixelSolidAngle {
    /// Pixels whose centres are aimed at the mirror.
    pub pixels: u64,
    /// Solid angle of the world that a pixel shows, microsteradians; none without pixels.
    pub pixel_usr: Option<MinMeanMax>,
    /// The largest over the smallest.
    pub ratio: Option<f64>,
    /// Solid angle of all pixels together, sr.
    pub total_sr: f64,
}

/// A round mirror on the sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RoundMirror {
    /// Name of the shipped profile.
    pub profile: String,
    /// What it does with the pixels.
    #[serde(flatten)]
    pub resolution: PixelSolidAngle,
}
