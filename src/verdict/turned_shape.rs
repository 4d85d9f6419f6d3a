//! What of a mirror decides how a turned face of it is followed by facets.

use super::polar_face::{self, ROWS};
use crate::geom::{DVec2, DVec3};
use crate::num::{cos, sin};
use crate::turning::{DiscSections, Meridian};
use std::f64::consts::TAU;

/// A mirror as a lathe goes around it.
pub(crate) struct TurnedShape<'a> {
    /// The disc, whose sections differ; none of a round mirror.
    pub disc: Option<&'a DiscSections<'a>>,
    /// Distance from the axis and Z of places of the mirror; none of a disc.
    pub meridian: Vec<DVec2>,
    /// Distance of the inner rim from the axis, 0 of a disc, and the farthest of the outer one, mm.
    pub radii_mm: [f64; 2],
    /// Largest bend around the axis: of a round mirror its slope.
    pub bend: f64,
    /// Largest change of a section's slope with the azimuth.
    twist: f64,
}

impl TurnedShape<'_> {
    /// That of a round mirror.
    pub(crate) fn round(meridian: &Meridian) -> Self {
        Self {
            disc: None,
            meridian: meridian.places().map(|place| place.at).collect(),
            radii_mm: meridian.ends().map(|q| meridian.at(q).at.x),
            bend: meridian.steepest(),
            twist: 0.0,
        }
    }
}

impl<'a> TurnedShape<'a> {
    /// That of a disc.
    pub(crate) fn disc(disc: &'a DiscSections<'a>) -> Self {
        let outer = disc.most(|place| place.section.at.x);
        Self {
            disc: Some(disc),
            meridian: Vec::new(),
            radii_mm: [0.0, outer],
            bend: disc.most(|place| place.bend.abs()),
            twist: disc.most(|place| place.twist.abs()),
        }
    }

    /// Azimuths of facets that follow turns so far apart of a nose, both in mm.
    pub(crate) fn azimuths(&self, nose_mm: f64, feed_mm: f64) -> f64 {
        let even = polar_face::azimuths(self.bend, 0.5 * feed_mm / nose_mm);
        // Cusps that go inwards and out again around the axis, by the nose's radius for each unit of slope, do so by less than a row from
        // one azimuth to the next.
        let slips = TAU * nose_mm * self.twist * ROWS as f64 / feed_mm;
        polar_face::whole(even.max(slips))
    }

    /// Distance of the rim from the axis at an azimuth, radians, mm; none of a round mirror, and where there is none.
    pub(crate) fn rim_mm(&self, azimuth: f64) -> Option<f64> {
        Some(self.disc?.rim(azimuth)?.at.x)
    }

    /// A place of the mirror under a nose, mm, whose centre is `centre` in the half-plane at an azimuth, radians, and which is deeper
    /// than `touch_mm` in it.
    pub(crate) fn cut_by(
        &self,
        (azimuth, centre): (f64, DVec2),
        nose_mm: f64,
        touch_mm: f64,
    ) -> Option<DVec3> {
        let disc = self.disc?;
        let out = DVec2::new(cos(azimuth), sin(azimuth));
        let rim = disc.rim(azimuth)?.at.x;
        let deep = |k: i32| {
            let off = nose_mm * f64::from(k) / f64::from(ACROSS);
            let radius_mm = centre.x + off;
            let at = disc.at(azimuth, radius_mm).filter(|_| radius_mm.abs() <= rim)?.at;
            let z = centre.y - f64::sqrt(nose_mm * nose_mm - off * off);
            (z < at.y - touch_mm).then(|| (radius_mm * out).extend(at.y))
        };
        (-ACROSS..=ACROSS).find_map(deep)
    }
}

/// Places of a nose on each side of its middle at which it is held against a disc.
const ACROSS: i32 = 16;
