//! `frame.png`: which pixels are filled, how large they are in the world, and why the others are not.

use crate::raster::palette::grey;
use crate::raster::{FalseColourMap, Srgb};
use crate::report::frame::LOST;
use crate::results::{FrameReport, digits};
use crate::trace::PixelClass;

/// Share of the filled pixels beyond either end of the scale.
const BEYOND: f64 = 0.02;

/// Colours of the causes, in the order of [`PixelClass::LOST`].
const COLOURS: [Srgb; 8] = [
    [31, 59, 115],
    [255, 140, 0],
    [255, 225, 0],
    [208, 0, 32],
    [224, 0, 192],
    [0, 160, 0],
    [0, 200, 216],
    [128, 80, 32],
];

impl FrameReport {
    /// The map of the frame: filled pixels grey by solid angle (`usr`, one a pixel), the others in the colour
    /// of their cause; a map of so many columns and rows of the frame's pixels.
    ///
    /// # Panics
    /// When `classes` or `usr` have not one entry a pixel of the map.
    #[must_use]
    pub fn map(
        &self,
        pixels: [u32; 2],
        classes: &[PixelClass],
        usr: &[Option<f64>],
    ) -> FalseColourMap {
        assert_eq!(classes.len(), usr.len(), "one entry a pixel");
        let filled = classes.iter().zip(usr).filter(|(class, _)| **class == PixelClass::Filled);
        let mut sorted: Vec<f64> = filled.filter_map(|(_, usr)| *usr).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let rank = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
            sorted.get(rank).copied().unwrap_or(0.0)
        };
        // A few pixels at an edge or pole must not make all others look alike.
        let [low, middle, high] = [BEYOND, 0.5, 1.0 - BEYOND].map(at);
        // Where all are equal but for rounding there is no scale.
        let even = !(high - low > 1e-6 * middle);
        let share = |usr: f64| if even { 0.5 } else { (usr - low) / (high - low) };
        let colour = |(class, usr): (&PixelClass, &Option<f64>)| match class {
            PixelClass::Filled => grey(usr.map_or(0.0, share)),
            class => {
                PixelClass::LOST.iter().position(|f| f == class).map_or([0; 3], |k| COLOURS[k])
            }
        };
        let keys = COLOURS.into_iter().zip(LOST).zip(self.frame.lost.counts());
        let keys = keys.filter(|(_, count)| *count > 0);
        FalseColourMap {
            pixels,
            colours: classes.iter().zip(usr).map(colour).collect(),
            title: "solid angle of a pixel, usr".into(),
            ramp: grey,
            ticks: if even {
                vec![digits(middle)]
            } else {
                let ends = [(at(0.0) < low, "under ", low), (at(1.0) > high, "over ", high)];
                let [low_text, high_text] = ends.map(|(is_beyond, word, usr)| {
                    format!("{}{}", if is_beyond { word } else { "" }, digits(usr))
                });
                vec![low_text, digits(0.5 * (low + high)), high_text]
            },
            keys: keys.map(|((c, name), n)| (c, format!("{n} {name}"))).collect(),
            pixel_mm: None,
        }
    }
}
