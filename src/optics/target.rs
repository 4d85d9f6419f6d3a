//! Target surfaces: where the world that the picture shows is.

use super::{PosedTarget, stereographic};
use crate::geom::DVec3;
use crate::num::Scalar;

/// The surface S that is imaged. The projection gives directions from the target's origin, the middle of the mirror
/// or a viewpoint; a ray that leaves the mirror elsewhere meets the surface where another direction
/// from the origin does.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// Infinity: the world is so far away that only directions count.
    Infinity,
    /// The cylinder of this radius about the axis, mm.
    Cylinder {
        /// Radius, mm.
        radius_mm: f64,
    },
    /// The plane perpendicular to the axis at this height over the origin, mm; negative below it.
    Plane {
        /// Height, mm.
        height_mm: f64,
    },
    /// A surface in any pose, whose origin is the viewpoint.
    Posed(PosedTarget),
}

impl Target {
    /// Distance from the origin in the unit direction `direction` to the surface, mm; NaN or negative where it is not
    /// met.
    #[must_use]
    pub fn reach_mm(&self, direction: DVec3) -> f64 {
        match self {
            Self::Infinity => f64::INFINITY,
            Self::Cylinder { radius_mm } => radius_mm / direction.truncate().length(),
            Self::Plane { height_mm } => height_mm / direction.z,
            Self::Posed(target) => target.reach_mm(direction),
        }
    }

    /// Distance from `from` (mm, relative to the origin) in the unit direction `direction` to where a ray first meets
    /// the surface, mm; infinite where it never does.
    #[must_use]
    pub fn distance_mm(&self, from: DVec3, direction: DVec3) -> f64 {
        let distance = match self {
            Self::Infinity => f64::INFINITY,
            Self::Cylinder { radius_mm } => {
                let (p, u) = (from.truncate(), direction.truncate());
                let (along, square) = (p.dot(u), u.length_squared());
                let inside = radius_mm * radius_mm - p.length_squared();
                // Of a place inside, the meeting ahead: no two numbers of nearly equal size are subtracted.
                let root = (along * along + square * inside).sqrt();
                if along < 0.0 { (root - along) / square } else { inside / (along + root) }
            }
            Self::Plane { height_mm } => (height_mm - from.z) / direction.z,
            Self::Posed(target) => target.distance_mm(from, direction),
        };
        if distance >= 0.0 { distance } else { f64::INFINITY }
    }

    /// Whether it is made of flat facets, across whose edges what is seen has no derivatives.
    #[must_use]
    pub fn is_faceted(&self) -> bool {
        matches!(self, Self::Posed(target) if target.is_faceted())
    }

    /// Whether it is its own reflection in the plane X = 0 (`axis` 0) or Y = 0 (1).
    #[must_use]
    pub fn is_symmetric(&self, axis: usize) -> bool {
        match self {
            Self::Infinity | Self::Cylinder { .. } | Self::Plane { .. } => true,
            Self::Posed(target) => target.is_symmetric(axis),
        }
    }

    /// The direction from the origin to where a ray that leaves `from` (mm, relative to the origin)
    /// in direction `sigma` meets the target. Not finite where it never does, and for points beyond
    /// the target.
    #[inline]
    pub fn direction_from_origin<S: Scalar>(&self, from: [S; 3], sigma: [S; 2]) -> [S; 2] {
        match *self {
            Self::Infinity => sigma,
            Self::Posed(ref target) => target.direction_from_origin(from, sigma),
            Self::Cylinder { radius_mm } => {
                let u = stereographic::vector(sigma);
                let p = [from[0] / radius_mm, from[1] / radius_mm];
                // The positive root of |p + t u| = 1, as 1 / t: that stays finite for a ray along
                // the axis. A point outside is no number.
                let across = stereographic::norm_squared(sigma);
                let along = p[0] * u[0] + p[1] * u[1];
                let inside = -stereographic::norm_squared(p) + 1.0;
                let root = (along.square() + across * inside).sqrt();
                let per = if along.mid() >= 0.0 {
                    (along + root) / inside
                } else {
                    across / (root - along)
                };
                let from = [p[0], p[1], from[2] / radius_mm];
                stereographic::sigma([0, 1, 2].map(|k| from[k] * per + u[k]))
            }
            Self::Plane { height_mm } => {
                let u = stereographic::unit(sigma);
                let inside = -from[2] / height_mm + 1.0;
                let t = inside / u[2] * height_mm.signum();
                if !(inside.mid() > 0.0 && t.mid() > 0.0) {
                    return [S::constant(f64::NAN); 2];
                }
                stereographic::sigma([0, 1, 2].map(|k| u[k] * t + from[k] / height_mm.abs()))
            }
        }
    }

    /// The direction from `from` (mm, relative to the origin) to where direction `sigma` from the
    /// origin meets the target: undoes [`Target::direction_from_origin`].
    #[inline]
    pub fn direction_at<S: Scalar>(&self, from: [S; 3], sigma: [S; 2]) -> [S; 2] {
        match *self {
            Self::Infinity => sigma,
            Self::Posed(ref target) => target.direction_at(from, sigma),
            Self::Cylinder { radius_mm } => {
                let u = stereographic::vector(sigma);
                let across = stereographic::norm_squared(sigma).sqrt();
                stereographic::sigma([0, 1, 2].map(|k| u[k] - from[k] / radius_mm * across))
            }
            Self::Plane { height_mm } => {
                let u = stereographic::unit(sigma);
                let inside = -from[2] / height_mm + 1.0;
                let t = S::constant(height_mm.signum()) / u[2];
                if !(inside.mid() > 0.0 && t.mid() > 0.0) {
                    return [S::constant(f64::NAN); 2];
                }
                stereographic::sigma([0, 1, 2].map(|k| u[k] * t - from[k] / height_mm.abs()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;

    #[test]
    fn aim_and_seen_undo_each_other_and_meet_the_surface() {
        let from = DVec3::new(11.0, -7.0, 4.0);
        for (target, sigmas) in [
            (Target::Infinity, vec![[0.3, 0.2], [2.0, -1.0]]),
            (Target::Cylinder { radius_mm: 20.0 }, vec![[0.3, 0.2], [2.0, -1.0], [-0.9, 0.1]]),
            (Target::Cylinder { radius_mm: 1e12 }, vec![[0.3, 0.2], [-2.0, -1.0]]),
            (Target::Plane { height_mm: 90.0 }, vec![[0.3, 0.2], [0.0, 0.0], [-0.9, 0.1]]),
            (Target::Plane { height_mm: -50.0 }, vec![[1.3, 0.2], [5.0, -3.0]]),
        ] {
            for sigma in sigmas {
                let sent = target.direction_at(from.to_array(), sigma);
                let back = DVec2::from_array(target.direction_from_origin(from.to_array(), sent));
                assert!((back - DVec2::from_array(sigma)).length() < 1e-14, "{target:?} {back}");
                // Both lines meet in one point of the surface.
                let (a, b) = (stereographic::direction(sigma), stereographic::direction(sent));
                let reach = target.reach_mm(a);
                if target == Target::Infinity {
                    continue;
                }
                let off = (a * reach - from).normalize() - b;
                assert!(reach > 0.0 && off.length() < 1e-14, "{target:?}: {off}");
            }
        }
    }

    /// The place at that distance is where directions from the origin and from the place meet.
    #[test]
    fn the_distance_of_a_target_ends_on_it() {
        let from = DVec3::new(11.0, -7.0, 4.0);
        let direction = DVec3::new(0.48, -0.6, 0.64);
        for target in [
            Target::Cylinder { radius_mm: 20.0 },
            Target::Cylinder { radius_mm: 1e12 },
            Target::Plane { height_mm: 90.0 },
        ] {
            for direction in [direction, DVec3::new(-0.48, 0.6, 0.64)] {
                let distance = target.distance_mm(from, direction);
                let met = from + direction * distance;
                let sigma = stereographic::sigma(direction.to_array());
                let seen = target.direction_from_origin(from.to_array(), sigma);
                let apart = met.normalize() - stereographic::direction(seen);
                assert!(apart.length() < 1e-14, "{target:?}: {apart}");
                let reach = target.reach_mm(met.normalize());
                assert!((reach / met.length() - 1.0).abs() < 1e-14, "{target:?}: {reach}");
            }
        }
        let plane = Target::Plane { height_mm: 90.0 };
        for (target, direction) in [
            (plane.clone(), -DVec3::Z),
            (plane, DVec3::X),
            (Target::Cylinder { radius_mm: 20.0 }, DVec3::Z),
            (Target::Infinity, DVec3::X),
        ] {
            assert_eq!(target.distance_mm(from, direction), f64::INFINITY, "{target:?}");
        }
    }

    #[test]
    fn a_ray_up_the_axis_of_a_cylinder_stays_there() {
        let cylinder = Target::Cylinder { radius_mm: 50.0 };
        assert_eq!(cylinder.direction_from_origin([0.0, 0.0, -3.0], [0.0; 2]), [0.0; 2]);
        assert_eq!(cylinder.direction_at([0.0, 0.0, -3.0], [0.0; 2]), [0.0; 2]);
    }

    #[test]
    fn a_ray_that_never_meets_the_plane_sees_nothing() {
        let plane = Target::Plane { height_mm: 50.0 };
        assert!(plane.direction_from_origin([0.0; 3], [2.0, 0.0])[0].is_nan());
        assert!(plane.direction_at([0.0; 3], [2.0, 0.0])[0].is_nan());
    }

    #[test]
    fn a_point_beyond_the_plane_does_not_see_its_back() {
        for sign in [1.0, -1.0] {
            let plane = Target::Plane { height_mm: 50.0 * sign };
            let beyond = [3.0, 0.0, 60.0 * sign];
            // Back towards the plane: upwards for the plane below.
            let sigma = if sign > 0.0 { [2.0, 0.0] } else { [0.5, 0.0] };
            assert!(plane.direction_from_origin(beyond, sigma)[0].is_nan());
            let sigma = if sign > 0.0 { [0.5, 0.0] } else { [2.0, 0.0] };
            assert!(plane.direction_at(beyond, sigma)[0].is_nan());
        }
    }
}
