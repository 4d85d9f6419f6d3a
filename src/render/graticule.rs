//! The grid of meridians and circles on the sphere of directions.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;

use super::angle_tables::{AngleTables, round_to_integer};
use crate::num;

/// Angle between grid lines, in degrees of azimuth and of elevation.
pub const GRID_DEG: f64 = 15.0;
/// Apparent width of the thin grid lines, in degrees.
pub const THIN_DEG: f64 = 0.35;
/// Apparent width of the horizon and of the meridians 0, +-90 and 180, in degrees.
pub const HEAVY_DEG: f64 = 0.8;
/// [`GRID_DEG`] in radians.
pub(super) const GRID: f64 = GRID_DEG / 180.0 * PI;
/// Azimuth between the heavy meridians, in radians.
pub(super) const QUARTER: f64 = FRAC_PI_2;
/// Number of the last grid circle, at 75 degrees: the thin meridians end on it, lest they crowd at the pole.
pub(super) const LAST_CIRCLE: i32 = 5;
/// Meridians of the grid for each heavy one.
const PER_QUARTER: i32 = 90 / GRID_DEG as i32;

/// A direction with its position in the graticule; angles in radians.
pub(super) struct GraticulePoint {
    /// Elevation over the horizon.
    pub elevation: f64,
    /// Cosine of the elevation.
    pub level: f64,
    /// Number of the nearest meridian of the grid.
    pub meridian: i32,
    /// Azimuth from that meridian.
    pub aside: f64,
    /// Number of the nearest circle of the grid.
    pub circle: i32,
    /// Elevation over that circle.
    pub above: f64,
    /// Number of the last heavy meridian.
    pub quarter: i32,
    /// Azimuth past that one.
    pub past: f64,
    /// Angle that the sample covers.
    pub footprint: f64,
    /// Its reciprocal.
    pub per_footprint: f64,
}

impl GraticulePoint {
    /// Finds the unit vector `direction`, seen by a sample of `footprint_rad` radians.
    #[inline]
    #[must_use]
    pub(super) fn new(angles: &AngleTables, direction: DVec3, footprint_rad: f64) -> Self {
        let level = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let azimuth = angles.atan2(direction.x, direction.y);
        let elevation = angles.elevation(direction.z, level);
        let (meridian, line) = round_to_integer(azimuth * (1.0 / GRID));
        let (circle, row) = round_to_integer(elevation * (1.0 / GRID));
        let (quarter, column) = round_to_integer(azimuth * (1.0 / QUARTER) - 0.5);
        let footprint = footprint_rad.max(1e-9);
        Self {
            elevation,
            level,
            meridian,
            aside: azimuth - line * GRID,
            circle,
            above: elevation - row * GRID,
            quarter,
            past: azimuth - column * QUARTER,
            footprint,
            per_footprint: 1.0 / footprint,
        }
    }
}

/// Cover of the thin and of the heavy lines, 0 to 1; where they cross, the heavy one counts.
#[inline]
#[must_use]
pub(super) fn line_cover(place: &GraticulePoint) -> (f32, f32) {
    let cover = |distance: f64, heavy: bool| {
        let half = num::radians(if heavy { HEAVY_DEG } else { THIN_DEG }) / 2.0;
        let reach = place.footprint / 2.0;
        if distance >= half + reach {
            return 0.0;
        }
        let overlap = (distance + reach).min(half) - (distance - reach).max(-half);
        (overlap * place.per_footprint) as f32
    };
    let mut thin = 0.0;
    let mut heavy = 0.0;
    let beyond = place.elevation.abs() - f64::from(LAST_CIRCLE) * GRID;
    if beyond < 0.0 {
        let main = place.meridian % PER_QUARTER == 0;
        let share = cover(place.aside.abs() * place.level, main);
        *(if main { &mut heavy } else { &mut thin }) = share;
    } else {
        let aside = place.past.min(QUARTER - place.past).abs();
        heavy = cover(aside * place.level, true);
    }
    if place.circle == 0 {
        heavy = join(heavy, cover(place.above.abs(), true));
    } else if place.circle.abs() <= LAST_CIRCLE {
        thin = join(thin, cover(place.above.abs(), false));
    }
    (thin * (1.0 - heavy), heavy)
}

/// Cover of two crossing lines, as if they were independent.
#[inline]
fn join(a: f32, b: f32) -> f32 {
    a + b - a * b
}
