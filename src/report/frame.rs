//! The frame-fill check's results as JSON, CSV and text.

use super::text::{digits, head_line, pretty, verdict_lines, written};
use super::{ProfileId, Verdict};
use crate::trace::{Coverage, FrameFill, MinMeanMax};
use serde::Serialize;
use std::fmt::Write;

/// `frame.json`, schema 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameReport {
    /// Version of these keys.
    pub schema: u32,
    /// Which profile.
    pub profile: ProfileId,
    /// The witness's count, as in `report.json`.
    pub frame: FrameFill,
    /// What the filled pixels cover of the world.
    pub coverage: Coverage,
    /// The solid angle of a pixel of the designed mirror.
    pub resolution: Resolution,
    /// The shipped round mirrors, inscribed in the same sensor.
    pub round_mirrors: Vec<RoundMirror>,
    /// Least share of the pixels that must be filled.
    pub min: f64,
    /// Whether it is.
    pub verdict: Verdict,
    /// Why not.
    pub reasons: Vec<String>,
}

/// How evenly a mirror spends its pixels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Resolution {
    /// Pixels whose centres are aimed at the mirror.
    pub pixels: u64,
    /// Solid angle of the world that a pixel shows, microsteradians; none without pixels.
    pub pixel_usr: Option<MinMeanMax>,
    /// The largest over the smallest.
    pub ratio: Option<f64>,
    /// All pixels together, sr.
    pub total_sr: f64,
}

/// A round mirror on the sensor.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RoundMirror {
    /// Shipped profile.
    pub profile: String,
    /// What it does with the pixels.
    #[serde(flatten)]
    pub resolution: Resolution,
}

/// Names of the causes, in the order of [`crate::trace::PixelClass::LOST`].
pub(super) const LOST: [&str; 7] = [
    "beyond the mirror",
    "at the rim",
    "at the ridge",
    "in shadow",
    "wrong content",
    "back face",
    "missed",
];

impl FrameReport {
    /// `frame.json`.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// `frame.csv`: a line a column of the sensor.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut out = String::from("column,filled_px,lowest_deg,highest_deg\n");
        for (k, column) in self.coverage.columns.iter().enumerate() {
            let [lowest, highest] = match column.elevation_deg {
                Some(range) => range.map(|deg| format!("{deg:.6}")),
                None => Default::default(),
            };
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{k},{},{lowest},{highest}", column.filled);
        }
        out
    }

    /// A readable summary.
    #[must_use]
    pub fn text(&self) -> String {
        written(|out| self.write_text(out))
    }

    fn write_text(&self, out: &mut String) -> std::fmt::Result {
        let Self { profile, frame, coverage, resolution, .. } = self;
        head_line(out, profile)?;
        writeln!(
            out,
            "  frame      {:.3} % of {} x {} filled within {} px; {:+.1} % against a disc",
            100.0 * frame.filled,
            frame.pixels[0],
            frame.pixels[1],
            frame.tolerance_px,
            100.0 * frame.gain_over_disc
        )?;
        let lost: Vec<String> = frame
            .lost
            .counts()
            .iter()
            .zip(LOST)
            .filter(|(count, _)| **count > 0)
            .map(|(count, name)| format!("{count} {name}"))
            .collect();
        let lost = if lost.is_empty() { "none".into() } else { lost.join(", ") };
        writeln!(out, "  lost       {lost}")?;
        writeln!(
            out,
            "  azimuth    {:.3} of 360 deg covered{}",
            coverage.azimuth_deg,
            coverage
                .gaps_deg
                .iter()
                .map(|[a, b]| format!(", not {a:.3} to {b:.3}"))
                .collect::<String>()
        )?;
        for seam in &coverage.seams {
            let (px, deg) = (seam.gap_px, seam.gap_deg);
            writeln!(
                out,
                "  seam       {} edge: gap {:.3} to {:.3} px, {:.3} in the mean ({:.4} to {:.4} deg)",
                seam.edges, px.min, px.max, px.mean, deg.min, deg.max
            )?;
        }
        if let (Some(low), Some(high)) = (coverage.lowest_deg, coverage.highest_deg) {
            writeln!(
                out,
                "  elevation  columns begin at {:.2} to {:.2} ({:.2} in the mean) and end at {:.2} to \
                 {:.2} ({:.2}) deg",
                low.min, low.max, low.mean, high.min, high.max, high.mean
            )?;
        }
        writeln!(
            out,
            "  solid angle of a pixel, usr  {:>9} {:>9} {:>9} {:>8} {:>9}",
            "least", "mean", "most", "ratio", "pixels"
        )?;
        let rounds =
            self.round_mirrors.iter().map(|round| (round.profile.as_str(), &round.resolution));
        for (name, resolution) in std::iter::once((&*profile.name, resolution)).chain(rounds) {
            let figures = match (resolution.pixel_usr, resolution.ratio) {
                (Some(usr), Some(ratio)) => [usr.min, usr.mean, usr.max, ratio].map(digits),
                _ => ["-"; 4].map(String::from),
            };
            let [least, mean, most, ratio] = figures;
            let pixels = resolution.pixels;
            writeln!(out, "    {name:26} {least:>9} {mean:>9} {most:>9} {ratio:>8} {pixels:>9}")?;
        }
        verdict_lines(out, &self.reasons, self.verdict)
    }
}
