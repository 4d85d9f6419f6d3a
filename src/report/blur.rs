//! The blur's results as JSON and text.

use super::answer::{Answer, AnswerRows, Head};
use super::facts::ProfileId;
use super::sharpness::SharpnessFacts;
use super::wording::{digits, three_digits};
use crate::pencil::Quantiles;
use crate::profile::Aperture;
use serde::Serialize;

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
    pub spots: SpotFacts,
    /// The spots in the focus that makes their 95th percentile smallest.
    pub best: SpotFacts,
    /// Where the mirror's virtual images of the world lie, along the chief rays.
    pub images: VirtualImages,
    /// How sharp the picture is with diffraction and pixel; absent where spots are points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sharpness: Option<SharpnessFacts>,
}

/// The plane in focus, across the axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FocusPlane {
    /// Its Z in the part frame; none infinitely far away.
    pub z_mm: f64,
    /// Its distance from the entrance pupil, of a pinhole camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
}

/// Blur with one focus.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpotFacts {
    /// Which.
    pub focus: FocusPlane,
    /// Full length of a pixel's blur ellipse.
    pub length_px: Quantiles,
    /// Twice the root mean square distance of its rays from the chief ray.
    pub rms_diameter_px: Quantiles,
    /// The aperture with which 95 % of the lengths are at most one pixel.
    pub largest: Aperture,
}

/// Where the virtual images lie.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct VirtualImages {
    /// The farthest from the camera and the nearest line image of any pixel.
    pub range: [FocusPlane; 2],
    /// Distance along the axis between a pixel's two line images.
    pub astigmatism_mm: Quantiles,
}

impl Answer for BlurReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile)
    }

    fn rows(&self) -> AnswerRows {
        let Self { spots, best, images, .. } = self;
        let mut rows = AnswerRows::default();
        let which = if self.focus_is_best { ", the best focus" } else { "" };
        let (aperture, focus) = (aperture(&self.aperture), plane(&spots.focus));
        rows.terminal("lens", format!("{aperture}, focused on {focus}{which}"));
        let [length, diameter] = [spots.length_px, spots.rms_diameter_px].map(percentiles);
        let aimed = self.aimed;
        rows.terminal(
            "spot",
            format!("full length {length} px; RMS diameter {diameter} px; {aimed} pixels"),
        );
        let widest = largest(&spots.largest);
        rows.terminal("largest", format!("{widest} keeps 95 % of the spots within 1 px"));
        if !self.focus_is_best {
            let (focus, widest) = (plane(&best.focus), largest(&best.largest));
            let length = percentiles(best.length_px);
            rows.terminal("best", format!("focused on {focus}: full length {length} px; {widest}"));
        }
        let [far, near] = images.range.map(|focus| plane(&focus));
        let apart = percentiles(images.astigmatism_mm);
        rows.terminal(
            "images",
            format!(
                "of the world from {near} to {far}; the two line images of a pixel are {apart} mm apart"
            ),
        );
        if let Some(sharpness) = &self.sharpness {
            if let Some(given) = &sharpness.given {
                rows.terminal("sharp", format!("through {}", given.line()));
            }
            rows.terminal("", format!("best through {}", sharpness.best.line()));
            if let Some(warning) = sharpness.warning() {
                rows.terminal("", warning);
            }
        }
        rows
    }
}

/// P50, P95 and maximum.
fn percentiles(of: Quantiles) -> String {
    let [p50, p95, max] = [of.p50, of.p95, of.max].map(|x: f64| match x {
        f64::INFINITY => "infinitely far".into(),
        ..5e-7 => "0".into(),
        _ => digits(x),
    });
    format!("{p50} p50, {p95} p95, {max} max")
}

fn aperture(aperture: &Aperture) -> String {
    match aperture {
        Aperture::Pupil { pupil_mm } => format!("entrance pupil of {} mm", digits(*pupil_mm)),
        Aperture::Na { na } => format!("numerical aperture of {}", three_digits(*na)),
    }
}

fn largest(largest: &Aperture) -> String {
    let (Aperture::Pupil { pupil_mm: size } | Aperture::Na { na: size }) = *largest;
    // A spot that is a point at any aperture.
    if !size.is_finite() || matches!(largest, Aperture::Na { na: 1.0 }) {
        return "any aperture".into();
    }
    format!("an {}", aperture(largest)).replace("an num", "a num")
}

fn plane(focus: &FocusPlane) -> String {
    match focus {
        FocusPlane { z_mm, .. } if !z_mm.is_finite() => "infinity".into(),
        FocusPlane { z_mm, distance_mm: None } => format!("the plane Z {z_mm:.3} mm"),
        FocusPlane { z_mm, distance_mm: Some(mm) } => {
            format!("the plane {mm:.3} mm from the pupil (Z {z_mm:.3})")
        }
    }
}
