//! The table of expected rays that the witness is handed, made from the design.

use crate::design::Design;
use crate::geom::{DVec2, DVec3};
use crate::optics::{ReflectedRay, ShownContent, reflect};
use crate::trace::{ExpectedRay, PixelRay};

/// More than coordinates of the chart change with a place of the plan.
const NEAR: f64 = 4.0;

/// Where the camera sees the rim of what is traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RimShift {
    /// Where the mirror's is.
    None,
    /// Where that of facets is, each of whose places is up to so many millimetres above or below a place of the mirror, on its chart's rays.
    Facets(f64),
    /// Where that of a part as cut is, which is so many millimetres above or below the mirror's, and in the plan there; but no more than a pixel
    /// farther, beyond which the picture ends elsewhere.
    Cut(f64),
}

/// The table of expected rays, of neighbours in a row of the sensor from a column and a row on, from their camera rays.
/// Rays that may pass by the `rim` of what is traced are not aimed at it.
pub(crate) fn expected_rays(
    design: &Design,
    rim: RimShift,
) -> impl Fn([u32; 2], &[PixelRay]) -> Vec<ExpectedRay> {
    let Design { mirror, view, camera, .. } = design;
    let outline = mirror.full_outline();
    let shifts = rim != RimShift::None;
    let needs_place = shifts || view.as_ref().is_some_and(|view| !view.is_at_infinity());
    let plan = mirror.chart.parallel();
    let beside = move |place: DVec2, at: DVec3, along: DVec3, normal: DVec3| {
        let step = |mm: f64| along * (mm * normal.z / along.dot(normal));
        match rim {
            RimShift::None => false,
            RimShift::Facets(mm) => {
                let aims = |at: DVec3| outline.aims(mirror.chart.coordinates(at).0);
                !(aims(at + step(mm)) && aims(at - step(mm)))
            }
            RimShift::Cut(mm) => {
                let step = step(mm);
                let apart = step.truncate().length();
                let step = step * (camera.pixel_mm / apart).min(1.0);
                // Far from the rim nothing passes by it.
                let reach = NEAR * apart.min(camera.pixel_mm);
                let ways = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
                let is_far = ways.into_iter().all(|way| outline.aims(place + reach * way));
                let aims = |at: DVec3| {
                    let under = mirror.intersect_camera_ray_near(&plan, at.truncate(), at.z);
                    under.is_some_and(|place| outline.aims(place))
                };
                !(is_far || aims(at + step) && aims(at - step))
            }
        }
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
            expected[k].aimed = !beside(place, at, arriving, normal);
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
