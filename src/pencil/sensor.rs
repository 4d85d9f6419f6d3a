//! Pencils over a sensor.

use super::Pencil;
use crate::geom::DVec2;
use crate::mirror::Mirror;
use crate::optics::{Camera, ImagingTask};
use crate::parallel;
use std::ops::Range;

/// Values of `each` for the pencils of all pixel centres in `columns` and `rows`, row by row; `None` where
/// the camera is not aimed at the mirror or it has no pencil.
#[must_use]
pub fn map_pencils<T: Send>(
    mirror: &Mirror,
    camera: &Camera,
    view: Option<&ImagingTask>,
    [columns, rows]: [Range<u32>; 2],
    each: impl Fn(&Pencil) -> T + Sync,
) -> Vec<Option<T>> {
    let row = |row: u32| {
        let each = &each;
        columns
            .clone()
            .map(move |column| pencil(mirror, camera, view, [column, row]).map(|p| each(&p)))
    };
    parallel::gather(rows.len(), 1, |part| part.flat_map(|k| row(rows.start + k as u32)).collect())
}

/// The pencil of a pixel's centre; none where the camera is not aimed at the mirror or it has none.
fn pencil(
    mirror: &Mirror,
    camera: &Camera,
    view: Option<&ImagingTask>,
    [column, row]: [u32; 2],
) -> Option<Pencil> {
    let image = camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
    let place: DVec2 =
        mirror.intersect_camera_ray(&camera.chart, camera.picture.chart_point(image))?;
    if !mirror.full_outline().aims(place) {
        return None;
    }
    Pencil::new(camera, view, image, &mirror.local_surface(place))
}

/// Values of `each` for the pencils of `counts` columns and rows of pixels spread evenly over the sensor, row by row;
/// none where there is no pencil.
#[must_use]
pub fn map_pencils_sparsely<T: Send>(
    mirror: &Mirror,
    camera: &Camera,
    view: Option<&ImagingTask>,
    counts: [u32; 2],
    each: impl Fn(&Pencil) -> T + Sync,
) -> Vec<Option<T>> {
    let place = |k: u32, axis: usize| {
        let step = f64::from(camera.pixels[axis]) / f64::from(counts[axis]);
        ((f64::from(k) + 0.5) * step) as u32
    };
    let row = |j: u32| {
        let at = |i: u32| pencil(mirror, camera, view, [place(i, 0), place(j, 1)]);
        (0..counts[0]).map(|i| at(i).map(|pencil| each(&pencil))).collect::<Vec<_>>()
    };
    parallel::gather(counts[1] as usize, 1, |part| part.flat_map(|k| row(k as u32)).collect())
}

/// Multiplicity of each of the first half of `count` columns or rows of a symmetric picture, the middle
/// one included.
pub fn mirror_symmetric_weights(count: u32) -> impl Iterator<Item = u32> {
    (0..count.div_ceil(2)).map(move |k| if 2 * k + 1 == count { 1 } else { 2 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_picture_stands_for_all_of_it() {
        assert_eq!(mirror_symmetric_weights(5).collect::<Vec<_>>(), [2, 2, 1]);
        for count in 0..9 {
            assert_eq!(mirror_symmetric_weights(count).sum::<u32>(), count);
        }
    }
}
