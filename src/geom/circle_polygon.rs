//! Circles and arcs as polygons whose corners lie on them.

use super::DVec2;
use crate::num::{cos, sin};
use std::f64::consts::FRAC_PI_2;

/// The most by which the chords of a meshed circle cut inside it, mm. The chords' ends lie on
/// the circle.
pub const CHORD_MM: f64 = 2e-3;

/// Chords of a quarter of a circle that cut no more than [`CHORD_MM`].
pub(super) fn circle_chords(radius: f64) -> usize {
    // 1 - cos(t) <= t^2 / 2 for half a chord's angle t.
    (FRAC_PI_2 * f64::sqrt(radius / (8.0 * CHORD_MM))).ceil().max(2.0) as usize
}

/// A quarter of a circle from the X axis to the Y axis in so many chords, both ends included.
pub(super) fn arc_of(radius: f64, chords: usize) -> Vec<DVec2> {
    let at = |k: usize| {
        let angle = FRAC_PI_2 * k as f64 / chords as f64;
        radius * DVec2::new(cos(angle), sin(angle))
    };
    let between = (1..chords).map(at);
    [DVec2::new(radius, 0.0)].into_iter().chain(between).chain([DVec2::new(0.0, radius)]).collect()
}

/// The points after so many quarter turns, to the last bit.
pub(super) fn turned(points: &[DVec2], quarters: usize) -> impl Iterator<Item = DVec2> + '_ {
    points.iter().map(move |&p| (0..quarters).fold(p, |p, _| p.perp()) + DVec2::ZERO)
}

/// A circle about the origin as a polygon, counter-clockwise, its corners on it.
pub(super) fn circle(radius: f64) -> Vec<DVec2> {
    circle_of(radius, circle_chords(radius))
}

/// A circle about the origin as a polygon of four times so many chords, counter-clockwise, its corners on it.
pub(super) fn circle_of(radius: f64, chords: usize) -> Vec<DVec2> {
    let mut quarter = arc_of(radius, chords);
    quarter.pop();
    (0..4).flat_map(|k| turned(&quarter, k).collect::<Vec<_>>()).collect()
}

/// The area inside a polygon, mm^2.
pub(super) fn area(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| 0.5 * a.perp_dot(*b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chords_are_no_finer_than_needed() {
        for radius in [0.05, 0.5, 3.0, 40.0, 1e5] {
            let corners = circle(radius);
            let cut = radius - (0.5 * (corners[0] + corners[1])).length();
            assert!(cut <= CHORD_MM, "{radius}: {cut}");
            assert!(cut > 0.5 * CHORD_MM || corners.len() < 40, "{radius}: {cut}");
            assert_eq!(corners[corners.len() / 2], DVec2::new(-radius, 0.0));
        }
    }
}
