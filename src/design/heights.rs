//! The lowest point of a mirror, under which the part's base is, and the highest.

use super::facts::SAMPLES;
use crate::geom::{DVec2, Outline, Rect};
use crate::mirror::Mirror;

/// The least and the largest Z over the mirror, mm, to rounding (of a surface that sampling does not
/// miss a dip or a peak of).
pub(super) fn height_range(mirror: &Mirror) -> [f64; 2] {
    if !mirror.has_steps() {
        return range_without_steps(mirror);
    }
    // Samples on a line between panels are those of one of them, and the other one may be highest there.
    let of_panels = mirror.panels().into_iter().map(|panel| range_without_steps(&panel));
    of_panels.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], [low, high]| {
        [least.min(low), most.max(high)]
    })
}

fn range_without_steps(mirror: &Mirror) -> [f64; 2] {
    let lines = mirror.outline.samples(SAMPLES).into_iter();
    let all: Vec<DVec2> = lines.flatten().map(|(q, _)| q).collect();
    let found = along(mirror, &all);
    [1.0, -1.0].map(|sign| sign * least(mirror, &all, &found, sign))
}

/// Z at `places`, mm.
fn along(mirror: &Mirror, places: &[DVec2]) -> Vec<f64> {
    let points = mirror.eval_many(places);
    places.iter().zip(points).map(|(&q, point)| mirror.position(q, &point).z).collect()
}

/// The least Z times `sign`, sought from the least of the `heights` of `places` on.
fn least(mirror: &Mirror, places: &[DVec2], heights: &[f64], sign: f64) -> f64 {
    let lower = |places: &[DVec2], heights: &[f64]| -> Option<(DVec2, f64)> {
        let signed = heights.iter().map(|z| sign * z);
        places.iter().copied().zip(signed).min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let Some((mut at, mut z)) = lower(places, heights) else { return f64::NAN };
    let bounds = mirror.outline.bounds();
    let mut reach = bounds.size() / SAMPLES as f64;
    // Each step looks closer around the least place so far, by a factor of four.
    for _ in 0..12 {
        let near = Rect { min: (at - reach).max(bounds.min), max: (at + reach).min(bounds.max) };
        let mut places: Vec<DVec2> =
            near.grid(8, 8).map(|(q, _)| onto(mirror.outline, q)).collect();
        places.push(at);
        (at, z) = lower(&places, &along(mirror, &places)).unwrap_or((at, z));
        reach /= 4.0;
    }
    z
}

/// The nearest point of the outline.
fn onto(outline: Outline, q: DVec2) -> DVec2 {
    match outline {
        Outline::Rect(_) => q,
        Outline::Ring { inner, outer } => {
            let r = q.length();
            if r > 0.0 { q * (r.clamp(inner, outer) / r) } else { DVec2::new(inner, 0.0) }
        }
    }
}
