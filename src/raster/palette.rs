//! Colours of scales, from a share between 0 and 1.

use super::Srgb;

/// A colour as style sheets write it.
#[must_use]
pub fn hexadecimal([r, g, b]: Srgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// From black to white, without either end: the colours of what is lost stand out.
#[must_use]
pub fn grey(share: f64) -> Srgb {
    [(50.0 + 195.0 * share.clamp(0.0, 1.0)).round() as u8; 3]
}

/// From dark blue over green to yellow: ever brighter (the corners of matplotlib's viridis).
#[must_use]
pub fn viridis(share: f64) -> Srgb {
    const CORNERS: [Srgb; 5] =
        [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
    between(&CORNERS, share)
}

/// From blue over white to red, for departures: ColorBrewer's RdBu, which the colour-blind can read.
#[must_use]
pub fn diverging(share: f64) -> Srgb {
    const CORNERS: [Srgb; 9] = [
        [33, 102, 172],
        [67, 147, 195],
        [146, 197, 222],
        [209, 229, 240],
        [247, 247, 247],
        [253, 219, 199],
        [244, 165, 130],
        [214, 96, 77],
        [178, 24, 43],
    ];
    between(&CORNERS, share)
}

/// The colour at a share of the way along evenly spaced ones.
fn between(corners: &[Srgb], share: f64) -> Srgb {
    let along = share.clamp(0.0, 1.0) * (corners.len() - 1) as f64;
    let k = (along as usize).min(corners.len() - 2);
    let rest = along - k as f64;
    [0, 1, 2].map(|c| {
        let [a, b] = [corners[k], corners[k + 1]].map(|corner| f64::from(corner[c]));
        (a * (1.0 - rest) + b * rest).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_get_brighter() {
        for ramp in [grey as fn(f64) -> Srgb, viridis] {
            let light = |k: i32| {
                let [r, g, b] = ramp(f64::from(k) / 100.0).map(f64::from);
                0.2126 * r + 0.7152 * g + 0.0722 * b
            };
            assert!(
                (0..100).all(|k| light(k + 1) >= light(k) - 0.5) && light(100) > light(0) + 150.0
            );
        }
    }
}
