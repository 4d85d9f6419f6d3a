//! The chart points of a whole frame's image points.

use super::distortion::InverseTable;
use super::{Camera, PictureMap};
use crate::geom::DVec2;

/// Pixels along a side of a cell of the table.
const CELL_PX: usize = 16;
/// Most cells along a side of the frame: more make Newton's method no shorter.
const MOST_CELLS: usize = 128;

/// Chart points of the image points of a camera's frame, for all of which to ask.
///
/// Behind a lens that distorts it has a table of the inverse, which is made once: a point is then found in less time than
/// by [`PictureMap::chart_point`], to rounding the same.
#[derive(Debug, Clone)]
pub struct ChartedFrame {
    picture: PictureMap,
    table: Option<InverseTable>,
}

impl ChartedFrame {
    /// The frame of `camera`.
    #[must_use]
    pub fn new(camera: &Camera) -> Self {
        let cells = camera.pixels.map(|n| (n as usize).div_ceil(CELL_PX).min(MOST_CELLS));
        let table = camera.picture.inverse_table(camera.frame(), cells);
        Self { picture: camera.picture, table }
    }

    /// The chart coordinates that an image point shows: not finite where the plane is not seen.
    #[inline]
    #[must_use]
    pub fn chart_point(&self, image: DVec2) -> DVec2 {
        match &self.table {
            None => self.picture.chart_point(image),
            Some(table) => self.picture.chart_point_by(table, image),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{CameraModel, Distortion, Mount};

    #[test]
    fn chart_points_of_a_frame_are_those_of_the_picture_to_rounding() {
        let brown = Distortion::BrownConrady {
            radial: [-0.31, 0.14, -0.02, 0.0, 0.0, 0.0],
            tangential: [0.0011, -0.0006],
            prism: [0.0; 4],
        };
        let fisheye = Distortion::KannalaBrandt { radial: [-0.02, 0.004, 0.0, 0.0] };
        let fold = Mount { fold_deg: 50.0, towards_deg: 70.0, shift_mm: [2.0, -1.0] };
        let lenses = [(brown, 900.0), (fisheye, 420.0), (Distortion::None, 900.0)];
        for ((distortion, focal_px), mount) in
            lenses.into_iter().flat_map(|lens| [(lens, Mount::default()), (lens, fold)])
        {
            let model = CameraModel::Calibrated {
                pixels: [640, 480],
                focal_px: [focal_px, 1.01 * focal_px],
                principal_px: [327.4, 234.1],
                distortion,
                distance_mm: 150.0,
            };
            let camera = Camera::new(&model, &mount, 80.0);
            let frame = ChartedFrame::new(&camera);
            for k in 0..640 * 480 / 7 {
                let [x, y] = [7 * k % 640, 7 * k / 640].map(|n| f64::from(n) + 0.5);
                let image = camera.image_point(x, y);
                let (found, exact) = (frame.chart_point(image), camera.picture.chart_point(image));
                // As a share of the distance from the camera, which is oblique rays' longer one.
                let off = (found - exact).length() / (150.0 + exact.length_squared() / 150.0);
                assert!(off < 1e-14 || (found.is_nan() && exact.is_nan()), "{x} {y} {off:e}");
            }
        }
    }
}
