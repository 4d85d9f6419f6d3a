//! `gouge.png`: what a ball cutter leaves on the face.

use crate::machining::{FLOOR_MM, Gouge};
use crate::num::log;
use crate::num::stats::Summary;
use crate::raster::palette::viridis;
use crate::raster::{FalseColourMap, Srgb};

/// Where there is no mirror, and where the ball leaves nothing.
const NO_MIRROR: Srgb = [255; 3];
const FITS: Srgb = [200, 200, 204];

/// What a ball of `ball_mm` leaves on the face.
#[must_use]
pub fn gouge_map(gouge: &Gouge, ball_mm: f64) -> FalseColourMap {
    let title = format!("left by a ball of {ball_mm} mm radius, um");
    left_map(&gouge.rest_mm, (gouge.size, gouge.step), (title, "fits"))
}

/// What is left on the face over a grid of columns and rows, mm, row by row with Y rising, and none off it, seen from above, on a
/// scale of decades from [`FLOOR_MM`] that ends above all but one in twenty of the places where something is left. A place
/// where less is left is called `little`.
pub(in super::super) fn left_map(
    left_mm: &[Option<f64>],
    ([columns, rows], pitch_mm): ([usize; 2], f64),
    (title, little): (String, &str),
) -> FalseColourMap {
    let over = |mm: f64| log(mm / FLOOR_MM) / log(10.0);
    let left = left_mm.iter().flatten().filter(|mm| **mm >= FLOOR_MM);
    let found = Summary::of(left.copied().collect());
    let decades = found.map_or(1.0, |found| (over(found.p95) - 1e-9).ceil().max(1.0));
    let beyond = found.is_some_and(|found| over(found.max) > decades + 1e-9);
    let colour = |left: Option<f64>| match left {
        None => NO_MIRROR,
        Some(..FLOOR_MM) => FITS,
        Some(mm) => viridis(over(mm) / decades),
    };
    let row = |row: usize| left_mm[row * columns..][..columns].iter();
    // In um: tenths of a power of ten are exact.
    let powers = std::iter::successors(Some(1e4 * FLOOR_MM), |power| Some(10.0 * power));
    FalseColourMap {
        pixels: [columns as u32, rows as u32],
        colours: (0..rows).rev().flat_map(row).map(|left| colour(*left)).collect(),
        title,
        ramp: viridis,
        ticks: powers
            .take(decades as usize + 1)
            .enumerate()
            .map(|(k, um)| {
                let word = if beyond && k == decades as usize { "over " } else { "" };
                format!("{word}{}", 0.1 * um)
            })
            .collect(),
        keys: vec![(FITS, format!("{little}: less than {} um", 1e3 * FLOOR_MM))],
        pixel_mm: Some(pitch_mm),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;
    use crate::raster::decoded;

    #[test]
    fn the_map_has_y_upwards_and_the_colours_of_its_decades() {
        let left = vec![Some(0.0), None, Some(1e-1), Some(1e-2)];
        let gouge = Gouge {
            size: [2, 2],
            first: DVec2::ZERO,
            step: 0.5,
            rest_mm: left,
            largest: None,
            largest_outside_fillet: None,
        };
        let (width, _, rgb) = decoded(&gouge_map(&gouge, 3.0).png().unwrap());
        let (width, cell) = (width as usize, 320);
        let at = |x: usize, y: usize| {
            let start = 3 * ((y * cell + cell / 2) * width + x * cell + cell / 2);
            [rgb[start], rgb[start + 1], rgb[start + 2]]
        };
        // 100 um is three decades over 0.1 um, the upper end; 10 um are two.
        assert_eq!([at(0, 0), at(1, 0)], [viridis(1.0), viridis(2.0 / 3.0)]);
        assert_eq!([at(0, 1), at(1, 1)], [FITS, NO_MIRROR]);
    }
}
