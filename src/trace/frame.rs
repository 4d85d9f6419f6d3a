//! The frame-fill check: how much of the sensor sees what it is meant to see, and why the rest does
//! not.

use super::{Outcome, Seen, Witness};
use crate::num::{asin, atan2, degrees, wrap_turn};
use crate::parallel;
use serde::{Deserialize, Serialize};

/// What the frame as a whole sees.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Share of the pixels that see their intended part of the world: hit, unshadowed and within
    /// `tolerance_px`.
    pub filled: f64,
    /// The pixel error up to which a pixel counts as filled.
    pub tolerance_px: f64,
    /// Least and largest azimuth seen by the filled pixels, degrees; none without such pixels.
    pub azimuth_deg: Option<[f64; 2]>,
    /// Least and largest elevation seen by them, degrees.
    pub elevation_deg: Option<[f64; 2]>,
    /// Filled pixels over those of a round mirror inscribed in the frame, less one.
    pub gain_over_disc: f64,
    /// The other pixels, by why they are lost.
    pub lost: Lost,
}

/// What becomes of a pixel: it is filled, or lost for the first of these reasons that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It sees its part of the world.
    Filled,
    /// The mirror is not meant to be there.
    Beyond,
    /// The nearest facet shows it its back.
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

impl Fate {
    /// Every reason why a pixel is lost, in the order of [`Lost`].
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

/// Numbers of lost pixels.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lost {
    /// [`Fate::Beyond`].
    pub beyond: usize,
    /// [`Fate::Rim`].
    pub rim: usize,
    /// [`Fate::Ridge`].
    pub ridge: usize,
    /// [`Fate::Shadow`].
    pub shadow: usize,
    /// [`Fate::Content`].
    pub content: usize,
    /// [`Fate::BackFace`].
    pub back_face: usize,
    /// [`Fate::Missed`].
    pub missed: usize,
}

impl Lost {
    /// Counts them.
    #[must_use]
    pub fn of(fates: &[Fate]) -> Self {
        let count = |fate: Fate| fates.iter().filter(|&&f| f == fate).count();
        let [beyond, rim, ridge, shadow, content, back_face, missed] = Fate::LOST.map(count);
        Self { beyond, rim, ridge, shadow, content, back_face, missed }
    }

    /// The numbers in the order of [`Fate::LOST`].
    #[must_use]
    pub fn counts(&self) -> [usize; 7] {
        let Self { beyond, rim, ridge, shadow, content, back_face, missed } = *self;
        [beyond, rim, ridge, shadow, content, back_face, missed]
    }
}

/// What becomes of every pixel of `witness`, taken with a sensor of `pixels` of `pixel_mm` each;
/// `folded`: a ridge runs across the middle of the picture.
///
/// # Panics
/// When the witness has not one entry a pixel.
#[must_use]
pub fn fates(
    witness: &Witness,
    pixels: [u32; 2],
    pixel_mm: f64,
    tolerance_px: f64,
    folded: bool,
) -> Vec<Fate> {
    let [width, height] = pixels.map(|n| n as usize);
    assert_eq!(witness.seen.len(), width * height, "one entry a pixel");
    let limit = tolerance_px * pixel_mm;
    let aimed = |column: Option<usize>, row: Option<usize>| match (column, row) {
        (Some(column), Some(row)) if column < width && row < height => {
            witness.seen[row * width + column].aimed
        }
        _ => false,
    };
    let at_rim = |column: usize, row: usize| {
        let around = |k: usize| [k.checked_sub(1), Some(k), Some(k + 1)];
        around(row).iter().any(|&row| around(column).iter().any(|&column| !aimed(column, row)))
    };
    let at_ridge = |row: usize| folded && (2 * row + 1).abs_diff(height) <= 2;
    let fate = |(k, seen): (usize, &Seen)| {
        let (column, row) = (k % width, k / width);
        let as_designed = seen.errors.is_some_and(|e| e.facet_mm <= limit);
        match seen.outcome {
            _ if !seen.aimed => Fate::Beyond,
            Outcome::BackFace => Fate::BackFace,
            Outcome::Shadowed(_) => Fate::Shadow,
            Outcome::Hit if seen.errors.is_some_and(|e| e.image_mm <= limit) => Fate::Filled,
            Outcome::Hit if as_designed => Fate::Content,
            _ if at_rim(column, row) => Fate::Rim,
            Outcome::Hit if at_ridge(row) => Fate::Ridge,
            Outcome::Hit => Fate::Content,
            Outcome::Missed => Fate::Missed,
        }
    };
    parallel::map(witness.seen.len(), 1, |k| fate((k, &witness.seen[k])))
}

impl Frame {
    /// Evaluates `witness` and the `fates` of its pixels under the same `tolerance_px`.
    #[must_use]
    pub fn new(witness: &Witness, fates: &[Fate], pixels: [u32; 2], tolerance_px: f64) -> Self {
        let pairs = witness.seen.iter().zip(fates);
        let filled: Vec<&Seen> =
            pairs.filter(|(_, fate)| **fate == Fate::Filled).map(|(seen, _)| seen).collect();
        let [width, height] = pixels.map(f64::from);
        let radius = 0.5 * width.min(height);
        let disc = std::f64::consts::PI * radius * radius;
        let range = |angle: fn(&Seen) -> f64| {
            let angles = parallel::map_slice(&filled, 1, |seen| [angle(seen); 2]);
            let widest = angles.into_iter().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
            widest.map(|range| range.map(degrees))
        };
        Self {
            pixels,
            filled: filled.len() as f64 / (width * height),
            tolerance_px,
            azimuth_deg: range(|seen| {
                // Continued from the wanted azimuth, so that errors at the seam do not wrap.
                let wanted = atan2(seen.wanted.x, seen.wanted.y);
                wanted + wrap_turn(atan2(seen.direction.x, seen.direction.y) - wanted)
            }),
            elevation_deg: range(|seen| asin(seen.direction.z.clamp(-1.0, 1.0))),
            gain_over_disc: filled.len() as f64 / disc - 1.0,
            lost: Lost::of(fates),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;
    use crate::trace::Errors;

    fn pixel(outcome: Outcome, error: f64) -> Seen {
        Seen {
            outcome,
            aimed: true,
            wanted: DVec3::Y,
            direction: DVec3::new(0.6, 0.8, 0.0),
            at: DVec3::ZERO,
            errors: Some(Errors { ray: error, image_mm: error, facet_mm: error }),
            smooth: None,
        }
    }

    fn frame(seen: Vec<Seen>, pixels: [u32; 2]) -> Frame {
        let witness = Witness { seen };
        let fates = fates(&witness, pixels, 0.1, 6.0, false);
        Frame::new(&witness, &fates, pixels, 6.0)
    }

    #[test]
    fn a_filled_frame_gains_what_the_paper_says() {
        let frame = frame(vec![pixel(Outcome::Hit, 0.0); 640 * 480], [640, 480]);
        assert_eq!(frame.filled, 1.0);
        assert!((frame.gain_over_disc - 0.698).abs() < 5e-4, "{}", frame.gain_over_disc);
        assert_eq!(frame.lost, Lost::default());
    }

    #[test]
    fn lost_pixels_of_every_kind_count_as_lost() {
        let mut seen = vec![pixel(Outcome::Hit, 0.0); 6];
        seen.extend([
            pixel(Outcome::Missed, 0.0),
            pixel(Outcome::Shadowed(3), 0.0),
            pixel(Outcome::BackFace, 0.0),
            pixel(Outcome::Hit, 0.7),
            Seen { aimed: false, ..pixel(Outcome::Hit, 0.0) },
            pixel(Outcome::Hit, f64::NAN),
        ]);
        let frame = frame(seen, [4, 3]);
        assert_eq!(frame.filled, 0.5);
        assert_eq!(frame.lost.counts().iter().sum::<usize>(), 6);
        let [lo, hi] = frame.azimuth_deg.unwrap();
        assert!((lo - 36.87).abs() < 0.01 && lo == hi);
    }

    #[test]
    fn each_lost_pixel_has_its_cause() {
        // 9 columns, 8 rows, the last column beyond the mirror, a ridge under row 3.
        let (pixels, width) = ([9, 8], 9);
        let bad = |facet_mm: f64| Seen {
            errors: Some(Errors { ray: 9.0, image_mm: 9.0, facet_mm }),
            ..pixel(Outcome::Hit, 0.0)
        };
        let good = pixel(Outcome::Hit, 0.0);
        let mut seen = vec![good; 72];
        for row in 0..8 {
            seen[row * width + 8] = Seen { aimed: false, ..good };
        }
        let cases = [
            (2, 7, bad(9.0), Fate::Rim),
            (5, 0, pixel(Outcome::Missed, 0.0), Fate::Rim),
            (5, 7, bad(0.1), Fate::Content),
            (3, 4, bad(9.0), Fate::Ridge),
            (4, 4, bad(f64::NAN), Fate::Ridge),
            (4, 5, bad(0.1), Fate::Content),
            (2, 3, bad(9.0), Fate::Content),
            (5, 3, pixel(Outcome::Missed, 0.0), Fate::Missed),
            (3, 2, pixel(Outcome::Shadowed(1), 0.0), Fate::Shadow),
            (1, 1, pixel(Outcome::BackFace, 0.0), Fate::BackFace),
        ];
        for (row, column, pixel, _) in cases {
            seen[row * width + column] = pixel;
        }
        let witness = Witness { seen };
        let found = fates(&witness, pixels, 0.1, 6.0, true);
        for (row, column, _, fate) in cases {
            assert_eq!(found[row * width + column], fate, "row {row}, column {column}");
        }
        let lost = Lost::of(&found);
        assert_eq!(lost.counts(), [8, 2, 2, 1, 3, 1, 1]);
        assert_eq!(Frame::new(&witness, &found, pixels, 6.0).filled, (72.0 - 18.0) / 72.0);
    }
}
