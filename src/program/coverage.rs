//! How the cutting moves of a program cover a rectangle: their direction, and how far apart they are.

use super::ToolMove;
use crate::geom::{DVec2, Rect};
use crate::num::atan2;

/// The cutting moves over a rectangle of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathCoverage {
    /// Their length in the plan, mm.
    pub length_mm: f64,
    /// Mean distance from line to line, mm: the area over the length.
    pub apart_mm: f64,
    /// The direction that most of them have, from X towards Y, radians; that of half a turn more is the same.
    pub angle: f64,
    /// How much they agree in it: 1 of parallel moves, 0 of those that turn around evenly.
    pub parallel: f64,
}

impl PathCoverage {
    /// Of the cutting ones among `moves` whose middle is between two corners; none where there is none.
    #[must_use]
    pub fn new(moves: &[ToolMove], [min, max]: [DVec2; 2]) -> Option<Self> {
        let face = Rect { min, max };
        let (mut length_mm, mut double) = (0.0, DVec2::ZERO);
        for step in moves.iter().filter(|step| step.feed.is_some()) {
            let [from, to] = [step.from, step.to].map(|p| p.truncate());
            let way = to - from;
            let length = way.length();
            if length > 0.0 && face.contains(0.5 * (from + to)) {
                length_mm += length;
                // The direction's angle twice, so that there and back are one.
                double += DVec2::new(way.x * way.x - way.y * way.y, 2.0 * way.x * way.y) / length;
            }
        }
        (length_mm > 0.0).then(|| Self {
            length_mm,
            apart_mm: face.area() / length_mm,
            angle: 0.5 * atan2(double.y, double.x),
            parallel: double.length() / length_mm,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::num::{cos, radians, sin};

    fn lines(degrees: f64, apart: f64) -> Vec<ToolMove> {
        let along = DVec2::new(cos(radians(degrees)), sin(radians(degrees)));
        let line = |k: i32| {
            let foot = along.perp() * (f64::from(k) * apart);
            let ends = [-30.0, 30.0].map(|t: f64| (foot + along * t).extend(1.0));
            let [from, to] = if k % 2 == 0 { ends } else { [ends[1], ends[0]] };
            let cut = (0..200).map(move |n| {
                let place = |n: i32| from.lerp(to, f64::from(n) / 200.0);
                ToolMove { from: place(n), to: place(n + 1), feed: Some(1.0), line: 1 }
            });
            let over = ToolMove { from: to, to: DVec3::ZERO, feed: None, line: 2 };
            cut.chain([over])
        };
        (-60..=60).flat_map(line).collect()
    }

    #[test]
    fn lines_tell_their_direction_and_distance() {
        for (degrees, apart) in [(0.0, 0.4), (90.0, 0.5), (30.0, 0.3), (-70.0, 0.25)] {
            let corners = [DVec2::splat(-5.0), DVec2::splat(5.0)];
            let found = PathCoverage::new(&lines(degrees, apart), corners).unwrap();
            let off = sin(found.angle - radians(degrees));
            assert!(off.abs() < 1e-12, "{degrees}: {}", found.angle);
            assert!((found.apart_mm / apart - 1.0).abs() < 0.08, "{degrees}: {}", found.apart_mm);
            assert!((found.parallel - 1.0).abs() < 1e-12);
        }
        let both = [lines(0.0, 0.4), lines(90.0, 0.4)].concat();
        let corners = [DVec2::splat(-5.0), DVec2::splat(5.0)];
        assert!(PathCoverage::new(&both, corners).unwrap().parallel < 0.02);
        assert_eq!(PathCoverage::new(&both, [DVec2::splat(90.0), DVec2::splat(91.0)]), None);
    }
}
