//! Points of a slow tool servo at even steps of C, with lifts between cuts, and the speed that the machine can follow.

use super::TurningError;
use super::nose_heights::NoseHeights;
use crate::geom::DVec2;
use crate::num::rounding::floor_four_digits;
use serde::Serialize;

/// Places of a point that are written, to a millimetre: a nanometre, so that their rounding shakes no axis.
const ROUNDING: f64 = 1e6;
/// Largest second derivative of `10 s^3 - 15 s^4 + 6 s^5`, by which lifts begin and end at rest.
const STEP_SECOND: f64 = 5.78;
/// Largest acceleration of a lift over that of a cut, to which it adds.
const LIFT_SHARE: f64 = 0.5;
/// Most turns of a lift.
const MOST_TURNS: f64 = 64.0;

/// Points of a tool at even steps of C, from 0 on.
#[derive(Debug, Clone, PartialEq)]
pub struct PointTable {
    /// X and Z of the tool point, mm.
    pub points: Vec<DVec2>,
    /// Points of a turn of C.
    pub per_turn: usize,
}

/// What holds the speed of C down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ServoLimit {
    /// The acceleration of X and Z.
    Acceleration,
    /// Their speed.
    Speed,
    /// The speed of C that the profile names, the material has, or the machine can.
    Spindle,
}

/// What a machine's axes can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisLimits {
    /// Acceleration of X and Z, mm/s^2.
    pub acceleration_mm_s2: f64,
    /// Their speed, mm/min.
    pub speed_mm_min: f64,
    /// Largest speed of C, 1/min.
    pub spindle_rpm: f64,
}

impl PointTable {
    /// Largest first and second difference quotients of X and Z by turns of C, mm.
    #[must_use]
    pub fn derivatives_mm(&self) -> [f64; 2] {
        let n = self.per_turn as f64;
        let largest = |found: f64, at: DVec2| found.max(at.x.abs()).max(at.y.abs());
        let first = self.points.windows(2).map(|p| p[1] - p[0]).fold(0.0, largest);
        [n * first, n * n * bend(&self.points)]
    }

    /// The largest speed of C, 1/min, at which an axis stays within its limits, and which of them holds it.
    pub(super) fn speed(&self, limits: &AxisLimits) -> (f64, ServoLimit) {
        let [first, second] = self.derivatives_mm();
        let all = [
            (limits.spindle_rpm, ServoLimit::Spindle),
            (60.0 * f64::sqrt(limits.acceleration_mm_s2 / second), ServoLimit::Acceleration),
            (limits.speed_mm_min / first, ServoLimit::Speed),
        ];
        let least = all.into_iter().reduce(|a, b| if b.0 < a.0 { b } else { a });
        let (rpm, limit) = least.unwrap_or(all[0]);
        (floor_four_digits(rpm), limit)
    }
}

/// Largest second difference of X and Z, mm.
pub(super) fn bend(points: &[DVec2]) -> f64 {
    let second = points.windows(3).map(|p| p[2] - 2.0 * p[1] + p[0]);
    second.fold(0.0, |found: f64, at| found.max(at.x.abs()).max(at.y.abs()))
}

/// A cut along a part of a spiral.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpiralCut<'s> {
    /// Places of the nose's centre, mm.
    pub places: &'s [DVec2],
    /// Number of the azimuth of the first.
    pub first: usize,
    /// How much higher than these it goes, mm.
    pub lift_mm: f64,
}

/// A table in the making: cuts, between which the tool is lifted while C goes on.
pub(super) struct TableBuilder<'a> {
    heights: &'a NoseHeights<'a>,
    /// Z of the centre where X moves fast, mm.
    safe_mm: f64,
    /// Second derivative by turns that lifts may have, mm.
    second_mm: f64,
    centres: Vec<DVec2>,
}

impl<'a> TableBuilder<'a> {
    /// A table without a point. Lifts have no more of a second derivative by turns of C than cuts, or than the machine can follow at its
    /// largest speed.
    pub(super) fn new(
        heights: &'a NoseHeights<'a>,
        safe_mm: f64,
        cut: &[DVec2],
        limits: &AxisLimits,
    ) -> Self {
        let n = heights.per_turn() as f64;
        let per_second = limits.spindle_rpm / 60.0;
        let allowed = limits.acceleration_mm_s2 / (per_second * per_second);
        let second_mm = LIFT_SHARE * allowed.max(n * n * bend(cut));
        Self { heights, safe_mm, second_mm, centres: Vec::new() }
    }

    /// Turns in which a way is gone from rest to rest.
    fn turns(&self, way_mm: f64) -> usize {
        let turns = f64::sqrt(STEP_SECOND * way_mm / self.second_mm).ceil();
        turns.clamp(1.0, MOST_TURNS) as usize
    }

    /// Goes over to a cut, along it, and up again.
    ///
    /// # Errors
    /// [`TurningError::NoSection`].
    pub(super) fn cut(&mut self, cut: &SpiralCut) -> Result<(), TurningError> {
        let (Some(&begin), Some(&end)) = (cut.places.first(), cut.places.last()) else {
            return Ok(());
        };
        let n = self.heights.per_turn();
        self.across(begin.x);
        // C is to be at the azimuth of the cut's first place.
        while self.centres.len() % n != cut.first % n {
            self.centres.push(DVec2::new(begin.x, self.safe_mm));
        }
        let way = |at: DVec2| (self.safe_mm - at.y - cut.lift_mm).abs();
        let [down, up] = [begin, end].map(|at| n * self.turns(way(at)));
        for j in 0..down {
            let share = smooth_step(j as f64 / down as f64);
            self.lifted(cut.first + j, begin.x, (cut.lift_mm, share))?;
        }
        self.centres.extend(cut.places.iter().map(|at| at + DVec2::Y * cut.lift_mm));
        let last = cut.first + cut.places.len() - 1;
        for j in 1..=up {
            let share = smooth_step(1.0 - j as f64 / up as f64);
            self.lifted(last + j, end.x, (cut.lift_mm, share))?;
        }
        Ok(())
    }

    /// A point between the height of fast moves and that of a cut at an azimuth.
    fn lifted(
        &mut self,
        azimuth: usize,
        x_mm: f64,
        (lift_mm, share): (f64, f64),
    ) -> Result<(), TurningError> {
        let z = self.heights.over(azimuth % self.heights.per_turn(), x_mm)? + lift_mm;
        self.centres.push(DVec2::new(x_mm, self.safe_mm + share * (z - self.safe_mm)));
        Ok(())
    }

    /// Over to a distance from the axis at the height of fast moves.
    fn across(&mut self, x_mm: f64) {
        let Some(from) = self.centres.last().map(|at| at.x) else { return };
        let count = self.heights.per_turn() * self.turns((x_mm - from).abs());
        for j in 1..=count {
            let x = from + (x_mm - from) * smooth_step(j as f64 / count as f64);
            self.centres.push(DVec2::new(x, self.safe_mm));
        }
    }

    /// The table of the tool point, which is a nose's radius nearer to the axis and lower than the centre.
    pub(super) fn finish(self, nose_mm: f64) -> PointTable {
        let written = |mm: f64| ((mm - nose_mm) * ROUNDING).round() / ROUNDING;
        let points = self.centres.iter().map(|at| DVec2::new(written(at.x), written(at.y)));
        PointTable { points: points.collect(), per_turn: self.heights.per_turn() }
    }
}

/// A way from 0 to 1 that begins and ends at rest, without a jump of the acceleration.
fn smooth_step(share: f64) -> f64 {
    share * share * share * (10.0 - share * (15.0 - 6.0 * share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::cos;
    use std::f64::consts::TAU;

    /// Z = A cos(m C) has Z'' = A (2 pi m)^2 by turns: the speed is sqrt(a / Z''), unless the axis is too slow or C.
    #[test]
    fn the_speed_is_the_largest_that_every_limit_allows() {
        let (n, amplitude, waves) = (720, 0.4, 2.0);
        let z = |k: usize| amplitude * cos(waves * TAU * k as f64 / n as f64);
        let points = (0..3 * n).map(|k| DVec2::new(5.0, z(k))).collect();
        let table = PointTable { points, per_turn: n };
        let rate = waves * TAU;
        let [first, second] = table.derivatives_mm();
        assert!((first / (amplitude * rate) - 1.0).abs() < 1e-4, "{first}");
        assert!((second / (amplitude * rate * rate) - 1.0).abs() < 1e-4, "{second}");
        let limits = |acceleration_mm_s2: f64, speed_mm_min: f64, spindle_rpm: f64| AxisLimits {
            acceleration_mm_s2,
            speed_mm_min,
            spindle_rpm,
        };
        let (rpm, limit) = table.speed(&limits(300.0, 1e6, 1e6));
        let exact = 60.0 * f64::sqrt(300.0 / (amplitude * rate * rate));
        assert!((rpm / exact - 1.0).abs() < 1e-3 && rpm < exact * 1.0001, "{rpm} {exact}");
        assert_eq!(limit, ServoLimit::Acceleration);
        let (rpm, limit) = table.speed(&limits(1e9, 1000.0, 1e6));
        assert!((rpm / (1000.0 / (amplitude * rate)) - 1.0).abs() < 1e-3, "{rpm}");
        assert_eq!(limit, ServoLimit::Speed);
        assert_eq!(table.speed(&limits(1e9, 1e6, 200.0)), (200.0, ServoLimit::Spindle));
    }

    #[test]
    fn ways_begin_and_end_at_rest() {
        let second =
            |s: f64| (smooth_step(s + 1e-4) - 2.0 * smooth_step(s) + smooth_step(s - 1e-4)) / 1e-8;
        let most = (1..1000).map(|k| second(f64::from(k) * 1e-3).abs()).fold(0.0, f64::max);
        assert!(most < STEP_SECOND && most > 0.99 * STEP_SECOND, "{most}");
        assert_eq!([smooth_step(0.0), smooth_step(0.5), smooth_step(1.0)], [0.0, 0.5, 1.0]);
        assert!(second(1e-4).abs() < 0.02);
    }
}
