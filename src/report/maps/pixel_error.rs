//! The pixel error over the frame.

use crate::num::rounding::ceil_125;
use crate::num::stats::Summary;
use crate::raster::palette::viridis;
use crate::raster::{FalseColourMap, Srgb};
use crate::results::digits;

const NO_MIRROR: Srgb = [200; 3];
/// The least scale, px: the errors of an exact mirror are rounding.
const LEAST: f64 = 1e-3;

/// The map of the pixel errors (px, one a pixel of the map; none where nothing is seen), with a scale that
/// ends above all but one in twenty of them.
///
/// # Panics
/// When there is not one entry a pixel.
#[must_use]
pub fn pixel_error_map(pixels: [u32; 2], errors: &[Option<f64>]) -> FalseColourMap {
    let known = errors.iter().flatten().map(|px| (*px, 1.0)).collect();
    let summary = Summary::weighted(known);
    let top = summary.map_or(1.0, |found| ceil_125(found.p95.max(LEAST)));
    let beyond = if summary.is_some_and(|found| found.max > top) { "over " } else { "" };
    let title = summary.map_or("no pixel shows the target".into(), |found| {
        format!("pixel error, px: {} rms, {} max", digits(found.rms), digits(found.max))
    });
    let colour = |px: &Option<f64>| px.map_or(NO_MIRROR, |px| viridis(px / top));
    FalseColourMap {
        pixels,
        colours: errors.iter().map(colour).collect(),
        title,
        ramp: viridis,
        ticks: vec!["0".into(), (0.5 * top).to_string(), format!("{beyond}{top}")],
        keys: vec![(NO_MIRROR, "no mirror, in its own shadow, or no place in the image".into())],
        pixel_mm: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::decoded;

    #[test]
    fn the_scale_ends_at_a_round_number_above_the_95th_percentile() {
        let mut errors = vec![Some(0.9); 99];
        errors.push(None);
        let (width, _, rgb) = decoded(&pixel_error_map([10, 10], &errors).png().unwrap());
        let at = |x: u32, y: u32| &rgb[3 * (y * width + x) as usize..][..3];
        assert_eq!(at(0, 0), viridis(0.9));
        assert_eq!(at(width - 1, 9 * width / 10), NO_MIRROR);
        assert!(pixel_error_map([2, 1], &[None, None]).png().is_ok());
    }
}
