//! Cameras: which ray each point of the picture sends out.

use super::picture_map::LensMap;
use super::{Distortion, Mount, PictureMap};
use crate::geom::{Chart, DVec2, DVec3, Ray, Rect};
use crate::num::units::{Mm, Px};

/// Camera that looks into the mirror, by its frame and its focal length in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CameraModel {
    /// Telecentric camera: all its rays are parallel to the optical axis.
    Orthographic {
        /// Width and height of the frame in pixels.
        pixels: [u32; 2],
    },
    /// Camera whose rays all pass through one point on the optical axis.
    Pinhole {
        /// Width and height of the frame in pixels.
        pixels: [u32; 2],
        /// Focal length in pixels, positive.
        focal_px: f64,
        /// Distance of the reference plane from the pinhole along the optical axis, mm, positive.
        distance_mm: f64,
    },
    /// Camera whose rays all pass through the middle of its entrance pupil, as a calibration found it.
    Calibrated {
        /// Width and height of the frame in pixels.
        pixels: [u32; 2],
        /// Focal length across and down the picture, in pixels, positive.
        focal_px: [f64; 2],
        /// Picture point of the optical axis, as of [`Camera::image_point`]: pixel centres at halves.
        principal_px: [f64; 2],
        /// Distortion of the lens; every pixel of the frame has a ray.
        distortion: Distortion,
        /// Distance of the reference plane from the entrance pupil along the optical axis, mm, positive.
        distance_mm: f64,
    },
}

impl CameraModel {
    /// Width and height of the frame in pixels.
    #[must_use]
    pub fn pixels(&self) -> [u32; 2] {
        match *self {
            Self::Orthographic { pixels }
            | Self::Pinhole { pixels, .. }
            | Self::Calibrated { pixels, .. } => pixels,
        }
    }

    /// Side of a pixel on the reference plane, mm: the frame of a telecentric camera is as wide as the
    /// mirror, `width_mm`. Of a calibrated camera it is that on the optical axis, the geometric mean of both
    /// sides.
    #[must_use]
    pub fn pixel_mm(&self, width_mm: f64) -> f64 {
        match *self {
            Self::Orthographic { pixels } => width_mm / f64::from(pixels[0]),
            Self::Pinhole { focal_px, distance_mm, .. } => distance_mm / focal_px,
            Self::Calibrated { focal_px: [across, down], distance_mm, .. } => {
                distance_mm / (across * down).sqrt()
            }
        }
    }

    /// The lens in the way of a picture whose pixels have the side `pixel_mm`; none where the picture is a scaled
    /// plane, centred on the axis.
    fn lens(&self, pixel_mm: f64) -> Option<LensMap> {
        let Self::Calibrated { pixels, focal_px, principal_px, distortion, distance_mm } = *self
        else {
            return None;
        };
        let [width, height] = pixels.map(f64::from);
        let [x, y] = principal_px;
        Some(LensMap {
            distortion,
            distance_mm,
            focal: DVec2::from_array(focal_px) * pixel_mm,
            principal: DVec2::new(x - 0.5 * width, 0.5 * height - y) * pixel_mm,
        })
    }

    /// Distance of the reference plane from the entrance pupil along the optical axis, mm: infinite for parallel
    /// rays.
    #[must_use]
    pub fn distance_mm(&self) -> f64 {
        match *self {
            Self::Orthographic { .. } => f64::INFINITY,
            Self::Pinhole { distance_mm, .. } | Self::Calibrated { distance_mm, .. } => distance_mm,
        }
    }
}

/// A camera, orthographic (telecentric) or pinhole, its picture centred on its axis.
///
/// Image points are mm in the picture, at the scale of `pixel_mm`; chart coordinates are mm on the part's reference
/// plane. They are one where the camera stands on the part's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Columns and rows of the sensor.
    pub pixels: [u32; 2],
    /// Side of a (square) pixel on the reference plane, mm.
    pub pixel_mm: f64,
    /// Coordinates along its rays.
    pub chart: Chart,
    /// From chart coordinates to image points.
    pub picture: PictureMap,
}

impl Camera {
    /// The same camera with so many columns and rows in as wide a frame.
    #[must_use]
    pub fn with_pixels(self, pixels: [u32; 2]) -> Self {
        let scale = f64::from(self.pixels[0]) / f64::from(pixels[0]);
        Self { pixels, pixel_mm: self.pixel_mm * scale, ..self }
    }

    /// The same camera with so many columns at most, and rows in their number: an even one if it has an even one, so that none looks along
    /// the middle of the frame, where panels may meet in a wall.
    #[must_use]
    pub fn at_most(self, columns: u32) -> Self {
        let [width, height] = self.pixels;
        if width <= columns {
            return self;
        }
        let exact = f64::from(height) * f64::from(columns) / f64::from(width);
        let parts = if height.is_multiple_of(2) { 2.0 } else { 1.0 };
        let rows = (parts * (exact / parts).round()) as u32;
        self.with_pixels([columns, rows.max(1)])
    }

    /// Camera of a model over a mirror `width_mm` wide, its reference plane at Z = 0.
    #[must_use]
    pub fn new(model: &CameraModel, mount: &Mount, width_mm: f64) -> Self {
        let distance_mm = model.distance_mm();
        let [s, c] = mount.tilt();
        let vergence = 1.0 / (distance_mm * c);
        let shift = DVec2::from_array(mount.shift_mm) * vergence;
        let chart = Chart { vergence, plane_mm: 0.0, lean: shift - mount.towards() * (s / c) };
        let chart = if mount.is_on_axis() { Chart::on_axis(vergence, 0.0) } else { chart };
        let pixel_mm = model.pixel_mm(width_mm);
        let picture = PictureMap::new(mount, distance_mm).with_lens(model.lens(pixel_mm));
        Self { pixels: model.pixels(), pixel_mm, chart, picture }
    }

    /// The image point, mm, of the picture point (`x`, `y`) pixels: x to the right, y downwards, both from the
    /// upper left corner; pixel centres at halves.
    #[inline]
    #[must_use]
    pub fn image_point(&self, x: f64, y: f64) -> DVec2 {
        let [width, height] = self.pixels.map(f64::from);
        DVec2::new(x - 0.5 * width, 0.5 * height - y) * self.pixel_mm
    }

    /// Column and row of an image point (mm) in pixels from the upper left corner: the inverse of
    /// [`Camera::image_point`].
    #[must_use]
    pub fn picture_point(&self, image: DVec2) -> [f64; 2] {
        let [width, height] = self.pixels.map(f64::from);
        [image.x / self.pixel_mm + 0.5 * width, 0.5 * height - image.y / self.pixel_mm]
    }

    /// A length in the image in mm.
    #[must_use]
    pub fn to_mm(&self, px: Px) -> Mm {
        Mm(px.0 * self.pixel_mm)
    }

    /// A length in mm of the image in pixels.
    #[must_use]
    pub fn to_px(&self, mm: Mm) -> Px {
        Px(mm.0 / self.pixel_mm)
    }

    /// The ray through an image point, from the pinhole or from height `top_mm`.
    #[inline]
    #[must_use]
    pub fn ray(&self, image: DVec2, top_mm: f64) -> Ray {
        self.chart.ray(self.picture.chart_point(image), top_mm)
    }

    /// The image point at which the camera sees a point of space.
    #[inline]
    #[must_use]
    pub fn image_at(&self, at: DVec3) -> DVec2 {
        self.picture.image_point(self.chart.coordinates(at).0)
    }

    /// Unit vector along the camera's axis, towards the camera.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        let [right, up] = self.picture.axes();
        right.cross(up)
    }

    /// Inverse of the distance of the reference plane along the camera's axis, 1/mm; 0 for parallel rays.
    #[must_use]
    pub fn vergence(&self) -> f64 {
        self.chart.vergence * self.axis().z
    }

    /// Whether the frame has an image point, its edge included.
    #[must_use]
    pub fn frames(&self, image: DVec2) -> bool {
        image.abs().cmple(self.half_frame()).all()
    }

    /// The frame, mm of the picture.
    #[must_use]
    pub fn frame(&self) -> Rect {
        let half = self.half_frame();
        Rect { min: -half, max: half }
    }

    /// Whether all of the frame's edge sees the reference plane: nothing of it reaches beyond the plane's horizon.
    #[must_use]
    pub fn sees_plane(&self) -> bool {
        edge_places(self.frame()).all(|image| self.picture.chart_point(image).is_finite())
    }

    /// The smallest rectangle of the reference plane, in chart coordinates, that holds all that a rectangle of the
    /// picture shows of it.
    #[must_use]
    pub fn seen_of(&self, picture: Rect) -> Rect {
        bounds_of_edge(picture, |image| self.picture.chart_point(image))
    }

    /// The smallest rectangle of the picture that holds the image of a rectangle of the reference plane, in chart
    /// coordinates.
    #[must_use]
    pub fn image_of(&self, area: Rect) -> Rect {
        bounds_of_edge(area, |q| self.picture.image_point(q))
    }

    /// The line across the part, in chart coordinates, that stands for the edge between two columns (`axis` 0) or rows (1)
    /// of the frame, `edge` of them from its left or its top: its constant coordinate, mm. Where the lens bends the edge
    /// on the part, or a camera that leans sees it aslant, the line is in the middle of what of the edge lies beside `area`; infinite
    /// where nothing does.
    #[must_use]
    pub fn line_at(&self, axis: usize, edge: u32, area: Rect) -> f64 {
        /// Places along the edge: of one whose part lies in an eighth of the frame, 32.
        const PLACES: u32 = 256;
        let [width, height] = self.pixels.map(f64::from);
        let edge = f64::from(edge);
        let at = |k: u32| {
            let share = f64::from(k) / f64::from(PLACES);
            let image = match axis {
                0 => self.image_point(edge, share * height),
                _ => self.image_point(share * width, edge),
            };
            self.picture.chart_point(image)
        };
        if self.picture.is_identity() {
            return at(0)[axis];
        }
        let along = 1 - axis;
        let is_beside = |q: &DVec2| (area.min[along]..=area.max[along]).contains(&q[along]);
        let ends = |[low, high]: [f64; 2], q: DVec2| [low.min(q[axis]), high.max(q[axis])];
        let places = (0..=PLACES).map(at).filter(is_beside);
        let [low, high] = places.fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        if low <= high { 0.5 * (low + high) } else { f64::INFINITY }
    }

    /// The rectangle about the part's axis that is `width_mm` wide, and of that height or as high for its width as the frame
    /// is at the mirror, mm.
    #[must_use]
    pub fn rectangle(&self, width_mm: f64, height_mm: Option<f64>) -> Rect {
        let height_mm = height_mm.unwrap_or_else(|| {
            let seen = self.seen_of(self.frame()).size();
            width_mm * seen.y / seen.x
        });
        let half = 0.5 * DVec2::new(width_mm, height_mm);
        Rect { min: -half, max: half }
    }

    /// Half the frame's width and height, mm of the image.
    #[must_use]
    pub fn half_frame(&self) -> DVec2 {
        0.5 * self.pixel_mm * DVec2::from_array(self.pixels.map(f64::from))
    }
}

/// Places on a rectangle's edge, corners included.
fn edge_places(rect: Rect) -> impl Iterator<Item = DVec2> {
    /// Places along each side: between two of them the image of an edge is straight, or nearly so.
    const SIDE: usize = 64;
    (0..=SIDE).flat_map(move |k| {
        let t = k as f64 / SIDE as f64;
        let edges =
            [DVec2::new(t, 1.0), DVec2::new(t, 0.0), DVec2::new(1.0, t), DVec2::new(0.0, t)];
        edges.map(|share| rect.min + share * rect.size())
    })
}

/// The smallest rectangle around the image of a rectangle's edge.
fn bounds_of_edge(rect: Rect, image: impl Fn(DVec2) -> DVec2) -> Rect {
    let none = Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY };
    edge_places(rect)
        .map(image)
        .fold(none, |all, q| Rect { min: all.min.min(q), max: all.max.max(q) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_square_centred_and_run_right_and_down() {
        let chart = Chart::on_axis(0.0, 0.0);
        let camera =
            Camera { pixels: [4, 2], pixel_mm: 0.5, chart, picture: PictureMap::default() };
        assert_eq!(camera.image_point(0.5, 0.5), DVec2::new(-0.75, 0.25));
        assert_eq!(camera.image_point(3.5, 1.5), DVec2::new(0.75, -0.25));
        assert_eq!(camera.image_point(2.0, 1.0), DVec2::ZERO);
    }
    #[test]
    fn fewer_pixels_keep_the_frame_and_no_row_of_them_looks_along_its_middle() {
        let chart = Chart::on_axis(0.0, 0.0);
        let of = |pixels| Camera { pixels, pixel_mm: 0.01, chart, picture: PictureMap::default() };
        for (pixels, fewer) in
            [([4056, 3040], [1600, 1200]), ([2000, 1001], [1600, 801]), ([1600, 7], [1600, 7])]
        {
            let (camera, small) = (of(pixels), of(pixels).at_most(1600));
            assert_eq!(small.pixels, fewer);
            // Centres of the outermost pixels are within the frame.
            let corner = small.image_point(f64::from(fewer[0]) - 0.5, 0.5);
            let frame = camera.image_point(f64::from(pixels[0]), 0.0);
            assert!(corner.x < frame.x && corner.y < frame.y, "{corner} {frame}");
            let middle = |row: u32| small.image_point(0.5, f64::from(row) + 0.5).y == 0.0;
            assert_eq!((0..fewer[1]).any(middle), pixels[1] % 2 == 1);
        }
    }
}
