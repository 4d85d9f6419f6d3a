//! Fill of the frame: the class of every pixel, filled or lost for a cause, and their numbers.

use super::ray_end::Outcome;
use super::trace_result::{PixelTrace, TraceResult};
use crate::num::{asin, atan2, degrees, wrap_turn};
use crate::parallel;
use serde::{Deserialize, Serialize};

/// Share of filled pixels, their field of view, and the numbers of lost pixels by cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    pub const LOST: [Self; 7] = [
        Self::Beyond,
        Self::Rim,
        Self::Ridge,
        Self::Shadow,
        Self::Content,
        Self::BackFace,
        Self::Missed,
    ];
}

/// Numbers of lost pixels by cause.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LostPixels {
    /// [`PixelClass::Beyond`].
    pub beyond: usize,
    /// [`PixelClass::Rim`].
    pub rim: usize,
    /// [`PixelClass::Ridge`].
    pub ridge: usize,
    /// [`PixelClass::Shadow`].
    pub shadow: usize,
    /// [`PixelClass::Content`].
    pub content: usize,
    /// [`PixelClass::BackFace`].
    pub back_face: usize,
    /// [`PixelClass::Missed`].
    pub missed: usize,
}

impl LostPixels {
    /// Counts the lost ones of all pixels.
    #[must_use]
    pub fn of(classes: &[PixelClass]) -> Self {
        let count = |class: PixelClass| classes.iter().filter(|&&f| f == class).count();
        let [beyond, rim, ridge, shadow, content, back_face, missed] = PixelClass::LOST.map(count);
        Self { beyond, rim, ridge, shadow, content, back_face, missed }
    }

    /// The numbers in the order of [`PixelClass::LOST`].
    #[must_use]
    pub fn counts(&self) -> [usize; 7] {
        let Self { beyond, rim, ridge, shadow, content, back_face, missed } = *self;
        [beyond, rim, ridge, shadow, content, back_face, missed]
    }
}

/// Class of every pixel of `trace`, taken with a sensor of `pixels` of `pixel_mm` each; `folded`: a ridge
/// runs across the middle of the picture.
///
/// # Panics
/// When the trace has not one entry a pixel.
#[must_use]
pub fn classify_pixels(
    trace: &TraceResult,
    pixels: [u32; 2],
    pixel_mm: f64,
    tolerance_px: f64,
    folded: bool,
) -> Vec<PixelClass> {
    let [width, height] = pixels.map(|n| n as usize);
    assert_eq!(trace.pixels.len(), width * height, "one entry a pixel");
    let limit = tolerance_px * pixel_mm;
    let aimed = |column: Option<usize>, row: Option<usize>| match (column, row) {
        (Some(column), Some(row)) if column < width && row < height => {
            trace.pixels[row * width + column].aimed
        }
        _ => false,
    };
    let at_rim = |column: usize, row: usize| {
        let around = |k: usize| [k.checked_sub(1), Some(k), Some(k + 1)];
        around(row).iter().any(|&row| around(column).iter().any(|&column| !aimed(column, row)))
    };
    let at_ridge = |row: usize| folded && (2 * row + 1).abs_diff(height) <= 2;
    let class = |(k, pixel): (usize, &PixelTrace)| {
        let (column, row) = (k % width, k / width);
        let as_designed = pixel.errors.is_some_and(|e| e.facet_mm <= limit);
        match pixel.outcome {
            _ if !pixel.aimed => PixelClass::Beyond,
            Outcome::BackFace => PixelClass::BackFace,
            Outcome::Shadowed(_) => PixelClass::Shadow,
            Outcome::Hit if pixel.errors.is_some_and(|e| e.image_mm <= limit) => PixelClass::Filled,
            Outcome::Hit if as_designed => PixelClass::Content,
            _ if at_rim(column, row) => PixelClass::Rim,
            Outcome::Hit if at_ridge(row) => PixelClass::Ridge,
            Outcome::Hit => PixelClass::Content,
            Outcome::Missed => PixelClass::Missed,
        }
    };
    parallel::map(trace.pixels.len(), 1, |k| class((k, &trace.pixels[k])))
}

impl FrameFill {
    /// Evaluates `trace` and the `classes` of its pixels under the same `tolerance_px`.
    #[must_use]
    pub fn new(
        trace: &TraceResult,
        classes: &[PixelClass],
        pixels: [u32; 2],
        tolerance_px: f64,
    ) -> Self {
        let pairs = trace.pixels.iter().zip(classes);
        let filled: Vec<&PixelTrace> = pairs
            .filter(|(_, class)| **class == PixelClass::Filled)
            .map(|(pixel, _)| pixel)
            .collect();
        let [width, height] = pixels.map(f64::from);
        let radius = 0.5 * width.min(height);
        let disc = std::f64::consts::PI * radius * radius;
        let range = |angle: fn(&PixelTrace) -> f64| {
            let angles = parallel::map_slice(&filled, 1, |pixel| [angle(pixel); 2]);
            let widest = angles.into_iter().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
            widest.map(|range| range.map(degrees))
        };
        Self {
            pixels,
            filled: filled.len() as f64 / (width * height),
            tolerance_px,
            azimuth_deg: range(|pixel| {
                // Continuous from the expected azimuth, so that errors at the seam do not wrap.
                let expected = atan2(pixel.expected.x, pixel.expected.y);
                expected + wrap_turn(atan2(pixel.direction.x, pixel.direction.y) - expected)
            }),
            elevation_deg: range(|pixel| asin(pixel.direction.z.clamp(-1.0, 1.0))),
            gain_over_disc: filled.len() as f64 / disc - 1.0,
            lost: LostPixels::of(classes),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
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

    fn frame(pixel: Vec<PixelTrace>, pixels: [u32; 2]) -> FrameFill {
        let trace = TraceResult { pixels: pixel };
        let classes = classify_pixels(&trace, pixels, 0.1, 6.0, false);
        FrameFill::new(&trace, &classes, pixels, 6.0)
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
            pixel(Outcome::Hit, 0.7),
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
        ];
        for (row, column, pixel, _) in cases {
            traced[row * width + column] = pixel;
        }
        let trace = TraceResult { pixels: traced };
        let found = classify_pixels(&trace, pixels, 0.1, 6.0, true);
        for (row, column, _, class) in cases {
            assert_eq!(found[row * width + column], class, "row {row}, column {column}");
        }
        let lost = LostPixels::of(&found);
        assert_eq!(lost.counts(), [8, 2, 2, 1, 3, 1, 1]);
        assert_eq!(FrameFill::new(&trace, &found, pixels, 6.0).filled, (72.0 - 18.0) / 72.0);
    }
}
