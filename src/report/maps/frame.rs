//! `frame.png`: which pixels are filled, how large they are in the world, and why the others are not.

use crate::raster::palette::grey;
use crate::raster::{FalseColourMap, Srgb};
use crate::report::frame::LOST;
use crate::results::{FrameReport, digits};
use crate::trace::{MinMeanMax, PixelClass};

/// Colours of the causes, in the order of [`PixelClass::LOST`].
const COLOURS: [Srgb; 7] = [
    [31, 59, 115],
    [255, 140, 0],
    [255, 225, 0],
    [208, 0, 32],
    [224, 0, 192],
    [0, 160, 0],
    [0, 200, 216],
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
        let MinMeanMax { min, mean, max } =
            self.resolution.pixel_usr.unwrap_or(MinMeanMax { min: 0.0, mean: 0.0, max: 0.0 });
        // Where all are equal but for rounding there is no scale.
        let even = !(max - min > 1e-6 * mean);
        let share = |usr: f64| if even { 0.5 } else { (usr - min) / (max - min) };
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
                vec![digits(mean)]
            } else {
                [min, 0.5 * (min + max), max].map(digits).to_vec()
            },
            keys: keys.map(|((c, name), n)| (c, format!("{n} {name}"))).collect(),
            pixel_mm: None,
        }
    }
}
