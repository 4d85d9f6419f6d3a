//! Pictures given as data: NumPy arrays, OpenEXR pictures and text.

use morion::internals::geom::{DVec2, Rect};
use morion::internals::optics::{DirectionSamples, SampledMap};
use morion::internals::profile::VectorMap;

pub fn holds(bytes: &[u8]) {
    let Ok(map) = VectorMap::parse(bytes) else { return };
    let count = map.vectors.len();
    assert!(map.columns > 0 && count % map.columns == 0, "{} of {count}", map.columns);
    // Larger ones take their time.
    if count > 4096 {
        return;
    }
    let towards = map.vectors.iter().map(|v| v.normalize()).collect();
    for directions in [map.vectors, towards] {
        if let Ok(samples) = DirectionSamples::new(map.columns, directions) {
            is_a_picture(&samples);
        }
    }
}

/// Each place of the frame sees a direction, and what is found of that sees the same.
fn is_a_picture(samples: &DirectionSamples) {
    let frame = Rect { min: DVec2::new(-4.0, -3.0), max: DVec2::new(4.0, 3.0) };
    let map = SampledMap::new(samples, frame, frame);
    assert!(map.interpolation_error() >= 0.0 && (0.0..1.0).contains(&map.gap_share()));
    for k in 0..63 {
        let share = DVec2::new(f64::from(k % 9), f64::from(k / 9)) / DVec2::new(8.0, 6.0);
        let image = frame.min + share * frame.size();
        let sigma = map.direction_of(image.to_array());
        assert!(sigma.iter().all(|x| x.is_finite()), "{image} {samples:?}");
        let found = map.image_of(sigma, image + DVec2::new(0.1, -0.1));
        let seen = map.direction_of(found);
        let off = DVec2::from_array(seen) - DVec2::from_array(sigma);
        let size = 1.0 + DVec2::from_array(sigma).length();
        assert!(off.is_nan() || off.length() <= 1e-6 * size, "{image} {found:?} {off}");
    }
}
