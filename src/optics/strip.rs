//! Straight panoramic strips: azimuth along X, elevation by a law along Y.

use super::StripLaw;
use crate::geom::DVec2;
use crate::num::{Scalar, cos, sin};

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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuth_wraps_to_the_nearer_turn() {
        let strip = Strip { law: StripLaw::Cylindrical, scale_mm: 10.0, azimuth: 0.0, z: 0.0 };
        let edge = DVec2::new(10.0 * std::f64::consts::PI - 0.01, 1.0);
        let beyond = edge + DVec2::new(0.02, 0.0);
        let back = DVec2::from_array(strip.image_of(strip.direction_of(beyond.to_array()), edge));
        assert!((back - beyond).length() < 1e-12);
    }
}
