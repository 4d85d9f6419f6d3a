//! Time that a machine takes for moves, with its starts, stops and corners.
//!
//! Each move speeds up and slows down at the machine's acceleration a between the speeds at its two ends, and goes no faster than
//! its feed. Through a corner that turns the direction by the angle t the speed is that at which an arc that stays within `d` of
//! the corner has a centripetal acceleration of a: `v^2 = a d s / (1 - s)`, where s is the sine of half the angle between the two
//! moves, so that s = cos(t / 2) (S. K. Jeon's corners, which grbl takes, with d = 0.01 mm). At the program's ends the speed is 0.
//! Two passes over the moves, backwards and forwards, hold the speeds at corners to what can be reached and stopped from.

use super::ToolMove;

/// What an axis can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineLimits {
    /// Speed of rapid moves, mm/min.
    pub rapid_mm_min: f64,
    /// Acceleration, mm/s^2.
    pub acceleration_mm_s2: f64,
}

/// How far the arc that gives a corner its speed is off the corner, mm: what grbl sets as it comes.
const CORNER_MM: f64 = 0.01;

impl MachineLimits {
    /// Time for `moves` one after the other, minutes.
    #[must_use]
    pub fn minutes(&self, moves: &[ToolMove]) -> f64 {
        let moves: Vec<&ToolMove> = moves.iter().filter(|step| step.from != step.to).collect();
        let speeds = self.corner_speeds(&moves);
        let time = |(step, ends): (&&ToolMove, &[f64])| {
            seconds(
                step.from.distance(step.to),
                self.speed(step),
                [ends[0], ends[1]],
                self.acceleration_mm_s2,
            )
        };
        moves.iter().zip(speeds.windows(2)).map(time).sum::<f64>() / 60.0
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

/// Time of a move of a length, mm, between two speeds and at most at a third, mm/s.
fn seconds(length: f64, speed: f64, [from, to]: [f64; 2], acceleration: f64) -> f64 {
    // The speed at which it would turn from faster to slower, if it may be so fast.
    let turn = (acceleration * length + 0.5 * (from * from + to * to)).sqrt();
    let most = turn.min(speed).max(from).max(to);
    let slopes = 2.0 * most * most - from * from - to * to;
    let even = (length - slopes / (2.0 * acceleration)).max(0.0);
    (2.0 * most - from - to) / acceleration + if most > 0.0 { even / most } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;

    const LIMITS: MachineLimits = MachineLimits { rapid_mm_min: 6000.0, acceleration_mm_s2: 500.0 };

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
        assert!((60.0 * LIMITS.minutes(&long) - (0.04 + 9.8 / 10.0)).abs() < 1e-12);
        // Never as fast as that: 2 sqrt(l / a).
        let short = path(&[DVec3::ZERO, DVec3::X * 0.1], 600.0);
        assert!((60.0 * LIMITS.minutes(&short) - 2.0 * f64::sqrt(0.1 / 500.0)).abs() < 1e-12);
        let there_and_back = path(&[DVec3::ZERO, DVec3::X * 10.0, DVec3::ZERO], 600.0);
        assert!((LIMITS.minutes(&there_and_back) - 2.0 * LIMITS.minutes(&long)).abs() < 1e-12);
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
        let found = 60.0 * LIMITS.minutes(&moves);
        assert!((found / time - 1.0).abs() < 2e-3, "{found} {time}");
    }
}
