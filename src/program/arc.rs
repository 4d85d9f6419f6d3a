//! Arcs and helices as chords.

use crate::geom::{DVec2, DVec3};
use crate::num::{atan2, cos, sin};
use std::f64::consts::TAU;

/// Height of an arc over its chords, mm: a tenth of what controls resolve.
const CHORD_MM: f64 = 1e-5;
/// Most chords of an arc.
const MOST: usize = 100_000;
/// What the radii at both ends may differ by, mm: what numbers of three decimals leave of a centre and an end.
const OFF_MM: f64 = 0.005;

/// Plane of an arc: numbers of its axes in the order of a positive turn, and of the axis across.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ArcPlane(pub [usize; 3]);

impl ArcPlane {
    pub(super) const XY: Self = Self([0, 1, 2]);
    pub(super) const ZX: Self = Self([2, 0, 1]);
    pub(super) const YZ: Self = Self([1, 2, 0]);

    pub(super) fn flat(self, p: DVec3) -> DVec2 {
        let [x, y, _] = self.0;
        DVec2::new(p[x], p[y])
    }

    fn place(self, flat: DVec2, across: f64) -> DVec3 {
        let [x, y, z] = self.0;
        let mut p = DVec3::ZERO;
        (p[x], p[y], p[z]) = (flat.x, flat.y, across);
        p
    }
}

/// An arc or a helix from a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub plane: ArcPlane,
    pub is_clockwise: bool,
    pub from: DVec3,
    pub to: DVec3,
    /// Its centre in the plane, mm.
    pub centre: DVec2,
}

impl Arc {
    /// The centre of the arc with this radius, mm: of the shorter arc if it is positive, or else of the longer one.
    pub(super) fn centre_by_radius(
        plane: ArcPlane,
        is_clockwise: bool,
        [from, to]: [DVec3; 2],
        radius: f64,
    ) -> Result<DVec2, String> {
        let [from, to] = [from, to].map(|p| plane.flat(p));
        let chord = to - from;
        let half = 0.5 * chord.length();
        if half == 0.0 {
            return Err("R of an arc that ends where it begins tells no centre".into());
        }
        if radius.abs() < half - OFF_MM {
            return Err(format!(
                "R{radius} is less than half the distance of the arc's ends, {half}"
            ));
        }
        let rise = f64::sqrt((radius * radius - half * half).max(0.0));
        let side = if is_clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
        Ok(from + 0.5 * chord + side * rise * chord.perp() / (2.0 * half))
    }

    /// The ends of its chords, each after the one before.
    pub(super) fn chords(&self) -> Result<Vec<DVec3>, String> {
        let Self { plane, is_clockwise, from, to, centre } = *self;
        let [start, end] = [from, to].map(|p| plane.flat(p) - centre);
        let [radius, last] = [start, end].map(DVec2::length);
        if !(radius > 0.0) || (last - radius).abs() > OFF_MM.max(1e-3 * radius) {
            return Err(format!("an arc of radius {radius} at its start and {last} at its end"));
        }
        let sense = if is_clockwise { -1.0 } else { 1.0 };
        let turn = |p: DVec2| atan2(p.y, p.x);
        let mut angle = sense * (turn(end) - turn(start));
        // An arc that ends where it begins is a whole turn.
        if angle <= 1e-12 {
            angle += TAU;
        }
        // A chord over the angle a is r a^2 / 8 below its arc.
        let step = f64::sqrt(8.0 * CHORD_MM / radius.max(last)).min(0.5);
        let count = (angle / step).ceil().min(MOST as f64) as usize;
        let across = [from, to].map(|p| p[plane.0[2]]);
        let at = |k: usize| {
            if k == count {
                return to;
            }
            let share = k as f64 / count as f64;
            let (turn, radius) = (sense * share * angle, radius + share * (last - radius));
            let (c, s) = (cos(turn), sin(turn));
            let way = DVec2::new(c * start.x - s * start.y, s * start.x + c * start.y);
            let flat = centre + way * (radius / start.length());
            plane.place(flat, across[0] + share * (across[1] - across[0]))
        };
        Ok((1..=count).map(at).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_lie_on_the_arc_and_end_where_it_does() {
        for (plane, normal) in
            [(ArcPlane::XY, DVec3::Z), (ArcPlane::ZX, DVec3::Y), (ArcPlane::YZ, DVec3::X)]
        {
            for is_clockwise in [false, true] {
                let from = plane.place(DVec2::new(3.0, 0.0), 1.0);
                let to = plane.place(DVec2::new(0.0, 3.0), 5.0);
                let arc = Arc { plane, is_clockwise, from, to, centre: DVec2::ZERO };
                let chords = arc.chords().unwrap();
                assert_eq!(chords[chords.len() - 1], to);
                let share = if is_clockwise { 0.75 } else { 0.25 };
                let mut length = 0.0;
                let mut before = from;
                for &p in &chords {
                    assert!((plane.flat(p).length() - 3.0).abs() < 1e-14);
                    // Counter-clockwise is about the axis across.
                    let turn = plane.flat(before).perp_dot(plane.flat(p));
                    assert!((turn > 0.0) != is_clockwise);
                    let lies = before.cross(p).dot(normal) - turn;
                    assert!(lies.abs() < 1e-12);
                    length += (plane.flat(p) - plane.flat(before)).length();
                    before = p;
                }
                assert!((length / (share * TAU * 3.0) - 1.0).abs() < 1e-5, "{length}");
            }
        }
    }

    #[test]
    fn centres_by_radius_are_those_of_both_arcs() {
        let ends = [DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 2.0, 0.0)];
        let centre = |clockwise, radius| {
            Arc::centre_by_radius(ArcPlane::XY, clockwise, ends, radius).unwrap()
        };
        assert!(centre(false, 2.0).length() < 1e-12);
        assert!(centre(true, -2.0).length() < 1e-12);
        assert!((centre(true, 2.0) - DVec2::splat(2.0)).length() < 1e-12);
        assert!((centre(false, -2.0) - DVec2::splat(2.0)).length() < 1e-12);
        assert!(Arc::centre_by_radius(ArcPlane::XY, true, ends, 1.0).is_err());
        assert!(Arc::centre_by_radius(ArcPlane::XY, true, [ends[0]; 2], 1.0).is_err());
    }
}
