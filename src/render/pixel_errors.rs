//! Pixel errors over the frame: how far what each pixel shows is from where the projection wants it.

use super::reflected;
use crate::design::Design;
use crate::geom::{DVec2, Ray};
use crate::optics::ThinnedFrame;
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
    let image = |x: usize, y: usize| camera.image_point(x as f64 + 0.5, y as f64 + 0.5);
    let turns: Vec<[f64; 2]> = columns.iter().map(|&x| view.turn(image(x, 0).x)).collect();
    parallel::gather(rows.len(), 1, |lines| {
        let line = |k: usize| {
            let images: Vec<DVec2> = columns.iter().map(|&x| image(x, rows[k])).collect();
            let rays = reflected(design, &images);
            let error = |((near, turn), ray): ((DVec2, [f64; 2]), Option<Ray>)| {
                let ray = ray.filter(|_| view.projection.wants(near))?;
                let seen = view.image_of_turned(ray.origin, ray.direction, near, turn);
                let px = (seen - near).length() / camera.pixel_mm;
                px.is_finite().then_some(px)
            };
            images.into_iter().zip(turns.iter().copied()).zip(rays).map(error).collect::<Vec<_>>()
        };
        lines.flat_map(line).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::design;
    use crate::profile::{Profile, shipped};

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
