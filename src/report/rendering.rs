//! A picture that was rendered, in words.

use super::ProfileId;
use super::text::{head_line, pretty, written};
use serde::Serialize;
use std::fmt::Write;

/// A picture of a scene in a mirror, or of the mirror.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Rendering {
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

impl Rendering {
    /// As JSON.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// A readable summary.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { profile, scene, traced, file, pixels: [columns, rows], rays, .. } = self;
        let from = match *traced {
            "design" => "the designed mirror".to_owned(),
            format => format!("the mesh written as {format} and read back"),
        };
        written(|out| {
            head_line(out, profile)?;
            writeln!(out, "  scene    {scene}, from {from}")?;
            writeln!(out, "  picture  {file}  {columns} x {rows} pixels, {rays} rays")
        })
    }
}
