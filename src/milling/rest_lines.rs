//! Lines of a flat or a bull-nosed cutter that roughs: where it rests on the mirror, over straight lines of the plan.

use super::bridge::TipLines;
use super::rest_heights::RestHeights;
use super::tip_line::TipLine;
use crate::geom::{DVec2, DVec3};
use crate::machining::BallRaster;
use crate::parallel;

/// Places of a line along the longer side of a mirror: a hemisphere over that side stands over the chord between two by three millionths of it.
const PLACES: f64 = 300.0;

/// Lines in the direction and at the distance of a raster over the plan between two corners, from where the cutter first rests on the mirror or on
/// what goes on beyond its rim to where it does so last. Where nothing is below it, as over the hole of an annulus, it goes straight on.
pub(super) fn rest_lines(
    heights: &RestHeights,
    raster: &BallRaster,
    [low, high]: [DVec2; 2],
) -> TipLines {
    let (along, across) = (raster.along(), raster.along().perp());
    let corners = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)];
    let range = |way: DVec2| {
        let all = corners.map(|corner| corner.dot(way));
        all.into_iter().fold([f64::MAX, f64::MIN], |[a, b], p| [a.min(p), b.max(p)])
    };
    let w = raster.stepover_mm;
    let [[t_low, t_high], [u_low, u_high]] = [along, across].map(range);
    // Beyond both sides as far as the cutter reaches and some more.
    let beyond = 2.0 * raster.ball_mm;
    let [t_low, t_high] = [t_low - beyond, t_high + beyond];
    let step = (high - low).max_element() / PLACES;
    let count = ((t_high - t_low) / step).ceil() as usize;
    let first = (u_low / w - 0.5).floor() as i64 - 1;
    let last = (u_high / w - 0.5).ceil() as i64 + 1;
    let line = |k: i64| {
        let foot = across * ((k as f64 + 0.5) * w);
        let place = |n: usize| {
            let at = foot + along * (t_low + (t_high - t_low) * n as f64 / count as f64);
            heights.tip(at).map(|z| at.extend(z))
        };
        let places: Vec<DVec3> = (0..=count).filter_map(place).collect();
        let directions = [along.extend(0.0); 2];
        (places.len() > 1).then_some(TipLine { places, directions })
    };
    let all = parallel::map((last - first + 1).max(0) as usize, 1, |k| line(first + k as i64));
    TipLines { across: all.into_iter().flatten().collect(), ridge: Vec::new() }
}
