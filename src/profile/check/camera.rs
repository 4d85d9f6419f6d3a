//! The camera.

use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, number, numbers};
use super::super::{Aperture, CameraBody, LensSpec};
use super::obstacle::size;
use super::{LARGE, is_large};
use crate::num::tan;
use crate::optics::CameraModel;

/// Pixels along a side: the ray trace numbers them in 16 bits, one of which is a sign.
const MAX_PIXELS: f64 = 32767.0;
/// Pixels of a frame, each of which is traced: a minute's work.
const MOST_PIXELS: f64 = 4e8;

/// A camera, and where its table stands.
pub(super) struct CameraEntry {
    pub(super) name: CameraName,
    pub(super) at: usize,
    pub(super) camera: Option<CameraModel>,
    pub(super) lens: LensSpec,
    /// The calibration file that it names.
    pub(super) file: Option<String>,
    /// Its body.
    pub(super) body: Option<CameraBody>,
}

/// Which camera it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CameraName {
    Orthographic,
    Pinhole,
    Calibrated,
}

impl CameraName {
    /// The camera of a table's name: one that the schema has.
    pub(super) fn find(name: &str) -> Self {
        match name {
            "pinhole" => Self::Pinhole,
            "calibrated" => Self::Calibrated,
            _ => Self::Orthographic,
        }
    }

    /// Its table.
    pub(super) fn table(self) -> &'static str {
        match self {
            Self::Orthographic => "camera.orthographic",
            Self::Pinhole => "camera.pinhole",
            Self::Calibrated => "camera.calibrated",
        }
    }
}

/// A camera without distortion.
pub(super) fn ideal(
    reader: &mut ProfileReader,
    name: CameraName,
    section: &Section,
) -> CameraEntry {
    let pixels = pixels(reader, section);
    let wavelength_nm = wavelength(reader, section);
    let (camera, (aperture, focal_mm)) = if name == CameraName::Pinhole {
        pinhole(reader, section, pixels)
    } else {
        let camera = pixels.map(|pixels| CameraModel::Orthographic { pixels });
        (camera, (na(reader, section), None))
    };
    let lens = LensSpec { aperture, focal_mm, wavelength_nm };
    let body = body(reader, section);
    CameraEntry { name, at: section.at, camera, lens, file: None, body }
}

/// Its body: never of a telecentric camera, whose lens is at no known place and which has no such key.
pub(super) fn body(reader: &mut ProfileReader, section: &Section) -> Option<CameraBody> {
    let key = "body_mm";
    if !section.has(key) {
        return None;
    }
    let example = "as in body_mm = [29, 29, 42]; the front face goes through the entrance pupil";
    let found = size(reader, section, key, "[width, height, depth]", example)?;
    Some(CameraBody { size_mm: found.value, place: reader.place(found.at) })
}

pub(super) fn pixels(reader: &mut ProfileReader, section: &Section) -> Option<[u32; 2]> {
    let form = "the size of the camera's frame in pixels, as in pixels = [640, 480]";
    let pixels = NumbersFormat {
        key: "pixels",
        parts: "[width, height]",
        each: "a whole number from 1 to 32767",
        form,
        limit: form,
    };
    let pixels =
        numbers(reader, section, &pixels, |f| f.fract() == 0.0 && (1.0..=MAX_PIXELS).contains(&f))?;
    let [width, height] = pixels.value;
    if width * height > MOST_PIXELS {
        let path = section.path_of("pixels");
        let message = format!(
            "{path} must make a frame of at most 400 million pixels, found {width} x {height}"
        );
        let hint = "every pixel is traced; try half as many on each side";
        reader.complain(pixels.at, message, hint);
        return None;
    }
    Some(pixels.value.map(|f| f as u32))
}

pub(super) fn wavelength(reader: &mut ProfileReader, section: &Section) -> f64 {
    let must = "a number from 100 to 20000";
    let hint = "nanometres of the light that the camera sees, as in wavelength_nm = 550 for green";
    let allowed = |f: f64| (100.0..=20000.0).contains(&f);
    let found = number(reader, section, "wavelength_nm", Optional, must, hint, allowed);
    found.map_or(LensSpec::USUAL_NM, |found| found.value)
}

/// A telecentric lens's aperture.
fn na(reader: &mut ProfileReader, section: &Section) -> Option<Aperture> {
    let must = "a number from 0.000001 to 0.9";
    let hint = "the numerical aperture on the mirror's side, as in na = 0.01";
    let allowed = |f: f64| (1e-6..=0.9).contains(&f);
    let na = number(reader, section, "na", Optional, must, hint, allowed)?.value;
    Some(Aperture::Na { na })
}

/// Any other lens's aperture; its f-number is told of the focal length in millimetres, which `lens_keys` say.
pub(super) fn pupil(
    reader: &mut ProfileReader,
    section: &Section,
    lens: Option<Located<f64>>,
    lens_keys: &str,
) -> Option<Aperture> {
    let must = "a number from 0.000001 to 1000";
    let hint = "the diameter of the entrance pupil in millimetres, as in pupil_mm = 2";
    let allowed = |f: f64| (1e-6..=1e3).contains(&f);
    let pupil = number(reader, section, "pupil_mm", Optional, must, hint, allowed);
    let must = "a number from 0.1 to 10000";
    let hint = "what the lens's aperture ring is set to, as in f_number = 8";
    let allowed = |f: f64| (0.1..=1e4).contains(&f);
    let stop = number(reader, section, "f_number", Optional, must, hint, allowed);
    let path = &section.path;
    match (pupil, stop) {
        (Some(_), Some(stop)) => {
            let message = format!("{path} must hold pupil_mm or f_number, found both");
            reader.complain(stop.at, message, "they say the same; keep one of them");
            None
        }
        (Some(pupil), None) => Some(Aperture::Pupil { pupil_mm: pupil.value }),
        (None, Some(stop)) => {
            let Some(lens) = lens else {
                let message = format!("{path}.f_number must stand beside lens_mm, found none");
                let hint = format!(
                    "the entrance pupil is lens_mm / f_number wide; write {lens_keys}, or pupil_mm"
                );
                reader.complain(stop.at, message, &hint);
                return None;
            };
            Some(Aperture::Pupil { pupil_mm: lens.value / stop.value })
        }
        (None, None) => None,
    }
}

fn pinhole(
    reader: &mut ProfileReader,
    section: &Section,
    pixels: Option<[u32; 2]>,
) -> (Option<CameraModel>, (Option<Aperture>, Option<f64>)) {
    let must = "a number from 0.001 to 1e7";
    let hint = "the focal length divided by the size of a pixel, as in focal_px = 800";
    let focal =
        number(reader, section, "focal_px", Optional, must, hint, |f| (1e-3..=1e7).contains(&f));
    let must = "a number from 0.001 to 179";
    let hint = "the angle of view across the frame's width, as in hfov_deg = 40";
    let view =
        number(reader, section, "hfov_deg", Optional, must, hint, |f| (1e-3..=179.0).contains(&f));
    let must = "a number from 0.001 to 100000";
    let size = |f: f64| (1e-3..=1e5).contains(&f);
    let hint = "the focal length that is printed on the lens, in millimetres, as in lens_mm = 12.5";
    let lens = number(reader, section, "lens_mm", Optional, must, hint, size);
    let hint =
        "the side of a pixel in micrometres, from the sensor's data sheet, as in pixel_um = 3.45";
    let pitch = number(reader, section, "pixel_um", Optional, must, hint, size);
    let distance = distance(reader, section);
    let placed = [&focal, &view, &lens, &pitch].into_iter().flatten().map(|found| found.at);
    let last = placed.max().unwrap_or(section.at);
    one_focal_length(reader, section, last);
    let aperture = pupil(reader, section, lens, "lens_mm and pixel_um");
    let mut focal_px = |pixels: [u32; 2]| match (focal, view) {
        (Some(focal), _) => Some(focal.value),
        (None, Some(view)) => Some(focal_of_view(f64::from(pixels[0]), view.value)),
        (None, None) => focal_of_lens(reader, section, [lens?, pitch?]),
    };
    let focal_px = pixels.and_then(&mut focal_px);
    let whole = pixels.zip(focal_px).zip(distance);
    let camera = whole.map(|((pixels, focal_px), distance)| CameraModel::Pinhole {
        pixels,
        focal_px,
        distance_mm: distance.value,
    });
    (camera, (aperture, lens.map(|lens| lens.value)))
}

/// Distance of the mirror from the entrance pupil, mm.
pub(super) fn distance(reader: &mut ProfileReader, section: &Section) -> Option<Located<f64>> {
    let must = &format!("a number {LARGE}");
    let hint = "millimetres from the entrance pupil to the mirror, as in distance_mm = 200";
    number(reader, section, "distance_mm", Required, must, hint, is_large)
}

/// Complains where the focal length is said in no way, or, up to the place `last`, in more than one.
fn one_focal_length(reader: &mut ProfileReader, section: &Section, last: usize) {
    let path = &section.path;
    let said: Vec<&str> = [
        ("focal_px", section.has("focal_px")),
        ("hfov_deg", section.has("hfov_deg")),
        ("lens_mm and pixel_um", section.has("lens_mm") || section.has("pixel_um")),
    ]
    .into_iter()
    .filter_map(|(way, has)| has.then_some(way))
    .collect();
    let must = format!("{path} must hold focal_px, hfov_deg, or lens_mm and pixel_um");
    let whole = section.has("lens_mm") == section.has("pixel_um");
    match said[..] {
        [] => reader.missing(
            section,
            format!("{must}, found none"),
            "hfov_deg = 40 is an angle of view of 40 degrees across the frame's width",
        ),
        [_] if whole => {}
        [_] => {
            let missing = if section.has("lens_mm") { "pixel_um" } else { "lens_mm" };
            reader.missing(
                section,
                format!("{must}, found no {missing}"),
                "lens_mm = 12.5 and pixel_um = 3.45 are a lens of 12.5 mm over pixels of 3.45 um",
            );
        }
        _ => {
            let message = format!("{must}, found {}", said.join(" as well as "));
            reader.complain(last, message, "they say the same; keep one of them");
        }
    }
}

/// The focal length in pixels of a lens over a sensor, if it is one that `focal_px` may be.
fn focal_of_lens(
    reader: &mut ProfileReader,
    section: &Section,
    [lens, pitch]: [Located<f64>; 2],
) -> Option<f64> {
    let focal_px = 1e3 * lens.value / pitch.value;
    if (1e-3..=1e7).contains(&focal_px) {
        return Some(focal_px);
    }
    let path = section.path_of("lens_mm");
    let message = format!(
        "{path} must be 0.001 to 1e7 pixels long, found {focal_px:e} of {} um each",
        pitch.value
    );
    reader.complain(lens.at, message, "lens_mm is in millimetres and pixel_um in micrometres");
    None
}

/// The focal length in pixels of an angle of view.
fn focal_of_view(width_px: f64, view_deg: f64) -> f64 {
    0.5 * width_px / tan((0.5 * view_deg).to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_angle_of_view_has_half_the_width_as_its_focal_length() {
        assert!((focal_of_view(640.0, 90.0) - 320.0).abs() < 1e-12);
        assert!(focal_of_view(1.0, 179.0) > 0.0);
        assert!(focal_of_view(32767.0, 1e-3).is_finite());
    }
}
