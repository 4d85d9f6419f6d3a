//! Residuals of the three methods, point by point (paper, sections 3.1 to 3.3).

use super::residual_sample::PointwiseResidual;
use crate::geom::{Chart, DVec2};
use crate::num::Scalar;
use crate::optics::{ImagingTask, stereographic};
use glam::DMat2;

/// The mirror's chart slope less the slope field (paper, equation for A in section 4), along the picture's axes.
pub(super) struct GradientResidual<'a> {
    /// The camera.
    pub chart: &'a Chart,
    /// The imaging task.
    pub view: &'a ImagingTask,
}

impl PointwiseResidual<2> for GradientResidual<'_> {
    fn at<S: Scalar>(&self, at: DVec2, f: S, slope: [S; 2]) -> [S; 2] {
        let q = at.to_array().map(S::constant);
        let s = self.view.field(self.chart, q, f);
        let [x, y] = [slope[0] - s[0], slope[1] - s[1]];
        if self.view.picture.is_identity() {
            return [x, y];
        }
        // A gradient along the picture's axes, whatever the plane that the part is made on.
        let DMat2 { x_axis: a, y_axis: b } = self.view.picture.jacobian(at).inverse();
        [x * a.x + y * a.y, x * b.x + y * b.y]
    }
}

/// The ray error as a vector: the chord between the directions seen and wanted is the distance of
/// their stereographic coordinates, measured on the sphere. Under a vertical ray to a far target
/// the coordinates are the slopes (docs/theory.md, T7): this is the vector field's residual,
/// weighted by what a slope error does to the ray (T8, T27).
pub(super) struct RayResidual<'a> {
    /// The camera.
    pub chart: &'a Chart,
    /// The imaging task.
    pub view: &'a ImagingTask,
}

impl PointwiseResidual<2> for RayResidual<'_> {
    fn at<S: Scalar>(&self, q: DVec2, f: S, slope: [S; 2]) -> [S; 2] {
        let q = q.to_array().map(S::constant);
        let camera = stereographic::towards_camera(self.chart.tangent(q));
        let seen = stereographic::reflect(camera, self.chart.slope(q, slope));
        let wanted = self.view.direction_at(q, self.chart.position(q, f));
        let sizes =
            (stereographic::norm_squared(seen) + 1.0) * (stereographic::norm_squared(wanted) + 1.0);
        let half = sizes.sqrt() * 0.5;
        [(seen[0] - wanted[0]) / half, (seen[1] - wanted[1]) / half]
    }
}

/// The image displacement of what the mirror shows, mm.
pub(super) struct ImageResidual<'a> {
    /// The camera.
    pub chart: &'a Chart,
    /// The imaging task.
    pub view: &'a ImagingTask,
}

impl PointwiseResidual<2> for ImageResidual<'_> {
    fn at<S: Scalar>(&self, q: DVec2, f: S, slope: [S; 2]) -> [S; 2] {
        let image = self.view.picture.image_point(q);
        let q = q.to_array().map(S::constant);
        let at = self.chart.position(q, f);
        let content = self.view.image_of_seen(self.chart, at, self.chart.slope(q, slope), image);
        [content[0] - image.x, content[1] - image.y]
    }
}

/// The sine of the angle between the mirror's normal and W, as a vector.
pub(super) struct NormalResidual<'a> {
    /// The camera.
    pub chart: &'a Chart,
    /// The imaging task.
    pub view: &'a ImagingTask,
}

impl PointwiseResidual<3> for NormalResidual<'_> {
    fn at<S: Scalar>(&self, q: DVec2, f: S, slope: [S; 2]) -> [S; 3] {
        let q = q.to_array().map(S::constant);
        let n = normal(self.chart, q, slope);
        let w = normal(self.chart, q, self.view.field(self.chart, q, f));
        let square = |v: [S; 3]| v[0].square() + v[1].square() + v[2].square();
        let size = (square(n) * square(w)).sqrt();
        let minor = |i: usize, j: usize| (n[i] * w[j] - n[j] * w[i]) / size;
        [minor(1, 2), minor(2, 0), minor(0, 1)]
    }
}

/// A normal in space of a surface of the given chart slope.
fn normal<S: Scalar>(chart: &Chart, q: [S; 2], slope: [S; 2]) -> [S; 3] {
    [-slope[0], -slope[1], chart.normal_scale(q, slope)]
}
