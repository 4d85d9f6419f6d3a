//! Time that a machine takes for moves, with its starts, stops and corners.
//!
//! Each move speeds up and slows down at the machine's acceleration a between the speeds at its two ends, and goes no faster than
//! its feed. Through a corner that turns the direction by the angle t the speed is that at which an arc that stays within `d` of
//! the corner has a centripetal acceleration of a: `v^2 = a d s / (1 - s)`, where s is the sine of half the angle between the two
//! moves, so that s = cos(t / 2) (S. K. Jeon's corners, which grbl takes, with d = 0.01 mm). At the program's ends the speed is 0.
//! Where a move turns back, the speed is 0 too. With a jerk j the control takes the mean of its speeds over a / j, by which each stop
//! is later: a move from rest to rest over the length l at its feed v takes l / v + v / a + a / j. From v = a^2 / j on that is the time
//! of S-shaped ramps; a slower move would take 2 sqrt(v / j) in the place of the last two terms, which is less.
//! Two passes over the moves, backwards and forwards, hold the speeds at corners to what can be reached and stopped from.

use super::ToolMove;

/// What an axis can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineLimits {
    /// Speed of rapid moves, mm/min.
    pub rapid_mm_min: f64,
    /// Acceleration, mm/s^2.
    pub acceleration_mm_s2: f64,
    /// Jerk, mm/s^3; none for any.
    pub jerk_mm_s3: Option<f64>,
}

/// Where the time of moves goes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MachineTime {
    /// At the feeds, minutes.
    pub at_feed_min: f64,
    /// Speeding up, slowing down and in corners of cutting moves, minutes.
    pub changing_min: f64,
    /// Rapid moves with their starts and stops, minutes.
    pub rapid_min: f64,
    /// Mean speed in equal parts of the time, mm/min; none of a program without a move.
    pub speeds_mm_min: Vec<f64>,
}

impl MachineTime {
    /// All of it, minutes.
    #[must_use]
    pub fn minutes(&self) -> f64 {
        self.at_feed_min + self.changing_min + self.rapid_min
    }
}

/// Parts of the time of which speeds are told: each is seen in a plot.
const PARTS: usize = 220;

/// How far the arc that gives a corner its speed is off the corner, mm: what grbl sets as it comes.
const CORNER_MM: f64 = 0.01;

/// Cosine of the angle between two moves from which on the second one goes back: what grbl takes.
const TURNS_BACK: f64 = -0.999_999;

impl MachineLimits {
    /// Time for `moves` one after the other.
    #[must_use]
    pub fn time(&self, moves: &[ToolMove]) -> MachineTime {
        let moves: Vec<&ToolMove> = moves.iter().filter(|step| step.from != step.to).collect();
        let speeds = self.corner_speeds(&moves);
        let (mut seconds, mut way) = (0.0, 0.0);
        let [mut at_feed, mut changing, mut rapid] = [0.0; 3];
        let mut reached = vec![[0.0; 2]];
        for (step, ends) in moves.iter().zip(speeds.windows(2)) {
            let length = step.from.distance(step.to);
            let ends = [ends[0], ends[1]];
            let [even, mut ramps] = phases(length, self.speed(step), ends, self.acceleration_mm_s2);
            if ends[1] == 0.0 {
                ramps += self.smoothing_s();
            }
            match step.feed {
                Some(_) => {
                    at_feed += even;
                    changing += ramps;
                }
                None => rapid += even + ramps,
            }
            seconds += even + ramps;
            way += length;
            reached.push([seconds, way]);
        }
        let [at_feed_min, changing_min, rapid_min] = [at_feed, changing, rapid].map(|s| s / 60.0);
        MachineTime { at_feed_min, changing_min, rapid_min, speeds_mm_min: mean_speeds(&reached) }
    }

    /// Time for `moves` of which each cutting one takes the minutes that it is told, at whatever speed.
    #[must_use]
    pub fn told_time(&self, moves: &[ToolMove], minutes: &[f64]) -> MachineTime {
        let mut found = MachineTime::default();
        let mut reached = vec![[0.0; 2]];
        let (mut seconds, mut way) = (0.0, 0.0);
        for (step, &minutes) in moves.iter().zip(minutes) {
            let length = step.from.distance(step.to);
            let rapid_min = match step.feed {
                Some(_) => 0.0,
                None if length == 0.0 => 0.0,
                None => {
                    let limit = self.rapid_mm_min / 60.0;
                    let parts = phases(length, limit, [0.0; 2], self.acceleration_mm_s2);
                    (parts.iter().sum::<f64>() + self.smoothing_s()) / 60.0
                }
            };
            found.at_feed_min += minutes;
            found.rapid_min += rapid_min;
            seconds += 60.0 * (minutes + rapid_min);
            way += length;
            reached.push([seconds, way]);
        }
        found.speeds_mm_min = mean_speeds(&reached);
        found
    }

    /// Time over which the control takes the mean of its speeds, seconds: by which each stop is later.
    fn smoothing_s(&self) -> f64 {
        self.jerk_mm_s3.map_or(0.0, |jerk| self.acceleration_mm_s2 / jerk)
    }

    /// Speed of a move where it is fastest, mm/s.
    fn speed(&self, step: &ToolMove) -> f64 {
        step.feed.unwrap_or(self.rapid_mm_min) / 60.0
    }

    /// Speeds at the beginning of each move and at the end of the last, mm/s.
    fn corner_speeds(&self, moves: &[&ToolMove]) -> Vec<f64> {
        let acceleration = self.acceleration_mm_s2;
        let mut speeds = vec![0.0; moves.len() + 1];
        for (k, pair) in moves.windows(2).enumerate() {
            let [before, after] = [pair[0], pair[1]];
            let [along, on] = [before, after].map(|step| (step.to - step.from).normalize());
            let cosine = along.dot(on).clamp(-1.0, 1.0);
            let half = (0.5 * (1.0 + cosine)).sqrt();
            let corner = (acceleration * CORNER_MM * half / (1.0 - half)).sqrt();
            // (Straight on there is no corner.)
            let corner = if half < 1.0 { corner } else { f64::INFINITY };
            let corner = if cosine > TURNS_BACK { corner } else { 0.0 };
            speeds[k + 1] = corner.min(self.speed(before)).min(self.speed(after));
        }
        let reached = |speed: f64, step: &ToolMove| {
            (speed * speed + 2.0 * acceleration * step.from.distance(step.to)).sqrt()
        };
        for (k, step) in moves.iter().enumerate().rev() {
            speeds[k] = speeds[k].min(reached(speeds[k + 1], step));
        }
        for (k, step) in moves.iter().enumerate() {
            speeds[k + 1] = speeds[k + 1].min(reached(speeds[k], step));
        }
        speeds
    }
}

/// Seconds of a move of a length, mm, between two speeds and at most at a third, mm/s: at an even speed, and speeding up and
/// slowing down.
fn phases(length: f64, speed: f64, [from, to]: [f64; 2], acceleration: f64) -> [f64; 2] {
    // The speed at which it would turn from faster to slower, if it may be so fast.
    let turn = (acceleration * length + 0.5 * (from * from + to * to)).sqrt();
    let most = turn.min(speed).max(from).max(to);
    let slopes = 2.0 * most * most - from * from - to * to;
    let even = (length - slopes / (2.0 * acceleration)).max(0.0);
    [if most > 0.0 { even / most } else { 0.0 }, (2.0 * most - from - to) / acceleration]
}

/// Mean speeds, mm/min, in equal parts of the time of moves that reach these seconds and mm of the way, the first none of both.
fn mean_speeds(reached: &[[f64; 2]]) -> Vec<f64> {
    let Some(&[whole, _]) = reached.last().filter(|[whole, _]| *whole > 0.0) else {
        return Vec::new();
    };
    let part = whole / PARTS as f64;
    let mut k = 0;
    let mut way_after = |seconds: f64| {
        while k + 2 < reached.len() && reached[k + 1][0] < seconds {
            k += 1;
        }
        let [[from, before], [to, after]] = [reached[k], reached[k + 1]];
        let share = if to > from { ((seconds - from) / (to - from)).min(1.0) } else { 1.0 };
        before + share * (after - before)
    };
    let ways: Vec<f64> = (0..=PARTS).map(|k| way_after(part * k as f64)).collect();
    ways.windows(2).map(|pair| 60.0 * (pair[1] - pair[0]) / part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;

    const LIMITS: MachineLimits =
        MachineLimits { rapid_mm_min: 6000.0, acceleration_mm_s2: 500.0, jerk_mm_s3: None };

    fn minutes(moves: &[ToolMove]) -> f64 {
        LIMITS.time(moves).minutes()
    }

    fn path(places: &[DVec3], feed: f64) -> Vec<ToolMove> {
        places
            .windows(2)
            .map(|pair| ToolMove { from: pair[0], to: pair[1], feed: Some(feed), line: 1 })
            .collect()
    }

    #[test]
    fn a_single_move_is_a_trapezoid() {
        // 10 mm/s after 0.02 s and 0.1 mm, and the same at its end.
        let long = path(&[DVec3::ZERO, DVec3::X * 10.0], 600.0);
        assert!((60.0 * minutes(&long) - (0.04 + 9.8 / 10.0)).abs() < 1e-12);
        // Never as fast as that: 2 sqrt(l / a).
        let short = path(&[DVec3::ZERO, DVec3::X * 0.1], 600.0);
        assert!((60.0 * minutes(&short) - 2.0 * f64::sqrt(0.1 / 500.0)).abs() < 1e-12);
        let there_and_back = path(&[DVec3::ZERO, DVec3::X * 10.0, DVec3::ZERO], 600.0);
        assert!((minutes(&there_and_back) - 2.0 * minutes(&long)).abs() < 1e-12);
    }

    /// Of a cut of 10 mm at 10 mm/s, whose acceleration is built up in 0.01 s: the time of the S-shaped ramps, integrated from the jerk, and
    /// once more for each stop on the way.
    #[test]
    fn a_jerk_makes_each_stop_later() {
        let limits = MachineLimits { jerk_mm_s3: Some(50_000.0), ..LIMITS };
        let long = path(&[DVec3::ZERO, DVec3::X * 10.0], 600.0);
        let (tick, [build_up, ramp]) = (1e-6, [0.01, 0.02]);
        let (mut way, mut speed, mut time) = (0.0, 0.0, 0.0);
        while speed < 10.0 - 1e-9 {
            let acceleration = (50_000.0 * f64::min(time, build_up + ramp - time)).min(500.0);
            speed += tick * acceleration;
            way += tick * speed;
            time += tick;
        }
        let found = 60.0 * limits.time(&long).minutes();
        assert!((found - (2.0 * time + (10.0 - 2.0 * way) / 10.0)).abs() < 1e-4, "{found}");
        assert!((found - (60.0 * minutes(&long) + 0.01)).abs() < 1e-12);
        let oblique = DVec3::new(3.0, 7.0, 1.3).normalize() * 10.0;
        let there_and_back = path(&[DVec3::ZERO, oblique, DVec3::ZERO], 600.0);
        let on = path(&[DVec3::ZERO, DVec3::X * 3.0, DVec3::X * 10.0], 600.0);
        let time = |moves: &[ToolMove]| 60.0 * limits.time(moves).minutes();
        assert!((time(&there_and_back) - 2.0 * found).abs() < 1e-12);
        assert!((time(&on) - found).abs() < 1e-12);
        let mut rapid = path(&[DVec3::ZERO, DVec3::X * 10.0, DVec3::X * 10.0], 600.0);
        rapid.iter_mut().for_each(|step| step.feed = None);
        let told = 60.0 * limits.told_time(&rapid, &[0.0; 2]).minutes();
        assert!((told - (2.0 * f64::sqrt(10.0 / 500.0) + 0.01)).abs() < 1e-12);
    }

    /// Of a cut of 10 mm at 10 mm/s, which takes 0.02 s and 0.1 mm to speed up and to slow down, and the rapid way back.
    #[test]
    fn the_time_is_divided_into_feed_changes_and_rapid_moves() {
        let mut moves = path(&[DVec3::ZERO, DVec3::X * 10.0, DVec3::ZERO], 600.0);
        moves[1].feed = None;
        let found = LIMITS.time(&moves);
        let seconds =
            [found.at_feed_min, found.changing_min, found.rapid_min].map(|min| 60.0 * min);
        // (10 mm are too short for 100 mm/s.)
        let expected = [0.98, 0.04, 2.0 * f64::sqrt(10.0 / 500.0)];
        for (found, expected) in seconds.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{seconds:?}");
        }
        assert_eq!(found.speeds_mm_min.len(), PARTS);
        let mean = found.speeds_mm_min.iter().sum::<f64>() / PARTS as f64;
        assert!((mean - 20.0 / found.minutes()).abs() < 1e-9, "{mean}");
        assert!((found.speeds_mm_min[PARTS / 2] - 10.0 / (1.02 / 60.0)).abs() < 1e-9);
        assert_eq!(LIMITS.time(&[]), MachineTime::default());
    }

    /// A cut of 3 mm that is told to take half a minute, and 10 mm of a rapid move from rest to rest.
    #[test]
    fn told_times_are_taken_as_they_are() {
        let mut moves = path(&[DVec3::ZERO, DVec3::X * 3.0, DVec3::X * 13.0], 600.0);
        moves[1].feed = None;
        let found = LIMITS.told_time(&moves, &[0.5, 0.0]);
        assert_eq!((found.at_feed_min, found.changing_min), (0.5, 0.0));
        assert!((60.0 * found.rapid_min - 2.0 * f64::sqrt(10.0 / 500.0)).abs() < 1e-12);
        let mean = found.speeds_mm_min.iter().sum::<f64>() / PARTS as f64;
        assert!((mean - 13.0 / found.minutes()).abs() < 1e-9, "{mean}");
    }

    /// The speed over each place of the path is the least that the feed and every corner before and after it allow; its inverse,
    /// integrated in small steps, is the time.
    #[test]
    fn the_time_is_the_integral_over_the_path() {
        let corner = |k: i32| {
            let x = 0.7 * f64::from(k);
            DVec3::new(x, (1.3 * x).rem_euclid(2.0), 0.1 * (x * 0.77).rem_euclid(1.5))
        };
        let places: Vec<DVec3> = (0..120).map(corner).collect();
        let moves = path(&places, 1500.0);
        let refs: Vec<&ToolMove> = moves.iter().collect();
        let corners: Vec<f64> = (0..moves.len() + 1)
            .map(|k| {
                if k == 0 || k == moves.len() {
                    return 0.0;
                }
                let [a, b] = [k - 1, k].map(|k| (moves[k].to - moves[k].from).normalize());
                let s = (0.5 * (1.0 + a.dot(b))).sqrt();
                (500.0 * 0.01 * s / (1.0 - s)).sqrt()
            })
            .collect();
        assert_eq!(refs.len(), 119);
        let mut marks = vec![0.0];
        for step in &moves {
            marks.push(marks[marks.len() - 1] + step.from.distance(step.to));
        }
        let whole = marks[marks.len() - 1];
        let count = 400_000;
        let step = whole / f64::from(count);
        let mut time = 0.0;
        for k in 0..count {
            let at = (f64::from(k) + 0.5) * step;
            let allowed = marks
                .iter()
                .zip(&corners)
                .map(|(mark, speed)| (speed * speed + 2.0 * 500.0 * (at - mark).abs()).sqrt());
            time += step / allowed.fold(25.0, f64::min);
        }
        let found = 60.0 * minutes(&moves);
        assert!((found / time - 1.0).abs() < 2e-3, "{found} {time}");
    }
}
