//! Calibrations of cameras: YAML, JSON and XML.

use morion::internals::optics::Calibration;
use morion::internals::profile::{CalibrationFile, LensModel};

pub fn holds(bytes: &[u8]) {
    let Ok(file) = CalibrationFile::parse(bytes) else { return };
    let numbers = file.focal_px.iter().chain(&file.principal_px).chain(&file.coefficients);
    assert!(numbers.clone().all(|number| number.is_finite()), "{file:?}");
    let ([fx, fy], [cx, cy]) = (file.focal_px, file.principal_px);
    // Written again as plain JSON it reads the same.
    let mut again =
        format!("{{\"K\": [[{fx:e}, 0, {cx:e}], [0, {fy:e}, {cy:e}], [0, 0, 1]], \"D\": [");
    let coefficients: Vec<String> = file.coefficients.iter().map(|k| format!("{k:e}")).collect();
    again += &coefficients.join(", ");
    again += "]";
    if let Some([width, height]) = file.pixels {
        again += &format!(", \"image_size\": [{width}, {height}]");
    }
    if let Some(model) = file.model {
        again += &format!(", \"distortion_model\": \"{model}\"");
    }
    let again =
        CalibrationFile::parse((again + "}").as_bytes()).expect("a calibration that was read");
    assert_eq!(again.focal_px, file.focal_px);
    assert_eq!(again.principal_px, file.principal_px);
    assert_eq!(again.coefficients, file.coefficients);
    assert_eq!((again.pixels, again.model), (file.pixels, file.model));

    for model in [LensModel::OpenCv, LensModel::Fisheye] {
        let frame = file.pixels.is_none().then_some([64, 48]);
        let Ok(found) = file.calibration(Some(model), frame) else { continue };
        // The boundary of a large frame takes its time.
        let small = Calibration { pixels: found.pixels.map(|side| side.min(64)), ..found };
        if small.check().is_ok() {
            has_rays(&small);
        }
    }
}

/// Each of some places in the frame has a ray, which is seen there.
fn has_rays(camera: &Calibration) {
    let [width, height] = camera.pixels.map(f64::from);
    for k in 0..25 {
        let place = [0.25 * f64::from(k % 5) * width, 0.25 * f64::from(k / 5) * height];
        let ray = camera.ray(place).unwrap_or_else(|fault| panic!("{fault}: {place:?} {camera:?}"));
        let back = camera.picture_point(ray);
        for k in 0..2 {
            let size = place[k].abs() + camera.principal_px[k].abs();
            assert!((back[k] - place[k]).abs() <= 1e-9 * size, "{place:?} {back:?} {camera:?}");
        }
    }
}
