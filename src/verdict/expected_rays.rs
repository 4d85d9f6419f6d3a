//! The table of expected rays that the witness is handed, made from the design.

use crate::design::Design;
use crate::geom::{DVec2, DVec3};
use crate::optics::{ReflectedRay, ShownContent, reflect};
use crate::trace::{ExpectedRay, PixelRay};

/// The table of expected rays, of neighbours in a row of the sensor from a column and a row on, from their camera rays.
/// Rays that may pass by the rim of facets `chord_mm` off the mirror are not aimed at it.
pub(crate) fn expected_rays(
    design: &Design,
    chord_mm: f64,
) -> impl Fn([u32; 2], &[PixelRay]) -> Vec<ExpectedRay> {
    let Design { mirror, view, camera, .. } = design;
    let outline = mirror.full_outline();
    // The mirror's own camera sees the rim of the facets where the mirror's is.
    let off_mm = if camera.chart == mirror.chart { 0.0 } else { chord_mm };
    let needs_place = off_mm != 0.0 || view.as_ref().is_some_and(|view| !view.is_at_infinity());
    let beside = move |at: DVec3, along: DVec3, normal: DVec3| {
        let step = along * (off_mm * normal.z / along.dot(normal));
        let aims = |at: DVec3| outline.aims(mirror.chart.coordinates(at).0);
        !(aims(at + step) && aims(at - step))
    };
    let turn = |column: u32| {
        let x = camera.image_point(f64::from(column) + 0.5, 0.0).x;
        view.as_ref().map_or([0.0, 1.0], |view| view.turn(x))
    };
    let turns: Vec<[f64; 2]> = (0..camera.pixels[0]).map(turn).collect();
    move |[column, row], rays| {
        let image_point =
            |k: u32| camera.image_point(f64::from(column + k) + 0.5, f64::from(row) + 0.5);
        let points: Vec<DVec2> = (0..rays.len() as u32).map(image_point).collect();
        let rise = view.as_ref().map_or(1.0, |view| view.rise(image_point(0).y));
        let under = |ray: &PixelRay| mirror.intersect_camera_ray(&camera.chart, ray.charted);
        let places: Vec<DVec2> =
            rays.iter().map(|ray| under(ray).unwrap_or(DVec2::INFINITY)).collect();
        let is_wanted = |image| view.as_ref().is_none_or(|view| view.projection.wants(image));
        let aims = |image: DVec2, place: DVec2| outline.aims(place) && is_wanted(image);
        let aimed: Vec<usize> = (0..rays.len()).filter(|k| aims(points[*k], places[*k])).collect();
        let of_aimed = mirror.eval_many(&aimed.iter().map(|k| places[*k]).collect::<Vec<_>>());
        let nothing = ShownContent::NONE;
        let unaimed = ExpectedRay { aimed: false, direction: DVec3::Z, designed: nothing };
        let mut expected = vec![unaimed; rays.len()];
        // Their numbers, and what they see.
        let (mut seeing, mut seen) = (Vec::new(), Vec::new());
        for (k, designed) in aimed.into_iter().zip(&of_aimed) {
            let (near, turn, place) = (points[k], turns[column as usize + k], places[k]);
            let arriving = rays[k].ray.direction;
            let normal = mirror.normal(place, designed);
            let at = if needs_place { mirror.position(place, designed) } else { DVec3::ZERO };
            expected[k].aimed = off_mm == 0.0 || !beside(at, arriving, normal);
            if let (true, Some(view)) = (expected[k].aimed, view) {
                let wanted = view.wanted((near, turn), rise);
                expected[k].direction = view.direction_to(&wanted, at);
                let direction = reflect(arriving, normal);
                seen.push((ReflectedRay { at, direction, near, turn }, wanted));
                seeing.push(k);
            }
        }
        let shown = view.as_ref().map_or(Vec::new(), |view| view.shown_beside(&seen));
        for (k, shown) in seeing.into_iter().zip(shown) {
            expected[k].designed = shown;
        }
        expected
    }
}
