//! Fill of the frame: the class of every pixel, filled or lost for a cause, and their numbers.

use super::pixel_trace::PixelTrace;
use super::ray_end::Outcome;
use super::trace_result::{TraceResult, TraceStrip};
use crate::geom::DVec3;
use crate::num::{asin, atan2, degrees, wrap_turn};
use crate::parallel;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Share of filled pixels, their field of view, and the numbers of lost pixels by cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FrameFill {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Share of the pixels whose ray hits, leaves unoccluded and shows its content within
    /// `tolerance_px`.
    pub filled: f64,
    /// Largest pixel error of a filled pixel.
    pub tolerance_px: f64,
    /// Least and largest azimuth pixel by the filled pixels, degrees; none without such pixels.
    pub azimuth_deg: Option<[f64; 2]>,
    /// Least and largest elevation pixel by them, degrees.
    pub elevation_deg: Option<[f64; 2]>,
    /// Filled pixels over those of a round mirror inscribed in the frame, less one.
    pub gain_over_disc: f64,
    /// Numbers of the other pixels by cause.
    pub lost: LostPixels,
}

/// Class of a pixel: filled, or lost for the first of these causes that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelClass {
    /// It shows its part of the world.
    Filled,
    /// The designed mirror is not under its ray.
    Beyond,
    /// The nearest facet shows it the back.
    BackFace,
    /// Its ray is reflected and then meets the part.
    Shadow,
    /// An obstacle is in the way of its ray, before the mirror or behind it.
    Obstacle,
    /// It shows something else than the designed mirror does, or nothing, within a pixel of where
    /// the mirror ends.
    Rim,
    /// It shows something else than the designed mirror does within a pixel of the ridge: part of
    /// the other panel.
    Ridge,
    /// Its ray meets nothing, far from the rim.
    Missed,
    /// What it shows belongs farther away than the tolerance.
    Content,
}

impl PixelClass {
    /// The causes of loss, in the order of [`LostPixels`].
    pub const LOST: [Self; 8] = [
        Self::Beyond,
        Self::Rim,
        Self::Ridge,
        Self::Shadow,
        Self::Content,
        Self::BackFace,
        Self::Missed,
        Self::Obstacle,
    ];
}

/// Numbers of lost pixels by cause.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LostPixels {
    /// Pixels where the designed mirror is not under the ray.
    pub beyond: usize,
    /// Pixels lost within a pixel of where the mirror ends.
    pub rim: usize,
    /// Pixels lost within a pixel of the ridge.
    pub ridge: usize,
    /// Pixels whose reflected ray meets the part.
    pub shadow: usize,
    /// Pixels whose content is farther off than the tolerance.
    pub content: usize,
    /// Pixels to which the nearest facet shows its back.
    pub back_face: usize,
    /// Pixels whose ray meets nothing, far from the rim.
    pub missed: usize,
    /// Pixels that an obstacle hides; left out where there is none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub obstacle: usize,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl LostPixels {
    /// The numbers in the order of [`PixelClass::LOST`].
    #[must_use]
    pub fn counts(&self) -> [usize; 8] {
        let Self { beyond, rim, ridge, shadow, content, back_face, missed, obstacle } = *self;
        [beyond, rim, ridge, shadow, content, back_face, missed, obstacle]
    }
}

/// Class of every pixel of a strip, taken with pixels of `pixel_mm` each; `folded`: a ridge runs across the
/// middle of the picture.
#[must_use]
pub fn classify_pixels(
    strip: &TraceStrip,
    pixel_mm: f64,
    tolerance_px: f64,
    folded: bool,
) -> Vec<PixelClass> {
    let [width, height] = strip.frame;
    let limit = tolerance_px * pixel_mm;
    let at_rim = |column: usize, row: usize| {
        let around = |k: usize| [k.checked_sub(1), Some(k), Some(k + 1)];
        around(row)
            .iter()
            .any(|&row| around(column).iter().any(|&column| !strip.is_aimed(column, row)))
    };
    let at_ridge = |row: usize| folded && (2 * row + 1).abs_diff(height) <= 2;
    let class = |(k, pixel): (usize, &PixelTrace)| {
        let (column, row) = (k % width, strip.rows.start + k / width);
        let as_designed = pixel.errors.is_some_and(|e| e.facet_mm <= limit);
        match pixel.outcome {
            _ if !pixel.aimed => PixelClass::Beyond,
            Outcome::BackFace => PixelClass::BackFace,
            Outcome::Shadowed(_) => PixelClass::Shadow,
            Outcome::Obstructed(_) => PixelClass::Obstacle,
            Outcome::Hit if pixel.errors.is_some_and(|e| e.image_mm <= limit) => PixelClass::Filled,
            Outcome::Hit if as_designed => PixelClass::Content,
            _ if at_rim(column, row) => PixelClass::Rim,
            Outcome::Hit if at_ridge(row) => PixelClass::Ridge,
            Outcome::Hit => PixelClass::Content,
            Outcome::Missed => PixelClass::Missed,
        }
    };
    let pixels = &strip.traced.pixels;
    parallel::map(pixels.len(), 1, |k| class((k, &pixels[k])))
}

/// Fill of a frame of which strip after strip is added.
#[derive(Debug, Clone, Default)]
pub struct FrameFillBuilder {
    filled: usize,
    /// Least and greatest azimuth, radians.
    azimuth: ValueRange,
    /// Least and greatest Z of the directions seen.
    rise: ValueRange,
    lost: [usize; 8],
}

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

/// The azimuth that a pixel shows, continuous from the expected one, so that errors at the seam do not wrap.
fn azimuth(pixel: &PixelTrace) -> f64 {
    let expected = atan2(pixel.expected.x, pixel.expected.y);
    expected + wrap_turn(atan2(pixel.direction.x, pixel.direction.y) - expected)
}

impl FrameFillBuilder {
    /// Adds the pixels of some rows, and their classes.
    pub fn add(&mut self, rows: &TraceResult, classes: &[PixelClass]) {
        const PIECE: usize = 1 << 14;
        let pieces = classes.len().div_ceil(PIECE);
        let before = self.azimuth;
        let piece = |k: usize| {
            let piece = k * PIECE..classes.len().min((k + 1) * PIECE);
            let mut found = Self { azimuth: before, ..Self::default() };
            for (pixel, class) in rows.pixels[piece.clone()].iter().zip(&classes[piece]) {
                found.add_pixel(pixel, *class);
            }
            found
        };
        for found in parallel::map(pieces, 1, piece) {
            self.filled += found.filled;
            self.azimuth.join(found.azimuth);
            self.rise.join(found.rise);
            self.lost.iter_mut().zip(found.lost).for_each(|(sum, count)| *sum += count);
        }
    }

    fn add_pixel(&mut self, pixel: &PixelTrace, class: PixelClass) {
        if class != PixelClass::Filled {
            let cause = PixelClass::LOST.iter().position(|lost| *lost == class);
            self.lost[cause.expect("every other class is listed")] += 1;
            return;
        }
        self.filled += 1;
        self.rise.add(pixel.direction.z);
        // Most pixels are no end of the range, which needs no exact angle.
        let expected = rough_azimuth(pixel.expected);
        let step = rough_azimuth(pixel.direction) - expected;
        if step.abs() < FRAC_PI_2 && self.azimuth.holds(expected + step) {
            return;
        }
        self.azimuth.add(azimuth(pixel));
    }

    /// The fill of the frame of so many columns and rows, under the tolerance of the classes.
    #[must_use]
    pub fn finish(self, pixels: [u32; 2], tolerance_px: f64) -> FrameFill {
        let [width, height] = pixels.map(f64::from);
        let radius = 0.5 * width.min(height);
        let disc = std::f64::consts::PI * radius * radius;
        let filled = self.filled as f64;
        let [beyond, rim, ridge, shadow, content, back_face, missed, obstacle] = self.lost;
        FrameFill {
            pixels,
            filled: filled / (width * height),
            tolerance_px,
            azimuth_deg: self.azimuth.0.map(|range| range.map(degrees)),
            elevation_deg: self
                .rise
                .0
                .map(|range| range.map(|z| degrees(asin(z.clamp(-1.0, 1.0))))),
            gain_over_disc: filled / disc - 1.0,
            lost: LostPixels { beyond, rim, ridge, shadow, content, back_face, missed, obstacle },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, sin};
    use crate::trace::RayErrors;

    fn pixel(outcome: Outcome, error: f64) -> PixelTrace {
        PixelTrace {
            outcome,
            aimed: true,
            expected: DVec3::Y,
            direction: DVec3::new(0.6, 0.8, 0.0),
            hit_point: DVec3::ZERO,
            errors: Some(RayErrors { angle_rad: error, image_mm: error, facet_mm: error }),
            smooth: None,
        }
    }

    fn frame_of(
        trace: TraceResult,
        pixels: [u32; 2],
        folded: bool,
    ) -> (FrameFill, Vec<PixelClass>) {
        let strip = TraceStrip::whole(trace, pixels);
        let classes = classify_pixels(&strip, 0.1, 6.0, folded);
        let mut frame = FrameFillBuilder::default();
        frame.add(&strip.traced, &classes);
        (frame.finish(pixels, 6.0), classes)
    }

    fn frame(pixel: Vec<PixelTrace>, pixels: [u32; 2]) -> FrameFill {
        frame_of(TraceResult { pixels: pixel }, pixels, false).0
    }

    #[test]
    fn rough_azimuths_are_as_near_as_is_said() {
        for k in -3141..=3141 {
            let angle = f64::from(k) * 1e-3;
            let direction = DVec3::new(sin(angle), cos(angle), 0.3);
            assert!((rough_azimuth(direction) - angle).abs() < 0.004, "{angle}");
        }
    }

    #[test]
    fn a_filled_frame_gains_what_the_paper_says() {
        let frame = frame(vec![pixel(Outcome::Hit, 0.0); 640 * 480], [640, 480]);
        assert_eq!(frame.filled, 1.0);
        assert!((frame.gain_over_disc - 0.698).abs() < 5e-4, "{}", frame.gain_over_disc);
        assert_eq!(frame.lost, LostPixels::default());
    }

    #[test]
    fn lost_pixels_of_every_kind_count_as_lost() {
        let mut pixels = vec![pixel(Outcome::Hit, 0.0); 6];
        pixels.extend([
            pixel(Outcome::Missed, 0.0),
            pixel(Outcome::Shadowed(3), 0.0),
            pixel(Outcome::BackFace, 0.0),
            pixel(Outcome::Obstructed(1), 0.0),
            PixelTrace { aimed: false, ..pixel(Outcome::Hit, 0.0) },
            pixel(Outcome::Hit, f64::NAN),
        ]);
        let frame = frame(pixels, [4, 3]);
        assert_eq!(frame.filled, 0.5);
        assert_eq!(frame.lost.counts().iter().sum::<usize>(), 6);
        let [lo, hi] = frame.azimuth_deg.unwrap();
        assert!((lo - 36.87).abs() < 0.01 && lo == hi);
    }

    #[test]
    fn each_lost_pixel_has_its_cause() {
        // 9 columns, 8 rows, the last column beyond the mirror, a ridge under row 3.
        let (pixels, width) = ([9, 8], 9);
        let bad = |facet_mm: f64| PixelTrace {
            errors: Some(RayErrors { angle_rad: 9.0, image_mm: 9.0, facet_mm }),
            ..pixel(Outcome::Hit, 0.0)
        };
        let good = pixel(Outcome::Hit, 0.0);
        let mut traced = vec![good; 72];
        for row in 0..8 {
            traced[row * width + 8] = PixelTrace { aimed: false, ..good };
        }
        let cases = [
            (2, 7, bad(9.0), PixelClass::Rim),
            (5, 0, pixel(Outcome::Missed, 0.0), PixelClass::Rim),
            (5, 7, bad(0.1), PixelClass::Content),
            (3, 4, bad(9.0), PixelClass::Ridge),
            (4, 4, bad(f64::NAN), PixelClass::Ridge),
            (4, 5, bad(0.1), PixelClass::Content),
            (2, 3, bad(9.0), PixelClass::Content),
            (5, 3, pixel(Outcome::Missed, 0.0), PixelClass::Missed),
            (3, 2, pixel(Outcome::Shadowed(1), 0.0), PixelClass::Shadow),
            (1, 1, pixel(Outcome::BackFace, 0.0), PixelClass::BackFace),
            (6, 0, pixel(Outcome::Obstructed(0), 0.0), PixelClass::Obstacle),
        ];
        for (row, column, pixel, _) in cases {
            traced[row * width + column] = pixel;
        }
        let (frame, found) = frame_of(TraceResult { pixels: traced }, pixels, true);
        for (row, column, _, class) in cases {
            assert_eq!(found[row * width + column], class, "row {row}, column {column}");
        }
        assert_eq!(frame.lost.counts(), [8, 2, 2, 1, 3, 1, 1, 1]);
        assert_eq!(frame.filled, (72.0 - 19.0) / 72.0);
    }
}
