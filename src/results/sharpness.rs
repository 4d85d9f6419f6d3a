//! How sharp a picture can be.

use super::{digits, three_digits};
use crate::pencil::ApertureSharpness;
use crate::profile::Aperture;
use serde::{Deserialize, Serialize};

/// How sharp the picture of a mirror is through the profile's lens and at best.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SharpnessFacts {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Through the aperture at which 95 % of the spots are least, in the best focus.
    pub best: ApertureFacts,
    /// Through the aperture that was asked for; absent where none was.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub given: Option<ApertureFacts>,
}

/// A lens, open so far.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ApertureFacts {
    /// The aperture.
    #[serde(flatten)]
    pub aperture: Aperture,
    /// Focal length over entrance pupil; absent where the profile has no focal length in mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub f_number: Option<f64>,
    /// The spots.
    #[serde(flatten)]
    pub sharp: ApertureSharpness,
    /// How many such spots lie side by side across the frame and up it.
    pub resolved: [u32; 2],
}

impl ApertureFacts {
    /// The lens in words, with an article.
    #[must_use]
    pub fn lens(&self) -> String {
        let size = match self.aperture {
            Aperture::Pupil { pupil_mm } => {
                format!("an entrance pupil of {} mm", three_digits(pupil_mm))
            }
            Aperture::Na { na } => format!("a numerical aperture of {}", three_digits(na)),
        };
        let stop = self.f_number.map_or(String::new(), |n| format!(" (f/{})", three_digits(n)));
        format!("{size}{stop}")
    }

    /// What is seen through it, on one line.
    #[must_use]
    pub fn line(&self) -> String {
        let ApertureSharpness { geometric_px, diffraction_px, spot_px, mtf_p50, mtf_p05 } =
            self.sharp;
        let [across, up] = self.resolved;
        format!(
            "{}: spots of {} px p95 (mirror {}, diffraction {}), about {across} x {up} of them; MTF at a \
             quarter of the sampling frequency {mtf_p50:.2} p50, {mtf_p05:.2} p05",
            self.lens(),
            three_digits(spot_px),
            digits(geometric_px),
            digits(diffraction_px),
        )
    }
}
