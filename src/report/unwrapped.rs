//! What became of a photo.

use super::text::{figures, head_line, pretty, written};
use super::{FileFacts, ProfileId};
use crate::num::stats::{Summary, or_null};
use serde::Serialize;
use std::fmt::Write;

/// A photo through a mirror, unwrapped.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unwrapped {
    /// The version of the report's schema whose keys these are.
    pub schema: u32,
    /// Which profile.
    pub profile: ProfileId,
    /// The photo.
    pub photo: PhotoFacts,
    /// The panorama.
    pub panorama: PanoramaFacts,
    /// The table behind it; absent for simple cuts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<MapFacts>,
    /// The files written.
    pub files: Vec<FileFacts>,
}

/// A photo.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhotoFacts {
    /// As it was named.
    pub name: String,
    /// Across and down.
    pub pixels: [usize; 2],
    /// Pixels of the photo to one of the sensor, across.
    pub pixels_per_sensor_pixel: f64,
}

/// A panorama.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PanoramaFacts {
    /// "remap" or "cuts".
    pub way: &'static str,
    /// How rows map to elevation.
    pub projection: &'static str,
    /// Across and down.
    pub pixels: [usize; 2],
    /// At the left and at the right edge; for cuts as the mirror is meant to show them.
    pub azimuth_deg: [f64; 2],
    /// At the lower and at the upper edge.
    pub elevation_deg: [f64; 2],
}

/// A table of places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MapFacts {
    /// Share of the panorama's pixels that the photo shows.
    pub seen: f64,
    /// Distance on the sensor between where things are seen and where the projection has them.
    #[serde(serialize_with = "or_null")]
    pub distortion_px: Option<Summary>,
}

impl Unwrapped {
    /// As JSON.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// A readable summary.
    #[must_use]
    pub fn text(&self) -> String {
        written(|out| self.write_text(out))
    }

    fn write_text(&self, out: &mut String) -> std::fmt::Result {
        let Self { profile, photo, panorama, .. } = self;
        head_line(out, profile)?;
        let scale = match photo.pixels_per_sensor_pixel {
            1.0 => "as the sensor".to_owned(),
            scale => format!("{scale:.4} to one of the sensor"),
        };
        let [width, height] = photo.pixels;
        writeln!(out, "  photo    {}: {width} x {height} pixels, {scale}", photo.name)?;
        let [width, height] = panorama.pixels;
        let [[left, right], [low, high]] = [panorama.azimuth_deg, panorama.elevation_deg];
        writeln!(
            out,
            "  panorama {width} x {height} pixels, {}, by {}; azimuth {left:.2} to {right:.2} deg, \
             elevation {low:.2} to {high:.2} deg",
            panorama.projection, panorama.way
        )?;
        if let Some(map) = &self.map {
            writeln!(
                out,
                "  map      {:.2} % of the panorama is seen; distortion removed {} px",
                100.0 * map.seen,
                figures(map.distortion_px)
            )?;
        }
        for file in &self.files {
            writeln!(out, "  file     {}  {:.1} MB", file.name, file.bytes as f64 / 1e6)?;
        }
        Ok(())
    }
}
