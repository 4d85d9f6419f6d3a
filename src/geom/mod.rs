//! Vectors, rays, rectangles and triangle meshes: shapes without a meaning.
//!
//! Vectors are `glam`'s double-precision ones. Everything is in the part frame (millimetres;
//! X = y, Y = z, Z = x of the paper) unless a name says otherwise.

mod rect;
mod trimesh;

pub use glam::{DVec2, DVec3};
pub use rect::Rect;
pub use trimesh::{TriMesh, Welder, turn};

/// A half-line from `origin` along the unit vector `direction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, mm.
    pub origin: DVec3,
    /// Where it goes, unit length.
    pub direction: DVec3,
}

impl Ray {
    /// The point `t` mm along the ray.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// Angle between two unit vectors, radians: exact for small angles and near pi alike.
#[inline]
#[must_use]
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * crate::num::asin((0.5 * (a - b).length()).min(1.0))
}
