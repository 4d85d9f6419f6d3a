//! How the cutting moves of a program go around the axis of the part: whether they are its turns, and how far apart.

use super::ToolMove;
use std::f64::consts::PI;

/// The cutting moves over a ring about X0 Y0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnCoverage {
    /// Distance of the turns, mm: the area over the length, which is that of even ones.
    pub apart_mm: f64,
    /// How much the moves go around: 1 of circles, -1 of spokes, 0 of parallel lines.
    pub around: f64,
}

impl TurnCoverage {
    /// Of the cutting ones among `moves`, one of `every` of a program, whose middle is between two distances from the axis, mm; none where
    /// there is none.
    #[must_use]
    pub fn new(moves: &[ToolMove], every: usize, [inner, outer]: [f64; 2]) -> Option<Self> {
        let (mut length_mm, mut around) = (0.0, 0.0);
        for step in moves.iter().filter(|step| step.feed.is_some()) {
            let [from, to] = [step.from, step.to].map(|p| p.truncate());
            let (way, middle) = (to - from, 0.5 * (from + to));
            let (length, radius) = (way.length(), middle.length());
            if length > 0.0 && radius > 0.0 && (inner..=outer).contains(&radius) {
                length_mm += length;
                let across = way.dot(middle) / (length * radius);
                around += length * (1.0 - 2.0 * across * across);
            }
        }
        let area = PI * (outer * outer - inner * inner);
        let apart_mm = area / (length_mm * every as f64);
        (length_mm > 0.0).then(|| Self { apart_mm, around: around / length_mm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec2, DVec3};
    use crate::num::{cos, sin};

    fn moves(places: &[DVec3]) -> Vec<ToolMove> {
        let step =
            |pair: &[DVec3]| ToolMove { from: pair[0], to: pair[1], feed: Some(1.0), line: 1 };
        places.windows(2).map(step).collect()
    }

    /// Of a spiral from beyond the rim to the axis each turn is as far from the next as it says; lines are no turns.
    #[test]
    fn turns_are_told_from_lines_and_have_their_distance() {
        let at = |angle: f64| {
            let radius = 10.5 - 0.25 * angle / (2.0 * PI);
            (radius * DVec2::new(cos(angle), sin(angle))).extend(1.0)
        };
        let spiral: Vec<DVec3> = (0..=4200).map(|k| at(2.0 * PI * f64::from(k) / 100.0)).collect();
        let spiral = moves(&spiral);
        for inner in [0.0, 4.0] {
            let found = TurnCoverage::new(&spiral, 1, [inner, 10.0]).unwrap();
            assert!((found.apart_mm / 0.25 - 1.0).abs() < 5e-3, "{inner}: {found:?}");
            assert!(found.around > 0.995, "{inner}: {found:?}");
        }
        let some: Vec<ToolMove> = spiral.iter().step_by(3).copied().collect();
        let found = TurnCoverage::new(&some, 3, [0.0, 10.0]).unwrap();
        assert!((found.apart_mm / 0.25 - 1.0).abs() < 5e-3, "{found:?}");
        let line = |k: i32| {
            let y = 0.25 * f64::from(k);
            let place = |n: i32| DVec3::new(0.1 * f64::from(n), y, 1.0);
            moves(&(-100..=100).map(place).collect::<Vec<_>>())
        };
        let lines: Vec<ToolMove> = (-40..=40).flat_map(line).collect();
        let found = TurnCoverage::new(&lines, 1, [0.0, 10.0]).unwrap();
        assert!(found.around.abs() < 0.05, "{found:?}");
        assert_eq!(TurnCoverage::new(&lines, 1, [50.0, 60.0]), None);
    }
}
