//! The frame-fill check's results as JSON, CSV, text and a picture.

use super::map::{Colour, Map, grey};
use super::text::{digits, head_line, pretty, verdict_lines, written};
use super::{ProfileId, Verdict};
use crate::raster::EncodingError;
use crate::trace::{Coverage, FrameFill, MinMeanMax, PixelClass};
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

/// Colour and name of the causes, in the order of [`PixelClass::LOST`].
const LOST: [(Colour, &str); 7] = [
    ([31, 59, 115], "beyond the mirror"),
    ([255, 140, 0], "at the rim"),
    ([255, 225, 0], "at the ridge"),
    ([208, 0, 32], "in shadow"),
    ([224, 0, 192], "wrong content"),
    ([0, 160, 0], "back face"),
    ([0, 200, 216], "missed"),
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
            .map(|(count, (_, name))| format!("{count} {name}"))
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

    /// `frame.png`: filled pixels grey by solid angle (`usr`, one a pixel), the others in the colour
    /// of their cause.
    ///
    /// # Errors
    /// What the encoder reports.
    ///
    /// # Panics
    /// When `classes` or `usr` have not one entry a pixel of the frame.
    pub fn png(
        &self,
        classes: &[PixelClass],
        usr: &[Option<f64>],
    ) -> Result<Vec<u8>, EncodingError> {
        assert_eq!(classes.len(), usr.len(), "one entry a pixel");
        let MinMeanMax { min, mean, max } =
            self.resolution.pixel_usr.unwrap_or(MinMeanMax { min: 0.0, mean: 0.0, max: 0.0 });
        // Where all are equal but for rounding there is no scale.
        let even = !(max - min > 1e-6 * mean);
        let share = |usr: f64| if even { 0.5 } else { (usr - min) / (max - min) };
        let colour = |(class, usr): (&PixelClass, &Option<f64>)| match class {
            PixelClass::Filled => grey(usr.map_or(0.0, share)),
            class => PixelClass::LOST.iter().position(|f| f == class).map_or([0; 3], |k| LOST[k].0),
        };
        let counts = self.frame.lost.counts();
        let map = Map {
            pixels: self.frame.pixels,
            colours: classes.iter().zip(usr).map(colour).collect(),
            title: "solid angle of a pixel, usr".into(),
            ramp: grey,
            ticks: if even {
                vec![digits(mean)]
            } else {
                [min, 0.5 * (min + max), max].map(digits).to_vec()
            },
            keys: LOST
                .iter()
                .zip(counts)
                .map(|((c, name), n)| (*c, format!("{n} {name}")))
                .collect(),
        };
        map.png()
    }
}
