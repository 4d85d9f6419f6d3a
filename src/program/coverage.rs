//! How the cutting moves of a program cover a rectangle: their direction, and how far apart they are.

use super::ToolMove;
use crate::geom::{DVec2, Rect};
use crate::num::{atan2, cos, sin};
use std::f64::consts::TAU;

/// Share by which the distance of even lines may differ from the mean one: ways from line to line, and lines that end beside
/// the face, make that too small or too large by some per cent.
const SPREAD: f64 = 0.12;
/// Distances that are tried for one by which all lines together would shift by one.
const TRIES: f64 = 8.0;
/// Times that the best distance is looked at more closely, and tries to each of its sides.
const ZOOMS: usize = 3;
const CLOSER: usize = 8;
/// Share of their length that even lines have in step, at least. The others are not even.
const IN_STEP: f64 = 0.5;

/// The cutting moves over a rectangle of the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathCoverage {
    /// Their length in the plan, mm.
    pub length_mm: f64,
    /// Distance from line to line, mm: that of even lines, else the mean one, the area over the length.
    pub apart_mm: f64,
    /// Place across their direction (mm) of one of them, where they are even.
    pub line_mm: f64,
    /// The direction that most of them have, from X towards Y, radians; that of half a turn more is the same.
    pub angle: f64,
    /// How much they agree in it: 1 of parallel moves, 0 of those that turn around evenly.
    pub parallel: f64,
}

impl PathCoverage {
    /// Of the cutting ones among `moves`, one of `every` of a program, whose middle is between two corners; none where there is
    /// none.
    #[must_use]
    pub fn new(moves: &[ToolMove], every: usize, [min, max]: [DVec2; 2]) -> Option<Self> {
        let face = Rect { min, max };
        let (mut length_mm, mut double) = (0.0, DVec2::ZERO);
        let mut middles = Vec::new();
        for step in moves.iter().filter(|step| step.feed.is_some()) {
            let [from, to] = [step.from, step.to].map(|p| p.truncate());
            let way = to - from;
            let length = way.length();
            if length > 0.0 && face.contains(0.5 * (from + to)) {
                length_mm += length;
                middles.push((0.5 * (from + to), length));
                // The direction's angle twice, so that there and back are one.
                double += DVec2::new(way.x * way.x - way.y * way.y, 2.0 * way.x * way.y) / length;
            }
        }
        if length_mm == 0.0 {
            return None;
        }
        let angle = 0.5 * atan2(double.y, double.x);
        let across = DVec2::new(-sin(angle), cos(angle));
        let places: Vec<_> = middles.iter().map(|(p, length)| (across.dot(*p), *length)).collect();
        let mean_mm = face.area() / (length_mm * every as f64);
        let [apart_mm, line_mm] = even_lines(&places, mean_mm).unwrap_or([mean_mm, 0.0]);
        Some(Self { length_mm, apart_mm, line_mm, angle, parallel: double.length() / length_mm })
    }
}

/// The distance of even lines, near `mean_mm`, and the place of one of them, mm, from places across them (mm) and lengths
/// there; none where they are not even. The distance is the one of the largest |sum of length e^(2 pi i place / distance)|,
/// the places' periodogram; the sum's angle tells where the lines are.
fn even_lines(places: &[(f64, f64)], mean_mm: f64) -> Option<[f64; 2]> {
    let ends = places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], (y, _)| {
        [low.min(*y), high.max(*y)]
    });
    let [low, extent] = [ends[0], ends[1] - ends[0]];
    if !(extent > mean_mm) {
        return None;
    }
    let best = |first: f64, step: f64, count: usize| {
        let sums = sums_in_step(places, low, [first, step], count);
        let size = |k: usize| sums[k].length_squared();
        let largest = (0..count).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0);
        (first + step * largest as f64, sums[largest])
    };
    let [least, most] = [1.0 / (1.0 + SPREAD), 1.0 / (1.0 - SPREAD)].map(|times| times / mean_mm);
    let mut step = 1.0 / (TRIES * extent);
    let (mut found, mut sum) = best(least, step, ((most - least) / step).ceil() as usize + 1);
    for _ in 0..ZOOMS {
        let closer = step / CLOSER as f64;
        (found, sum) = best(found - step, closer, 2 * CLOSER + 1);
        step = closer;
    }
    let total: f64 = places.iter().map(|(_, length)| length).sum();
    let phase = atan2(sum.y, sum.x) / TAU;
    (sum.length() > IN_STEP * total).then(|| [1.0 / found, low + phase / found])
}

/// The sum of length e^(2 pi i place frequency) for `count` frequencies (1/mm) from the first on in equal steps, for places from
/// `low` on.
fn sums_in_step(
    places: &[(f64, f64)],
    low: f64,
    [first, step]: [f64; 2],
    count: usize,
) -> Vec<DVec2> {
    let turn = |angle: f64| DVec2::new(cos(angle), sin(angle));
    let mut sums = vec![DVec2::ZERO; count];
    for &(y, length) in places {
        let mut at = length * turn(TAU * first * (y - low));
        let by = turn(TAU * step * (y - low));
        for sum in &mut sums {
            *sum += at;
            at = by.rotate(at);
        }
    }
    sums
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
            let all = lines(degrees, apart);
            let found = PathCoverage::new(&all, 1, corners).unwrap();
            let off = sin(found.angle - radians(degrees));
            assert!(off.abs() < 1e-12, "{degrees}: {}", found.angle);
            assert!((found.apart_mm / apart - 1.0).abs() < 1e-4, "{degrees}: {}", found.apart_mm);
            assert!((found.parallel - 1.0).abs() < 1e-12);
            // One of them goes through the origin.
            let lines_off = found.line_mm / found.apart_mm;
            assert!((lines_off - lines_off.round()).abs() < 1e-3, "{degrees}: {}", found.line_mm);
            let some: Vec<_> = all.into_iter().step_by(7).collect();
            let found = PathCoverage::new(&some, 7, corners).unwrap();
            assert!((found.apart_mm / apart - 1.0).abs() < 1e-4, "{degrees}: {}", found.apart_mm);
        }
        let both = [lines(0.0, 0.4), lines(90.0, 0.4)].concat();
        let corners = [DVec2::splat(-5.0), DVec2::splat(5.0)];
        assert!(PathCoverage::new(&both, 1, corners).unwrap().parallel < 0.02);
        assert_eq!(PathCoverage::new(&both, 1, [DVec2::splat(90.0), DVec2::splat(91.0)]), None);
    }
}
