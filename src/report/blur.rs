//! The blur's results as JSON and text.

use super::answer::{Answer, AnswerRows, Head};
use super::page::{map_figure, page_of};
use crate::pencil::Quantiles;
use crate::profile::{Aperture, Profile};
use crate::raster::{EncodingError, FalseColourMap};
use crate::results::{BlurReport, FocusPlane, digits, three_digits};

impl BlurReport {
    /// `blur.html`, with the map of the spots.
    ///
    /// # Errors
    /// What the encoder of pictures reports.
    pub fn html(&self, profile: &Profile, map: &FalseColourMap) -> Result<String, EncodingError> {
        let caption = format!(
            "Full length of the spot that a point of the world makes at each pixel, by the mirror's shape alone. 95 % \
             are at most {} px long, the longest {} px.",
            three_digits(self.spots.length_px.p95),
            three_digits(self.spots.length_px.max)
        );
        Ok(page_of(
            self,
            (Some(("blur.html", profile)), "sharpness"),
            [map_figure("Length of the spots, px", map, caption)?],
            &[],
        ))
    }
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
        let apart = match images.astigmatism_mm {
            mm if mm.p50.is_finite() => {
                format!("the two line images of a pixel are {} mm apart", percentiles(mm))
            }
            _ => "the two line images of most pixels are infinitely far apart".into(),
        };
        rows.terminal("images", format!("of the world from {near} to {far}; {apart}"));
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
