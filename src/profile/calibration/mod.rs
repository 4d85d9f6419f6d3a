//! The calibration of a camera from the file that OpenCV or ROS writes.
//!
//! `cv::FileStorage` writes YAML, JSON and XML; all three are read into one tree, whose keys are read once. ROS
//! writes YAML with the same keys. Spellings of the programs in use are understood, with capitals and
//! underscores or without: `camera_matrix` (or `K`, `mtx`), `distortion_coefficients` (`dist_coeffs`, `D`,
//! `dist`), `image_width` and `image_height` (`width`, `height`, or `image_size`).

mod error;
mod json;
mod lens_model;
#[cfg(test)]
mod tests;
mod tree;
mod xml;
mod yaml;

use crate::optics::Calibration;
pub use error::CalibrationError;
pub use lens_model::{CoefficientFault, LensModel};
use tree::{TreeNode, Value, find};

/// Most bytes of a file: a calibration has some two thousand, with all corners of its pictures a hundred times
/// as many.
pub(super) const MOST_BYTES: usize = 1_000_000;
/// Focal lengths, px.
const FOCAL: std::ops::RangeInclusive<f64> = 1e-3..=1e7;
/// Pixels along a side of a frame, and in all, as of `camera.pinhole.pixels`.
const MOST_SIDE: f64 = 32767.0;
const MOST_PIXELS: f64 = 4e8;
/// Largest principal point and coefficient in size: those of any lens are far below.
const LARGE: f64 = 1e6;

/// What a calibration file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationFile {
    /// Width and height of the frame in pixels, if the file says it.
    pub pixels: Option<[u32; 2]>,
    /// Focal length across and down, px.
    pub focal_px: [f64; 2],
    /// Principal point in OpenCV's convention: the centres of pixels are at whole numbers.
    pub principal_px: [f64; 2],
    /// Distortion coefficients in OpenCV's order.
    pub coefficients: Vec<f64>,
    /// Model of the distortion, if the file says it.
    pub model: Option<LensModel>,
    /// Line of the coefficients.
    line: usize,
    /// Key of the coefficients.
    key: String,
}

impl CalibrationFile {
    /// Reads YAML, JSON or XML.
    ///
    /// # Errors
    /// [`CalibrationError`] of the first fault.
    pub fn parse(bytes: &[u8]) -> Result<Self, CalibrationError> {
        if bytes.len() > MOST_BYTES {
            return Err(CalibrationError::TooLong { bytes: bytes.len() });
        }
        let text = str::from_utf8(bytes).map_err(|error| {
            let before = &bytes[..error.valid_up_to()];
            let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
            CalibrationError::NotText { line }
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let root = match text.trim_start().as_bytes().first() {
            Some(b'{') => json::parse(text)?,
            Some(b'<') => xml::parse(text)?,
            _ => yaml::parse(text)?,
        };
        let Value::Table(table) = &root.value else {
            return Err(root.fault("the file", "a table of keys such as camera_matrix"));
        };
        Self::of_keys(table)
    }

    fn of_keys(table: &[(String, TreeNode)]) -> Result<Self, CalibrationError> {
        let must = "a matrix of 3 x 3 with the focal lengths and the principal point";
        let (key, node) = required(table, "camera_matrix", &["cameramatrix", "k", "mtx"], must)?;
        let [focal_px, principal_px] = intrinsics(node, key)?;
        let names = ["distortioncoefficients", "distcoeffs", "distcoeff", "d", "dist"];
        let must = "a list of the distortion coefficients";
        let (key, node) = required(table, "distortion_coefficients", &names, must)?;
        let coefficients = coefficients(node, key)?;
        let (pixels, model) = (pixels(table)?, said_model(table)?);
        let (line, key) = (node.line, key.to_owned());
        Ok(Self { pixels, focal_px, principal_px, coefficients, model, line, key })
    }

    /// The calibration, with what the profile says of model and frame; without either, the model is OpenCV's
    /// usual one.
    ///
    /// # Errors
    /// [`CalibrationError`] if neither the profile nor the file says how large the frame is, both say different
    /// things, or the coefficients are not the model's.
    pub fn calibration(
        &self,
        model: Option<LensModel>,
        pixels: Option<[u32; 2]>,
    ) -> Result<Calibration, CalibrationError> {
        let model = match (self.model, model) {
            (Some(file), Some(profile)) if file != profile => {
                return Err(CalibrationError::Models { file, profile });
            }
            (file, profile) => profile.or(file).unwrap_or(LensModel::OpenCv),
        };
        let pixels = match (self.pixels, pixels) {
            (Some(file), Some(profile)) if file != profile => {
                return Err(CalibrationError::Frames { file, profile });
            }
            (file, profile) => file.or(profile).ok_or_else(|| CalibrationError::Missing {
                key: "image_width".to_owned(),
                must: "the width of the frame in pixels, with image_height; or give pixels in the profile"
                    .to_owned(),
            })?,
        };
        let distortion =
            model.distortion(&self.coefficients).map_err(|fault| CalibrationError::Value {
                line: self.line,
                key: self.key.clone(),
                must: fault.must,
                found: fault.found,
            })?;
        let (focal_px, principal_px) = (self.focal_px, self.principal_px.map(|px| px + 0.5));
        Ok(Calibration { pixels, focal_px, principal_px, distortion })
    }
}

fn required<'t>(
    table: &'t [(String, TreeNode)],
    usual: &str,
    names: &[&str],
    must: &str,
) -> Result<(&'t str, &'t TreeNode), CalibrationError> {
    let missing = || CalibrationError::Missing { key: usual.to_owned(), must: must.to_owned() };
    find(table, names)?.ok_or_else(missing)
}

/// Focal lengths and principal point of a camera matrix.
fn intrinsics(node: &TreeNode, key: &str) -> Result<[[f64; 2]; 2], CalibrationError> {
    let matrix = node.matrix(key)?;
    let must = "a matrix of 3 x 3";
    let Ok([fx, skew, cx, below, fy, cy, last @ ..]) =
        <[f64; 9]>::try_from(matrix.numbers.as_slice())
    else {
        let found = match matrix.size {
            Some([rows, columns]) => format!("{rows} x {columns}"),
            None => format!("{} numbers", matrix.numbers.len()),
        };
        return Err(node.found_other(key, must, found));
    };
    if let Some([rows, columns]) = matrix.size.filter(|size| *size != [3, 3]) {
        return Err(node.found_other(key, must, format!("{rows} x {columns}")));
    }
    if skew != 0.0 {
        let must = "without skew, its second number 0";
        return Err(node.found_other(key, must, skew.to_string()));
    }
    if below != 0.0 || last != [0.0, 0.0, 1.0] {
        let [a, b, c] = last;
        let must = "[fx, 0, cx], [0, fy, cy], [0, 0, 1] row by row";
        let found = format!("[{fx}, {skew}, {cx}], [{below}, {fy}, {cy}], [{a}, {b}, {c}]");
        return Err(node.found_other(key, must, found));
    }
    if let Some(focal) = [fx, fy].into_iter().find(|focal| !FOCAL.contains(focal)) {
        let must = "a matrix with focal lengths from 0.001 to 1e7 pixels";
        return Err(node.found_other(key, must, focal.to_string()));
    }
    if let Some(principal) = [cx, cy].into_iter().find(|place| !(place.abs() <= LARGE)) {
        let must = "a matrix with a principal point from -1e6 to 1e6 pixels";
        return Err(node.found_other(key, must, principal.to_string()));
    }
    Ok([[fx, fy], [cx, cy]])
}

fn coefficients(node: &TreeNode, key: &str) -> Result<Vec<f64>, CalibrationError> {
    let matrix = node.matrix(key)?;
    if let Some([rows, columns]) = matrix.size.filter(|[rows, columns]| *rows > 1 && *columns > 1) {
        let must = "one row or one column of coefficients";
        return Err(node.found_other(key, must, format!("{rows} x {columns}")));
    }
    if let Some(large) = matrix.numbers.iter().find(|k| !(k.abs() <= LARGE)) {
        let must = "a list of coefficients from -1e6 to 1e6";
        return Err(node.found_other(key, must, large.to_string()));
    }
    Ok(matrix.numbers)
}

/// The frame, if the file says it.
fn pixels(table: &[(String, TreeNode)]) -> Result<Option<[u32; 2]>, CalibrationError> {
    let side = |key: &str, node: &TreeNode| {
        let number = node.number(key)?;
        if number.fract() == 0.0 && (1.0..=MOST_SIDE).contains(&number) {
            return Ok(number);
        }
        Err(node.fault(key, "a whole number of pixels from 1 to 32767"))
    };
    let width = find(table, &["imagewidth", "width"])?;
    let height = find(table, &["imageheight", "height"])?;
    let size = find(table, &["imagesize"])?;
    let (sides, key, node) = match (width, height, size) {
        (None, None, None) => return Ok(None),
        (Some((key, width)), Some((other, height)), None) => {
            ([side(key, width)?, side(other, height)?], key, width)
        }
        (None, None, Some((key, node))) => match &node.value {
            Value::List(list) if list.len() == 2 => {
                ([side(key, &list[0])?, side(key, &list[1])?], key, node)
            }
            _ => return Err(node.fault(key, "a list of the width and the height in pixels")),
        },
        (Some((key, node)), None, None) | (None, Some((key, node)), None) => {
            let must = "beside the other side of the frame";
            return Err(node.found_other(key, must, "it alone"));
        }
        (Some((key, node)), _, Some(_)) | (_, Some((key, node)), Some(_)) => {
            let must = "absent beside image_size";
            return Err(node.found_other(key, must, "both"));
        }
    };
    let [width, height] = sides;
    if !(width * height <= MOST_PIXELS) {
        let must = "that of a frame of at most 400 million pixels";
        return Err(node.found_other(key, must, format!("{width} x {height}")));
    }
    Ok(Some(sides.map(|side| side as u32)))
}

/// The model that a file names: `distortion_model` of ROS, `fisheye_model` of OpenCV's sample program.
fn said_model(table: &[(String, TreeNode)]) -> Result<Option<LensModel>, CalibrationError> {
    let named = match find(table, &["distortionmodel"])? {
        None => None,
        Some((key, node)) => match &node.value {
            Value::Text(word) if word.is_empty() => None,
            Value::Text(word) => Some(match word.as_str() {
                "plumb_bob" | "rational_polynomial" | "opencv" => LensModel::OpenCv,
                "equidistant" | "fisheye" => LensModel::Fisheye,
                _ => {
                    let must = "plumb_bob, rational_polynomial, equidistant or fisheye";
                    return Err(node.fault(key, must));
                }
            }),
            _ => return Err(node.fault(key, "a word")),
        },
    };
    let Some((key, node)) = find(table, &["fisheyemodel"])? else { return Ok(named) };
    let flagged = match node.value {
        Value::Number(0.0) => LensModel::OpenCv,
        Value::Number(1.0) => LensModel::Fisheye,
        _ => return Err(node.fault(key, "0 or 1")),
    };
    match named {
        Some(named) if named != flagged => Err(node.found_other(
            key,
            format!("that of the model \"{named}\""),
            format!("\"{flagged}\""),
        )),
        _ => Ok(Some(flagged)),
    }
}
