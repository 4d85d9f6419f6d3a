//! The frame-fill check: how much of the sensor sees what it is meant to see.

use super::{Outcome, Seen, Witness};
use crate::num::{asin, atan2, degrees, wrap_turn};
use rayon::prelude::*;
use serde::Serialize;

/// What the frame as a whole sees.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
}

impl Frame {
    /// Evaluates `witness`, taken with a sensor of `pixels` of `pixel_mm` each.
    #[must_use]
    pub fn new(witness: &Witness, pixels: [u32; 2], pixel_mm: f64, tolerance_px: f64) -> Self {
        let fills = |seen: &&Seen| {
            seen.aimed
                && seen.outcome == Outcome::Hit
                && seen.errors.is_some_and(|e| e.image_mm <= tolerance_px * pixel_mm)
        };
        let filled: Vec<&Seen> = witness.seen.iter().filter(fills).collect();
        let [width, height] = pixels.map(f64::from);
        let radius = 0.5 * width.min(height);
        let disc = std::f64::consts::PI * radius * radius;
        let range = |angle: fn(&Seen) -> f64| {
            let widest = filled
                .par_iter()
                .map(|seen| [angle(seen); 2])
                .reduce_with(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
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

    #[test]
    fn a_filled_frame_gains_what_the_paper_says() {
        let witness = Witness { seen: vec![pixel(Outcome::Hit, 0.0); 640 * 480] };
        let frame = Frame::new(&witness, [640, 480], 0.1, 6.0);
        assert_eq!(frame.filled, 1.0);
        assert!((frame.gain_over_disc - 0.698).abs() < 5e-4, "{}", frame.gain_over_disc);
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
        let frame = Frame::new(&Witness { seen }, [4, 3], 0.1, 6.0);
        assert_eq!(frame.filled, 0.5);
        let [lo, hi] = frame.azimuth_deg.unwrap();
        assert!((lo - 36.87).abs() < 0.01 && lo == hi);
    }
}
