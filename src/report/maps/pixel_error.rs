//! The pixel error over the frame.

use crate::design::DesignFacts;
use crate::num::degrees;
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

/// The map of the pixel errors of a designed mirror (as of [`pixel_error_map`]); its title has those of the design's
/// `facts`, with the angles in degrees.
///
/// # Panics
/// When there is not one entry a pixel.
#[must_use]
pub fn design_error_map(
    pixels: [u32; 2],
    errors: &[Option<f64>],
    facts: &DesignFacts,
) -> FalseColourMap {
    let map = pixel_error_map(pixels, errors);
    let (Some(pixel), Some(ray)) = (facts.pixel_error_px, facts.ray_error_mrad) else { return map };
    let [rms_deg, max_deg] = [ray.rms, ray.max].map(|mrad| digits(degrees(1e-3 * mrad)));
    let [rms, max] = [pixel.rms, pixel.max].map(digits);
    let title =
        format!("design's pixel error, px: {rms} rms, {max} max ({rms_deg}, {max_deg} deg)");
    FalseColourMap { title, ..map }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::decoded;

    /// A degree is pi / 180 of a radian.
    #[test]
    fn the_map_of_a_design_tells_angles_in_degrees() {
        let of = |rms, max| Some(Summary { rms, p95: max, max });
        let (pixel_error_px, ray_error_mrad) = (of(1.5, 4.0), of(17.453_292_52, 34.906_585_04));
        let facts = DesignFacts { pixel_error_px, ray_error_mrad, ..DesignFacts::given(2) };
        let map = design_error_map([1, 1], &[Some(1.0)], &facts);
        let wanted = "design's pixel error, px: 1.500 rms, 4.000 max (1.000, 2.000 deg)";
        assert_eq!(map.title, wanted);
        let unknown = design_error_map([1, 1], &[Some(1.0)], &DesignFacts::given(2));
        assert_eq!(unknown.title, "pixel error, px: 1.000 rms, 1.000 max");
    }

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
