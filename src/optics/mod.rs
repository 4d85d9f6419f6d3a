//! Cameras, projections, laws and reflection: what the picture should be.

mod camera;
mod image;
mod law;

pub use camera::Orthographic;
pub use image::{Fold, Image, Strip};
pub use law::Law;

use crate::geom::DVec3;

/// The unit direction `d` after reflection at a surface with normal `n` of any length.
#[inline]
#[must_use]
pub fn reflect(d: DVec3, n: DVec3) -> DVec3 {
    d - n * (2.0 * d.dot(n) / n.length_squared())
}

/// What a vertical camera ray (direction -Z) sees from a surface of slope `p` = (Z_X, Z_Y): the
/// stereographic image of the slope, U = (-2p, 1 - |p|^2) / (1 + |p|^2).
#[inline]
#[must_use]
pub fn reflect_vertical(p: crate::geom::DVec2) -> DVec3 {
    let square = p.length_squared();
    DVec3::new(-2.0 * p.x, -2.0 * p.y, 1.0 - square) / (1.0 + square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;

    #[test]
    fn vertical_reflection_obeys_the_law_of_reflection() {
        for p in [DVec2::new(0.3, -1.7), DVec2::ZERO, DVec2::new(-5.0, 40.0)] {
            let normal = DVec3::new(-p.x, -p.y, 1.0);
            let by_law = reflect(DVec3::NEG_Z, normal);
            assert!((by_law - reflect_vertical(p)).length() < 1e-15);
            assert!((by_law.length() - 1.0).abs() < 1e-15);
            // Equal angles to the normal, and in one plane with it.
            let incidence = DVec3::Z.dot(normal) - by_law.dot(normal);
            assert!(incidence.abs() < 1e-13 * normal.length());
            assert!(DVec3::Z.cross(normal).dot(by_law).abs() < 1e-13 * normal.length());
        }
    }

    #[test]
    fn a_slope_error_turns_the_ray_alike_in_every_direction() {
        let (p, step) = (DVec2::new(0.8, -0.4), 1e-7);
        let expected = 2.0 * step / (1.0 + p.length_squared());
        for axis in [DVec2::X, DVec2::Y, DVec2::new(0.6, 0.8)] {
            let turned = (reflect_vertical(p + axis * step) - reflect_vertical(p)).length();
            assert!((turned / expected - 1.0).abs() < 1e-6);
        }
    }
}
