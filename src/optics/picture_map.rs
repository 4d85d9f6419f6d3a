//! From the part's reference plane to the picture: what stands between chart coordinates and image points.
//!
//! The mirror is a height over chart coordinates q, mm on a plane across the part; the picture has its own
//! coordinates w, mm at the scale of a pixel's side where the camera's axis meets that plane, from the middle
//! of the frame. For a camera over the part, looking straight down, both are one. A camera that looks at the
//! plane obliquely sees it in perspective: w is a projective function of q (docs/theory.md, T97).

use super::distortion::{Distortion, DistortionFault, InverseTable};
use crate::geom::{DVec2, DVec3, Rect};
use crate::num::{Dual, Scalar, cos, radians, sin};
use glam::DMat2;

/// Where the camera stands over the part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mount {
    /// Angle between the directions back to the camera and to what a flat mirror in the place of the part shows it
    /// in the middle of the picture, degrees: twice the angle between the camera's axis and the part's normal.
    pub fold_deg: f64,
    /// Azimuth, in the picture, of the direction to which that fold leads: 0 is up, 90 to the right, degrees.
    pub towards_deg: f64,
    /// X and Y of the point of the part's reference plane on the camera's axis, mm.
    pub shift_mm: [f64; 2],
}

impl Mount {
    /// Whether the camera stands on the part's own axis.
    #[must_use]
    pub fn is_on_axis(&self) -> bool {
        self.fold_deg == 0.0 && self.shift_mm == [0.0; 2]
    }

    /// Unit vector in the picture, and on the part, towards which the fold leads.
    pub(super) fn towards(&self) -> DVec2 {
        let [s, c] = sine_and_cosine(self.towards_deg);
        DVec2::new(s, c)
    }

    /// Sine and cosine of the angle between the camera's axis and the part's normal.
    pub(super) fn tilt(&self) -> [f64; 2] {
        sine_and_cosine(0.5 * self.fold_deg)
    }
}

/// Sine and cosine of an angle in degrees, as symmetric as the circle: what is symmetric stays so to the last bit.
pub(super) fn sine_and_cosine(angle_deg: f64) -> [f64; 2] {
    // (Remainders and differences are exact.)
    let turn = (angle_deg % 360.0).abs();
    let side = if angle_deg < 0.0 { -1.0 } else { 1.0 };
    let (half, side) = if turn > 180.0 { (360.0 - turn, -side) } else { (turn, side) };
    let (quarter, ahead) = if half > 90.0 { (180.0 - half, -1.0) } else { (half, 1.0) };
    let [s, c] = match quarter > 45.0 {
        true => [cos(radians(90.0 - quarter)), sin(radians(90.0 - quarter))],
        false => [sin(radians(quarter)), cos(radians(quarter))],
    };
    // (No zero is negative.)
    [side * s + 0.0, ahead * c + 0.0]
}

/// Map of chart coordinates to image points, and back.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PictureMap {
    plane: Option<ObliquePlane>,
    lens: Option<LensMap>,
}

/// The lens of a calibrated camera: from the picture that it would make without distortion, and centred on its axis,
/// to its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LensMap {
    /// The distortion.
    pub distortion: Distortion,
    /// Distance of the reference plane along the optical axis, mm.
    pub distance_mm: f64,
    /// Focal lengths across and down, mm of the picture.
    pub focal: DVec2,
    /// Image point of the optical axis, mm.
    pub principal: DVec2,
}

impl LensMap {
    /// The image point of a place in the picture without distortion.
    #[inline]
    fn image_of<S: Scalar>(&self, ideal: [S; 2]) -> [S; 2] {
        let ray = [ideal[0] / self.distance_mm, -ideal[1] / self.distance_mm];
        let [x, y] = self.distortion.distorted(ray);
        [x * self.focal.x + self.principal.x, -y * self.focal.y + self.principal.y]
    }

    /// The place in the picture without distortion of an image point; not finite where the lens has none.
    fn ideal(&self, image: DVec2) -> DVec2 {
        self.place(self.distortion.undistorted(self.normalised(image)))
    }

    /// The distorted point of an image point.
    #[inline]
    fn normalised(&self, image: DVec2) -> [f64; 2] {
        let at = (image - self.principal) / self.focal;
        [at.x, -at.y]
    }

    /// The place in the picture without distortion of a ray.
    #[inline]
    fn place(&self, ray: Result<[f64; 2], DistortionFault>) -> DVec2 {
        ray.map_or(DVec2::NAN, |[x, y]| DVec2::new(x, -y) * self.distance_mm)
    }
}

/// A plane as a camera sees it that does not stand over it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ObliquePlane {
    /// Where the camera's axis meets the plane, mm.
    foot: DVec2,
    /// The picture's axes, to the right and upwards, in the part's frame.
    axes: [DVec3; 2],
    /// Components along them of a vector in the plane.
    across: DMat2,
    /// How much farther from the camera the plane is for a mm along it, as a share of the distance, 1/mm.
    recession: DVec2,
}

impl PictureMap {
    /// The map of a camera `distance_mm` from the plane along its axis, infinite for parallel rays.
    #[must_use]
    pub fn new(mount: &Mount, distance_mm: f64) -> Self {
        if mount.is_on_axis() {
            return Self::default();
        }
        let ([s, c], towards) = (mount.tilt(), mount.towards());
        // The camera's axes are carried with its axis on the shortest way.
        let carried = |axis: DVec2| {
            let along = axis.dot(towards);
            (axis + towards * (along * (c - 1.0))).extend(along * s)
        };
        let axes = [DVec2::X, DVec2::Y].map(carried);
        let across = DMat2::from_cols(axes[0].truncate(), axes[1].truncate()).transpose();
        let plane = ObliquePlane {
            foot: DVec2::from_array(mount.shift_mm),
            axes,
            across,
            recession: towards * (s / distance_mm),
        };
        Self { plane: Some(plane), lens: None }
    }

    /// The same through a lens.
    #[must_use]
    pub(super) fn with_lens(self, lens: Option<LensMap>) -> Self {
        Self { lens, ..self }
    }

    /// Whether image points are chart coordinates.
    #[inline]
    #[must_use]
    pub fn is_identity(&self) -> bool {
        self.plane.is_none() && self.lens.is_none()
    }

    /// Whether the camera stands on the part's axis and looks along it.
    #[must_use]
    pub fn is_over_axis(&self) -> bool {
        self.plane.is_none()
    }

    /// Whether straight lines on the part are straight in the picture.
    #[must_use]
    pub fn keeps_lines(&self) -> bool {
        self.lens.is_none()
    }

    /// Whether a lens bends lines.
    #[must_use]
    pub fn is_distorted(&self) -> bool {
        self.lens.is_some_and(|lens| lens.distortion != Distortion::None)
    }

    /// The place that an image point would have through a lens without distortion, from the optical axis: not finite
    /// where the lens has none.
    #[must_use]
    pub fn undistorted(&self, image: DVec2) -> DVec2 {
        self.lens.map_or(image, |lens| lens.ideal(image))
    }

    /// Whether what is symmetric about X = 0 (`axis` 0) or Y = 0 (1) on the part is so in the picture.
    #[must_use]
    pub fn is_symmetric(&self, axis: usize) -> bool {
        let upright = |plane: ObliquePlane| {
            let is_diagonal = plane.across.x_axis.y == 0.0 && plane.across.y_axis.x == 0.0;
            plane.foot[axis] == 0.0 && plane.recession[axis] == 0.0 && is_diagonal
        };
        self.lens.is_none() && self.plane.is_none_or(upright)
    }

    /// The image point of chart coordinates, mm.
    #[inline]
    pub fn image_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        let ideal = match &self.plane {
            None => q,
            Some(plane) => plane.image_of(q),
        };
        match &self.lens {
            None => ideal,
            Some(lens) => lens.image_of(ideal),
        }
    }

    /// [`PictureMap::image_of`] for plain numbers.
    #[inline]
    #[must_use]
    pub fn image_point(&self, q: DVec2) -> DVec2 {
        if self.is_identity() { q } else { DVec2::from_array(self.image_of(q.to_array())) }
    }

    /// The chart coordinates that an image point shows: not finite where the plane is not seen.
    #[inline]
    #[must_use]
    pub fn chart_point(&self, image: DVec2) -> DVec2 {
        self.on_plane(self.undistorted(image))
    }

    /// The chart coordinates of a place in the picture without distortion.
    #[inline]
    fn on_plane(&self, ideal: DVec2) -> DVec2 {
        match &self.plane {
            None => ideal,
            Some(plane) => plane.chart_point(ideal),
        }
    }

    /// The table of the lens's inverse over a rectangle of the picture, in so many cells; none where the lens does not
    /// distort.
    #[must_use]
    pub(super) fn inverse_table(&self, picture: Rect, cells: [usize; 2]) -> Option<InverseTable> {
        let lens = self.lens.filter(|_| self.is_distorted())?;
        let corners = [picture.min, picture.max].map(|image| lens.normalised(image));
        Some(InverseTable::new(&lens.distortion, corners, cells))
    }

    /// [`PictureMap::chart_point`] by the table of this lens.
    #[inline]
    #[must_use]
    pub(super) fn chart_point_by(&self, table: &InverseTable, image: DVec2) -> DVec2 {
        let ideal = |lens: LensMap| lens.place(table.undistorted(lens.normalised(image)));
        self.on_plane(self.lens.map_or(image, ideal))
    }

    /// The picture's axes, to the right and upwards, in the part's frame.
    #[must_use]
    pub fn axes(&self) -> [DVec3; 2] {
        self.plane.map_or([DVec3::X, DVec3::Y], |plane| plane.axes)
    }

    /// Where the camera's axis meets the reference plane, mm.
    #[must_use]
    pub fn foot(&self) -> DVec2 {
        self.plane.map_or(DVec2::ZERO, |plane| plane.foot)
    }

    /// Derivatives of the image point by the chart coordinates: its columns are those along X and Y.
    #[must_use]
    pub fn jacobian(&self, q: DVec2) -> DMat2 {
        if self.is_identity() {
            return DMat2::IDENTITY;
        }
        let q: [Dual<2>; 2] = [0, 1].map(|k| Dual::variable(q[k], k));
        DMat2::from_cols_array_2d(&self.image_of(q).map(|w| w.slope)).transpose()
    }

    /// Area of the picture to an area of the plane: every integral over the picture has this weight over the
    /// chart.
    #[must_use]
    pub fn density(&self, q: DVec2) -> f64 {
        if self.is_identity() { 1.0 } else { self.jacobian(q).determinant().abs() }
    }
}

impl ObliquePlane {
    #[inline]
    fn image_of<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        let [x, y] = [q[0] - self.foot.x, q[1] - self.foot.y];
        let DMat2 { x_axis: a, y_axis: b } = self.across;
        let farther = x * self.recession.x + y * self.recession.y + 1.0;
        [(x * a.x + y * b.x) / farther, (x * a.y + y * b.y) / farther]
    }

    fn chart_point(&self, image: DVec2) -> DVec2 {
        // across p = image (1 + recession . p)
        let DMat2 { x_axis, y_axis } = self.across;
        let seen =
            DMat2::from_cols(x_axis - image * self.recession.x, y_axis - image * self.recession.y);
        let p = seen.inverse() * image;
        if 1.0 + self.recession.dot(p) > 0.0 { self.foot + p } else { DVec2::NAN }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Chart;
    use crate::optics::{Camera, CameraModel};

    fn mounts() -> Vec<Mount> {
        [
            (60.0, 90.0, [0.0, 0.0]),
            (35.0, 0.0, [0.0, 4.0]),
            (-50.0, 25.0, [7.0, -3.0]),
            (0.0, 0.0, [5.0, 2.0]),
        ]
        .map(|(fold_deg, towards_deg, shift_mm)| Mount { fold_deg, towards_deg, shift_mm })
        .to_vec()
    }

    fn cameras() -> impl Iterator<Item = (Mount, Camera)> {
        let pinhole =
            CameraModel::Pinhole { pixels: [640, 480], focal_px: 900.0, distance_mm: 150.0 };
        let models = [pinhole, CameraModel::Orthographic { pixels: [640, 480] }];
        mounts()
            .into_iter()
            .flat_map(move |mount| models.map(|model| (mount, Camera::new(&model, &mount, 80.0))))
    }

    #[test]
    fn sines_and_cosines_are_as_symmetric_as_the_circle() {
        for angle in (-1440..=1440).map(|k| 0.25 * f64::from(k)) {
            let [s, c] = sine_and_cosine(angle);
            let exact = radians(angle);
            assert!((s - sin(exact)).abs() < 2e-15 && (c - cos(exact)).abs() < 2e-15, "{angle}");
            assert_eq!(sine_and_cosine(-angle), [-s, c], "{angle}");
            assert_eq!(sine_and_cosine(180.0 - angle), [s, -c], "{angle}");
            assert_eq!(sine_and_cosine(360.0 + angle), [s, c], "{angle}");
            let is_positive_zero = |x: f64| x != 0.0 || x.is_sign_positive();
            assert!(is_positive_zero(s) && is_positive_zero(c), "{angle}");
        }
    }

    #[test]
    fn image_points_and_chart_coordinates_undo_each_other() {
        for (mount, camera) in cameras() {
            for image in [DVec2::ZERO, DVec2::new(21.0, -13.0), DVec2::new(-30.0, 22.0)] {
                let q = camera.picture.chart_point(image);
                let off = (camera.picture.image_point(q) - image).length();
                assert!(off < 1e-13, "{mount:?} {off:e}");
            }
        }
    }

    /// Rays from the camera's own frame: the axis carried to the side that the fold leads away from.
    #[test]
    fn rays_are_those_of_a_camera_turned_about_the_foot_of_its_axis() {
        for (mount, camera) in cameras() {
            let ([s, c], t) = (mount.tilt(), mount.towards());
            let turned = |v: DVec3| {
                let along = v.truncate().dot(t);
                let rest = v.truncate() - t * along;
                (rest + t * (along * c - v.z * s)).extend(along * s + v.z * c)
            };
            let foot = DVec2::from_array(mount.shift_mm).extend(0.0);
            for image in [DVec2::ZERO, DVec2::new(21.0, -13.0), DVec2::new(-30.0, 22.0)] {
                let ray = camera.ray(image, 40.0);
                let (origin, along) = match camera.chart.vergence {
                    0.0 => (turned(image.extend(0.0)) + foot, turned(DVec3::NEG_Z)),
                    _ => (turned(DVec3::Z * 150.0) + foot, turned(image.extend(-150.0))),
                };
                assert!((along.normalize() - ray.direction).length() < 1e-14, "{mount:?} {image}");
                let off = (ray.origin - origin).cross(ray.direction).length();
                assert!(off < 1e-12, "{mount:?} {image} {off:e}");
            }
        }
    }

    #[test]
    fn densities_are_ratios_of_areas() {
        for (_, camera) in cameras() {
            let (q, e) = (DVec2::new(9.0, -14.0), 1e-4);
            let [a, b] = [DVec2::X, DVec2::Y].map(|d| {
                (camera.picture.image_point(q + d * e) - camera.picture.image_point(q - d * e))
                    / (2.0 * e)
            });
            assert!((a.perp_dot(b).abs() / camera.picture.density(q) - 1.0).abs() < 1e-8);
        }
    }

    #[test]
    fn a_camera_on_the_axis_has_the_chart_and_picture_of_its_own() {
        let model =
            CameraModel::Pinhole { pixels: [640, 480], focal_px: 900.0, distance_mm: 150.0 };
        let camera = Camera::new(&model, &Mount::default(), 80.0);
        assert!(camera.picture.is_identity());
        assert_eq!(camera.chart, Chart::on_axis(1.0 / 150.0, 0.0));
    }
}
