//! `form-error.png`: how far a measured part is from its design.

use crate::align::{FormError, FormMap};
use crate::num::rounding::ceil_125;
use crate::raster::palette::diverging;
use crate::raster::{FalseColourMap, Srgb};
use crate::results::digits;

/// Where nothing is known.
const NOTHING: Srgb = [110, 110, 114];

/// The map of the form error as the camera would see it: red above the design, blue below,
/// grey where nothing is known, with a scale that reaches as far as the map does without outliers.
#[must_use]
pub fn form_map(map: &FormMap, error: Option<&FormError>) -> FalseColourMap {
    let limit = error.map_or(1.0, limit);
    let colour = |mm: &f64| {
        if mm.is_nan() { NOTHING } else { diverging(0.5 + 0.5e3 * mm / limit) }
    };
    let tick = |share: f64| if share == 0.0 { "0".into() } else { format!("{:+}", share * limit) };
    let title = error.map_or("nothing measured".into(), |error| {
        let [pv, rms] = [error.all.pv, error.all.rms].map(digits);
        format!("form error, um: {pv} PV, {rms} rms")
    });
    FalseColourMap {
        pixels: map.pixels,
        colours: map.mm.iter().map(colour).collect(),
        title,
        ramp: diverging,
        ticks: [-1.0, -0.5, 0.0, 0.5, 1.0].map(tick).to_vec(),
        keys: vec![(NOTHING, "nothing known".into())],
        pixel_mm: None,
    }
}

/// The next round number, um, that is not less than any departure but the outliers'.
fn limit(error: &FormError) -> f64 {
    ceil_125(error.without_outliers.highest.max(-error.without_outliers.lowest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::decoded;

    #[test]
    fn scales_end_at_round_numbers() {
        for (most, exact) in
            [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (4.0, 5.0), (60.0, 100.0), (3e-4, 5e-4)]
        {
            let mm = vec![-1e-3 * most, 0.5e-3 * most, f64::NAN];
            let error = FormMap { pixels: [3, 1], mm }.error().unwrap();
            assert_eq!(limit(&error), exact, "{most}");
        }
    }

    #[test]
    fn the_picture_holds_the_map_and_a_scale() {
        let map = FormMap { pixels: [2, 1], mm: vec![1e-3, f64::NAN] };
        let (width, _, rgb) = decoded(&form_map(&map, map.error().as_ref()).png().unwrap());
        // Each pixel a square; the first as high as it gets, the second unknown.
        let middle = |k: usize| 3 * (width as usize * (2 * k + 1) / 4);
        assert_eq!(width, 640);
        assert_eq!(rgb[middle(0)..][..3], diverging(1.0));
        assert_eq!(rgb[middle(1)..][..3], NOTHING);
        assert!(form_map(&FormMap { pixels: [2, 1], mm: vec![f64::NAN; 2] }, None).png().is_ok());
    }
}
