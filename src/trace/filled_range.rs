//! What the filled pixels of a frame show: the range of azimuths and elevations.

use crate::geom::DVec3;
use crate::num::{atan2, wrap_turn};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Least and greatest of some values.
#[derive(Debug, Clone, Copy, Default)]
struct ValueRange(Option<[f64; 2]>);

impl ValueRange {
    fn add(&mut self, value: f64) {
        let [lo, hi] = self.0.unwrap_or([value; 2]);
        self.0 = Some([lo.min(value), hi.max(value)]);
    }

    /// Whether a value that is off by [`ROUGH`] at the most changes nothing.
    fn holds(&self, value: f64) -> bool {
        self.0.is_some_and(|[lo, hi]| value > lo + ROUGH && value < hi - ROUGH)
    }

    fn join(&mut self, other: Self) {
        other.0.into_iter().flatten().for_each(|end| self.add(end));
    }
}

/// More than a difference of two azimuths by [`rough_azimuth`] is off, and one more, radians.
const ROUGH: f64 = 0.02;

/// The azimuth of a direction to 0.004 radians, in the time of a division.
#[inline]
fn rough_azimuth(direction: DVec3) -> f64 {
    let (east, north) = (direction.x.abs(), direction.y.abs());
    let ratio = east.min(north) / east.max(north);
    let angle = ratio * (FRAC_PI_4 + 0.273 * (1.0 - ratio));
    let angle = if east > north { FRAC_PI_2 - angle } else { angle };
    let angle = if direction.y < 0.0 { PI - angle } else { angle };
    angle.copysign(direction.x)
}

/// The azimuth of a direction that is seen, continuous from that of the expected one, so that errors at the seam do not
/// wrap.
fn azimuth(seen: DVec3, expected: DVec3) -> f64 {
    let expected = atan2(expected.x, expected.y);
    expected + wrap_turn(atan2(seen.x, seen.y) - expected)
}

/// What filled pixels show.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FilledRange {
    /// Least and greatest azimuth, radians.
    azimuth: ValueRange,
    /// Least and greatest Z of the directions seen.
    rise: ValueRange,
}

impl FilledRange {
    /// Adds a pixel that is to see one direction and sees another.
    #[inline]
    pub(super) fn add(&mut self, seen: DVec3, expected: DVec3) {
        self.rise.add(seen.z);
        // Most pixels are no end of the range, which needs no exact angle.
        let rough = rough_azimuth(expected);
        let step = rough_azimuth(seen) - rough;
        if step.abs() < FRAC_PI_2 && self.azimuth.holds(rough + step) {
            return;
        }
        self.azimuth.add(azimuth(seen, expected));
    }

    /// Least and greatest azimuth, radians; none of no pixel.
    pub(super) fn azimuth(&self) -> Option<[f64; 2]> {
        self.azimuth.0
    }

    /// Least and greatest Z of the directions seen; none of no pixel.
    pub(super) fn rise(&self) -> Option<[f64; 2]> {
        self.rise.0
    }

    pub(super) fn join(&mut self, other: Self) {
        self.azimuth.join(other.azimuth);
        self.rise.join(other.rise);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, sin};

    #[test]
    fn rough_azimuths_are_as_near_as_is_said() {
        for k in -3141..=3141 {
            let angle = f64::from(k) * 1e-3;
            let direction = DVec3::new(sin(angle), cos(angle), 0.3);
            assert!((rough_azimuth(direction) - angle).abs() < 0.004, "{angle}");
        }
    }
}
