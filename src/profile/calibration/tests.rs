//! The three formats and the spellings of their keys, and the refusal of everything else.

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

/// Each edit of a text, and how its complaint begins.
fn refused(text: &str, edits: &[(&str, &str, &str)]) {
    for (from, to, told) in edits {
        assert!(text.contains(from), "{from}");
        let found = parse(&text.replacen(from, to, 1)).expect_err(to).to_string();
        assert!(found.starts_with(told), "{found}\n{told}");
    }
}

#[test]
fn faults_of_yaml_name_line_and_key() {
    refused(
        YAML,
        &[
            ("camera_matrix", "cameras", "camera_matrix must be a matrix of 3 x 3"),
            ("distortion_co", "co", "distortion_coefficients must be a list"),
            (
                "0., 331.25",
                "0.5, 331.25",
                "line 7: camera_matrix must be without skew, its second number 0, found 0.5",
            ),
            (
                "0., 0., 1. ]",
                "0., 0., 2. ]",
                "line 7: camera_matrix must be [fx, 0, cx], [0, fy, cy], [0, 0, 1]",
            ),
            ("820.5", ".Nan", "line 11: camera_matrix.data must be a finite number, found NaN"),
            ("819.5", "1e999", "line 12: camera_matrix.data must be a finite number, found inf"),
            ("819.5", "-.Inf", "line 12: camera_matrix.data must be a finite number, found -inf"),
            (
                "819.5",
                "wide",
                "line 12: camera_matrix.data must be a finite number, found the text \"wide\"",
            ),
            ("820.5", "-820.5", "line 7: camera_matrix must be a matrix with focal lengths from"),
            ("331.25", "1e7", "line 7: camera_matrix must be a matrix with a principal point from"),
            (
                "rows: 3",
                "rows: 4",
                "line 11: camera_matrix.data must be a list of rows x cols = 4 x 3 numbers, found a list of 9",
            ),
            (
                "rows: 3",
                "rows: 1.5",
                "line 8: camera_matrix.rows must be a whole number, found 1.5",
            ),
            (
                "rows: 3\n   cols: 3",
                "rows: 1\n   cols: 9",
                "line 7: camera_matrix must be a matrix of 3 x 3, found 1 x 9",
            ),
            (
                "cols: 3",
                "columns: 3",
                "line 7: camera_matrix must be a matrix with rows, cols and data, found no cols",
            ),
            (
                "rows: 5\n",
                "rows: 6\n",
                "line 17: distortion_coefficients.data must be a list of rows x cols = 6 x 1",
            ),
            ("rows: 5", "rows: 0", "line 17: distortion_coefficients.data must be"),
            (
                ", .01 ]",
                ", 1e7 ]",
                "line 13: distortion_coefficients must be a list of coefficients from",
            ),
            (
                "rows: 5\n   cols: 1\n   dt: d\n   data: [ ",
                "rows: 2\n   cols: 3\n   dt: d\n   data: [ 0, ",
                "line 13: distortion_coefficients must be one row or one column of coefficients, found 2 x 3",
            ),
            (
                "rows: 5\n   cols: 1\n   dt: d\n   data: [ ",
                "rows: 6\n   cols: 1\n   dt: d\n   data: [ 0, ",
                "line 13: distortion_coefficients must be a list of 4, 5, 8, 12 or 14 coefficients",
            ),
            (
                "image_width: 640",
                "image_width: 640.5",
                "line 4: image_width must be a whole number of pixels from 1 to 32767, found 640.5",
            ),
            ("image_width: 640", "image_width: 0", "line 4: image_width must be"),
            (
                "image_width: 640\n",
                "",
                "line 4: image_height must be beside the other side of the frame",
            ),
            (
                "image_width: 640\nimage_height: 480",
                "image_width: 32000\nimage_height: 32000",
                "line 4: image_width must be that of a frame of at most 400 million pixels, found 32000 x 32000",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "image_size: [640, 480]",
                "line 4: image_width must be absent beside image_size",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "K: [1]",
                "line 18: camera_matrix must be given only once, found K as well",
            ),
            (
                "avg_reprojection_error",
                "image_width",
                "line 18: image_width must be given only once, found image_width as well",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "distortion_model: pinhole",
                "line 18: distortion_model must be plumb_bob",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "distortion_model: equidistant",
                "line 13: distortion_coefficients must be a list of 4 coefficients, k1 to k4",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "fisheye_model: 2",
                "line 18: fisheye_model must be 0 or 1, found 2",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "fisheye_model: 1\ndistortion_model: plumb_bob",
                "line 18: fisheye_model must be that of the model \"opencv\", found \"fisheye\"",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "distortion_model: [1]",
                "line 18: distortion_model must be a word",
            ),
            ("avg_reprojection_error: 2.5e-01", "a: [1", "line 19: the text must be YAML"),
            (
                "avg_reprojection_error: 2.5e-01",
                "a: &b 1\nc: *b",
                "line 19: the text must be YAML: aliases are not read",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "[1]: 2",
                "line 18: the text must be YAML: keys must be words",
            ),
            (
                "avg_reprojection_error: 2.5e-01",
                "...\n---\na: 1",
                "line 20: the text must be YAML: one document alone is read",
            ),
        ],
    );
    let deep = format!("a: {}{}", "[".repeat(40), "]".repeat(40));
    let told = parse(&deep).unwrap_err().to_string();
    assert_eq!(told, "line 1: the text must be YAML: at most 32 levels are read");
    for (text, told) in [
        ("", "line 1: the file must be a table of keys such as camera_matrix, found the text"),
        (
            "- 1\n- 2\n",
            "line 1: the file must be a table of keys such as camera_matrix, found a list of 2",
        ),
        (
            "K: [[1, 0, 1], [0, 1]]",
            "line 1: K must be a list of rows of equal length, found a list of 2",
        ),
        ("K: [[1, 0, 1], 1]", "line 1: K must be a list of rows alone, found 1"),
        ("K: text", "line 1: K must be a matrix or a list of numbers, found the text \"text\""),
        ("K: [1, 2]", "line 1: K must be a matrix of 3 x 3, found 2 numbers"),
        ("K: 1", "line 1: K must be a matrix of 3 x 3, found 1 numbers"),
    ] {
        let found = parse(text).unwrap_err().to_string();
        assert!(found.starts_with(told), "{found}\n{told}");
    }
}

#[test]
fn faults_of_json_name_line_and_key() {
    refused(
        JSON,
        &[
            ("camera_matrix", "cameras", "camera_matrix must be a matrix of 3 x 3"),
            (
                "820.5",
                "null",
                "line 13: camera_matrix.data must be a finite number, found the text \"null\"",
            ),
            (
                "820.5",
                "\"820.5\"",
                "line 13: camera_matrix.data must be a finite number, found the text",
            ),
            ("236.75,", "true,", "line 14: camera_matrix.data must be a finite number"),
            ("0.0, 331.25", "0.5, 331.25", "line 8: camera_matrix must be without skew"),
            ("640", "640.5", "line 2: image_width must be a whole number"),
            ("-3.1e-01", ".Nan", "line 21: the text must be JSON: expected value"),
            ("-3.1e-01", "1e999", "line 21: the text must be JSON: number out of range"),
            ("640,", "640", "line 3: the text must be JSON: expected `,` or `}`"),
            ("    }\n}", "    }\n", "line 24: the text must be JSON: EOF"),
            ("    }\n}", "    }\n}}", "line 23: the text must be JSON: trailing characters"),
            ("\"url\"", "\"K\"", "line 8: K must be given only once, found camera_matrix as well"),
        ],
    );
    let deep = format!("{{\"a\": {}{}}}", "[".repeat(200), "]".repeat(200));
    assert_eq!(
        parse(&deep).unwrap_err().to_string(),
        "line 1: the text must be JSON: recursion limit exceeded"
    );
}

#[test]
fn faults_of_xml_name_line_and_key() {
    refused(
        XML,
        &[
            (
                "<camera_matrix type_id=\"opencv-matrix\">",
                "<cameras>",
                "line 13: the text must be XML",
            ),
            ("820.5", "nan", "line 12: camera_matrix.data must be a finite number, found NaN"),
            (
                "236.75",
                "wide",
                "line 13: camera_matrix.data must be a finite number, found the text \"wide\"",
            ),
            ("0. 331.25", "0.5 331.25", "line 7: camera_matrix must be without skew"),
            (
                "<rows>3</rows>",
                "",
                "line 7: camera_matrix must be a matrix with rows, cols and data, found no rows",
            ),
            (
                "-3.1e-01 1.2e-01 1e-3 -7e-4 .01",
                "",
                "line 18: distortion_coefficients.data must be",
            ),
            (
                "-3.1e-01 1.2e-01 1e-3 -7e-4 .01",
                "a b",
                "line 18: distortion_coefficients.data must be a list of numbers, found the text \"a b\"",
            ),
            ("640", "640 481", "line 4: image_width must be a finite number, found a list of 2"),
            (
                "</opencv_storage>",
                "",
                "line 21: the text must be XML: <opencv_storage> of line 2 is not closed",
            ),
            (
                "</opencv_storage>",
                "</opencv_storage>\n<opencv_storage/>",
                "line 21: the text must be XML: one element <opencv_storage>",
            ),
            ("</opencv_storage>", "</opencv_storage>\n5", "line 20: the text must be XML"),
            (
                "<opencv_storage>",
                "<storage>",
                "line 2: the text must be XML: one element <opencv_storage>",
            ),
            (
                "<opencv_storage>",
                "<!DOCTYPE a>\n<opencv_storage>",
                "line 2: the text must be XML: document types are not read",
            ),
            (
                "<opencv_storage>",
                "<opencv_storage>word",
                "line 2: the text must be XML: <opencv_storage> holds text",
            ),
            (
                "<image_width>640</image_width>",
                "<image_width>640<a/></image_width>",
                "line 4: the text must be XML: <image_width> holds text beside elements",
            ),
        ],
    );
    let deep = format!("<opencv_storage>{}", "<a>".repeat(40));
    assert_eq!(
        parse(&deep).unwrap_err().to_string(),
        "line 1: the text must be XML: at most 32 levels are read"
    );
    let told = parse("<opencv_storage/>").unwrap_err().to_string();
    assert!(told.starts_with("line 1: the file must be a table of keys"), "{told}");
    assert!(parse("<?xml version=\"1.0\"?>").unwrap_err().to_string().contains("no element"));
}

#[test]
fn what_is_no_text_or_too_long_is_refused() {
    let told = CalibrationFile::parse(b"image_width: 640\nK: \xff\n").unwrap_err().to_string();
    assert_eq!(told, "line 2: a calibration must be UTF-8 text, found other bytes");
    let long = vec![b'\n'; 1_000_001];
    let told = CalibrationFile::parse(&long).unwrap_err().to_string();
    assert_eq!(told, "a calibration must have at most 1000000 bytes, found 1000001");
}
