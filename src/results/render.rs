//! A picture that was rendered.

use super::ProfileId;
use serde::Serialize;

/// A picture of a scene in a mirror, or of the mirror.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct RenderReport {
    /// The version of the report's schema whose keys these are.
    pub schema: u32,
    /// Name and fingerprint of the profile.
    pub profile: ProfileId,
    /// The scene's name or file, as asked for.
    pub scene: String,
    /// What was traced: the format of the mesh that was written and read back, or `design`.
    pub traced: &'static str,
    /// The PNG file, with its folder.
    pub file: String,
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Rays sent: one a pixel, and those at edges.
    pub rays: u64,
}
