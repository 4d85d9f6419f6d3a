//! One row of a remap table: searched at some of its pixels, interpolated between where that is as good.

use super::{ImageLocation, InverseSearch};
use crate::geom::DVec2;

/// Number of searched pixels of a row, about.
const KNOTS: usize = 320;
/// The largest error, in pixels of the sensor, of a knot when it is interpolated between others twice as
/// far apart as those that are used then; the cubic's own error is a sixteenth.
const TOLERANCE_PX: f64 = 1e-3;

/// Where the `width` directions `sigma` of a row are seen, by a sensor with pixels of `pixel_mm`.
pub(super) fn locate_row(
    search: &mut InverseSearch,
    width: usize,
    pixel_mm: f64,
    sigma: impl Fn(usize) -> [f64; 2],
) -> Vec<Option<ImageLocation>> {
    let stride = (width / KNOTS).max(2);
    let knots: Vec<_> = (0..width).step_by(stride).map(|x| search.find(sigma(x))).collect();
    let four = |first: usize, step: usize| -> Option<[ImageLocation; 4]> {
        let knot = |k: usize| knots.get(first + k * step).copied().flatten();
        Some([knot(0)?, knot(1)?, knot(2)?, knot(3)?])
    };
    let good = |k: usize| {
        let error = || {
            let (known, found) = (knots[k]?, cubic(four(k.checked_sub(3)?, 2)?, 0.5));
            let off = |f: ImageLocation| f.image - f.intended;
            let error = (found.image - known.image).length();
            Some(error.max((off(found) - off(known)).length()))
        };
        error().is_some_and(|error| error <= TOLERANCE_PX * pixel_mm)
    };
    let good: Vec<bool> = (0..knots.len()).map(good).collect();
    let place = |x: usize| {
        let (k, part) = (x / stride, x % stride);
        if part == 0 {
            return knots[k];
        }
        let trusted = good[k] && good.get(k + 1) == Some(&true);
        match trusted.then(|| four(k - 1, 1)).flatten() {
            Some(around) => Some(cubic(around, part as f64 / stride as f64)),
            None => search.find(sigma(x)),
        }
    };
    (0..width).map(place).collect()
}

/// Cubic interpolation at `t` through locations at -1, 0, 1 and 2.
fn cubic(around: [ImageLocation; 4], t: f64) -> ImageLocation {
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    let weights = [-t * b * c / 6.0, a * b * c / 2.0, -a * t * c / 2.0, a * t * b / 6.0];
    let mix = |of: fn(&ImageLocation) -> DVec2| {
        around.iter().zip(weights).map(|(found, weight)| of(found) * weight).sum()
    };
    ImageLocation { image: mix(|found| found.image), intended: mix(|found| found.intended) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::design;
    use crate::profile::Profile;
    use crate::unwrap::{DirectionPicture, ImagingSystem, InverseMap, Panorama};

    #[test]
    fn interpolated_places_are_the_searched_ones_and_searches_are_few() {
        let text = "camera.orthographic.pixels = [160, 120]
projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }
layout.conquistador.fill_frame = true
method.vector-field.degree = 12
part = { width_mm = 15, base_mm = 2 }
mesh.chord_um = 20
export.formats = [\"stl\"]
";
        let profile = Profile::parse("p", "p.toml", text.as_bytes()).unwrap();
        let design = design(&profile).unwrap();
        let (mirror, camera) = (&design.mirror, &design.camera);
        let optics = ImagingSystem { mirror, camera, view: design.view.as_ref().unwrap() };
        let panorama = Panorama::new(&optics, [160, 120], None, Some(2000)).unwrap();
        let finder = InverseMap::new(optics);
        let [width, height] = panorama.size;
        for y in (0..height).step_by(23) {
            let searched = std::cell::Cell::new(0);
            let sigma = |x: usize| panorama.sigma(x as f64 + 0.5, y as f64 + 0.5);
            let counting = |x: usize| {
                searched.set(searched.get() + 1);
                sigma(x)
            };
            let row = locate_row(&mut finder.search(), width, camera.pixel_mm, counting);
            for (x, found) in row.into_iter().enumerate() {
                let exact = finder.search().find(sigma(x));
                assert_eq!(found.is_some(), exact.is_some(), "{x} {y}");
                let (Some(found), Some(exact)) = (found, exact) else { continue };
                let off = (found.image - exact.image).length() / camera.pixel_mm;
                let aside = (found.intended - exact.intended).length() / camera.pixel_mm;
                assert!(off < 1e-4 && aside < 1e-4, "{x} {y}: {off:e} {aside:e}");
            }
            assert!((300..width / 4).contains(&searched.get()), "{y}: {}", searched.get());
        }
    }
}
