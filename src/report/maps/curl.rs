//! The curl of the slopes that a picture asks for.

use super::pixel_error::pixel_error_map;
use crate::num::stats::Summary;
use crate::raster::FalseColourMap;
use crate::results::digits;

/// The map of the curl, as the pixel error that a square of a tenth of the frame's width around each pixel has for itself
/// (px, one a pixel of the map; none where nothing is wanted).
///
/// # Panics
/// When there is not one entry a pixel.
#[must_use]
pub fn curl_map(pixels: [u32; 2], own: &[Option<f64>]) -> FalseColourMap {
    let found = Summary::weighted(own.iter().flatten().map(|px| (*px, 1.0)).collect());
    let title = found.map_or("nothing is wanted".into(), |found| {
        let [rms, max] = [found.rms, found.max].map(digits);
        format!("curl, px that a square 0.1 wide is off: {rms} rms, {max} max")
    });
    let mut map = pixel_error_map(pixels, own);
    map.keys.iter_mut().for_each(|(_, text)| *text = "no mirror, or nothing is wanted".into());
    FalseColourMap { title, ..map }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_has_the_root_mean_square_and_the_largest() {
        let map = curl_map([2, 1], &[Some(3.0), Some(4.0)]);
        assert!(map.title.ends_with("is off: 3.536 rms, 4.000 max"), "{}", map.title);
        assert_eq!(curl_map([1, 1], &[None]).title, "nothing is wanted");
    }
}
