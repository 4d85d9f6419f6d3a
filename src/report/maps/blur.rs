//! `blur.png`: how large a spot each pixel sees.

use crate::pencil::Quantiles;
use crate::raster::palette::viridis;
use crate::raster::{EncodingError, FalseColourMap, Srgb};
use crate::results::{BlurReport, digits};

const NO_MIRROR: Srgb = [200; 3];

impl BlurReport {
    /// `blur.png`: the full `lengths` of the spots, px, one a pixel.
    ///
    /// # Errors
    /// What the encoder reports.
    ///
    /// # Panics
    /// When there is not one entry a pixel.
    pub fn png(&self, lengths: &[Option<f64>]) -> Result<Vec<u8>, EncodingError> {
        let Quantiles { p95, max, .. } = self.spots.length_px;
        // A few very large spots must not make all others look alike.
        let top = max.min(2.0 * p95);
        let beyond = if max > top { "over " } else { "" };
        let colour = |length: &Option<f64>| length.map_or(NO_MIRROR, |px| viridis(px / top));
        let map = FalseColourMap {
            pixels: self.pixels,
            colours: lengths.iter().map(colour).collect(),
            title: "full length of the spot, px".into(),
            ramp: viridis,
            ticks: vec!["0".into(), digits(0.5 * top), format!("{beyond}{}", digits(top))],
            keys: vec![(NO_MIRROR, "no mirror".into())],
            pixel_mm: None,
        };
        map.png()
    }
}
