//! Pencils over a sensor.

use super::Pencil;
use crate::geom::DVec2;
use crate::mirror::Mirror;
use crate::optics::{Camera, View};
use crate::parallel;
use std::ops::Range;

/// What `each` makes of the pencil of every pixel centre in `columns` and `rows`, row by row; none
/// where the camera is not aimed at the mirror or it has no pencil.
#[must_use]
pub fn over_sensor<T: Send>(
    mirror: &Mirror,
    camera: &Camera,
    view: Option<&View>,
    [columns, rows]: [Range<u32>; 2],
    each: impl Fn(&Pencil) -> T + Sync,
) -> Vec<Option<T>> {
    let outline = mirror.whole();
    let pixel = |column: u32, row: u32| {
        let image = camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
        let place: DVec2 = mirror.under(&camera.chart, image)?;
        if !outline.aims(place) {
            return None;
        }
        Pencil::new(&camera.chart, view, image, &mirror.quadric(place)).map(|p| each(&p))
    };
    let row = |row: u32| columns.clone().map(move |column| pixel(column, row));
    parallel::gather(rows.len(), 1, |part| part.flat_map(|k| row(rows.start + k as u32)).collect())
}

/// For each of the first half of `count` columns or rows of a symmetric picture, the middle one
/// included, for how many it stands.
pub fn weights(count: u32) -> impl Iterator<Item = u32> {
    (0..count.div_ceil(2)).map(move |k| if 2 * k + 1 == count { 1 } else { 2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_picture_stands_for_all_of_it() {
        assert_eq!(weights(5).collect::<Vec<_>>(), [2, 2, 1]);
        for count in 0..9 {
            assert_eq!(weights(count).sum::<u32>(), count);
        }
    }
}
