//! What is no calibration is refused with its line and key.

use super::{JSON, XML, YAML, parse};
use crate::num::sample::Draws;
use crate::profile::CalibrationFile;

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

/// Bytes changed, left out and given twice: read or refused, and what is read is finite.
#[test]
fn damaged_files_are_read_or_refused() {
    let mut draws = Draws::new(11);
    let (mut read, mut refused) = (0, 0);
    for text in [YAML, JSON, XML] {
        for _ in 0..3000 {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..1 + (3.0 * draws.unit()) as usize {
                let at = (draws.unit() * bytes.len() as f64) as usize;
                let length = ((1.0 + 9.0 * draws.unit()) as usize).min(bytes.len() - at);
                match (3.0 * draws.unit()) as u32 {
                    0 => {
                        let marks = b"<>[]{}&*!|#%:,-\"'\\/?~`@ \t\n.e0\xff";
                        bytes[at] = marks[(draws.unit() * marks.len() as f64) as usize];
                    }
                    1 => drop(bytes.drain(at..at + length)),
                    _ => {
                        let again = bytes[at..at + length].to_vec();
                        bytes.splice(at..at, again);
                    }
                }
            }
            match CalibrationFile::parse(&bytes) {
                Ok(file) => {
                    let numbers = file.focal_px.iter().chain(&file.principal_px);
                    assert!(numbers.chain(&file.coefficients).all(|number| number.is_finite()));
                    read += 1;
                }
                Err(error) => {
                    assert!(!error.to_string().is_empty());
                    refused += 1;
                }
            }
        }
    }
    assert!(read > 500 && refused > 500, "{read} read, {refused} refused");
}
