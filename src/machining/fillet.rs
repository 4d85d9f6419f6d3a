//! The valley between two panels of a folded mirror, of which a ball leaves a fillet.

use crate::geom::DVec2;
use crate::mirror::{LocalSurface, Mirror};
use crate::optics::Camera;
use serde::Serialize;

/// Whether a ball that touches the mirror at `place` stays on its own side of the ridge of a folded
/// mirror: in a valley the other panel is in the way of one that does not.
#[must_use]
pub fn clears_ridge(mirror: &Mirror, place: &LocalSurface, ball_mm: f64) -> bool {
    ridge_clearance(mirror, place, ball_mm) >= 0.0
}

/// How far the centre of a ball on `place` is from the plane of the ridge, on the place's own side, mm: without a ridge
/// infinitely far. On the ridge the designed panel's side counts.
pub(super) fn ridge_clearance(mirror: &Mirror, place: &LocalSurface, ball_mm: f64) -> f64 {
    if !mirror.folded {
        return f64::INFINITY;
    }
    let y = if place.at.y == 0.0 { mirror.outline.bounds().centre().y } else { place.at.y };
    y.signum() * (place.at.y + ball_mm * place.normal().y)
}

/// What the ball leaves of the valley of a folded mirror: a hollow edge becomes a fillet of the ball's
/// radius between the places where it touches both panels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Fillet {
    /// Width where it is widest, in the plan, mm.
    pub width_max_mm: f64,
    /// Mean width along the valley, mm.
    pub width_mean_mm: f64,
    /// Height that it leaves over the valley's bottom, at most, mm.
    pub left_max_mm: f64,
    /// Pixels of the image that it takes.
    pub pixels: f64,
}

/// Places along the ridge.
const ALONG: usize = 256;

impl Fillet {
    /// The fillet of a ball in the valley of `mirror`; none where there is no valley.
    #[must_use]
    pub fn new(mirror: &Mirror, camera: &Camera, ball_mm: f64) -> Option<Self> {
        let bounds = mirror.outline.bounds();
        let step = bounds.size().x / ALONG as f64;
        let (mut widths, mut area, mut left) = (Vec::new(), 0.0, 0.0f64);
        for k in 0..=ALONG {
            let x = bounds.min.x + step * k as f64;
            let Some(q) = fillet_foot(mirror, x, ball_mm) else {
                widths.push(0.0);
                continue;
            };
            let (foot, bottom) =
                (mirror.extended_surface(q), mirror.extended_surface(DVec2::new(x, 0.0)));
            let end = if k == 0 || k == ALONG { 0.5 } else { 1.0 };
            widths.push(2.0 * foot.at.y.abs());
            area += 2.0 * q.y.abs() * step * end;
            let lowest = foot.at.z + ball_mm * (foot.normal().z - 1.0);
            left = left.max(lowest - bottom.at.z);
        }
        let widest = widths.iter().copied().fold(0.0, f64::max);
        (widest > 0.0).then(|| Self {
            width_max_mm: widest,
            width_mean_mm: widths.iter().sum::<f64>() / widths.len() as f64,
            left_max_mm: left,
            pixels: area / (camera.pixel_mm * camera.pixel_mm),
        })
    }
}

/// Where on the designed panel, at `x` of the chart, a ball touches that lies in the valley on both panels;
/// none where there is no valley. The panel's far rim where it touches nowhere.
#[must_use]
pub fn fillet_foot(mirror: &Mirror, x: f64, ball_mm: f64) -> Option<DVec2> {
    if !mirror.folded {
        return None;
    }
    let bounds = mirror.outline.bounds();
    let far = if bounds.centre().y < 0.0 { bounds.min.y } else { bounds.max.y };
    let at = |share: f64| DVec2::new(x, far * share);
    // On the ridge itself the designed panel's side counts.
    let clear = |share: f64| {
        let place = mirror.extended_surface(at(share));
        far.signum() * (place.at.y + ball_mm * place.normal().y)
    };
    const STEPS: usize = 64;
    let share = |k: usize| k as f64 / STEPS as f64;
    // Where the panels meet without an edge, what is less is rounding.
    if clear(0.0) >= -1e-9 * ball_mm {
        return None;
    }
    let Some(first) = (1..=STEPS).find(|&k| clear(share(k)) >= 0.0) else { return Some(at(1.0)) };
    let [mut lo, mut hi] = [share(first - 1), share(first)];
    for _ in 0..50 {
        let middle = 0.5 * (lo + hi);
        if clear(middle) < 0.0 { lo = middle } else { hi = middle }
    }
    Some(at(hi))
}
