//! The blur's results as JSON and text.

use super::text::{digits, head_line, pretty, written};
use super::{ProfileId, Sharpness};
use crate::pencil::Quantiles;
use crate::profile::Aperture;
use serde::Serialize;
use std::fmt::Write;

/// `blur.json`, schema 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BlurReport {
    /// Version of these keys.
    pub schema: u32,
    /// Which profile.
    pub profile: ProfileId,
    /// Columns and rows of the sensor.
    pub pixels: [u32; 2],
    /// Pixels whose centres are aimed at the mirror.
    pub aimed: usize,
    /// The lens as it was asked for.
    pub aperture: Aperture,
    /// Whether the focus is the best one, for want of another.
    pub focus_is_best: bool,
    /// The spots in that focus.
    pub spots: Spots,
    /// The spots in the focus that makes their 95th percentile smallest.
    pub best: Spots,
    /// Where the mirror's virtual images of the world lie, along the chief rays.
    pub images: Images,
    /// How sharp the picture is with diffraction and pixel; absent where spots are points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<Sharpness>,
}

/// The plane in focus, across the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Focus {
    /// Its Z in the part frame; none infinitely far away.
    pub z_mm: f64,
    /// Its distance from the entrance pupil, of a pinhole camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
}

/// Blur with one focus.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spots {
    /// Which.
    pub focus: Focus,
    /// Full length of a pixel's blur ellipse.
    pub length_px: Quantiles,
    /// Twice the root mean square distance of its rays from the chief ray.
    pub rms_diameter_px: Quantiles,
    /// The aperture with which 95 % of the lengths are at most one pixel.
    pub largest: Aperture,
}

/// Where the virtual images lie.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Images {
    /// The farthest from the camera and the nearest line image of any pixel.
    pub range: [Focus; 2],
    /// Distance along the axis between a pixel's two line images.
    pub astigmatism_mm: Quantiles,
}

impl BlurReport {
    /// `blur.json`.
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
        let Self { profile, spots, best, images, .. } = self;
        let digits = |x: f64| match x {
            f64::INFINITY => "infinitely far".into(),
            ..5e-7 => "0".into(),
            _ => digits(x),
        };
        let three = |q: &Quantiles, unit: &str| {
            let [p50, p95, max] = [q.p50, q.p95, q.max].map(digits);
            format!("{p50} p50, {p95} p95, {max} max {unit}")
        };
        head_line(out, profile)?;
        let which = if self.focus_is_best { ", the best focus" } else { "" };
        let (aperture, focus) = (aperture(&self.aperture), plane(&spots.focus));
        writeln!(out, "  lens     {aperture}, focused on {focus}{which}")?;
        writeln!(
            out,
            "  spot     full length {}; RMS diameter {}; {} pixels",
            three(&spots.length_px, "px"),
            three(&spots.rms_diameter_px, "px"),
            self.aimed
        )?;
        let largest = |spots: &Spots| largest(&spots.largest);
        writeln!(out, "  largest  {} keeps 95 % of the spots within 1 px", largest(spots))?;
        if !self.focus_is_best {
            writeln!(
                out,
                "  best     focused on {}: full length {}; {}",
                plane(&best.focus),
                three(&best.length_px, "px"),
                largest(best)
            )?;
        }
        let [far, near] = &images.range;
        writeln!(
            out,
            "  images   of the world from {} to {}; the two line images of a pixel are {} apart",
            plane(near),
            plane(far),
            three(&images.astigmatism_mm, "mm")
        )?;
        if let Some(sharpness) = &self.sharpness {
            if let Some(given) = &sharpness.given {
                writeln!(out, "  sharp    through {}", given.line())?;
            }
            writeln!(out, "           best through {}", sharpness.best.line())?;
            if let Some(warning) = sharpness.warning() {
                writeln!(out, "           {warning}")?;
            }
        }
        Ok(())
    }
}

fn aperture(aperture: &Aperture) -> String {
    match aperture {
        Aperture::Pupil { pupil_mm } => format!("entrance pupil of {} mm", digits(*pupil_mm)),
        Aperture::Na { na } => format!("numerical aperture of {}", significant(*na)),
    }
}

/// Three digits of a number below 1.
fn significant(x: f64) -> String {
    let (mut decimals, mut first) = (3, x);
    while first < 0.1 && decimals < 12 {
        (decimals, first) = (decimals + 1, first * 10.0);
    }
    format!("{x:.decimals$}")
}

fn largest(largest: &Aperture) -> String {
    let (Aperture::Pupil { pupil_mm: size } | Aperture::Na { na: size }) = *largest;
    // A spot that is a point at any aperture.
    if !size.is_finite() || matches!(largest, Aperture::Na { na: 1.0 }) {
        return "any aperture".into();
    }
    format!("an {}", aperture(largest)).replace("an num", "a num")
}

fn plane(focus: &Focus) -> String {
    match focus {
        Focus { z_mm, .. } if !z_mm.is_finite() => "infinity".into(),
        Focus { z_mm, distance_mm: None } => format!("the plane Z {z_mm:.3} mm"),
        Focus { z_mm, distance_mm: Some(mm) } => {
            format!("the plane {mm:.3} mm from the pupil (Z {z_mm:.3})")
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn small_apertures_keep_three_digits() {
        let found = [0.5, 0.0129, 1.2851e-3].map(super::significant);
        assert_eq!(found, ["0.500", "0.0129", "0.00129"]);
    }
}
