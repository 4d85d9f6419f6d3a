//! Pixel errors over the frame: how far what each pixel shows is from where the projection wants it.

#[cfg(feature = "studio")]
use super::smooth_sight::SmoothCentres;
use super::smooth_sight::SmoothSight;
use crate::design::Design;
use crate::geom::{DVec2, Ray};
use crate::optics::{Camera, ImagingTask, ThinnedFrame};
use crate::parallel;

/// Pixel error of the smooth mirror at the centre of each pixel of a thinned frame, px, row by row from the upper
/// left: none off the mirror, where nothing is wanted, and where what is seen has no place in the image. Without a projection all are none.
///
/// It does not look for shadows; a mesh that is traced does.
#[must_use]
pub fn pixel_errors(design: &Design, thinned: ThinnedFrame) -> Vec<Option<f64>> {
    let columns: Vec<usize> = thinned.columns().collect();
    let rows: Vec<usize> = thinned.rows(0..design.camera.pixels[1] as usize).collect();
    let Some(view) = &design.view else { return vec![None; columns.len() * rows.len()] };
    let camera = &design.camera;
    let sight = SmoothSight::new(design);
    let turns = turns(view, camera, &columns);
    parallel::gather(rows.len(), 1, |lines| {
        let line = |k: usize| {
            let images = line_of(camera, &columns, rows[k]);
            let rays = sight.reflected(&images);
            errors_along(view, camera.pixel_mm, (&images, &turns), &rays)
        };
        lines.flat_map(line).collect()
    })
}

/// The same where the rays are known that the smooth mirror reflects at the centres of a camera's pixels; in pixels of the design.
#[cfg(feature = "studio")]
pub(crate) fn pixel_errors_of(design: &Design, centres: &SmoothCentres) -> Vec<Option<f64>> {
    let SmoothCentres { camera, rays } = centres;
    let Some(view) = &design.view else { return vec![None; rays.len()] };
    let columns: Vec<usize> = (0..camera.pixels[0] as usize).collect();
    let turns = turns(view, camera, &columns);
    let width = columns.len();
    parallel::gather(camera.pixels[1] as usize, 1, |lines| {
        let line = |row: usize| {
            let images = line_of(camera, &columns, row);
            let rays = &rays[row * width..(row + 1) * width];
            errors_along(view, design.camera.pixel_mm, (&images, &turns), rays)
        };
        lines.flat_map(line).collect()
    })
}

/// Image points of the centres of pixels in some columns of a row, mm.
fn line_of(camera: &Camera, columns: &[usize], row: usize) -> Vec<DVec2> {
    columns.iter().map(|&x| camera.image_point(x as f64 + 0.5, row as f64 + 0.5)).collect()
}

/// Sine and cosine of the azimuth that columns of pixels show, by the first row's.
fn turns(view: &ImagingTask, camera: &Camera, columns: &[usize]) -> Vec<[f64; 2]> {
    line_of(camera, columns, 0).into_iter().map(|image| view.turn(image.x)).collect()
}

/// Errors along a row of image points, of which the turns are known, that reflect these rays, px of the side `pixel_mm`.
fn errors_along(
    view: &ImagingTask,
    pixel_mm: f64,
    (images, turns): (&[DVec2], &[[f64; 2]]),
    rays: &[Option<Ray>],
) -> Vec<Option<f64>> {
    let error = |((&near, &turn), ray): ((&DVec2, &[f64; 2]), &Option<Ray>)| {
        let ray = ray.filter(|_| view.projection.wants(near))?;
        let seen = view.shown_turned(ray.origin, ray.direction, (near, turn)).image;
        let px = (seen - near).length() / pixel_mm;
        px.is_finite().then_some(px)
    };
    images.iter().zip(turns).zip(rays).map(error).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::design;
    use crate::profile::{Profile, shipped};

    #[test]
    #[cfg(feature = "studio")]
    fn errors_and_picture_of_rays_that_are_known_are_the_same() {
        use crate::render::{CameraPicture, CameraView, Distance, TestWorld};
        for name in ["conquistador", "calibrated", "soccer"] {
            let shipped = shipped().iter().find(|shipped| shipped.name == name).unwrap();
            let profile = Profile::parse(name, name, shipped.text.as_bytes()).unwrap();
            let design = crate::design::design_unmeasured(&profile).unwrap();
            let sight = SmoothSight::new(&design);
            let whole = sight.centres(design.camera);
            let errors = pixel_errors(&design, ThinnedFrame::new(design.camera.pixels));
            assert_eq!(pixel_errors_of(&design, &whole), errors, "{name}");
            let picture = || {
                let view = CameraView::Smooth(&sight);
                CameraPicture::new(&design, view, Distance::Target, 2).at_most(160)
            };
            let known = sight.centres(design.camera.at_most(160));
            let with_known = picture().of_centres(&known).picture(&TestWorld::new());
            assert!(with_known == picture().picture(&TestWorld::new()), "{name}");
        }
    }

    #[test]
    fn figures_of_the_frame_are_those_of_the_design() {
        for name in ["conquistador", "panoramic", "webcam", "robot-floor"] {
            let shipped = shipped().iter().find(|shipped| shipped.name == name).unwrap();
            let profile = Profile::parse(name, name, shipped.text.as_bytes()).unwrap();
            let design = design(&profile).unwrap();
            let errors = pixel_errors(&design, ThinnedFrame::new(design.camera.pixels));
            let known: Vec<f64> = errors.iter().flatten().copied().collect();
            let rms = (known.iter().map(|px| px * px).sum::<f64>() / known.len() as f64).sqrt();
            let max = known.iter().copied().fold(0.0, f64::max);
            let wanted = design.facts.pixel_error_px.unwrap();
            // The one is a mean over pixels, the other by quadrature, and no pixel's centre is on the rim.
            let off = (rms - wanted.rms).abs();
            assert!(off <= 0.02 * wanted.rms + 1e-9, "{name}: {rms} {}", wanted.rms);
            assert!(max <= wanted.max + 1e-9, "{name}: {max} {}", wanted.max);
            assert!(max >= 0.9 * wanted.max - 1e-9, "{name}: {max} {}", wanted.max);
        }
    }
}
