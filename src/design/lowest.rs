//! The lowest point of a mirror, under which the part's base is.

use super::facts::SAMPLES;
use crate::geom::{DVec2, Outline, Rect};
use crate::mirror::Mirror;

/// The least Z over the panel, mm, to rounding (of a surface that sampling does not miss a dip of).
pub fn lowest(mirror: &Mirror) -> f64 {
    let least = |places: Vec<DVec2>| -> Option<(DVec2, f64)> {
        let heights: Vec<f64> = places
            .iter()
            .zip(mirror.along(&places))
            .map(|(&q, point)| mirror.place(q, &point).z)
            .collect();
        places.into_iter().zip(heights).min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let outline = mirror.outline;
    let bounds = outline.bounds();
    let lines = outline.samples(SAMPLES).into_iter();
    let all = lines.flatten().map(|(q, _)| q).collect();
    let Some((mut at, mut z)) = least(all) else { return f64::NAN };
    let mut reach = bounds.size() / SAMPLES as f64;
    // Each step looks closer around the least place so far, by a factor of four.
    for _ in 0..12 {
        let near = Rect { min: (at - reach).max(bounds.min), max: (at + reach).min(bounds.max) };
        let mut places: Vec<DVec2> = near.grid(8, 8).map(|(q, _)| onto(outline, q)).collect();
        places.push(at);
        (at, z) = least(places).unwrap_or((at, z));
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
