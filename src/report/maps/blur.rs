//! How large a spot each pixel sees.

use crate::pencil::Quantiles;
use crate::raster::palette::viridis;
use crate::raster::{FalseColourMap, Srgb};
use crate::results::{BlurReport, digits};

const NO_MIRROR: Srgb = [200; 3];

impl BlurReport {
    /// The map of the full `lengths` of the spots, px, one a pixel.
    ///
    /// # Panics
    /// When there is not one entry a pixel.
    #[must_use]
    pub fn map(&self, lengths: &[Option<f64>]) -> FalseColourMap {
        spot_map(self.pixels, lengths, &self.spots.length_px, "full length of the spot, px")
    }
}

/// The map of the sizes of spots (px, one a pixel of the map; none where there is no mirror), on a scale that ends at
/// twice what 95 % of them do not exceed.
///
/// # Panics
/// When there is not one entry a pixel.
#[must_use]
pub fn spot_map(
    pixels: [u32; 2],
    sizes: &[Option<f64>],
    found: &Quantiles,
    title: &str,
) -> FalseColourMap {
    let Quantiles { p95, max, .. } = *found;
    // A few very large spots must not make all others look alike.
    let top = max.min(2.0 * p95);
    let beyond = if max > top { "over " } else { "" };
    let colour = |length: &Option<f64>| length.map_or(NO_MIRROR, |px| viridis(px / top));
    FalseColourMap {
        pixels,
        colours: sizes.iter().map(colour).collect(),
        title: title.into(),
        ramp: viridis,
        ticks: vec!["0".into(), digits(0.5 * top), format!("{beyond}{}", digits(top))],
        keys: vec![(NO_MIRROR, "no mirror".into())],
        pixel_mm: None,
    }
}
