//! The outer contour of a part with a flat rim: a circle or a rectangle about the axis.

use super::circle_polygon::{arc_of, circle_chords, circle_of, turned};
use super::hole::segment_distance;
use super::{DVec2, DVec3};
use std::f64::consts::PI;

/// A contour about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contour {
    /// A rectangle.
    Rect {
        /// Half its width and half its height.
        half: DVec2,
        /// The radius that its corners are rounded with; 0 for sharp ones.
        corner_mm: f64,
    },
    /// A circle.
    Circle {
        /// Its radius.
        radius_mm: f64,
    },
}

impl Contour {
    /// Area, mm^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        match *self {
            Self::Rect { half, corner_mm } => {
                4.0 * half.x * half.y - (4.0 - PI) * corner_mm * corner_mm
            }
            Self::Circle { radius_mm } => PI * radius_mm * radius_mm,
        }
    }

    /// How far inside it `p` is, mm; negative outside.
    #[must_use]
    pub fn inset(&self, p: DVec2) -> f64 {
        match *self {
            Self::Rect { half, corner_mm } => {
                let past = p.abs() - half + corner_mm;
                corner_mm - past.max(DVec2::ZERO).length() - past.max_element().min(0.0)
            }
            Self::Circle { radius_mm } => radius_mm - p.length(),
        }
    }

    /// The contour `by` mm inside it, parallel to it; `by` is less than the radius of a circle or of rounded corners.
    #[must_use]
    pub fn shrunk(&self, by: f64) -> Self {
        match *self {
            Self::Rect { half, corner_mm } => {
                Self::Rect { half: half - by, corner_mm: (corner_mm - by).max(0.0) }
            }
            Self::Circle { radius_mm } => Self::Circle { radius_mm: radius_mm - by },
        }
    }

    /// It as a polygon, counter-clockwise, its corners on it.
    #[must_use]
    pub fn polygon(&self) -> Vec<DVec2> {
        self.shrunk_polygon(0.0)
    }

    /// The contour `by` mm inside it as a polygon of as many corners as its own has, counter-clockwise, each inside the
    /// one of the same number.
    #[must_use]
    pub fn shrunk_polygon(&self, by: f64) -> Vec<DVec2> {
        let (half, corner_mm, chords) = match (*self, self.shrunk(by)) {
            (Self::Circle { radius_mm: own }, Self::Circle { radius_mm }) => {
                return circle_of(radius_mm, circle_chords(own));
            }
            (Self::Rect { corner_mm: own, .. }, Self::Rect { half, corner_mm }) => {
                (half, corner_mm, circle_chords(own))
            }
            _ => unreachable!("a contour keeps its kind"),
        };
        let arc = if corner_mm == 0.0 { vec![DVec2::ZERO] } else { arc_of(corner_mm, chords) };
        let signs = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let around = signs.iter().enumerate().flat_map(|(quarter, &(x, y))| {
            let centre = (half - corner_mm) * DVec2::new(x, y);
            turned(&arc, quarter).map(move |p| centre + p).collect::<Vec<_>>()
        });
        // Arcs that take up a whole side meet in one corner.
        let mut corners: Vec<DVec2> = around.collect();
        corners.dedup();
        if corners.first() == corners.last() {
            corners.pop();
        }
        corners
    }

    /// Distance, mm, from the chamfer of 45 degrees with this leg, mm, between the upright side over this contour and a level
    /// plane, of the place over `p` that is `height` mm from the plane, towards the material.
    pub(super) fn chamfer_distance(&self, p: DVec2, height: f64, leg: f64) -> f64 {
        let cut = [DVec2::new(leg, 0.0), DVec2::new(0.0, leg)];
        match *self {
            // Its planes meet at mitres.
            Self::Rect { half, corner_mm: 0.0 } => {
                let DVec2 { x, y } = half - p.abs();
                let one = |across: f64, along: f64| {
                    let share = (0.5 * (leg + across - height)).clamp(0.0, leg);
                    if along >= share {
                        return segment_distance(DVec2::new(across, height), cut);
                    }
                    let from = DVec3::new(across, along, height - leg);
                    let way = DVec3::new(leg, leg, -leg);
                    (from - (from.dot(way) / way.length_squared()).clamp(0.0, 1.0) * way).length()
                };
                one(x, y).min(one(y, x))
            }
            _ => segment_distance(DVec2::new(self.inset(p), height), cut),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::CHORD_MM;
    use super::super::circle_polygon::{area, circle};
    use super::*;

    fn contours() -> [Contour; 5] {
        let rect = |x, y, corner_mm| Contour::Rect { half: DVec2::new(x, y), corner_mm };
        [
            Contour::Circle { radius_mm: 7.0 },
            rect(9.0, 5.0, 0.0),
            rect(9.0, 5.0, 2.0),
            rect(9.0, 5.0, 5.0),
            rect(5.0, 5.0, 5.0),
        ]
    }

    #[test]
    fn polygons_keep_to_their_contours() {
        for contour in contours() {
            let corners = contour.polygon();
            let next = corners.iter().cycle().skip(1);
            for (a, b) in corners.iter().zip(next) {
                assert!(contour.inset(*a).abs() < 1e-14 && a != b, "{contour:?} {a}");
                let cut = contour.inset(0.5 * (*a + *b));
                assert!((-1e-14..=CHORD_MM).contains(&cut), "{contour:?}: {cut}");
                assert!(a.perp_dot(*b) > 0.0);
            }
            let lost = contour.area() - area(&corners);
            let rounded = contour.area() < 100.0 || corners.len() > 4;
            assert!((-1e-12..60.0 * CHORD_MM).contains(&lost), "{contour:?}: {lost}");
            assert_eq!(lost > 1e-6, rounded, "{contour:?}: {lost}");
        }
        let Contour::Rect { .. } = contours()[4] else { panic!() };
        assert_eq!(contours()[4].polygon().len(), circle(5.0).len());
        assert_eq!(contours()[1].polygon().len(), 4);
    }

    /// Corners of a shrunk polygon are as far inside as they should be, and next to their own.
    #[test]
    fn shrunk_contours_are_parallel_and_have_as_many_corners() {
        for contour in contours() {
            let (own, shrunk) = (contour.polygon(), contour.shrunk_polygon(1.5));
            assert_eq!(own.len(), shrunk.len(), "{contour:?}");
            let mitre = if contour == contours()[1] { f64::sqrt(2.0) } else { 1.0 };
            for (a, b) in own.iter().zip(&shrunk) {
                assert!((contour.inset(*b) - 1.5).abs() < 1e-14, "{contour:?} {b}");
                assert!(contour.shrunk(1.5).inset(*b).abs() < 1e-14, "{contour:?} {b}");
                assert!((a.distance(*b) - 1.5 * mitre).abs() < 1e-14, "{contour:?} {a} {b}");
            }
        }
    }

    /// Distances from a chamfer against the nearest of many places on it.
    #[test]
    fn distances_from_chamfers_are_those_of_their_nearest_places() {
        let leg = 1.25;
        for contour in contours() {
            // Rings of places on the chamfer, straight pieces in steps, mitres included.
            let mut places: Vec<DVec3> = Vec::new();
            for k in 0..=100 {
                let share = f64::from(k) / 100.0 * leg;
                let ring = contour.shrunk_polygon(share);
                let next = ring.iter().cycle().skip(1);
                for (a, b) in ring.iter().zip(next) {
                    let steps = (a.distance(*b) / 0.05).ceil();
                    let at = |j: u32| a.lerp(*b, f64::from(j) / steps).extend(leg - share);
                    places.extend((0..steps as u32).map(at));
                }
            }
            for (x, y, height) in [
                (0.0, 4.5, 0.5),
                (6.8, 3.0, 0.2),
                (8.7, 4.8, 1.1),
                (-9.5, 5.25, 1.5),
                (9.0, -5.0, -0.5),
                (8.5, 6.0, 0.0),
                (3.0, -6.5, -1.0),
                (-8.2, -4.1, -0.3),
                (5.0, 5.0, 2.0),
            ] {
                let (p, v) = (DVec2::new(x, y), DVec3::new(x, y, height));
                let near = places.iter().map(|at| at.distance(v)).fold(f64::INFINITY, f64::min);
                let found = contour.chamfer_distance(p, height, leg);
                // Places are up to 0.025 and 0.01 mm beside the nearest one, and chords 2 um inside the chamfer.
                let most = (found * found + 0.025 * 0.025 + 0.01 * 0.01).sqrt() + CHORD_MM;
                let least = found - CHORD_MM;
                assert!((least..=most).contains(&near), "{contour:?} {v}: {found}, not {near}");
            }
            for place in places.iter().step_by(97) {
                let off = contour.chamfer_distance(place.truncate(), place.z, leg);
                assert!(off <= CHORD_MM, "{contour:?} {place}: {off}");
            }
        }
    }
}
