//! Acceptance limits of a finished mirror: those of the profile, and usual ones in their place.

use super::{Layout, Profile};
use serde::{Deserialize, Serialize};

/// The limits that a profile names; a usual one stands in for each that is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AcceptanceSpec {
    /// Largest root-mean-square pixel error, in pixels.
    pub pixel_error_rms_px: Option<f64>,
    /// Largest pixel error anywhere, in pixels.
    pub pixel_error_max_px: Option<f64>,
    /// Smallest share of the frame's pixels that see their part of the world, 0 to 1.
    pub frame_filled: Option<f64>,
    /// Longest spot of 95 % of the pixels, with diffraction and pixel, in pixels; nothing stands in for it.
    pub blur_p95_px: Option<f64>,
}

/// A limit, and whether it stands there because the profile names none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AcceptanceLimit {
    /// The limit, in the unit of its key.
    pub value: f64,
    /// Whether the profile does not name it.
    pub usual: bool,
}

/// The limits that a mirror with a projection is held to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AcceptanceLimits {
    /// Root-mean-square pixel error, in pixels.
    pub pixel_error_rms_px: AcceptanceLimit,
    /// Largest pixel error, in pixels; also up to which a pixel counts as filled.
    pub pixel_error_max_px: AcceptanceLimit,
    /// Share of the frame that is filled.
    pub frame_filled: AcceptanceLimit,
}

impl AcceptanceLimits {
    /// Usual RMS pixel error as a share of the frame's width: a shift of content that is seen only beside
    /// the right picture.
    pub const RMS: f64 = 0.005;
    /// Usual largest one.
    pub const MAX: f64 = 0.015;
    /// Usual share of filled pixels of a mirror that is to fill the frame.
    pub const FULL: f64 = 0.995;
    /// Usual share of filled pixels of other mirrors: strips and discs leave most of a frame dark, and a
    /// mirror that covers less than this was made for another camera.
    pub const PART: f64 = 0.1;
}

impl Profile {
    /// The limits that the finished mirror must keep.
    #[must_use]
    pub fn acceptance_limits(&self) -> AcceptanceLimits {
        let bound = |named: Option<f64>, usual: f64| AcceptanceLimit {
            value: named.unwrap_or(usual),
            usual: named.is_none(),
        };
        // (As someone would write it.)
        let of_width =
            |share: f64| (1e3 * share * f64::from(self.camera.pixels()[0])).round() / 1e3;
        let fills = match self.layout {
            Layout::Strip { fill_frame } | Layout::Conquistador { fill_frame, .. } => fill_frame,
            _ => false,
        };
        let filled = if fills { AcceptanceLimits::FULL } else { AcceptanceLimits::PART };
        AcceptanceLimits {
            pixel_error_rms_px: bound(
                self.accept.pixel_error_rms_px,
                of_width(AcceptanceLimits::RMS),
            ),
            pixel_error_max_px: bound(
                self.accept.pixel_error_max_px,
                of_width(AcceptanceLimits::MAX),
            ),
            frame_filled: bound(self.accept.frame_filled, filled),
        }
    }
}
