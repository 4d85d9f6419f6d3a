//! The three formats and the spellings of their keys.

mod refusals;

use super::*;
use crate::optics::Distortion;

const YAML: &str = "%YAML:1.0
---
calibration_time: \"Mon 3 Feb 2025 10:11:12\"
image_width: 640
image_height: 480
# flags: +fix_aspectRatio
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 820.5, 0., 331.25, 0.,
       819.5, 236.75, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -3.1e-01, 1.2e-01, 1e-3, -7e-4, .01 ]
avg_reprojection_error: 2.5e-01
";

const JSON: &str = "{
    \"image_width\": 640,
    \"image_height\": 480,
    \"flags\": 0
    // flags: \"+fix_aspectRatio
    ,
    \"url\": \"file://here\",
    \"camera_matrix\": {
        \"type_id\": \"opencv-matrix\",
        \"rows\": 3,
        \"cols\": 3,
        \"dt\": \"d\",
        \"data\": [ 820.5, 0.0, 331.25, 0.0,
            819.5, 236.75, 0.0, 0.0, 1.0 ]
    },
    \"distortion_coefficients\": {
        \"type_id\": \"opencv-matrix\",
        \"rows\": 5,
        \"cols\": 1,
        \"dt\": \"d\",
        \"data\": [ -3.1e-01, 1.2e-01, 1e-3, -7e-4, 0.01 ]
    }
}
";

const XML: &str = "<?xml version=\"1.0\"?>
<opencv_storage>
<calibration_time>\"Mon 3 Feb &lt; 2025\"</calibration_time>
<image_width>640</image_width>
<image_height>480</image_height>
<!-- flags: +fix_aspectRatio -->
<camera_matrix type_id=\"opencv-matrix\">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    820.5 0. 331.25 0. 819.5
    236.75 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id=\"opencv-matrix\">
  <rows>5</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    -3.1e-01 1.2e-01 1e-3 -7e-4 .01</data></distortion_coefficients>
</opencv_storage>
";

const ROS: &str = "image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [820.5, 0, 331.25, 0, 819.5, 236.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.31, 0.12, 0.001, -0.0007, 0.01]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
";

fn parse(text: &str) -> Result<Calibration, CalibrationError> {
    CalibrationFile::parse(text.as_bytes())?.calibration(None, None)
}

fn expected() -> Calibration {
    Calibration {
        pixels: [640, 480],
        focal_px: [820.5, 819.5],
        principal_px: [331.75, 237.25],
        distortion: Distortion::BrownConrady {
            radial: [-0.31, 0.12, 0.01, 0.0, 0.0, 0.0],
            tangential: [0.001, -0.0007],
            prism: [0.0; 4],
        },
    }
}

#[test]
fn all_formats_and_spellings_give_the_same_numbers() {
    let matrix = "[[820.5, 0, 331.25], [0, 819.5, 236.75], [0, 0, 1]]";
    let coefficients = "[-0.31, 0.12, 0.001, -0.0007, 0.01]";
    for text in [
        YAML.to_owned(),
        YAML.replace('\n', "\r\n"),
        format!("\u{feff}{YAML}"),
        YAML.replace("%YAML:1.0", "%YAML 1.2"),
        format!("{YAML}...\n---\n"),
        YAML.replace("camera_matrix", "Camera_Matrix").replace("image_width", "image_Width"),
        YAML.replace("camera_matrix", "cameraMatrix")
            .replace("distortion_coefficients", "distCoeffs"),
        YAML.replace("camera_matrix", "K").replace("distortion_coefficients", "D"),
        JSON.to_owned(),
        format!("{{\"mtx\": {matrix}, \"dist\": [{coefficients}], \"image_size\": [640, 480]}}"),
        format!(
            "{{\"K\": {matrix}, \"dist_coeffs\": {coefficients}, \"width\": 640, \"height\": 480.0}}"
        ),
        format!("K: {matrix}\nD: {coefficients}\nimage_size:\n   - 640\n   - 480\n"),
        XML.to_owned(),
        XML.replace('\n', "\r\n"),
        XML.replace("<image_width>640</image_width>", "<image_size>640 480</image_size>")
            .replace("<image_height>480</image_height>\n", ""),
        XML.replace(
            "<image_width>640</image_width>",
            "<image_size><_>640</_><_>480</_></image_size>",
        )
        .replace("<image_height>480</image_height>\n", ""),
        ROS.to_owned(),
        ROS.replace("plumb_bob", "rational_polynomial"),
        format!("{ROS}---\n"),
    ] {
        assert_eq!(parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}")), expected(), "{text}");
    }
}

#[test]
fn a_fisheye_is_known_by_its_words() {
    let fisheye = ROS.replace("cols: 5", "cols: 4").replace(", 0.01]", "]");
    let wanted = Distortion::KannalaBrandt { radial: [-0.31, 0.12, 0.001, -0.0007] };
    for text in [
        fisheye.replace("plumb_bob", "equidistant"),
        fisheye.replace("plumb_bob", "fisheye"),
        fisheye.replace("distortion_model: plumb_bob", "fisheye_model: 1"),
    ] {
        assert_eq!(parse(&text).unwrap().distortion, wanted);
        let file = CalibrationFile::parse(text.as_bytes()).unwrap();
        let wrong = file.calibration(Some(LensModel::OpenCv), None).unwrap_err().to_string();
        assert_eq!(
            wrong,
            "the file is of the model \"fisheye\", found model = \"opencv\" in the profile"
        );
    }
    let silent = fisheye.replace("distortion_model: plumb_bob\n", "");
    let file = CalibrationFile::parse(silent.as_bytes()).unwrap();
    assert_eq!(file.calibration(Some(LensModel::Fisheye), None).unwrap().distortion, wanted);
    assert!(matches!(
        file.calibration(None, None).unwrap().distortion,
        Distortion::BrownConrady { .. }
    ));
}

#[test]
fn each_number_of_coefficients_has_its_meaning() {
    let all: Vec<f64> = (1..=12).map(f64::from).collect();
    let of = |count: usize| LensModel::OpenCv.distortion(&all[..count]);
    let brown = |radial: [f64; 6], prism: [f64; 4]| {
        Ok(Distortion::BrownConrady { radial, tangential: [3.0, 4.0], prism })
    };
    assert_eq!(of(0), Ok(Distortion::None));
    assert_eq!(LensModel::OpenCv.distortion(&[0.0; 5]), Ok(Distortion::None));
    assert_eq!(of(4), brown([1.0, 2.0, 0.0, 0.0, 0.0, 0.0], [0.0; 4]));
    assert_eq!(of(5), brown([1.0, 2.0, 5.0, 0.0, 0.0, 0.0], [0.0; 4]));
    assert_eq!(of(8), brown([1.0, 2.0, 5.0, 6.0, 7.0, 8.0], [0.0; 4]));
    let twelve = brown([1.0, 2.0, 5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0]);
    assert_eq!(of(12), twelve);
    let mut tilted = all.clone();
    tilted.extend([0.0, 0.0]);
    assert_eq!(LensModel::OpenCv.distortion(&tilted), twelve);
    tilted[13] = -0.02;
    let fault = LensModel::OpenCv.distortion(&tilted).unwrap_err();
    assert_eq!(fault.must, "without a tilted sensor, tau_x and tau_y 0");
    assert_eq!(fault.found, "0 and -0.02");
    for count in [1, 2, 3, 6, 7, 9, 10, 11] {
        assert_eq!(of(count).unwrap_err().found, format!("a list of {count}"));
    }
    for count in [0, 1, 3, 5, 8, 12] {
        let fault = LensModel::Fisheye.distortion(&all[..count]).unwrap_err();
        assert_eq!(fault.found, format!("a list of {count}"));
    }
}

#[test]
fn the_frame_comes_from_the_file_or_from_the_profile() {
    let without = YAML.replace("image_width: 640\nimage_height: 480\n", "");
    let file = CalibrationFile::parse(without.as_bytes()).unwrap();
    assert_eq!(file.calibration(None, Some([640, 480])), Ok(expected()));
    let missing = file.calibration(None, None).unwrap_err().to_string();
    assert!(missing.starts_with("image_width must be the width of the frame"), "{missing}");
    let file = CalibrationFile::parse(YAML.as_bytes()).unwrap();
    assert_eq!(file.calibration(None, Some([640, 480])), Ok(expected()));
    assert_eq!(
        file.calibration(None, Some([320, 240])).unwrap_err().to_string(),
        "the file is of a frame of 640 x 480 pixels, found pixels = [320, 240] in the profile"
    );
}
