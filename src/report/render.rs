//! A picture that was rendered, in words.

use super::answer::{Answer, AnswerRows, Head};
use super::facts::ProfileId;
use serde::Serialize;

/// A picture of a scene in a mirror, or of the mirror.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RenderReport {
    /// The version of the report's schema whose keys these are.
    pub schema: u32,
    /// Which profile.
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

impl Answer for RenderReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile)
    }

    fn rows(&self) -> AnswerRows {
        let Self { scene, traced, file, pixels: [columns, rows], rays, .. } = self;
        let picture = format!("{file}  {columns} x {rows} pixels, {rays} rays");
        let from = match *traced {
            "design" => "the designed mirror".to_owned(),
            format => format!("the mesh written as {format} and read back"),
        };
        let mut rows = AnswerRows::default();
        rows.terminal("scene", format!("{scene}, from {from}"));
        rows.terminal("picture", picture);
        rows
    }
}
