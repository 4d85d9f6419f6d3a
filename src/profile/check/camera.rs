//! The camera.

use super::super::Camera;
use super::super::reader::Need::{Optional, Required};
use super::super::reader::{Reader, Section};
use super::super::values::{Pair, number, pair};
use super::{LARGE, is_large, only};

const MAX_PIXELS: f64 = 16384.0;
/// Pixels of a frame: the ray trace keeps some 120 bytes for each.
const MOST_PIXELS: f64 = 4e7;

/// A camera, and where its table stands.
pub(super) struct Found {
    pub(super) name: &'static str,
    pub(super) at: usize,
    pub(super) camera: Option<Camera>,
}

pub(super) fn read(reader: &mut Reader, root: &Section) -> Option<Found> {
    let hint = "an orthographic camera has a telecentric lens, a pinhole camera any other";
    let read = reader
        .alternatives(root, "camera", hint)
        .into_iter()
        .map(|(name, section)| {
            let pixels = pixels(reader, &section);
            let camera = match name {
                "pinhole" => pinhole(reader, &section, pixels),
                _ => pixels.map(|pixels| Camera::Orthographic { pixels }),
            };
            Found { name, at: section.at, camera }
        })
        .collect();
    only(read)
}

fn pixels(reader: &mut Reader, section: &Section) -> Option<[u32; 2]> {
    let form = "the size of the camera's frame in pixels, as in pixels = [640, 480]";
    let pixels = Pair {
        key: "pixels",
        parts: "[width, height]",
        each: "a whole number from 1 to 16384",
        form,
        limit: form,
    };
    let pixels =
        pair(reader, section, &pixels, |f| f.fract() == 0.0 && (1.0..=MAX_PIXELS).contains(&f))?;
    let [width, height] = pixels.value;
    if width * height > MOST_PIXELS {
        let path = section.path_of("pixels");
        let message = format!(
            "{path} must make a frame of at most 40 million pixels, found {width} x {height}"
        );
        let hint = "every pixel is traced; try half as many on each side";
        reader.complain(pixels.at, message, hint);
        return None;
    }
    Some(pixels.value.map(|f| f as u32))
}

fn pinhole(reader: &mut Reader, section: &Section, pixels: Option<[u32; 2]>) -> Option<Camera> {
    let must = "a number from 0.001 to 1e7";
    let hint = "the focal length divided by the size of a pixel, as in focal_px = 800";
    let focal =
        number(reader, section, "focal_px", Optional, must, hint, |f| (1e-3..=1e7).contains(&f));
    let must = "a number from 0.001 to 179";
    let hint = "the angle of view across the frame's width, as in hfov_deg = 40";
    let view =
        number(reader, section, "hfov_deg", Optional, must, hint, |f| (1e-3..=179.0).contains(&f));
    let must = &format!("a number {LARGE}");
    let hint = "millimetres from the pinhole to the mirror, as in distance_mm = 200";
    let distance = number(reader, section, "distance_mm", Required, must, hint, is_large);
    let path = &section.path;
    match (section.has("focal_px"), section.has("hfov_deg")) {
        (false, false) => reader.missing(
            section,
            format!("{path} must hold focal_px or hfov_deg, found neither"),
            "hfov_deg = 40 is an angle of view of 40 degrees across the frame's width",
        ),
        (true, true) => {
            let at = focal.map_or(section.at, |f| f.at).max(view.map_or(section.at, |v| v.at));
            let message = format!("{path} must hold focal_px or hfov_deg, found both");
            reader.complain(at, message, "the two say the same; remove one of them");
        }
        _ => {}
    }
    let pixels = pixels?;
    let focal_px = match (focal, view) {
        (Some(focal), _) => focal.value,
        (None, view) => focal_of_view(f64::from(pixels[0]), view?.value),
    };
    Some(Camera::Pinhole { pixels, focal_px, distance_mm: distance?.value })
}

/// The focal length in pixels of an angle of view.
fn focal_of_view(width_px: f64, view_deg: f64) -> f64 {
    0.5 * width_px / libm::tan((0.5 * view_deg).to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_angle_of_view_has_half_the_width_as_its_focal_length() {
        assert!((focal_of_view(640.0, 90.0) - 320.0).abs() < 1e-12);
        assert!(focal_of_view(1.0, 179.0) > 0.0);
        assert!(focal_of_view(16384.0, 1e-3).is_finite());
    }
}
