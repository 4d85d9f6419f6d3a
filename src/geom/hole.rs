//! Round holes along Z, drilled from the base: their kinds, and the surfaces of revolution that bound them.

use super::circle_polygon::{area, circle_chords, circle_of};
use super::{DVec2, DVec3, MetricThread};
use crate::num::tan;
use std::f64::consts::PI;

/// A round hole along Z that opens in the base. Where it ends, what has it says: a through hole at the surface above it,
/// a [`BlindHole`] in the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hole {
    /// X and Y of its axis, mm.
    pub at: DVec2,
    /// Diameter of its cylinder, mm: of a threaded hole the pilot's.
    pub diameter_mm: f64,
    /// Its purpose.
    pub kind: HoleKind,
    /// Its counterbore from the base.
    pub counterbore: Option<Counterbore>,
    /// Leg of the chamfers of 45 degrees at its mouths, mm; 0 for sharp edges.
    pub chamfer_mm: f64,
}

/// Purpose of a hole, which its figures follow from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HoleKind {
    /// None that is known.
    Plain,
    /// Internal thread.
    Thread {
        /// Its size.
        size: MetricThread,
        /// Depth of the usable thread from the base, mm; none where it is as long as the hole.
        depth_mm: Option<f64>,
    },
    /// Clearance hole for a screw (ISO 273).
    Screw(MetricThread),
    /// Hole of tolerance class H7 for a dowel pin of the hole's diameter.
    Dowel,
}

/// A wider cylinder at a hole's mouth in the base, with a plane ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counterbore {
    /// Its diameter, mm; more than the hole's.
    pub diameter_mm: f64,
    /// Z of its ground, mm.
    pub depth_mm: f64,
}

/// Ground of a blind hole.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum HoleBottom {
    /// The cone of a twist drill, of 118 degrees, beyond the hole's depth.
    #[default]
    DrillPoint,
    /// A plane.
    Flat,
}

/// A hole that ends in the material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlindHole {
    /// Its mouth and its cylinder.
    pub hole: Hole,
    /// Z of the cylinder's upper end, mm.
    pub depth_mm: f64,
    /// What follows there.
    pub bottom: HoleBottom,
}

impl Hole {
    /// The through or blind cylinder about `at`, without anything else.
    #[must_use]
    pub fn plain(at: DVec2, diameter_mm: f64) -> Self {
        Self { at, diameter_mm, kind: HoleKind::Plain, counterbore: None, chamfer_mm: 0.0 }
    }

    /// Half the diameter of its cylinder, mm.
    #[must_use]
    pub fn radius(&self) -> f64 {
        0.5 * self.diameter_mm
    }

    /// Largest radius, mm: that of its mouth in the base.
    #[must_use]
    pub fn mouth_radius(&self) -> f64 {
        self.wall_radius() + self.chamfer_mm
    }

    /// Radius of the lowest cylinder, mm: the counterbore's or its own.
    fn wall_radius(&self) -> f64 {
        0.5 * self.counterbore.map_or(self.diameter_mm, |counterbore| counterbore.diameter_mm)
    }

    /// Z at which its cylinder begins: above its chamfer and its counterbore, mm.
    #[must_use]
    pub fn mouth_depth_mm(&self) -> f64 {
        self.counterbore.map_or(self.chamfer_mm, |counterbore| counterbore.depth_mm)
    }

    /// The surface of the through hole that ends in a plane at `top_mm`.
    #[must_use]
    pub fn meridian(&self, top_mm: f64) -> HoleMeridian {
        let mut meridian = self.mouth();
        let radius = self.radius();
        if self.chamfer_mm > 0.0 {
            meridian.push(radius, top_mm - self.chamfer_mm);
        }
        meridian.push(radius + self.chamfer_mm, top_mm);
        meridian
    }

    /// The surface up to where its cylinder begins.
    fn mouth(&self) -> HoleMeridian {
        let mut meridian = HoleMeridian { axis: self.at, points: [DVec2::ZERO; 6], count: 0 };
        meridian.push(self.mouth_radius(), 0.0);
        if self.chamfer_mm > 0.0 {
            meridian.push(self.wall_radius(), self.chamfer_mm);
        }
        if let Some(Counterbore { diameter_mm, depth_mm }) = self.counterbore {
            meridian.push(0.5 * diameter_mm, depth_mm);
            meridian.push(self.radius(), depth_mm);
        }
        meridian
    }
}

impl BlindHole {
    /// Tangent of half the point angle of a twist drill for general use, 118 degrees (DIN 1414-1, type N).
    fn half_point_tangent() -> f64 {
        tan(59.0 / 180.0 * PI)
    }

    /// Z of its highest point, mm.
    #[must_use]
    pub fn tip_mm(&self) -> f64 {
        match self.bottom {
            HoleBottom::DrillPoint => {
                self.depth_mm + self.hole.radius() / Self::half_point_tangent()
            }
            HoleBottom::Flat => self.depth_mm,
        }
    }

    /// Its surface.
    #[must_use]
    pub fn meridian(&self) -> HoleMeridian {
        let mut meridian = self.hole.mouth();
        meridian.push(self.hole.radius(), self.depth_mm);
        meridian.push(0.0, self.tip_mm());
        meridian
    }
}

/// The curve that turned about an axis along Z is a hole's surface: straight pieces between points (radius, Z) in mm,
/// from the mouth in the base upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HoleMeridian {
    /// X and Y of the axis, mm.
    pub axis: DVec2,
    /// Mouth with a chamfer, counterbore, and an upper end with a chamfer or a point: six points at the most.
    points: [DVec2; 6],
    count: usize,
}

impl HoleMeridian {
    fn push(&mut self, radius: f64, z: f64) {
        self.points[self.count] = DVec2::new(radius, z);
        self.count += 1;
    }

    /// Radius and Z of its points, mm, the base's first; the last has radius 0 where the hole is blind.
    #[must_use]
    pub fn points(&self) -> &[DVec2] {
        &self.points[..self.count]
    }

    /// Whether it ends in the material.
    #[must_use]
    pub fn is_blind(&self) -> bool {
        self.points()[self.count - 1].x == 0.0
    }

    /// Radius of the mouth in the base, mm: its largest.
    #[must_use]
    pub fn mouth_radius(&self) -> f64 {
        self.points[0].x
    }

    /// Radius, mm, of its upper end; 0 of a blind hole.
    #[must_use]
    pub fn upper_radius(&self) -> f64 {
        self.points()[self.count - 1].x
    }

    /// Its pieces, each from its lower to its upper end.
    pub fn pieces(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        self.points().windows(2).map(|ends| [ends[0], ends[1]])
    }

    /// Chords of its polygons: as many as the largest of its circles takes within [`super::CHORD_MM`].
    #[must_use]
    pub fn corners(&self) -> usize {
        4 * circle_chords(self.largest_radius())
    }

    /// The circle of this radius about the axis as a polygon, counter-clockwise, its corners on the circle.
    #[must_use]
    pub fn polygon(&self, radius: f64) -> Vec<DVec2> {
        let circle = circle_of(radius, circle_chords(self.largest_radius()));
        circle.into_iter().map(|p| self.axis + p).collect()
    }

    fn largest_radius(&self) -> f64 {
        self.points().iter().fold(0.0, |largest, point| point.x.max(largest))
    }

    /// Its volume, mm^3, if circles of a radius have such an area: that of frustums of cones and pyramids.
    pub(super) fn volume_with(&self, area: impl Fn(f64) -> f64) -> f64 {
        let frustum = |[low, high]: [DVec2; 2]| {
            let height = high.y - low.y;
            if low.x == high.x {
                return height * area(low.x);
            }
            let [a, b] = [area(low.x), area(high.x)];
            height / 3.0 * (a + (a * b).sqrt() + b)
        };
        self.pieces().map(frustum).sum()
    }

    /// Its volume, mm^3.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.volume_with(|radius| PI * radius * radius)
    }

    /// What polygons in the place of its circles take off its volume, mm^3.
    #[must_use]
    pub fn chords_mm3(&self) -> f64 {
        self.volume_with(|radius| PI * radius * radius - area(&self.polygon(radius)))
    }

    /// Distance of `v` from its surface, mm.
    #[must_use]
    pub fn distance(&self, v: DVec3) -> f64 {
        let p = self.across(v);
        self.pieces().map(|ends| segment_distance(p, ends)).fold(f64::INFINITY, f64::min)
    }

    /// Material, mm, between the hole and the place `v` in the part; negative inside the hole.
    #[must_use]
    pub fn wall(&self, v: DVec3) -> f64 {
        let p = self.across(v);
        let within = |[low, high]: [DVec2; 2]| {
            let share = (p.y - low.y) / (high.y - low.y);
            (low.y..=high.y).contains(&p.y) && p.x <= low.x + share * (high.x - low.x)
        };
        let distance = self.distance(v);
        // (A plane ring is no part of what has a height.)
        if self.pieces().filter(|[low, high]| high.y > low.y).any(within) {
            -distance
        } else {
            distance
        }
    }

    /// Distance of `v` from the axis, and its Z.
    fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.truncate().distance(self.axis), v.z)
    }
}

/// Distance of a point from a straight piece; of one along an axis without rounding.
pub(super) fn segment_distance(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let along = b - a;
    if along.x == 0.0 || along.y == 0.0 {
        return (p - p.clamp(a.min(b), a.max(b))).length();
    }
    let share = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (p - (a + along * share)).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threaded() -> BlindHole {
        let counterbore = Some(Counterbore { diameter_mm: 6.0, depth_mm: 2.0 });
        let kind = HoleKind::Thread { size: MetricThread::M3, depth_mm: Some(6.0) };
        let hole =
            Hole { at: DVec2::new(3.0, 4.0), diameter_mm: 2.5, kind, counterbore, chamfer_mm: 0.5 };
        BlindHole { hole, depth_mm: 8.0, bottom: HoleBottom::DrillPoint }
    }

    /// Cylinders, a frustum and a cone by their closed forms.
    #[test]
    fn volumes_are_those_of_cylinders_and_cones() {
        let hole = threaded();
        let point = 1.25 / crate::num::tan(59.0 * PI / 180.0);
        assert!((hole.tip_mm() - (8.0 + point)).abs() < 1e-15);
        let cone = PI * 1.25 * 1.25 * point / 3.0;
        let chamfer = PI * 0.5 / 3.0 * (3.5 * 3.5 + 3.5 * 3.0 + 9.0);
        let exact = chamfer + PI * 9.0 * 1.5 + PI * 1.25 * 1.25 * 6.0 + cone;
        let found = hole.meridian().volume();
        assert!((found - exact).abs() < 1e-13 * exact, "{found}, not {exact}");
        let flat = BlindHole { bottom: HoleBottom::Flat, ..hole };
        assert!((flat.meridian().volume() - (exact - cone)).abs() < 1e-13 * exact);
        let through = Hole { counterbore: None, ..hole.hole }.meridian(5.0);
        let chamfer = PI * 0.5 / 3.0 * (1.75 * 1.75 + 1.75 * 1.25 + 1.25 * 1.25);
        let exact = 2.0 * chamfer + PI * 1.25 * 1.25 * 4.0;
        assert!((through.volume() - exact).abs() < 1e-13 * exact);
    }

    /// A polygon of n corners has the share sin(2 pi / n) n / (2 pi) of its circle at every height.
    #[test]
    fn polygons_take_the_same_share_of_every_circle() {
        let meridian = threaded().meridian();
        let n = meridian.corners() as f64;
        let lost = 1.0 - crate::num::sin(2.0 * PI / n) * n / (2.0 * PI);
        let off = meridian.chords_mm3() / meridian.volume() - lost;
        assert!(off.abs() < 1e-12 && lost > 1e-4, "{off:e} {lost}");
        assert_eq!(meridian.polygon(1.0).len(), meridian.corners());
    }

    #[test]
    fn distances_and_walls_are_those_by_hand() {
        let meridian = threaded().meridian();
        let at = |radius: f64, z: f64| DVec3::new(3.0 + 0.6 * radius, 4.0 + 0.8 * radius, z);
        for (radius, z, off, wall) in [
            // Mouth, chamfer, counterbore's wall and ground, cylinder, beyond it and inside.
            (3.5, 0.0, 0.0, 0.0),
            (3.25, 0.25, 0.0, 0.0),
            (3.0, 1.0, 0.0, 0.0),
            (2.0, 2.0, 0.0, 0.0),
            (2.0, 3.0, 0.75, 0.75),
            (0.25, 6.0, 1.0, -1.0),
            (2.0, 1.0, 1.0, -1.0),
            (5.0, 1.5, 2.0, 2.0),
            (0.0, 20.0, 20.0 - threaded().tip_mm(), 20.0 - threaded().tip_mm()),
        ] {
            let found = [meridian.distance(at(radius, z)), meridian.wall(at(radius, z))];
            assert!((found[0] - off).abs() < 1e-14, "{radius} {z}: {found:?}");
            assert!((found[1].abs() - wall.abs()).abs() < 1e-14, "{radius} {z}: {found:?}");
            assert!(wall.abs() < 1e-14 || found[1] * wall > 0.0, "{radius} {z}: {found:?}");
        }
    }
}
