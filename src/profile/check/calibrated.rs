//! A calibrated camera: from its file, or from the same numbers as keys.

use super::super::calibration::{CalibrationFile, LensModel, MOST_BYTES};
use super::super::reader::Need::Optional;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, NumbersFormat, file, number, numbers, within, word};
use super::super::{Aperture, LensSpec};
use super::camera::{CameraEntry, CameraName, body, distance, pixels, pupil, wavelength};
use crate::optics::Calibration;
use toml::de::DeValue;

/// Keys whose numbers a file has.
const IN_FILE: [&str; 3] = ["focal_px", "principal_px", "distortion"];
/// Ways out of a distortion that leaves pixels without a ray.
const NO_RAY: &str =
    "calibrate with points up to the corners or with fewer coefficients, or crop the frame";
/// Most coefficients, OpenCV's.
const MOST: usize = 14;

pub(super) fn read(reader: &mut ProfileReader, section: &Section) -> CameraEntry {
    let has_file = section.has("file");
    let frame = (!has_file || section.has("pixels")).then(|| pixels(reader, section));
    let models = [("opencv", LensModel::OpenCv), ("fisheye", LensModel::Fisheye)];
    let hint =
        "the module of OpenCV that calibrated the camera: cv::calibrateCamera or cv::fisheye";
    let model = word(reader, section, "model", &models, hint);
    let (file, calibration) = if has_file {
        of_file(reader, section, model, frame)
    } else {
        (None, of_keys(reader, section, model, frame.flatten()))
    };
    let distance = distance(reader, section);
    let (aperture, focal_mm) = lens(reader, section);
    let lens = LensSpec { aperture, focal_mm, wavelength_nm: wavelength(reader, section) };
    let camera = calibration.zip(distance).map(|(found, distance)| found.camera(distance.value));
    let body = body(reader, section);
    CameraEntry { name: CameraName::Calibrated, at: section.at, camera, lens, file, body }
}

/// Its aperture and focal length in millimetres, if they are known.
fn lens(reader: &mut ProfileReader, section: &Section) -> (Option<Aperture>, Option<f64>) {
    let must = "a number from 0.001 to 100000";
    let hint = "the focal length that is printed on the lens, in millimetres, as in lens_mm = 12.5";
    let size = |f: f64| (1e-3..=1e5).contains(&f);
    let lens = number(reader, section, "lens_mm", Optional, must, hint, size);
    let aperture = pupil(reader, section, lens, "lens_mm");
    (aperture, lens.map(|lens| lens.value))
}

/// The file's name, and the calibration in it. `frame` is there if the profile has pixels.
fn of_file(
    reader: &mut ProfileReader,
    section: &Section,
    model: Option<LensModel>,
    frame: Option<Option<[u32; 2]>>,
) -> (Option<String>, Option<Calibration>) {
    let mut is_alone = true;
    for key in IN_FILE {
        if let Some(value) = reader.value(section, key, Optional, "", "") {
            is_alone = false;
            let path = section.path_of(key);
            let message = format!("{path} must be left out beside file, found both");
            reader.complain(
                value.span().start,
                message,
                "the calibration file has it; keep one of them",
            );
        }
    }
    let hint =
        "a calibration of OpenCV's or ROS's beside the profile, as in file = \"camera.yaml\"";
    let Some(Located { value: file, at }) = file(reader, section, hint) else {
        return (None, None);
    };
    let path = section.path_of("file");
    // A frame that is wrong has its complaint, as keys beside the file have.
    if frame == Some(None) || !is_alone {
        return (Some(file), None);
    }
    let read = reader.file(&file, MOST_BYTES as u64).and_then(|bytes| {
        let read = CalibrationFile::parse(&bytes);
        let read = read.and_then(|found| found.calibration(model, frame.flatten()));
        read.map_err(|error| format!("{file}: {error}"))
    });
    let (reason, hint) = match read {
        Ok(found) => match found.check() {
            Ok(()) => return (Some(file), Some(found)),
            Err(fault) => (format!("{file}: {fault}"), NO_RAY),
        },
        Err(reason) => (reason, ""),
    };
    reader.complain(at, format!("{path}: {reason}"), hint);
    (Some(file), None)
}

fn of_keys(
    reader: &mut ProfileReader,
    section: &Section,
    model: Option<LensModel>,
    pixels: Option<[u32; 2]>,
) -> Option<Calibration> {
    let form = "the first and the fifth number of OpenCV's camera matrix, as in focal_px = [820.1, 819.4]; \
                a file of the calibration is file = \"camera.yaml\"";
    let focal = NumbersFormat {
        key: "focal_px",
        parts: "[across, down]",
        each: "a number from 0.001 to 1e7",
        form,
        limit: form,
    };
    let focal = numbers(reader, section, &focal, |f| (1e-3..=1e7).contains(&f));
    let form = "the third and the sixth number of OpenCV's camera matrix, as in principal_px = [331.2, 236.9]";
    let principal = NumbersFormat {
        key: "principal_px",
        parts: "[x, y]",
        each: "a number from -1e6 to 1e6",
        form,
        limit: form,
    };
    let principal = numbers(reader, section, &principal, |f| f.abs() <= 1e6);
    let coefficients = coefficients(reader, section)?;
    let distortion = model.unwrap_or(LensModel::OpenCv).distortion(&coefficients.value);
    let path = section.path_of("distortion");
    let hint =
        "the coefficients in OpenCV's order: k1, k2, p1, p2, k3 and so on; k1 to k4 of a fisheye";
    let distortion = match distortion {
        Ok(distortion) => distortion,
        Err(fault) => {
            let message = format!("{path} must be {}, found {}", fault.must, fault.found);
            reader.complain(coefficients.at, message, hint);
            return None;
        }
    };
    let calibration = Calibration {
        pixels: pixels?,
        focal_px: focal?.value,
        principal_px: principal?.value.map(|px| px + 0.5),
        distortion,
    };
    if let Err(fault) = calibration.check() {
        let message = format!("{path} must leave each pixel its ray, found none: {fault}");
        reader.complain(coefficients.at, message, NO_RAY);
        return None;
    }
    Some(calibration)
}

/// The distortion coefficients, none if the key is absent.
fn coefficients(reader: &mut ProfileReader, section: &Section) -> Option<Located<Vec<f64>>> {
    let must = "a list of numbers from -1e6 to 1e6";
    let hint = "OpenCV's distortion coefficients, as in distortion = [-0.31, 0.12, 0, 0]";
    let path = section.path_of("distortion");
    let Some(value) = reader.value(section, "distortion", Optional, must, hint) else {
        // Of a fisheye without coefficients, the camera's place is to be told.
        return Some(Located { value: Vec::new(), at: section.at });
    };
    let at = value.span().start;
    let DeValue::Array(items) = value.get_ref() else {
        let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
        reader.complain(at, message, hint);
        return None;
    };
    let mut found = Vec::new();
    for item in items.iter().take(MOST + 1) {
        let each = "numbers from -1e6 to 1e6";
        found.push(within(reader, &path, item, each, hint, |f| f.abs() <= 1e6)?);
    }
    Some(Located { value: found, at })
}
