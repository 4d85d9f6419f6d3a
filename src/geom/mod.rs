//! Vectors, rays, rectangles and triangle meshes: shapes without a meaning.
//!
//! Vectors are `glam`'s double-precision ones. Everything is in the part frame (millimetres;
//! X = y, Y = z, Z = x of the paper) unless a name says otherwise.

mod bicubic_spline;
mod border;
mod cavity_floor;
mod chart;
mod circle_polygon;
mod contour;
mod cutter;
mod datum_scheme;
mod derivative_bounds;
mod even_places;
mod face_mesh;
mod hole;
mod mesh_search;
mod metric_thread;
mod obstacle;
mod outline;
mod panels;
mod part_features;
mod plan_polygon;
mod rect;
mod sampling;
mod split;
mod triangulate;
mod trimesh;
mod xyz_lines;

pub use bicubic_spline::{BicubicSpline, BicubicSplineRow, LEAST_KNOTS};
pub use border::{Border, Drilled, Land};
pub use cavity_floor::CavityFloor;
pub use chart::Chart;
pub use circle_polygon::CHORD_MM;
pub use contour::Contour;
pub use cutter::Cutter;
pub use datum_scheme::{DatumFeature, DatumScheme};
pub use derivative_bounds::DerivativeBounds;
pub(crate) use even_places::EvenPlaces;
pub use face_mesh::FaceMesh;
pub use glam::{DVec2, DVec3};
pub use hole::{BlindHole, Counterbore, Hole, HoleBottom, HoleKind, HoleMeridian};
pub use mesh_search::Hit;
pub(crate) use mesh_search::{MeshSearch, sheared_ray};
pub use metric_thread::{MetricThread, h7_upper_mm};
pub use obstacle::{Cuboid, Cylinder, Obstacle, ObstacleShape, Tube};
pub use outline::Outline;
pub use panels::{CommonStretch, DividingLine, Panels};
pub use part_features::{NumberedHole, PartFeatures};
pub use plan_polygon::PlanPolygon;
pub use rect::Rect;
pub use sampling::{GridAxis, ScanPath, ScanPattern};
pub use triangulate::{TriangulationFault, triangulate_loops};
pub use trimesh::{TriMesh, Welder, turn};
pub use xyz_lines::{XyzFault, XyzLine, xyz_lines};

/// How many digits the coordinates of a file carry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// 24 bits: every coordinate is rounded to `f32`.
    Single,
    /// 53 bits: coordinates as designed.
    Double,
}

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

/// Angle between two unit vectors, radians: to rounding for small angles and near pi alike.
#[inline]
#[must_use]
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    /// Squares of half a chord up to which the series of the arc sine below ends with a rounding: of angles up to 3.5
    /// degrees.
    const SHORT: f64 = 1.0 / 1024.0;
    const ARC_SINE: [f64; 5] =
        [945.0 / 42240.0, 105.0 / 3456.0, 15.0 / 336.0, 3.0 / 40.0, 1.0 / 6.0];
    let chord = a - b;
    let square = 0.25 * chord.length_squared();
    if square < SHORT {
        let rest = ARC_SINE.iter().fold(0.0, |sum, term| (sum + term) * square);
        return (1.0 + rest) * chord.length();
    }
    2.0 * crate::num::atan2(chord.length(), (a + b).length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, sin};

    #[test]
    fn angle_keeps_its_digits_at_both_ends() {
        let pi = std::f64::consts::PI;
        let sides = [0.999, 1.001].map(|share| share * 0.062_510_2);
        for exact in [1e-12, 1e-6, 0.01, sides[0], sides[1], 0.5, 2.0, pi - 1e-6, pi - 1e-8] {
            let found = angle(DVec3::X, DVec3::new(cos(exact), sin(exact), 0.0));
            assert!((found - exact).abs() < 1e-15, "{exact}: {found}");
        }
    }
}
