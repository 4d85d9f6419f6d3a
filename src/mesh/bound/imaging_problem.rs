//! The imaging problem, and bounds of derivatives over boxes of its chart by interval arithmetic.
//!
//! The mirror's bounds over a box become jets over intervals in the variables (x, y). The very formulas that the optics
//! evaluate, run on those jets, give bounds of the content's first and second derivatives. Intervals lose a factor of a
//! few, but only in terms of second order.

use super::content_bounds::{
    ContentBounds, FacetPlanes, IntervalJet, norm, ranges, second_derivatives,
};
use super::region::RegionBounds;
use super::tuning::TUNING;
use crate::geom::{Chart, DVec2, DerivativeBounds, Outline};
use crate::mirror::{Mirror, UnionBound};
use crate::num::{Arithmetic, Interval, Scalar, exp};
use crate::optics::{ImagingTask, Target};

/// Share of the mirror's size that no rounding to single precision moves a vertex by: its step is 6e-8.
const ROUNDING: f64 = 1e-6;
/// Relative error of an evaluation of the mirror, with a wide margin.
const EVALUATION_ERROR: f64 = 1e-11;

/// A mirror, the camera that looks at it, and what its image must show.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ImagingProblem<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// The camera's chart: the mirror's own, or any where the mirror's is that of parallel rays.
    pub camera: Chart,
    /// The imaging task; without one there is no facet error.
    pub view: Option<&'a ImagingTask>,
}

/// Ranges of h (mm) and of its gradient on facets.
#[derive(Debug, Clone, Copy)]
struct FacetRanges {
    h: Interval,
    gradient: [Interval; 2],
}

impl ImagingProblem<'_> {
    /// Whether only directions count, so that all places of a facet show the same: parallel rays in, far targets out.
    pub(crate) fn is_direction_only(&self) -> bool {
        let parallel = self.camera.is_plan() && self.mirror.chart.is_plan();
        parallel && self.view.is_none_or(|view| view.target == Target::Infinity)
    }

    /// Distance in h up to which facets may lie off the mirror where the table's bounds of their contents hold, mm, without rounding.
    pub(crate) fn height_reach(&self) -> f64 {
        TUNING.height_reach * self.mirror.outline.bounds().size().max_element()
    }

    /// What rounding moves heights of facets by, at most, mm.
    fn rounding_mm(&self) -> f64 {
        ROUNDING * self.mirror.outline.bounds().size().max_element()
    }

    /// Bounds over the box `lo`..`hi`, where `bounds` hold for the mirror, and for facets that touch it and lie where
    /// `around` holds, or inside the box without that.
    pub(crate) fn region_bounds(
        &self,
        [lo, hi]: [DVec2; 2],
        bounds: &DerivativeBounds,
        around: Option<&DerivativeBounds>,
    ) -> RegionBounds {
        let chart = &self.mirror.chart;
        let k = chart.vergence;
        let steepest = k * lo.abs().max(hi.abs()).length() + chart.lean.length();
        let low = exp(k * bounds.f.lo);
        let mut region = RegionBounds {
            h_third: third_derivatives_of_h(bounds, k),
            ray_per_h: (1.0 + steepest * steepest).sqrt() / (low * low),
            ..RegionBounds::EMPTY
        };
        if let Some(view) = self.view {
            region.parallax_rate = self.parallax_rate([lo, hi], bounds);
            // A box beside which facets reach cannot be divided without them.
            let (divisions, beyond) = match around {
                Some(_) => (0, TUNING.gradient_margin),
                None => (TUNING.box_divisions, TUNING.gradient_reach),
            };
            let facets = self.facet_ranges(around.unwrap_or(bounds), beyond);
            if let Some(FacetRanges { gradient: [x, y], .. }) = facets {
                region.gradient_box = [DVec2::new(x.lo, y.lo), DVec2::new(x.hi, y.hi)];
            }
            self.add_content_bounds(view, [lo, hi], (bounds, facets), divisions, &mut region);
        }
        region
    }

    /// Adds the bounds of the content to `region`; where these are loose or infinite, from parts of the box.
    fn add_content_bounds(
        &self,
        view: &ImagingTask,
        [lo, hi]: [DVec2; 2],
        (bounds, facets): (&DerivativeBounds, Option<FacetRanges>),
        divisions: usize,
        region: &mut RegionBounds,
    ) {
        let planes = facets.map(|FacetRanges { h, gradient }| {
            FacetPlanes::of_gradient(&self.mirror.chart, ranges([lo, hi]), h, gradient)
        });
        let contents = self.content_bounds(view, [lo, hi], bounds, planes);
        let (second, mirror) = (contents.second(), second_derivatives(&contents.mirror));
        let [xx, xy, yy] = second;
        let steepest = norm([xx, xy, xy, yy].into_iter());
        let across = self.mirror.outline.bounds().size().max_element();
        // With facet planes, boxes are many, and facets in loose ones are looked at one by one.
        let is_loose = !contents.is_bounded()
            || (planes.is_none() && !(steepest * across < TUNING.loose_second_derivative));
        if divisions > 0 && is_loose {
            let parts = TUNING.box_parts;
            let step = (hi - lo) / parts as f64;
            for k in 0..parts * parts {
                let lo = lo + step * DVec2::new((k % parts) as f64, (k / parts) as f64);
                let part = [lo, lo + step];
                if !is_outside(&self.mirror.outline, part) {
                    let narrowed = self.narrowed(bounds, part);
                    let both = (&narrowed, facets);
                    self.add_content_bounds(view, part, both, divisions - 1, region);
                }
            }
        } else {
            let found = RegionBounds {
                content_second: second,
                mirror_second: mirror,
                content_first: contents.first(),
                may_be_on_axis: !contents.is_bounded(),
                ..RegionBounds::EMPTY
            };
            *region = region.union(found);
        }
    }

    /// The ranges of facets that may touch a box where `bounds` hold, their gradients so far beyond the mirror's; none where only directions
    /// count.
    fn facet_ranges(&self, bounds: &DerivativeBounds, beyond: f64) -> Option<FacetRanges> {
        if self.is_direction_only() {
            return None;
        }
        let chart = &self.mirror.chart;
        let k = chart.vergence;
        let grow = Interval::new(exp(k * bounds.f.lo), exp(k * bounds.f.hi));
        let gradient = bounds.slope.map(|s| {
            let range = s * grow;
            Interval::around(range.mid(), (0.5 + beyond) * range.width())
        });
        let slack = self.height_reach() + self.rounding_mm();
        let h = Interval::new(
            chart.projective_height(bounds.f.lo) - slack,
            chart.projective_height(bounds.f.hi) + slack,
        );
        Some(FacetRanges { h, gradient })
    }

    /// Bounds of the mirror's derivatives over a part of a region where `bounds` hold, by Taylor's theorem about its
    /// middle.
    pub(crate) fn narrowed(
        &self,
        bounds: &DerivativeBounds,
        [lo, hi]: [DVec2; 2],
    ) -> DerivativeBounds {
        let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        if !self.expands_about_middle([lo, hi]) {
            return self.mirror.surface.box_bounds(lo, hi).unwrap_or(*bounds);
        }
        let point = self.mirror.surface.at(middle);
        let c = self.mirror.surface.hessian(middle);
        let [x, y] = [half.x, half.y].map(|half| Interval::around(0.0, half));
        let near = |at: f64, x_rate: Interval, y_rate: Interval, known: Interval| {
            let slack = EVALUATION_ERROR * (known.magnitude() + known.width());
            let here = Interval::around(at, slack) + x_rate * x + y_rate * y;
            let (lo, hi) = (here.lo.max(known.lo), here.hi.min(known.hi));
            if lo <= hi { Interval::new(lo, hi) } else { known }
        };
        let [xxx, xxy, xyy, yyy] = bounds.third;
        let [known_xx, known_xy, known_yy] = bounds.hessian;
        let xx = near(c.xx, xxx, xxy, known_xx);
        let xy = near(c.xy, xxy, xyy, known_xy);
        let yy = near(c.yy, xyy, yyy, known_yy);
        let [known_x, known_y] = bounds.slope;
        let slope = [near(point.slope.x, xx, xy, known_x), near(point.slope.y, xy, yy, known_y)];
        let f = near(point.f, slope[0], slope[1], bounds.f);
        DerivativeBounds { f, slope, hessian: [xx, xy, yy], third: bounds.third }
    }

    /// Whether the segments from a box's middle to its points on the mirror stay between the radii of a round surface,
    /// where its bounds hold.
    fn expands_about_middle(&self, [lo, hi]: [DVec2; 2]) -> bool {
        let Some([inner, outer]) = self.mirror.surface.radii() else { return true };
        let nearest = DVec2::ZERO.clamp(lo, hi).length();
        let middle = (0.5 * (lo + hi)).length();
        middle <= outer && nearest >= inner * (1.0 - Outline::EDGE)
    }

    /// Bounds of the content over a box where `bounds` hold; without planes the content of facets does not vary.
    pub(crate) fn content_bounds(
        &self,
        view: &ImagingTask,
        [lo, hi]: [DVec2; 2],
        bounds: &DerivativeBounds,
        planes: Option<FacetPlanes>,
    ) -> ContentBounds {
        let chart = &self.mirror.chart;
        let middle = chart.point(0.5 * (lo + hi), bounds.f.mid());
        let near = view.image_at(&self.camera, middle);
        let [x, y] = ranges([lo, hi]);
        let q = [IntervalJet::variable_x(x), IntervalJet::variable_y(y)];
        let f = IntervalJet::from_parts(bounds.f, bounds.slope, bounds.hessian);
        let ([xx, xy, yy], [xxx, xxy, xyy, yyy]) = (bounds.hessian, bounds.third);
        let slope = [
            IntervalJet::from_parts(bounds.slope[0], [xx, xy], [xxx, xxy, xyy]),
            IntervalJet::from_parts(bounds.slope[1], [xy, yy], [xxy, xyy, yyy]),
        ];
        let (at, p) = (|| chart.position(q, f), chart.slope(q, slope));
        let mirror = view.image_of_seen_along(self.ray_tangent(q, at), at, p, near);
        let facet = planes.map_or([IntervalJet::constant(0.0); 2], |planes| {
            self.facet_content(view, [lo, hi], planes, near)
        });
        ContentBounds { mirror, facet }
    }

    /// Bounds of the content c_T of facets with the given planes over a box.
    pub(crate) fn facet_content(
        &self,
        view: &ImagingTask,
        part: [DVec2; 2],
        planes: FacetPlanes,
        near: DVec2,
    ) -> [IntervalJet; 2] {
        let chart = &self.mirror.chart;
        let [x, y] = ranges(part);
        let q = [IntervalJet::variable_x(x), IntervalJet::variable_y(y)];
        let h = IntervalJet::from_parts(planes.h, planes.gradient, [Interval::point(0.0); 3]);
        let at = || chart.position_at_h(q, h);
        let slope = planes.slope.map(IntervalJet::flat);
        view.image_of_seen_along(self.ray_tangent(q, at), at, slope, near)
    }

    /// The tangent of the camera's ray to the point `at` over `q`. In the camera's own chart it follows from q alone,
    /// in closer bounds than from the point.
    fn ray_tangent(
        &self,
        q: [IntervalJet; 2],
        at: impl FnOnce() -> [IntervalJet; 3],
    ) -> [IntervalJet; 2] {
        if self.camera == self.mirror.chart {
            self.camera.tangent(q)
        } else {
            self.camera.view(at())
        }
    }

    /// [`RegionBounds::parallax_rate`]: |v| / (1 + p . v), with v the tangent of the ray's angle to the axis and p the
    /// mirror's slope. The chart is then that of parallel rays.
    fn parallax_rate(&self, part: [DVec2; 2], bounds: &DerivativeBounds) -> f64 {
        if self.camera == self.mirror.chart {
            return 0.0;
        }
        let view = self.camera.view(self.mirror.chart.position(ranges(part), bounds.f));
        let lean = view[0] * bounds.slope[0] + view[1] * bounds.slope[1] + 1.0;
        let tangent = norm(view.into_iter().map(Interval::magnitude));
        if lean.lo > 0.0 { tangent / lean.lo } else { f64::INFINITY }
    }
}

/// Whether a box has nothing of the outline, nor of what the chords of a rim cut off.
pub(crate) fn is_outside(outline: &Outline, [lo, hi]: [DVec2; 2]) -> bool {
    let Outline::Ring { inner, outer } = *outline else { return false };
    let nearest = DVec2::ZERO.clamp(lo, hi).length();
    let farthest = lo.abs().max(hi.abs()).length();
    nearest > outer * (1.0 + ROUNDING) || farthest < inner * (1.0 - 2.0 * Outline::EDGE)
}

/// The third derivatives of h = (exp(k f) - 1) / k:
/// exp(k f) (f_ijk + k (f_ij f_k + f_ik f_j + f_jk f_i) + k^2 f_i f_j f_k).
fn third_derivatives_of_h(bounds: &DerivativeBounds, k: f64) -> [Interval; 4] {
    if k == 0.0 {
        return bounds.third;
    }
    let ([x, y], [xx, xy, yy], [xxx, xxy, xyy, yyy]) = (bounds.slope, bounds.hessian, bounds.third);
    let grow = Interval::new(exp(k * bounds.f.lo), exp(k * bounds.f.hi));
    let part = |of: Interval, pairs: [(Interval, Interval); 3], cube: Interval| {
        let sum = pairs[0].0 * pairs[0].1 + pairs[1].0 * pairs[1].1 + pairs[2].0 * pairs[2].1;
        (of + sum * k + cube * (k * k)) * grow
    };
    [
        part(xxx, [(xx, x); 3], x.square() * x),
        part(xxy, [(xx, y), (xy, x), (xy, x)], x.square() * y),
        part(xyy, [(yy, x), (xy, y), (xy, y)], y.square() * x),
        part(yyy, [(yy, y); 3], y.square() * y),
    ]
}
