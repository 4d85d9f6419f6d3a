//! Fill of the frame: the class of every pixel, filled or lost for a cause, and their numbers.

use super::filled_range::FilledRange;
use super::pixel_class::PixelClass;
use super::trace_strip::TraceStrip;
use crate::num::{asin, degrees};
use serde::{Deserialize, Serialize};

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

/// Fill of a frame of which strip after strip is added.
#[derive(Debug, Clone, Default)]
pub struct FrameFillBuilder {
    filled: usize,
    range: FilledRange,
    lost: [usize; 8],
}

impl FrameFillBuilder {
    /// Adds a strip.
    pub fn add(&mut self, strip: &TraceStrip) {
        for class in &strip.classes {
            if *class == PixelClass::Filled {
                self.filled += 1;
                continue;
            }
            let cause = PixelClass::LOST.iter().position(|lost| lost == class);
            self.lost[cause.expect("every other class is listed")] += 1;
        }
        strip.digests.iter().for_each(|digest| self.range.join(digest.filled));
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
            azimuth_deg: self.range.azimuth().map(|range| range.map(degrees)),
            elevation_deg: self
                .range
                .rise()
                .map(|range| range.map(|z| degrees(asin(z.clamp(-1.0, 1.0))))),
            gain_over_disc: filled / disc - 1.0,
            lost: LostPixels { beyond, rim, ridge, shadow, content, back_face, missed, obstacle },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::optics::ShownContent;
    use crate::trace::digest::Digest;
    use crate::trace::{ExpectedRay, Outcome, PixelTrace, RayErrors};

    fn pixel(outcome: Outcome, error: f64) -> PixelTrace {
        PixelTrace {
            outcome,
            aimed: true,
            direction: DVec3::new(0.6, 0.8, 0.0),
            hit_point: DVec3::ZERO,
            errors: Some(RayErrors { angle_rad: error, image_mm: error, facet_mm: error }),
        }
    }

    /// The fill of pixels that are all to see the north, and their classes.
    fn frame_of(
        traced: Vec<PixelTrace>,
        pixels: [u32; 2],
        folded: bool,
    ) -> (FrameFill, Vec<PixelClass>) {
        let nothing = ShownContent::NONE;
        let north = ExpectedRay { aimed: true, direction: DVec3::Y, designed: nothing };
        let mut digest = Digest::default();
        digest.add(&traced, &vec![north; traced.len()], 0.6);
        let frame = pixels.map(|n| n as usize);
        let (rows, classes) = (0..frame[1], Vec::new());
        let mut strip = TraceStrip { frame, rows, pixels: traced, classes, digests: vec![digest] };
        strip.classify([vec![], vec![]], folded);
        let mut frame = FrameFillBuilder::default();
        frame.add(&strip);
        (frame.finish(pixels, 6.0), strip.classes)
    }

    fn frame(traced: Vec<PixelTrace>, pixels: [u32; 2]) -> FrameFill {
        frame_of(traced, pixels, false).0
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
        let (frame, found) = frame_of(traced, pixels, true);
        for (row, column, _, class) in cases {
            assert_eq!(found[row * width + column], class, "row {row}, column {column}");
        }
        assert_eq!(frame.lost.counts(), [8, 2, 2, 1, 3, 1, 1, 1]);
        assert_eq!(frame.filled, (72.0 - 19.0) / 72.0);
    }
}
