//! Target surfaces in any pose, and the viewpoint from which they show the picture.

use super::stereographic;
use super::target_mesh::TargetMesh;
use crate::geom::{DVec3, TriMesh};
use crate::num::Scalar;
use std::sync::Arc;

/// A surface of the world in the part's frame, mm from the middle of the mirror.
#[derive(Debug, Clone, PartialEq)]
pub enum PosedSurface {
    /// A plane.
    Plane {
        /// Any point of it, mm.
        point_mm: DVec3,
        /// Its normal, of any length and sense.
        normal: DVec3,
    },
    /// A sphere, seen from inside or from outside.
    Sphere {
        /// Centre, mm.
        centre_mm: DVec3,
        /// Radius, mm.
        radius_mm: f64,
    },
    /// A cylinder, seen from inside or from outside.
    Cylinder {
        /// Any point of its axis, mm.
        point_mm: DVec3,
        /// Direction of its axis, of any length and sense.
        axis: DVec3,
        /// Radius, mm.
        radius_mm: f64,
    },
    /// Triangles, seen from both sides.
    Mesh(Arc<TriMesh>),
}

/// A surface and the viewpoint: the projection gives directions from there to the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct PosedTarget {
    /// Place of the viewpoint, mm from the middle of the mirror.
    viewpoint_mm: DVec3,
    /// The length that is 1 in `shape`, mm.
    scale_mm: f64,
    shape: Shape,
}

/// A surface from the viewpoint, in lengths of the scale.
#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// The plane at the distance 1 in the direction of its unit normal.
    Plane { normal: DVec3 },
    /// The sphere of radius 1, or with an axis the cylinder of radius 1, about `centre`; `hollow`: seen from inside.
    Quadric { centre: DVec3, axis: Option<DVec3>, hollow: bool },
    /// Triangles, of which the first that a ray meets counts.
    Mesh(TargetMesh),
}

/// Reason why a surface shows nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseFault {
    /// The middle of the mirror lies in the surface.
    MirrorOnSurface,
    /// The viewpoint lies in the surface.
    ViewpointOnSurface,
    /// The surface parts the viewpoint from the middle of the mirror.
    Parted,
}

impl PosedTarget {
    /// A surface that is seen from `viewpoint_mm` (mm from the middle of the mirror).
    ///
    /// # Errors
    /// [`PoseFault`] where the surface cannot be seen both from the viewpoint and from the mirror.
    pub fn new(surface: PosedSurface, viewpoint_mm: DVec3) -> Result<Self, PoseFault> {
        let (scale_mm, shape) = match surface {
            PosedSurface::Plane { point_mm, normal } => {
                let normal = normal.normalize();
                let distance = normal.dot(point_mm - viewpoint_mm);
                (distance.abs(), Shape::Plane { normal: normal * distance.signum() })
            }
            PosedSurface::Sphere { centre_mm, radius_mm } => {
                let centre = (centre_mm - viewpoint_mm) / radius_mm;
                (radius_mm, Shape::Quadric { centre, axis: None, hollow: centre.length() < 1.0 })
            }
            PosedSurface::Cylinder { point_mm, axis, radius_mm } => {
                let axis = axis.normalize();
                let centre = (point_mm - viewpoint_mm).reject_from_normalized(axis) / radius_mm;
                let hollow = centre.length() < 1.0;
                (radius_mm, Shape::Quadric { centre, axis: Some(axis), hollow })
            }
            PosedSurface::Mesh(mesh) => {
                let mut mesh = (*mesh).clone();
                let from = mesh.vertices.iter().map(|v| (*v - viewpoint_mm).length());
                let scale_mm = from.fold(0.0, f64::max);
                mesh.vertices.iter_mut().for_each(|v| *v = (*v - viewpoint_mm) / scale_mm);
                (scale_mm, Shape::Mesh(TargetMesh::new(mesh)))
            }
        };
        let target = Self { viewpoint_mm, scale_mm, shape };
        let inside = |at| target.inside(at).unwrap_or(1.0);
        let [mirror, viewpoint] = [DVec3::ZERO, viewpoint_mm].map(inside);
        // A plane through the viewpoint has no scale.
        if viewpoint == 0.0 || scale_mm == 0.0 {
            return Err(PoseFault::ViewpointOnSurface);
        }
        if mirror == 0.0 {
            return Err(PoseFault::MirrorOnSurface);
        }
        if target.parts(viewpoint_mm, DVec3::ZERO) { Err(PoseFault::Parted) } else { Ok(target) }
    }

    /// Surface and viewpoint in a world `scale` times as large, about `centre_mm` (mm from the middle of the mirror).
    #[must_use]
    pub fn scaled_about(&self, centre_mm: DVec3, scale: f64) -> Self {
        let viewpoint_mm = centre_mm + (self.viewpoint_mm - centre_mm) * scale;
        Self { viewpoint_mm, scale_mm: self.scale_mm * scale, shape: self.shape.clone() }
    }

    /// How far a place (mm from the middle of the mirror) lies inside the surface, or on the viewpoint's side of a
    /// plane, as a share of radius or distance; negative beyond it. None of triangles, which may have no inside.
    fn inside(&self, at_mm: DVec3) -> Option<f64> {
        let at = (at_mm - self.viewpoint_mm) / self.scale_mm;
        match self.shape {
            Shape::Plane { normal } => Some(1.0 - normal.dot(at)),
            Shape::Quadric { centre, axis, .. } => {
                let from = at - centre;
                Some(1.0 - axis.map_or(from, |axis| from.reject_from_normalized(axis)).length())
            }
            Shape::Mesh(_) => None,
        }
    }

    /// Whether the surface lies between two places, mm from the middle of the mirror.
    #[must_use]
    pub fn parts(&self, a_mm: DVec3, b_mm: DVec3) -> bool {
        if let Shape::Mesh(mesh) = &self.shape {
            let [a, b] = [a_mm, b_mm].map(|at| (at - self.viewpoint_mm) / self.scale_mm);
            return mesh.parts(a, b);
        }
        self.inside(a_mm).zip(self.inside(b_mm)).is_some_and(|(a, b)| a * b < 0.0)
    }

    /// Whether it is made of flat facets, across whose edges what is seen has no derivatives.
    #[must_use]
    pub fn is_faceted(&self) -> bool {
        matches!(self.shape, Shape::Mesh(_))
    }

    /// Whether a place is on the side of the surface on which the viewpoint is.
    #[must_use]
    pub fn is_before(&self, at_mm: DVec3) -> bool {
        !self.parts(at_mm, self.viewpoint_mm) && self.inside(at_mm) != Some(0.0)
    }

    /// Whether surface and viewpoint are their own reflections in the plane X = 0 (`k` 0) or Y = 0 (1).
    #[must_use]
    pub fn is_symmetric(&self, k: usize) -> bool {
        self.viewpoint_mm[k] == 0.0
            && match self.shape {
                Shape::Plane { normal } => normal[k] == 0.0,
                Shape::Quadric { centre, axis: None, .. } => centre[k] == 0.0,
                Shape::Quadric { centre, axis: Some(axis), .. } => {
                    (axis[k] == 0.0 && centre[k] == 0.0) || axis[k].abs() == 1.0
                }
                Shape::Mesh(_) => false,
            }
    }

    /// The direction from the viewpoint to where a ray that leaves `from` (mm from the middle of the mirror) in direction
    /// `sigma` first meets the surface. Not finite where it never does.
    #[inline]
    pub fn direction_from_origin<S: Scalar>(&self, from: [S; 3], sigma: [S; 2]) -> [S; 2] {
        let from = self.placed(from);
        let u = stereographic::unit(sigma);
        let way = self.distance(from, u);
        stereographic::sigma([0, 1, 2].map(|k| u[k] * way + from[k]))
    }

    /// The direction from `from` (mm from the middle of the mirror) to where direction `sigma` from the viewpoint first
    /// meets the surface. Not finite where it never does.
    #[inline]
    pub fn direction_at<S: Scalar>(&self, from: [S; 3], sigma: [S; 2]) -> [S; 2] {
        let from = self.placed(from);
        let u = stereographic::unit(sigma);
        let way = self.distance([S::constant(0.0); 3], u);
        stereographic::sigma([0, 1, 2].map(|k| u[k] * way - from[k]))
    }

    /// Distance from the viewpoint in the unit direction `direction` to the surface, mm; NaN where it is not met.
    #[must_use]
    pub fn reach_mm(&self, direction: DVec3) -> f64 {
        self.distance([0.0; 3], direction.to_array()) * self.scale_mm
    }

    /// Distance from `from` (mm from the middle of the mirror) in the unit direction `direction` to the surface, mm; NaN
    /// where it is not met.
    #[must_use]
    pub fn distance_mm(&self, from: DVec3, direction: DVec3) -> f64 {
        self.distance(self.placed(from.to_array()), direction.to_array()) * self.scale_mm
    }

    /// Place of the viewpoint, mm from the middle of the mirror.
    #[must_use]
    pub fn viewpoint_mm(&self) -> DVec3 {
        self.viewpoint_mm
    }

    /// A place from the viewpoint, in lengths of the scale.
    #[inline]
    fn placed<S: Scalar>(&self, from: [S; 3]) -> [S; 3] {
        let viewpoint = self.viewpoint_mm.to_array();
        [0, 1, 2].map(|k| (from[k] - viewpoint[k]) / self.scale_mm)
    }

    /// Distance along the unit vector `u` from `start` to the surface, in lengths of the scale; NaN where it is not met.
    #[inline]
    fn distance<S: Scalar>(&self, start: [S; 3], u: [S; 3]) -> S {
        match &self.shape {
            Shape::Mesh(mesh) => mesh.distance(start, u),
            &Shape::Plane { normal } => {
                let inside = -dot(start, normal) + 1.0;
                let along = dot(u, normal);
                let ahead = inside.mid() > 0.0 && along.mid() > 0.0;
                if ahead { inside / along } else { S::constant(f64::NAN) }
            }
            &Shape::Quadric { centre, axis, hollow } => {
                let centre = centre.to_array();
                let mut from = [0, 1, 2].map(|k| start[k] - centre[k]);
                let mut across = u;
                if let Some(axis) = axis {
                    let parts = [dot(from, axis), dot(u, axis)];
                    let axis = axis.to_array();
                    from = [0, 1, 2].map(|k| from[k] - parts[0] * axis[k]);
                    across = [0, 1, 2].map(|k| u[k] - parts[1] * axis[k]);
                }
                let size = match axis {
                    Some(_) => product(across, across),
                    None => S::constant(1.0),
                };
                first_root(size, product(from, across), -product(from, from) + 1.0, hollow)
            }
        }
    }
}

/// The first positive root t of size t^2 + 2 along t = inside, from inside (`hollow`) or from outside; NaN where there is none
/// and on the other side.
#[inline]
fn first_root<S: Scalar>(size: S, along: S, inside: S, hollow: bool) -> S {
    let root = (along.square() + size * inside).sqrt();
    // Of two forms of a root the one that does not cancel.
    match (hollow, inside.mid() > 0.0, along.mid() > 0.0) {
        (true, true, true) => inside / (along + root),
        (true, true, false) => (root - along) / size,
        (false, false, false) => -inside / (root - along),
        _ => S::constant(f64::NAN),
    }
}

#[inline]
fn product<S: Scalar>(a: [S; 3], b: [S; 3]) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn dot<S: Scalar>(a: [S; 3], b: DVec3) -> S {
    a[0] * b.x + a[1] * b.y + a[2] * b.z
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Interval;
    use crate::optics::Target;

    const VIEWPOINT: DVec3 = DVec3::new(3.0, -8.0, 5.0);

    fn surfaces() -> [PosedSurface; 6] {
        let at = DVec3::new(20.0, -35.0, 90.0);
        [
            PosedSurface::Plane { point_mm: at, normal: DVec3::new(0.2, -0.3, 1.0) },
            PosedSurface::Plane { point_mm: at, normal: DVec3::new(-0.2, 0.3, -1.0) },
            PosedSurface::Sphere { centre_mm: at, radius_mm: 400.0 },
            PosedSurface::Sphere { centre_mm: at, radius_mm: 60.0 },
            PosedSurface::Cylinder {
                point_mm: at,
                axis: DVec3::new(3.0, 1.0, 0.2),
                radius_mm: 300.0,
            },
            PosedSurface::Cylinder {
                point_mm: at,
                axis: DVec3::new(3.0, 1.0, 0.2),
                radius_mm: 40.0,
            },
        ]
    }

    /// What vanishes on a surface, mm.
    fn off(surface: &PosedSurface, at: DVec3) -> f64 {
        match surface {
            PosedSurface::Plane { point_mm, normal } => (at - *point_mm).dot(normal.normalize()),
            PosedSurface::Sphere { centre_mm, radius_mm } => at.distance(*centre_mm) - radius_mm,
            PosedSurface::Cylinder { point_mm, axis, radius_mm } => {
                (*point_mm - at).cross(axis.normalize()).length() - radius_mm
            }
            PosedSurface::Mesh(_) => f64::NAN,
        }
    }

    #[test]
    fn both_lines_meet_the_surface_in_one_point_and_undo_each_other() {
        let from = DVec3::new(11.0, -7.0, 4.0);
        for surface in surfaces() {
            let target = PosedTarget::new(surface.clone(), VIEWPOINT).unwrap();
            for sigma in [[0.1, -0.15], [0.05, -0.2], [0.15, -0.05]] {
                let wanted = stereographic::direction(sigma);
                let met = VIEWPOINT + wanted * target.reach_mm(wanted);
                assert!(off(&surface, met).abs() < 1e-12, "{surface:?}: {met}");
                let met_after = target.distance_mm(from, (met - from).normalize());
                assert!((met_after / (met - from).length() - 1.0).abs() < 1e-13, "{surface:?}");
                let sent = target.direction_at(from.to_array(), sigma);
                let apart = (met - from).normalize() - stereographic::direction(sent);
                assert!(apart.length() < 1e-14, "{surface:?}: {apart}");
                let back = target.direction_from_origin(from.to_array(), sent);
                let apart = stereographic::direction(back) - wanted;
                assert!(apart.length() < 1e-14, "{surface:?}: {apart}");
            }
        }
    }

    /// A point of a surface that hides behind the surface is not met: the first one is.
    #[test]
    fn the_first_meeting_counts() {
        for surface in surfaces() {
            let target = PosedTarget::new(surface.clone(), VIEWPOINT).unwrap();
            let wanted = stereographic::direction([0.1, -0.15]);
            let reach = target.reach_mm(wanted);
            for share in 1..100 {
                let way = VIEWPOINT + wanted * (reach * f64::from(share) / 100.0);
                assert!(off(&surface, way) * off(&surface, VIEWPOINT) > 0.0, "{surface:?} {share}");
            }
        }
    }

    #[test]
    fn what_misses_the_surface_is_no_number() {
        // Of a plane what leads away from it; of a sphere and a cylinder seen from outside what leads past them too.
        let (away, past) = ([0.1, 9.0], [-0.9, 0.6]);
        for (surface, missing) in [
            (surfaces()[0].clone(), vec![away]),
            (surfaces()[3].clone(), vec![away, past]),
            (surfaces()[5].clone(), vec![away, past]),
        ] {
            let target = PosedTarget::new(surface.clone(), VIEWPOINT).unwrap();
            for sigma in missing {
                let reach = target.reach_mm(stereographic::direction(sigma));
                assert!(reach.is_nan(), "{surface:?}: {reach}");
                let sent = target.direction_from_origin([1.0, 2.0, 3.0], sigma);
                assert!(sent[0].is_nan(), "{surface:?}: {sent:?}");
            }
        }
    }

    /// The plane across the axis and the cylinder about it are those that have names of their own.
    #[test]
    fn surfaces_about_the_axis_are_those_of_the_axis() {
        let at = DVec3::new(11.0, -7.0, 4.0).to_array();
        for (surface, axial, sigmas) in [
            (
                PosedSurface::Plane { point_mm: DVec3::new(5.0, 7.0, -50.0), normal: DVec3::Z },
                Target::Plane { height_mm: -50.0 },
                [[1.3, 0.2], [5.0, -3.0]],
            ),
            (
                PosedSurface::Cylinder {
                    point_mm: DVec3::new(0.0, 0.0, 33.0),
                    axis: DVec3::NEG_Z * 4.0,
                    radius_mm: 20.0,
                },
                Target::Cylinder { radius_mm: 20.0 },
                [[0.3, 0.2], [2.0, -1.0]],
            ),
        ] {
            let posed = Target::Posed(PosedTarget::new(surface.clone(), DVec3::ZERO).unwrap());
            for sigma in sigmas {
                for [a, b] in [
                    [posed.direction_at(at, sigma), axial.direction_at(at, sigma)],
                    [
                        posed.direction_from_origin(at, sigma),
                        axial.direction_from_origin(at, sigma),
                    ],
                ] {
                    let apart = stereographic::direction(a) - stereographic::direction(b);
                    assert!(apart.length() < 2e-15, "{surface:?}: {apart}");
                }
            }
        }
    }

    #[test]
    fn bounds_hold_what_lies_in_a_box() {
        for surface in surfaces() {
            let target = PosedTarget::new(surface.clone(), VIEWPOINT).unwrap();
            let (at, sigma) = ([11.0, -7.0, 4.0], [0.1, -0.15]);
            let around = |x: f64, half: f64| Interval::new(x - half, x + half);
            let boxes = (at.map(|x| around(x, 0.5)), sigma.map(|s| around(s, 1e-3)));
            let bounds = [
                target.direction_at(boxes.0, boxes.1),
                target.direction_from_origin(boxes.0, boxes.1),
            ];
            for k in 0..64 {
                let side = |bit: i32| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let at = [0, 1, 2].map(|i| at[i as usize] + 0.5 * side(i));
                let sigma = [0, 1].map(|i| sigma[i as usize] + 1e-3 * side(i + 3));
                let exact =
                    [target.direction_at(at, sigma), target.direction_from_origin(at, sigma)];
                for (bound, exact) in bounds.iter().zip(exact) {
                    assert!(bound[0].contains(exact[0]) && bound[1].contains(exact[1]));
                    assert!(bound[0].width() < 0.2, "{surface:?}: {bound:?}");
                }
            }
        }
    }

    #[test]
    fn what_parts_the_viewpoint_from_the_mirror_is_refused() {
        let plane = |z: f64| PosedSurface::Plane { point_mm: DVec3::Z * z, normal: DVec3::Z };
        let new = |surface, z: f64| PosedTarget::new(surface, DVec3::Z * z).err();
        assert_eq!(new(plane(50.0), 60.0), Some(PoseFault::Parted));
        assert_eq!(new(plane(50.0), 50.0), Some(PoseFault::ViewpointOnSurface));
        assert_eq!(new(plane(0.0), 50.0), Some(PoseFault::MirrorOnSurface));
        assert_eq!(new(plane(50.0), 40.0), None);
        let dome = PosedSurface::Sphere { centre_mm: DVec3::Z * 90.0, radius_mm: 100.0 };
        assert_eq!(new(dome.clone(), 200.0), Some(PoseFault::Parted));
        assert_eq!(new(dome, 90.0), None);
    }
}
