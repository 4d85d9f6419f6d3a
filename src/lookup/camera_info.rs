//! What ROS can express of a camera: its lens.

use std::fmt::Write;

/// A lens as `sensor_msgs/CameraInfo` has it.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraInfo {
    /// Name of the camera.
    pub name: String,
    /// Pixels across and down.
    pub pixels: [usize; 2],
    /// Focal lengths along x and y, px.
    pub focal_px: [f64; 2],
    /// Principal point, px; the first pixel's middle is (0, 0).
    pub principal_px: [f64; 2],
    /// Name of the distortion's model.
    pub model: &'static str,
    /// Its coefficients.
    pub coefficients: Vec<f64>,
}

/// The YAML of a calibration as ROS's `camera_calibration_parsers` reads it. The mirror is no lens that ROS knows: it stands in the tables.
#[must_use]
pub fn camera_info(info: &CameraInfo, comments: &[String]) -> String {
    let CameraInfo { name, pixels: [width, height], model, coefficients, .. } = info;
    let ([fx, fy], [cx, cy]) = (info.focal_px, info.principal_px);
    let mut text = String::new();
    for comment in comments {
        let _ = writeln!(text, "# {comment}");
    }
    let _ = writeln!(text, "image_width: {width}\nimage_height: {height}\ncamera_name: {name}");
    let mut matrix = |name: &str, [rows, columns]: [usize; 2], data: &[f64]| {
        let data: Vec<String> = data.iter().map(|x| format!("{x:?}")).collect();
        let _ = writeln!(
            text,
            "{name}:\n  rows: {rows}\n  cols: {columns}\n  data: [{}]",
            data.join(", ")
        );
    };
    matrix("camera_matrix", [3, 3], &[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]);
    matrix("distortion_coefficients", [1, coefficients.len()], coefficients);
    matrix("rectification_matrix", [3, 3], &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let projection = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    matrix("projection_matrix", [3, 4], &projection);
    let _ = writeln!(text, "distortion_model: {model}");
    text
}
