//! Images: which world direction every point of the picture must see, and back.
//!
//! Image points are (X, Y) mm of the part frame; directions are unit vectors of the part frame
//! (X to the right of the picture, Y up in it, Z along the axis towards the camera). Azimuth a and
//! elevation e stand for the direction (cos e sin a, cos e cos a, sin e).

use super::Law;
use crate::geom::{DVec2, DVec3};
use crate::num::{atan2, cos, sin, wrap_turn};

/// A straight panoramic strip: azimuth along X, elevation by a law along Y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// How rows map to elevation.
    pub law: Law,
    /// Scale s, mm per radian of azimuth.
    pub scale_mm: f64,
    /// Azimuth at X = 0, radians.
    pub azimuth: f64,
    /// The law's coordinate z (paper's units) at Y = 0.
    pub z: f64,
}

impl Strip {
    /// (azimuth in radians, law coordinate z) of an image point.
    #[inline]
    #[must_use]
    pub fn paper(&self, q: DVec2) -> DVec2 {
        DVec2::new(self.azimuth, self.z) + q / self.scale_mm
    }

    /// The direction that image point `q` must see.
    #[inline]
    #[must_use]
    pub fn wanted(&self, q: DVec2) -> DVec3 {
        let DVec2 { x: azimuth, y: z } = self.paper(q);
        let [sin_e, cos_e] = self.law.elevation(z);
        DVec3::new(cos_e * sin(azimuth), cos_e * cos(azimuth), sin_e)
    }

    /// The image point that must see `direction`: the one nearest to `near` in azimuth, which
    /// repeats every turn. Not finite for the two directions along the axis.
    #[inline]
    #[must_use]
    pub fn locate(&self, direction: DVec3, near: DVec2) -> DVec2 {
        let DVec2 { x: azimuth, .. } = self.paper(near);
        let turn = wrap_turn(atan2(direction.x, direction.y) - azimuth);
        let tan_e = direction.z / direction.truncate().length();
        let z = self.law.image_of_tangent(tan_e);
        DVec2::new(near.x + turn * self.scale_mm, (z - self.z) * self.scale_mm)
    }

    /// The slope (Z_X, Z_Y) that a mirror under a vertical camera ray must have at `q` (paper,
    /// section 4: the field whose gradient potential is sought).
    #[inline]
    #[must_use]
    pub fn slope(&self, q: DVec2) -> DVec2 {
        let DVec2 { x: azimuth, y: z } = self.paper(q);
        DVec2::new(-sin(azimuth), -cos(azimuth)) * self.law.slope(z)
    }

    /// Curl of [`Strip::slope`] at `q` in the paper's units (per radian): zero everywhere exactly
    /// when an exact mirror exists. Equals -W . curl W for W scaled to W_x = 1.
    #[must_use]
    pub fn curl(&self, q: DVec2) -> f64 {
        let DVec2 { x: azimuth, y: z } = self.paper(q);
        sin(azimuth) * (self.law.slope(z) + self.law.slope_derivative(z))
    }
}

/// On which side of the line Y = 0 the designed panel of a folded mirror lies; the other panel is
/// its reflection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fold {
    /// The designed panel has Y >= 0.
    Above,
    /// The designed panel has Y <= 0.
    Below,
}

impl Fold {
    /// Whether `q` lies on the reflected panel. The ridge itself belongs to the designed panel.
    #[inline]
    #[must_use]
    pub fn reflects(self, q: DVec2) -> bool {
        match self {
            Self::Above => q.y < 0.0,
            Self::Below => q.y > 0.0,
        }
    }
}

/// The whole picture: one strip, or a strip and its reflection in the line Y = 0 (a mirror
/// reflected in a plane sees the reflected world).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Image {
    /// The designed panel's image.
    pub strip: Strip,
    /// Where it is folded, if it is.
    pub fold: Option<Fold>,
}

impl Image {
    /// Whether image point `q` belongs to a reflected panel.
    #[inline]
    #[must_use]
    pub fn reflects(&self, q: DVec2) -> bool {
        self.fold.is_some_and(|fold| fold.reflects(q))
    }

    /// The direction that image point `q` must see.
    #[inline]
    #[must_use]
    pub fn wanted(&self, q: DVec2) -> DVec3 {
        if self.reflects(q) {
            self.strip.wanted(flip(q)) * DVec3::new(1.0, -1.0, 1.0)
        } else {
            self.strip.wanted(q)
        }
    }

    /// The image point, continued from the panel of `near`, that must see `direction`.
    #[inline]
    #[must_use]
    pub fn locate(&self, direction: DVec3, near: DVec2) -> DVec2 {
        if self.reflects(near) {
            flip(self.strip.locate(direction * DVec3::new(1.0, -1.0, 1.0), flip(near)))
        } else {
            self.strip.locate(direction, near)
        }
    }
}

#[inline]
fn flip(q: DVec2) -> DVec2 {
    DVec2::new(q.x, -q.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::radians;
    use crate::optics::reflect_vertical;

    fn conquistador(law: Law) -> Image {
        let strip = Strip { law, scale_mm: 19.0, azimuth: 0.0, z: -0.589 };
        Image { strip, fold: Some(Fold::Above) }
    }

    fn points() -> impl Iterator<Item = DVec2> {
        (0..400).map(|k| DVec2::new(f64::from(k % 20) * 3.1 - 29.0, f64::from(k / 20) * 2.3 - 22.0))
    }

    #[test]
    fn locate_inverts_wanted_on_both_panels() {
        for law in [Law::Cylindrical, Law::Mercator] {
            let image = conquistador(law);
            for q in points() {
                let near = q + DVec2::new(1.5, 0.0);
                assert!((image.locate(image.wanted(q), near) - q).length() < 1e-12, "{law:?} {q}");
            }
        }
    }

    #[test]
    fn the_slope_field_reflects_the_camera_into_the_wanted_direction() {
        for law in [Law::Cylindrical, Law::Mercator] {
            let strip = conquistador(law).strip;
            for q in points() {
                let seen = reflect_vertical(strip.slope(q));
                assert!((seen - strip.wanted(q)).length() < 4e-15, "{law:?} {q}");
            }
        }
    }

    #[test]
    fn curl_is_that_of_the_field_and_vanishes_for_mercator() {
        let h = 1e-4;
        for q in points() {
            let strip = conquistador(Law::Cylindrical).strip;
            let d = |step: DVec2| (strip.slope(q + step) - strip.slope(q - step)) / (2.0 * h);
            let central = d(DVec2::new(h, 0.0)).y - d(DVec2::new(0.0, h)).x;
            assert!((strip.curl(q) / strip.scale_mm - central).abs() < 1e-8);
            assert_eq!(conquistador(Law::Mercator).strip.curl(q), 0.0);
        }
    }

    #[test]
    fn the_folded_half_sees_the_other_half_turn_upside_down() {
        let image = conquistador(Law::Cylindrical);
        let (above, below) = (DVec2::new(-7.0, 20.0), DVec2::new(-7.0, -20.0));
        let angle = |d: DVec3| atan2(d.x, d.y);
        let sum = angle(image.wanted(above)) + angle(image.wanted(below));
        assert!((wrap_turn(sum - radians(180.0))).abs() < 1e-12);
        assert_eq!(image.wanted(above).z, image.wanted(below).z);
    }

    #[test]
    fn azimuth_wraps_to_the_nearer_turn() {
        let strip = Strip { law: Law::Cylindrical, scale_mm: 10.0, azimuth: 0.0, z: 0.0 };
        let edge = DVec2::new(10.0 * std::f64::consts::PI - 0.01, 1.0);
        let beyond = edge + DVec2::new(0.02, 0.0);
        assert!((strip.locate(strip.wanted(beyond), edge) - beyond).length() < 1e-12);
    }
}
