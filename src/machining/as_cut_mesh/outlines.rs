//! Outlines of a face in the plan, as polygons.

use crate::geom::{DVec2, Outline};
use crate::mirror::Mirror;
use crate::num::{cos, sin};
use std::f64::consts::TAU;

/// Corners of a round rim: its chords cut 2e-6 of the radius.
const CORNERS: usize = 1440;
/// Corners of a side that is not straight in the plan.
const SIDE: usize = 256;

/// A closed polygon, its corners in order.
pub(super) type Polygon = Vec<DVec2>;

/// The outlines of the panels of `mirror` in X and Y, counter-clockwise, each with its hole if it has one.
#[must_use]
pub fn plan_outlines(mirror: &Mirror) -> Vec<Vec<Polygon>> {
    let place = |q: DVec2| mirror.extended_surface(q).at.truncate();
    let panel: Vec<Polygon> = match mirror.outline {
        Outline::Rect(rect) => {
            let corners = [
                rect.min,
                DVec2::new(rect.max.x, rect.min.y),
                rect.max,
                DVec2::new(rect.min.x, rect.max.y),
            ];
            let parts = if mirror.chart.is_plan() { 1 } else { SIDE };
            let side = |k: usize| {
                let (from, to) = (corners[k], corners[(k + 1) % 4]);
                (0..parts).map(move |part| from.lerp(to, part as f64 / parts as f64))
            };
            vec![(0..4).flat_map(side).map(place).collect()]
        }
        Outline::Ring { inner, outer } => {
            let circle = |radius: f64, sense: f64| -> Polygon {
                let angle = |k: usize| sense * TAU * k as f64 / CORNERS as f64;
                let at = |k: usize| DVec2::new(cos(angle(k)), sin(angle(k))) * radius;
                (0..CORNERS).map(at).map(place).collect()
            };
            let hole = (inner > 0.0).then(|| circle(inner, -1.0));
            std::iter::once(circle(outer, 1.0)).chain(hole).collect()
        }
    };
    if !mirror.folded {
        return vec![panel];
    }
    let image = |side: &Polygon| side.iter().rev().map(|p| DVec2::new(p.x, 0.0 - p.y)).collect();
    let images = panel.iter().map(image).collect();
    vec![panel, images]
}

/// Distances of the inner and of the outer rim of a round `mirror` from the axis in the plan, mm, each the least and the largest: the
/// inner one is 0 of a disc. None of a mirror with straight sides.
#[must_use]
pub fn rim_distances(mirror: &Mirror) -> Option<[[f64; 2]; 2]> {
    let Outline::Ring { .. } = mirror.outline else { return None };
    let rims = plan_outlines(mirror).into_iter().next()?;
    let ends = |rim: &Polygon| {
        let all = rim.iter().map(|corner| corner.length());
        all.fold([f64::INFINITY, 0.0], |[least, most], r| [r.min(least), r.max(most)])
    };
    Some([rims.get(1).map_or([0.0; 2], ends), ends(rims.first()?)])
}

/// The smallest rectangle around outlines: its lower left and upper right corner.
#[must_use]
pub fn bounding_corners(outlines: &[Vec<Polygon>]) -> [DVec2; 2] {
    let all = outlines.iter().flatten().flatten();
    let (lo, hi) = all.fold((DVec2::MAX, DVec2::MIN), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    [lo, hi]
}
