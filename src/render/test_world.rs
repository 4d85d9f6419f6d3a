//! A world at infinity in which every direction can be read off: sky, ground, graticule, numbers.

use glam::{DVec3, Vec3A};

use super::{
    World,
    angle_tables::AngleTables,
    graticule::{GRID, GraticulePoint, LAST_CIRCLE, QUARTER, line_cover},
    text_distance_field::TextDistanceField,
};
use crate::geom::Ray;
use crate::num;
use crate::raster::srgb;

pub use super::graticule::{GRID_DEG, HEAVY_DEG, THIN_DEG};

/// Apparent height of the digits, in degrees.
pub const DIGIT_DEG: f64 = 3.5;

/// Clear space between a label and the line that it names, in degrees.
const GAP_DEG: f64 = 1.0;
/// Width of the rim around the labels in which lines are wiped out, in degrees.
const HALO_DEG: f64 = 0.9;
/// Texels that are added to the half width of every stroke of the font.
const WEIGHT: f32 = 0.2;

const THIN_SHARE: f32 = 0.5;
const HEAVY_SHARE: f32 = 0.9;

/// A direction-coloured world: pale sky above, pale ground below, each of four hues by azimuth (0, 90, 180,
/// -90 degrees), with grid lines every [`GRID_DEG`], azimuth numbers above the horizon and
/// elevation numbers right of the heavy meridians. Numbers end at elevation +-75 degrees.
///
/// Numbers stand upright for who looks that way: azimuth grows to the right, elevation up.
pub struct TestWorld {
    /// Of each side, at the horizon and at the zenith.
    sky: [[Vec3A; 2]; 4],
    /// Of each side, at the horizon and at the nadir.
    ground: [[Vec3A; 2]; 4],
    thin: Vec3A,
    heavy: Vec3A,
    ink: Vec3A,
    /// For azimuths 0, 15, ..., 180, -165, ..., -15 degrees.
    azimuth: Vec<TextDistanceField>,
    /// For elevations -75, -60, ..., 75 degrees.
    elevation: Vec<TextDistanceField>,
    /// Cosines of the elevations of `elevation`.
    level: Vec<f64>,
    angles: AngleTables,
    /// Radians a texel of a label.
    texel: f64,
}

impl Default for TestWorld {
    fn default() -> Self {
        Self::new()
    }
}

impl TestWorld {
    /// Draws the labels and chooses the colours.
    #[must_use]
    pub fn new() -> Self {
        let count = (360.0 / GRID_DEG) as i32;
        let step = GRID_DEG as i32;
        let azimuth: Vec<TextDistanceField> = (0..count)
            .map(|k| if 2 * k > count { k - count } else { k })
            .map(|k| TextDistanceField::new(&format!("{}", k * step)))
            .collect();
        let elevation = (-LAST_CIRCLE..=LAST_CIRCLE)
            .map(|k| TextDistanceField::new(&format!("{:+}", k * step)))
            .collect();
        let level = (-LAST_CIRCLE..=LAST_CIRCLE).map(|k| num::cos(f64::from(k) * GRID)).collect();
        let texel = num::radians(DIGIT_DEG) / f64::from(azimuth[0].height());
        Self {
            sky: [
                [0xe6f0f8, 0x7fadd4],
                [0xe4f3ee, 0x7cbcae],
                [0xeee8f5, 0xa693cb],
                [0xf8eae8, 0xd89c9c],
            ]
            .map(|side| side.map(hex)),
            ground: [
                [0xe0e8d0, 0x86a26b],
                [0xf0e6c9, 0xbd9f5b],
                [0xefdccf, 0xbc8366],
                [0xe0e4e6, 0x8a979f],
            ]
            .map(|side| side.map(hex)),
            thin: hex(0x3a4f66),
            heavy: hex(0x24364a),
            ink: hex(0x121c28),
            azimuth,
            elevation,
            level,
            angles: AngleTables::new(),
            texel,
        }
    }

    /// Linear red, green and blue, 0 to 1, seen in the unit vector `direction` by a sample that covers
    /// `footprint_rad` radians.
    #[must_use]
    pub fn colour(&self, direction: DVec3, footprint_rad: f64) -> [f32; 3] {
        let place = GraticulePoint::new(&self.angles, direction, footprint_rad);
        let mut colour = self.paper(&place, direction.z);
        let (fill, halo) = self.text(&place);
        let (thin, heavy) = line_cover(&place);
        for (cover, ink, strength) in [
            (thin * (1.0 - halo), self.thin, THIN_SHARE),
            (heavy * (1.0 - halo), self.heavy, HEAVY_SHARE),
            (fill, self.ink, 1.0),
        ] {
            if cover > 0.0 {
                colour = mix(colour, ink, cover * strength);
            }
        }
        colour.to_array()
    }

    /// Sky or ground without lines.
    fn paper(&self, place: &GraticulePoint, height: f64) -> Vec3A {
        let [from, to] = [0, 1].map(|k| (place.quarter + k).rem_euclid(4) as usize);
        let share = smooth((place.past * (3.0 / QUARTER) - 1.0) as f32);
        let away = 1.0 - height.abs() as f32;
        let depth = 1.0 - away * away;
        let shade = |sides: &[[Vec3A; 2]; 4]| {
            let [near, far] = sides[from];
            let colour = mix(near, far, depth);
            if share > 0.0 {
                let [near, far] = sides[to];
                mix(colour, mix(near, far, depth), share)
            } else {
                colour
            }
        };
        let above = (place.elevation * place.per_footprint + 0.5) as f32;
        if above >= 1.0 {
            shade(&self.sky)
        } else if above <= 0.0 {
            shade(&self.ground)
        } else {
            mix(shade(&self.ground), shade(&self.sky), above)
        }
    }

    /// Cover of the label ink, and of the halo that wipes out lines around it.
    #[inline]
    fn text(&self, place: &GraticulePoint) -> (f32, f32) {
        let found = self.azimuth_label(place);
        found
            .or_else(|| self.elevation_label(place))
            .map_or((0.0, 0.0), |found| self.cover(place, found))
    }

    fn cover(
        &self,
        place: &GraticulePoint,
        (label, right, up): (&TextDistanceField, f64, f64),
    ) -> (f32, f32) {
        let texels = |angle: f64| (angle / self.texel) as f32;
        let Some(distance) = label.distance(texels(right), texels(up)) else {
            return (0.0, 0.0);
        };
        let pixel = texels(place.footprint);
        // Digits smaller than a few pixels cannot be read and would only leave a stain.
        let fade = ((6.0 - pixel) / 3.0).clamp(0.0, 1.0);
        let fill = ((distance + WEIGHT) / pixel + 0.5).clamp(0.0, 1.0);
        let halo = smooth((distance + texels(num::radians(HALO_DEG))) / 2.0);
        (fill * fade, halo * fade)
    }

    /// The nearest label of the horizon, centred on its meridian, if `place` is at its height, and
    /// the angles from the start of its baseline to the right and up.
    #[inline]
    fn azimuth_label(&self, place: &GraticulePoint) -> Option<(&TextDistanceField, f64, f64)> {
        let up = place.elevation - num::radians(HEAVY_DEG / 2.0 + GAP_DEG);
        if !in_sight(up) {
            return None;
        }
        let count = self.azimuth.len() as i32;
        let label = &self.azimuth[place.meridian.rem_euclid(count) as usize];
        let half = f64::from(label.width()) * self.texel / 2.0;
        Some((label, place.aside * place.level + half, up))
    }

    /// The label right of the last column and on the horizon side of a circle, likewise.
    #[inline]
    fn elevation_label(&self, place: &GraticulePoint) -> Option<(&TextDistanceField, f64, f64)> {
        let start = num::radians(HEAVY_DEG / 2.0 + GAP_DEG);
        // The widest label with its halo stays within four of its heights.
        if place.past * place.level > num::radians(4.0 * DIGIT_DEG) {
            return None;
        }
        let sign = if place.elevation < 0.0 { -1 } else { 1 };
        let circle = if place.above < 0.0 && sign < 0 || place.above > 0.0 && sign > 0 {
            place.circle + sign
        } else {
            place.circle
        };
        let index = (circle + LAST_CIRCLE) as usize;
        let label = self.elevation.get(index)?;
        let gap = num::radians(THIN_DEG / 2.0 + GAP_DEG);
        let beyond = place.elevation - f64::from(circle) * GRID;
        let up = if sign > 0 { beyond + gap + num::radians(DIGIT_DEG) } else { beyond - gap };
        if circle == 0 || !in_sight(up) {
            return None;
        }
        // One scale for the whole label, or its digits would lean.
        Some((label, place.past * self.level[index] - start, up))
    }
}

/// Whether a label or its halo can reach a point that lies `up` radians over its baseline.
#[inline]
fn in_sight(up: f64) -> bool {
    up > -num::radians(HALO_DEG) && up < num::radians(DIGIT_DEG + HALO_DEG)
}

impl World for TestWorld {
    fn light(&self, ray: &Ray, footprint_rad: f64) -> [f32; 3] {
        self.colour(ray.direction, footprint_rad)
    }
}

fn hex(code: u32) -> Vec3A {
    Vec3A::from_array(srgb::hex(code))
}

/// `from` at `share` 0, `to` at 1.
#[inline]
fn mix(from: Vec3A, to: Vec3A, share: f32) -> Vec3A {
    from + (to - from) * share
}

/// 0 below 0, 1 above 1, with no corner between.
fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: f64 = 1e-4;

    fn direction(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
        let [a, e] = [azimuth_deg, elevation_deg].map(num::radians);
        DVec3::new(num::cos(e) * num::sin(a), num::cos(e) * num::cos(a), num::sin(e))
    }

    fn seen(world: &TestWorld, azimuth_deg: f64, elevation_deg: f64) -> [f32; 3] {
        world.colour(direction(azimuth_deg, elevation_deg), FINE)
    }

    fn apart(a: [f32; 3], b: [f32; 3]) -> f32 {
        (0..3).map(|k| (a[k] - b[k]).abs()).sum()
    }

    #[test]
    fn meridians_keep_their_angular_width_up_to_the_last_circle() {
        let world = TestWorld::new();
        for elevation in [9.0, -9.0, 38.0, -52.0, 67.0] {
            let level = num::cos(num::radians(elevation));
            for (azimuth, width) in [(-105.0, THIN_DEG), (-180.0, HEAVY_DEG), (-90.0, HEAVY_DEG)] {
                let at =
                    |aside: f64| seen(&world, azimuth - aside * width / 2.0 / level, elevation);
                let (inside, outside) = (at(0.98), at(1.02));
                assert!(apart(inside, outside) > 0.2, "{azimuth} {elevation}");
                assert!(apart(at(0.1), inside) < 0.02, "{azimuth} {elevation}");
                assert!(apart(at(1.2), outside) < 0.02, "{azimuth} {elevation}");
            }
        }
    }

    #[test]
    fn circles_lie_on_their_elevations() {
        let world = TestWorld::new();
        for (elevation, width) in [(0.0, HEAVY_DEG), (15.0, THIN_DEG), (-75.0, THIN_DEG)] {
            for side in [-1.0, 1.0] {
                let at = |off: f64| seen(&world, 52.0, elevation + side * off * width / 2.0);
                assert!(apart(at(0.97), at(1.03)) > 0.2, "{elevation}");
            }
        }
    }

    #[test]
    fn a_sample_as_wide_as_three_lines_shows_a_third_of_one() {
        let world = TestWorld::new();
        let footprint = num::radians(3.0 * THIN_DEG);
        let wide = |elevation: f64| world.colour(direction(52.0, elevation), footprint);
        let full = apart(seen(&world, 52.0, 30.0), seen(&world, 52.0, 29.6));
        let paper = (0..3).map(|k| (wide(28.0)[k] + wide(32.0)[k]) / 2.0);
        let share = paper.zip(wide(30.0)).map(|(a, b)| a - b).sum::<f32>() / full;
        assert!((share - 1.0 / 3.0).abs() < 0.02, "{share}");
    }

    #[test]
    fn sides_and_halves_differ() {
        let world = TestWorld::new();
        let places: Vec<[f32; 3]> = [10.0, 100.0, -170.0, -80.0]
            .iter()
            .flat_map(|&azimuth| [20.0, -20.0].map(|e| seen(&world, azimuth + 10.0, e)))
            .collect();
        for (k, &a) in places.iter().enumerate() {
            for &b in &places[..k] {
                assert!(apart(a, b) > 0.05, "{a:?} {b:?}");
            }
        }
    }

    /// Share of dark samples in a window of degrees right of an azimuth and over an elevation.
    fn ink(world: &TestWorld, right: [f64; 2], up: [f64; 2]) -> f64 {
        let steps = 80;
        let at = |[from, to]: [f64; 2], k: i32| from + (to - from) * (f64::from(k) + 0.5) / 80.0;
        let dark = (0..steps * steps)
            .filter(|k| seen(world, at(right, k % steps), at(up, k / steps))[1] < 0.05)
            .count();
        dark as f64 / f64::from(steps * steps)
    }

    #[test]
    fn numbers_stand_upright_over_the_horizon() {
        let world = TestWorld::new();
        let base = HEAVY_DEG / 2.0 + GAP_DEG;
        // The 7 of "75": its bar is on top, its stem right of the middle.
        let (left, middle, right) = (72.4, 73.6, 75.0);
        let top = ink(&world, [left, right], [base + 2.9, base + 3.5]);
        let foot = ink(&world, [left, right], [base, base + 0.6]);
        assert!(top > 1.5 * foot && foot > 0.05, "{top} {foot}");
        let [stem, gap] = [[middle, right], [left, middle]]
            .map(|across| ink(&world, across, [base + 1.9, base + 2.8]));
        assert!(stem > 2.0 * gap, "{stem} {gap}");
        // A minus only west of 0.
        assert!(ink(&world, [-34.5, -32.5], [base, base + 3.5]) > 0.02);
        assert_eq!(ink(&world, [32.9, 34.5], [base, base + 3.5]), 0.0);
    }

    #[test]
    fn elevation_numbers_lie_between_their_circle_and_the_horizon() {
        let world = TestWorld::new();
        for column in [-180.0, -90.0, 0.0, 90.0] {
            let across = [column + 1.0, column + 10.0];
            assert!(ink(&world, across, [10.3, 13.8]) > 0.1);
            assert!(ink(&world, across, [-13.8, -10.3]) > 0.08);
            assert_eq!(ink(&world, across, [6.0, 10.0]), 0.0);
            assert_eq!(ink(&world, across, [75.3, 89.0]), 0.0);
        }
    }

    #[test]
    fn every_direction_and_footprint_has_a_colour() {
        let world = TestWorld::new();
        for direction in [DVec3::Z, -DVec3::Z, -DVec3::Y, DVec3::new(-0.0, -1.0, -0.0)] {
            for footprint in [0.0, 1e-3, 0.5, 4.0, -1.0, f64::NAN] {
                let colour = world.colour(direction, footprint);
                let valid = |c: &f32| (0.0..=1.0).contains(c);
                assert!(colour.iter().all(valid), "{direction} {footprint} {colour:?}");
            }
        }
    }
}
