//! Straight panoramic strips: azimuth along X, elevation by a law along Y.

use super::{StripLaw, stereographic};
use crate::geom::DVec2;
use crate::num::{Lanes, Scalar, cos, sin};

/// A strip of the world unrolled in the image.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Relation of image row and elevation.
    pub law: StripLaw,
    /// Scale s, mm per radian of azimuth.
    pub scale_mm: f64,
    /// Azimuth at X = 0, radians.
    pub azimuth: f64,
    /// The law's coordinate z (paper's units) at Y = 0.
    pub z: f64,
}

impl Strip {
    /// Direction that image point `q` must see, as a stereographic coordinate.
    #[inline]
    pub fn direction_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        let azimuth = q[0] / self.scale_mm + self.azimuth;
        let radius = self.law.stereographic_radius(q[1] / self.scale_mm + self.z);
        [radius * azimuth.sin(), radius * azimuth.cos()]
    }

    /// The image point that must see `sigma`: the one nearest to `near` in azimuth, which repeats
    /// every turn. Not finite for the two directions along the axis.
    #[inline]
    pub fn image_of<S: Scalar>(&self, sigma: [S; 2], near: DVec2) -> [S; 2] {
        self.image_of_turned(sigma, near, self.turn(near.x))
    }

    /// Sine and cosine of the azimuth that the picture shows at X.
    #[inline]
    pub(super) fn turn(&self, x: f64) -> [f64; 2] {
        let azimuth = x / self.scale_mm + self.azimuth;
        [sin(azimuth), cos(azimuth)]
    }

    /// Length of the stereographic coordinate of what the picture shows at Y.
    #[inline]
    pub(super) fn rise(&self, y: f64) -> f64 {
        self.law.stereographic_radius(y / self.scale_mm + self.z)
    }

    /// [`Self::image_of`] near a place of which the turn is known.
    #[inline]
    pub(super) fn image_of_turned<S: Scalar>(
        &self,
        sigma: [S; 2],
        near: DVec2,
        [s, c]: [f64; 2],
    ) -> [S; 2] {
        // Turned so that the arc tangent's jump lies opposite to what is near.
        let turn = (sigma[0] * c - sigma[1] * s).atan2(sigma[0] * s + sigma[1] * c);
        let length = (sigma[0].square() + sigma[1].square()).sqrt();
        let z = self.law.image_coordinate(length);
        [turn * self.scale_mm + near.x, (z - self.z) * self.scale_mm]
    }

    /// [`Self::image_of`] beside directions of which the image points are known, but for the last bits (docs/theory.md,
    /// T125); none where one of them needs the whole way, as the two are far apart or the law has no shorter one.
    #[inline]
    pub(super) fn images_beside<const L: usize>(
        &self,
        sigma: [Lanes<L>; 2],
        (known, [x, y]): ([Lanes<L>; 2], [Lanes<L>; 2]),
    ) -> Option<[Lanes<L>; 2]> {
        let [latitude, azimuth] = stereographic::step_between(known, sigma)?;
        let z = self.law.image_coordinate_beside(y / self.scale_mm + self.z, latitude)?;
        Some([x + azimuth * self.scale_mm, (z - self.z) * self.scale_mm])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;
    use crate::optics::TabulatedLaw;
    use std::sync::Arc;

    #[test]
    fn azimuth_wraps_to_the_nearer_turn() {
        let strip = Strip { law: StripLaw::Cylindrical, scale_mm: 10.0, azimuth: 0.0, z: 0.0 };
        let edge = DVec2::new(10.0 * std::f64::consts::PI - 0.01, 1.0);
        let beyond = edge + DVec2::new(0.02, 0.0);
        let back = DVec2::from_array(strip.image_of(strip.direction_of(beyond.to_array()), edge));
        assert!((back - beyond).length() < 1e-12);
    }

    fn beside(strip: &Strip, sigma: [f64; 2], (known, image): ([f64; 2], DVec2)) -> Option<DVec2> {
        let lane = |x: f64| Lanes([x]);
        let known = (known.map(lane), image.to_array().map(lane));
        let found = strip.images_beside(sigma.map(lane), known)?;
        Some(DVec2::from_array(found.map(|Lanes([x])| x)))
    }

    /// The short way and the whole one, for laws that have one, through the seam and up to where it ends.
    #[test]
    fn image_points_beside_a_known_one_are_those_of_the_whole_way() {
        let z: Vec<f64> = (0..=16).map(|k| f64::from(k) / 8.0 - 1.0).collect();
        let m: Vec<f64> = z.iter().map(|z| 0.8 * z + 0.1 * z * z).collect();
        let table = StripLaw::Tabulated(Arc::new(TabulatedLaw::from_latitudes(&z, &m).unwrap()));
        let mut r = Draws::new(5);
        for law in [StripLaw::Mercator, StripLaw::Cylindrical, table] {
            let strip = Strip { law, scale_mm: 10.0, azimuth: 0.3, z: 0.1 };
            let mut taken = 0;
            for _ in 0..2000 {
                let image = DVec2::new(r.inside([-32.0, 32.0]), r.inside([-9.0, 8.0]));
                let known = strip.direction_of(image.to_array());
                let size = [1e-9, 1e-6, 1e-3][taken % 3];
                let sigma = known.map(|x| x + size * r.inside([-1.0, 1.0]));
                let Some(beside) = beside(&strip, sigma, (known, image)) else { continue };
                taken += 1;
                let off = beside - DVec2::from_array(strip.image_of(sigma, image));
                assert!(off.length() < 5e-14, "{image}: {off}");
            }
            assert!(taken > 1000, "{taken}");
            let known = strip.direction_of([1.0, 2.0]);
            let far = known.map(|x| x * 1.04);
            assert!(beside(&strip, far, (known, DVec2::new(1.0, 2.0))).is_none());
        }
    }
}
