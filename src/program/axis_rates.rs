//! How fast the axes of a slow tool servo go, and how fast that changes.

use super::lathe::TurningPath;

/// The most of an axis on all cutting moves, and the line of the program.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AxisRate {
    /// mm/s^2 of an acceleration, mm/min of a speed.
    pub most: f64,
    /// Line, from 1.
    pub line: u32,
}

/// The most that X or Z are asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AxisRates {
    /// Their acceleration.
    pub acceleration: AxisRate,
    /// Their speed.
    pub speed: AxisRate,
}

impl TurningPath {
    /// What X and Z are asked for where C is commanded: the speed of each cutting move, and from one to the next its change over the mean of
    /// their times. Nothing of a spindle that turns freely.
    #[must_use]
    pub fn axis_rates(&self) -> AxisRates {
        let mut found = AxisRates::default();
        let mut before: Option<([f64; 2], f64)> = None;
        for (step, turn) in self.tool.moves.iter().zip(&self.commanded) {
            if !(turn.minutes > 0.0) {
                before = None;
                continue;
            }
            let (way, seconds) = (step.to - step.from, 60.0 * turn.minutes);
            let speeds = [way.x / seconds, way.z / seconds];
            for (axis, speed) in speeds.into_iter().enumerate() {
                found.speed.raise(60.0 * speed.abs(), step.line);
                if let Some((old, time)) = before {
                    let change = (speed - old[axis]).abs() / (0.5 * (time + seconds));
                    found.acceleration.raise(change, step.line);
                }
            }
            before = Some((speeds, seconds));
        }
        found
    }
}

impl AxisRate {
    fn raise(&mut self, value: f64, line: u32) {
        if !(value <= self.most) {
            *self = Self { most: value, line };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    /// Z = A cos(2 C) at 30 turns a minute: Z'' = A (2 w)^2 with w = pi rad/s, Z' = A 2 w; X goes evenly.
    #[test]
    fn a_wave_has_the_acceleration_and_speed_of_the_closed_form() {
        let mut text = "# spindle_rpm 30\n".to_owned();
        for k in 0..=720 {
            let z = 0.5 * crate::num::cos(2.0 * f64::from(k) * std::f64::consts::PI / 180.0);
            let _ = writeln!(text, "{} {z} {k}", 10.0 - 1e-4 * f64::from(k));
        }
        let found = TurningPath::read_table(text.as_bytes()).unwrap().axis_rates();
        let rate = 2.0 * std::f64::consts::PI;
        let off = found.acceleration.most / (0.5 * rate * rate) - 1.0;
        assert!(off.abs() < 1e-3, "{found:?}");
        assert!((found.speed.most / (60.0 * 0.5 * rate) - 1.0).abs() < 1e-3, "{found:?}");
        // A rapid move between two cuts has its own ramps.
        let text = "G8 G93\nG0 X9 Z5 C0\nG1 X8 C90 F60\nG0 Z9\nG1 X7 C180 F60\n";
        let found = TurningPath::read(text.as_bytes()).unwrap().axis_rates();
        assert_eq!((found.acceleration.most, found.speed), (0.0, AxisRate { most: 60.0, line: 3 }));
    }
}
