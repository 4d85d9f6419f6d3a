//! Obstacles: bodies beside the mirror, and where a line meets their surfaces, in closed form but for meshes.

use super::{DVec3, Ray, TriMesh};
use std::sync::Arc;

/// A body that may hide what a ray would show, with its name in reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// Name.
    pub name: String,
    /// Shape and place.
    pub shape: ObstacleShape,
}

/// Shape and place of an obstacle, mm.
#[derive(Debug, Clone, PartialEq)]
pub enum ObstacleShape {
    /// A box in any orientation.
    Cuboid(Cuboid),
    /// A circular cylinder.
    Cylinder(Cylinder),
    /// A tube.
    Tube(Tube),
    /// Triangles, met from both sides; nothing is promised about them.
    Mesh(Arc<TriMesh>),
}

/// A box in any orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    /// Centre, mm.
    pub centre_mm: DVec3,
    /// Half the length along each of its axes, mm.
    pub half_mm: DVec3,
    /// Orthogonal unit vectors along its edges.
    pub axes: [DVec3; 3],
}

/// A circular cylinder between two planes across its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Centre of the one end, mm.
    pub from_mm: DVec3,
    /// Centre of the other end, mm.
    pub to_mm: DVec3,
    /// Radius, mm.
    pub radius_mm: f64,
    /// Whether it is filled and so has ends; otherwise it is a wall without thickness, open at both ends.
    pub is_solid: bool,
}

/// A tube: what lies between two cylinders about one axis and between two planes across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tube {
    /// Centre of the one end, mm.
    pub from_mm: DVec3,
    /// Centre of the other end, mm.
    pub to_mm: DVec3,
    /// Radius of the bore, mm.
    pub inner_radius_mm: f64,
    /// Radius of the outer surface, mm.
    pub outer_radius_mm: f64,
}

/// Distances along a line between which it is inside a convex body, mm; none where the first is not less than the
/// second.
type Span = [f64; 2];

/// The span of a line that misses.
const MISSED: Span = [f64::INFINITY, f64::NEG_INFINITY];
/// The span of a line that is inside all along.
const ALL: Span = [f64::NEG_INFINITY, f64::INFINITY];

fn both([a, b]: Span, [c, d]: Span) -> Span {
    [a.max(c), b.min(d)]
}

/// Span in which a coordinate, `at` at the ray's origin with the slope `along`, is between `lo` and `hi`.
fn slab(at: f64, along: f64, [lo, hi]: [f64; 2]) -> Span {
    if along == 0.0 {
        return if at > lo && at < hi { ALL } else { MISSED };
    }
    let (a, b) = ((lo - at) / along, (hi - at) / along);
    [a.min(b), a.max(b)]
}

/// A circle's axis from the one end to the other.
struct Axis {
    from_mm: DVec3,
    along: DVec3,
    length_mm: f64,
}

impl Axis {
    fn new(from_mm: DVec3, to_mm: DVec3) -> Self {
        let length_mm = (to_mm - from_mm).length();
        Self { from_mm, along: (to_mm - from_mm) / length_mm, length_mm }
    }

    /// Span between the planes across it at both ends.
    fn between_ends(&self, ray: &Ray) -> Span {
        let at = (ray.origin - self.from_mm).dot(self.along);
        slab(at, ray.direction.dot(self.along), [0.0, self.length_mm])
    }

    /// Span inside the endless cylinder about it.
    fn within(&self, ray: &Ray, radius_mm: f64) -> Span {
        let from = (ray.origin - self.from_mm).reject_from_normalized(self.along);
        let across = ray.direction.reject_from_normalized(self.along);
        let square = across.length_squared();
        if square == 0.0 {
            return if from.length() < radius_mm { ALL } else { MISSED };
        }
        // The line's distance from the axis, times the slope: no square of a far origin is taken off another.
        let aside = from.cross(across).dot(self.along);
        let inside = radius_mm * radius_mm * square - aside * aside;
        if !(inside > 0.0) {
            return MISSED;
        }
        let (middle, half) = (-from.dot(across), inside.sqrt());
        [(middle - half) / square, (middle + half) / square]
    }

    /// Distance of a place along the axis from its first end, and from the axis, mm.
    fn coordinates(&self, at: DVec3) -> (f64, f64) {
        let from = at - self.from_mm;
        (from.dot(self.along), from.reject_from_normalized(self.along).length())
    }

    fn has_between_ends(&self, along: f64) -> bool {
        along > 0.0 && along < self.length_mm
    }
}

/// The first end of the spans that is more than `after`.
fn first_end(spans: &[Span], after: f64) -> Option<f64> {
    let ends = spans.iter().filter(|[a, b]| a < b).flatten();
    ends.copied().filter(|t| *t > after && t.is_finite()).min_by(f64::total_cmp)
}

impl Cuboid {
    /// A box with edges along X, Y and Z.
    #[must_use]
    pub fn aligned(centre_mm: DVec3, size_mm: DVec3) -> Self {
        Self { centre_mm, half_mm: 0.5 * size_mm, axes: DVec3::AXES }
    }

    /// Distance along the ray, more than `after`, at which it first meets the surface, mm.
    #[must_use]
    pub fn meeting(&self, ray: &Ray, after: f64) -> Option<f64> {
        let from = ray.origin - self.centre_mm;
        let span = (0..3).fold(ALL, |span, k| {
            let (axis, half) = (self.axes[k], self.half_mm[k]);
            both(span, slab(from.dot(axis), ray.direction.dot(axis), [-half, half]))
        });
        first_end(&[span], after)
    }

    /// Whether a place is inside.
    #[must_use]
    pub fn contains(&self, at: DVec3) -> bool {
        let from = at - self.centre_mm;
        (0..3).all(|k| from.dot(self.axes[k]).abs() < self.half_mm[k])
    }
}

impl Cylinder {
    /// Distance along the ray, more than `after`, at which it first meets the surface, mm.
    #[must_use]
    pub fn meeting(&self, ray: &Ray, after: f64) -> Option<f64> {
        let axis = Axis::new(self.from_mm, self.to_mm);
        let (ends, within) = (axis.between_ends(ray), axis.within(ray, self.radius_mm));
        if self.is_solid {
            return first_end(&[both(ends, within)], after);
        }
        let walls = [within].into_iter().filter(|[a, b]| a < b).flatten();
        walls.filter(|t| *t > after && *t > ends[0] && *t < ends[1]).find(|t| t.is_finite())
    }

    /// Whether a place is inside its material: never of a wall without thickness.
    #[must_use]
    pub fn contains(&self, at: DVec3) -> bool {
        let axis = Axis::new(self.from_mm, self.to_mm);
        let (along, aside) = axis.coordinates(at);
        self.is_solid && axis.has_between_ends(along) && aside < self.radius_mm
    }
}

impl Tube {
    /// Distance along the ray, more than `after`, at which it first meets the surface, mm.
    #[must_use]
    pub fn meeting(&self, ray: &Ray, after: f64) -> Option<f64> {
        let axis = Axis::new(self.from_mm, self.to_mm);
        let [a, b] = both(axis.between_ends(ray), axis.within(ray, self.outer_radius_mm));
        match axis.within(ray, self.inner_radius_mm) {
            [c, d] if c < d => first_end(&[[a, b.min(c)], [a.max(d), b]], after),
            _ => first_end(&[[a, b]], after),
        }
    }

    /// Whether a place is inside its material.
    #[must_use]
    pub fn contains(&self, at: DVec3) -> bool {
        let axis = Axis::new(self.from_mm, self.to_mm);
        let (along, aside) = axis.coordinates(at);
        axis.has_between_ends(along) && aside > self.inner_radius_mm && aside < self.outer_radius_mm
    }
}

impl Obstacle {
    /// The obstacle shifted by `by`, mm.
    #[must_use]
    pub fn shifted(&self, by: DVec3) -> Self {
        let shape = match self.shape {
            ObstacleShape::Cuboid(c) => {
                ObstacleShape::Cuboid(Cuboid { centre_mm: c.centre_mm + by, ..c })
            }
            ObstacleShape::Cylinder(c) => ObstacleShape::Cylinder(Cylinder {
                from_mm: c.from_mm + by,
                to_mm: c.to_mm + by,
                ..c
            }),
            ObstacleShape::Tube(t) => {
                ObstacleShape::Tube(Tube { from_mm: t.from_mm + by, to_mm: t.to_mm + by, ..t })
            }
            ObstacleShape::Mesh(ref mesh) => {
                let vertices = mesh.vertices.iter().map(|v| *v + by).collect();
                let triangles = mesh.triangles.clone();
                ObstacleShape::Mesh(Arc::new(TriMesh { vertices, triangles }))
            }
        };
        Self { name: self.name.clone(), shape }
    }
}

impl ObstacleShape {
    /// A height that nothing of it exceeds, mm.
    #[must_use]
    pub fn top_mm(&self) -> f64 {
        let round = |from: DVec3, to: DVec3, radius: f64| {
            let along = (to - from).normalize().z;
            from.z.max(to.z) + radius * (1.0 - along * along).max(0.0).sqrt()
        };
        match self {
            Self::Cuboid(c) => {
                let reach = (0..3).map(|k| c.half_mm[k] * c.axes[k].z.abs());
                c.centre_mm.z + reach.sum::<f64>()
            }
            Self::Cylinder(c) => round(c.from_mm, c.to_mm, c.radius_mm),
            Self::Tube(t) => round(t.from_mm, t.to_mm, t.outer_radius_mm),
            Self::Mesh(mesh) => mesh.bounds().map_or(f64::NEG_INFINITY, |(_, hi)| hi.z),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        let [origin, direction] = [origin, direction].map(DVec3::from_array);
        Ray { origin, direction: direction.normalize() }
    }

    /// A frame turned about two axes by angles of 3-4-5 triangles.
    const TURNED: [DVec3; 3] =
        [DVec3::new(0.6, 0.8, 0.0), DVec3::new(-0.48, 0.36, 0.8), DVec3::new(0.64, -0.48, 0.6)];

    fn turned(v: [f64; 3]) -> DVec3 {
        TURNED[0] * v[0] + TURNED[1] * v[1] + TURNED[2] * v[2]
    }

    #[test]
    fn a_box_is_met_at_its_faces() {
        let size = DVec3::new(2.0, 4.0, 6.0);
        let still = Cuboid::aligned(DVec3::new(10.0, 0.0, 0.0), size);
        let ahead = ray([0.0, 0.5, 0.5], [1.0, 0.0, 0.0]);
        assert_eq!(still.meeting(&ahead, 0.0), Some(9.0));
        assert_eq!(still.meeting(&ahead, 9.5), Some(11.0));
        assert_eq!(still.meeting(&ahead, 11.5), None);
        assert_eq!(still.meeting(&ray([0.0, 2.5, 0.0], [1.0, 0.0, 0.0]), 0.0), None);
        let box_ =
            Cuboid { centre_mm: turned([10.0, 0.0, 0.0]), half_mm: 0.5 * size, axes: TURNED };
        let same = Ray { origin: turned([0.0, 0.5, 0.5]), direction: TURNED[0] };
        assert!((box_.meeting(&same, 0.0).unwrap() - 9.0).abs() < 1e-14);
        assert!(
            box_.contains(turned([10.9, 1.9, -2.9])) && !box_.contains(turned([8.9, 0.0, 0.0]))
        );
    }

    #[test]
    fn a_cylinder_is_met_on_its_wall_or_at_its_ends() {
        let leg = |is_solid| Cylinder {
            from_mm: turned([10.0, 0.0, -5.0]),
            to_mm: turned([10.0, 0.0, 5.0]),
            radius_mm: 5.0,
            is_solid,
        };
        // Off the axis by 3 of 5 mm: half the chord is 4 mm.
        let aside = Ray { origin: turned([0.0, 3.0, 1.0]), direction: TURNED[0] };
        // Down into the open end, and past the wall beyond it.
        let down = Ray {
            origin: turned([10.0, 0.0, 9.0]),
            direction: turned([0.6, 0.0, -0.8]).normalize(),
        };
        for is_solid in [true, false] {
            let near = leg(is_solid).meeting(&aside, 0.0).unwrap();
            assert!((near - 6.0).abs() < 1e-13, "{near}");
            let far = leg(is_solid).meeting(&aside, 7.0).unwrap();
            assert!((far - 14.0).abs() < 1e-13, "{far}");
            let past = Ray { origin: turned([0.0, 5.1, 1.0]), direction: TURNED[0] };
            assert_eq!(leg(is_solid).meeting(&past, 0.0), None);
        }
        let [end, wall] = [true, false].map(|is_solid| leg(is_solid).meeting(&down, 0.0).unwrap());
        assert!((end - 5.0).abs() < 1e-13 && (wall - 5.0 / 0.6).abs() < 1e-12, "{end} {wall}");
        assert!(leg(true).contains(turned([10.0, 4.9, 0.0])));
        assert!(!leg(false).contains(turned([10.0, 4.9, 0.0])));
        // Along the axis there is no wall in the way.
        let along = Ray { origin: turned([10.0, 1.0, 9.0]), direction: -TURNED[2] };
        assert_eq!(leg(false).meeting(&along, 0.0), None);
        assert!((leg(true).meeting(&along, 0.0).unwrap() - 4.0).abs() < 1e-13);
    }

    #[test]
    fn a_tube_lets_through_its_bore_what_meets_no_wall() {
        let tube = Tube {
            from_mm: DVec3::ZERO,
            to_mm: DVec3::Z * 10.0,
            inner_radius_mm: 3.0,
            outer_radius_mm: 5.0,
        };
        let across = ray([-9.0, 0.0, 5.0], [1.0, 0.0, 0.0]);
        let met = [0.0, 5.0, 7.0, 13.0].map(|after| tube.meeting(&across, after).unwrap());
        assert_eq!(met, [4.0, 6.0, 12.0, 14.0]);
        assert_eq!(tube.meeting(&ray([1.0, 2.0, 12.0], [0.0, 0.0, -1.0]), 0.0), None);
        let on_ring = ray([0.0, 4.0, 12.0], [0.0, 0.0, -1.0]);
        assert_eq!(tube.meeting(&on_ring, 0.0), Some(2.0));
        assert_eq!(tube.meeting(&on_ring, 2.0), Some(12.0));
        // Out of the bore, through the wall or over its edge.
        let met = tube.meeting(&ray([0.0, 0.0, 5.0], [3.0, 0.0, 4.0]), 0.0).unwrap();
        assert!((met - 5.0).abs() < 1e-14, "{met}");
        assert_eq!(tube.meeting(&ray([0.0, 0.0, 9.0], [0.8, 0.0, 0.6]), 0.0), None);
        assert!(tube.contains(DVec3::new(4.0, 0.0, 1.0)) && !tube.contains(DVec3::Z));
    }

    #[test]
    fn nothing_of_an_obstacle_is_above_its_top() {
        let cylinder = ObstacleShape::Cylinder(Cylinder {
            from_mm: DVec3::ZERO,
            to_mm: DVec3::new(30.0, 0.0, 40.0),
            radius_mm: 5.0,
            is_solid: true,
        });
        assert!((cylinder.top_mm() - 43.0).abs() < 1e-14);
        let centre_mm = DVec3::Z * 7.0;
        let cuboid = Cuboid { centre_mm, half_mm: DVec3::ONE, axes: TURNED };
        assert!((ObstacleShape::Cuboid(cuboid).top_mm() - 8.4).abs() < 1e-14);
    }
}
