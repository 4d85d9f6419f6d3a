//! The local model of mirror and image at one place, from which errors of facets there follow.

use super::tuning::TUNING;
use crate::geom::{Chart, DVec2, Precision};
use crate::mesh::bound::deviation::largest_deviation;
use crate::mesh::bound::imaging_problem::ImagingProblem;
use crate::mesh::bound::vertex_snapping::rounding_left;
use crate::mirror::{Hessian, Mirror};
use crate::num::{Dual, exp};
use glam::DMat2;

/// Least curvature in any direction, as a share of the largest, for which cells are not longer than allowed.
const LEAST_CURVATURE: f64 = 1.0 / (TUNING.longest_cell * TUNING.longest_cell);

/// Quadratic model of the mirror, and linear model of its image, at one place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalModel {
    /// Second derivatives of h, 1/mm.
    pub hessian: Hessian,
    /// Displacement of the image (mm) per change of the gradient of h.
    pub image_per_gradient: DMat2,
    /// mm along the ray per mm of h.
    pub ray_per_h: f64,
    /// Distance by which single precision moves a vertex along its ray at worst, mm.
    pub rounding_mm: f64,
}

impl LocalModel {
    /// A mirror without curvature and image.
    pub(crate) const ZERO: Self = Self {
        hessian: Hessian { xx: 0.0, xy: 0.0, yy: 0.0 },
        image_per_gradient: DMat2::ZERO,
        ray_per_h: 0.0,
        rounding_mm: 0.0,
    };

    /// The model at `q` in a file of `precision`.
    pub(crate) fn new(problem: &ImagingProblem, q: DVec2, precision: Precision) -> Self {
        let mirror = problem.mirror;
        let chart = &mirror.chart;
        let k = chart.vergence;
        let point = mirror.surface.at(q);
        let at = mirror.position(q, &point);
        let grow = exp(k * point.f);
        let gradient = point.slope * grow;
        let Hessian { xx, xy, yy } = mirror.surface.hessian(q);
        let s = point.slope;
        let hessian = Hessian {
            xx: grow * (xx + k * s.x * s.x),
            xy: grow * (xy + k * s.x * s.y),
            yy: grow * (yy + k * s.y * s.y),
        };
        let image_per_gradient = problem.view.map_or(DMat2::ZERO, |view| {
            let fixed = |x: f64| Dual::<2> { value: x, slope: [0.0; 2] };
            let slope = [Dual::variable(gradient.x, 0), Dual::variable(gradient.y, 1)];
            let slope = chart.slope(q.to_array().map(fixed), slope.map(|s| s / grow));
            let image = view.image_at(&problem.camera, at);
            let [x, y] =
                view.image_of_seen(&problem.camera, at.to_array().map(fixed), slope, image);
            DMat2::from_cols_array_2d(&[[x.slope[0], y.slope[0]], [x.slope[1], y.slope[1]]])
        });
        Self {
            hessian: with_least_curvature(hessian),
            image_per_gradient,
            ray_per_h: ray_length(chart, q) / (grow * grow),
            rounding_mm: rounding_along_ray(mirror, q, None, precision),
        }
    }

    /// Adds `weight` times another model.
    pub(crate) fn add(&mut self, other: &Self, weight: f64) {
        self.hessian.xx += weight * other.hessian.xx;
        self.hessian.xy += weight * other.hessian.xy;
        self.hessian.yy += weight * other.hessian.yy;
        self.image_per_gradient += other.image_per_gradient * weight;
        self.ray_per_h += weight * other.ray_per_h;
        self.rounding_mm += weight * other.rounding_mm;
    }

    /// Chord error (mm) of a facet with edges `a` and `b` from one corner.
    #[inline]
    pub(crate) fn chord(&self, a: DVec2, b: DVec2) -> f64 {
        let h = &self.hessian;
        let (ha, hb) = (h.times(a), h.times(b));
        let (aa, ab, bb) = (ha.dot(a), ha.dot(b), hb.dot(b));
        largest_deviation(aa, bb, aa + bb - 2.0 * ab) * self.ray_per_h
    }

    /// Square of the facet error of such a facet, mm^2.
    #[inline]
    pub(crate) fn facet_squared(&self, a: DVec2, b: DVec2) -> f64 {
        let h = &self.hessian;
        let (ha, hb) = (h.times(a), h.times(b));
        let facet = (b.perp() * -ha.dot(a) + a.perp() * hb.dot(b)) * (0.5 / a.perp_dot(b));
        let shift =
            |gradient: DVec2| (self.image_per_gradient * (facet - gradient)).length_squared();
        shift(DVec2::ZERO).max(shift(ha)).max(shift(hb))
    }

    /// Facet error (mm) that rounding adds to such a facet at worst by tilting it.
    pub(crate) fn tilt(&self, a: DVec2, b: DVec2) -> f64 {
        let longest = a.length_squared().max(b.length_squared()).max((a - b).length_squared());
        let height = a.perp_dot(b).abs() / longest.sqrt();
        let [x, y] = [self.image_per_gradient.x_axis, self.image_per_gradient.y_axis];
        let norm = (x.length_squared() + y.length_squared()).sqrt();
        2.0 * self.rounding_mm / self.ray_per_h * norm / height
    }
}

/// The Hessian with the lesser curvature raised to a share of the larger one. Where a mirror is nearly developable, the
/// quadratic model would have facets of any length, which cubic terms break.
fn with_least_curvature(Hessian { xx, xy, yy }: Hessian) -> Hessian {
    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = DVec2::new(half, xy).length();
    let (larger, lesser) = (mean.abs() + radius, (mean.abs() - radius).abs());
    let missing = LEAST_CURVATURE * larger - lesser;
    if !(missing > 0.0 && radius > 0.0) {
        return Hessian { xx, xy, yy };
    }
    // The sign of the lesser one; its principal direction follows.
    let up = if mean.abs() >= radius { mean.signum() } else { -mean.signum() };
    let share = 0.5 * up * missing;
    let turn = share * mean.signum() / radius;
    Hessian { xx: xx + share - turn * half, xy: xy - turn * xy, yy: yy + share + turn * half }
}

/// The length of the ray over `q` for a unit along the axis.
fn ray_length(chart: &Chart, q: DVec2) -> f64 {
    (1.0 + chart.tangent_at(q).length_squared()).sqrt()
}

/// Half the distance between the single-precision numbers around `x`.
fn half_step(x: f64) -> f64 {
    let single = x.abs() as f32;
    0.5 * (f64::from(single.next_up()) - f64::from(single))
}

/// Distance (mm) by which the file's digits move a vertex over `q` along its ray at worst, when it may be snapped along
/// `direction`, or anywhere.
pub(crate) fn rounding_along_ray(
    mirror: &Mirror,
    q: DVec2,
    direction: Option<DVec2>,
    precision: Precision,
) -> f64 {
    let half = |x: f64| match precision {
        Precision::Single => half_step(x),
        Precision::Double => 0.0,
    };
    let (chart, point) = (&mirror.chart, mirror.surface.at(q));
    let p = mirror.slope(q, &point);
    let [x, y, z] = mirror.position(q, &point).to_array().map(half);
    let across = if chart.is_plan() { 0.0 } else { p.abs().dot(DVec2::new(x, y)) };
    let slope = direction.map_or_else(|| p.length(), |direction| p.dot(direction).abs());
    let left = rounding_left(2.0 * z, slope, mirror.outline.bounds().size().max_element());
    left * (z + across) * ray_length(chart, q) / chart.fall(q.to_array(), p.to_array())
}
