//! Points and parts of one facet, and the bounds of its errors over a part.

use super::bound_table::FacetFrame;
use super::deviation::largest_quadratic;
use super::error_bound::ErrorKind;
use super::error_bounder::{ErrorBounder, height_deviation};
use super::flat_facet::{FacetPair, gradient_of, third_derivative_norm};
use super::imaging_problem::ImagingProblem;
use super::tuning::TUNING;
use super::vertex::SurfaceVertex;
use crate::geom::{DVec2, DVec3};
use crate::num::{exp, max_or_nan};
use crate::optics::ImagingTask;

/// A point of a facet with the errors there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetPoint {
    /// Barycentric coordinates.
    weights: [f64; 3],
    /// Coordinates in the chart, mm.
    q: DVec2,
    /// h of the mirror, mm.
    h: f64,
    /// Gradient of h.
    gradient: DVec2,
    /// h of the mirror over that of the exact facet and over that of the rounded one, mm.
    over: [f64; 2],
    /// Facet error as the camera sees it, mm; a camera that is not the chart's sees another point of the mirror.
    seen: f64,
    /// Facet error against the mirror at the very point, mm.
    shown: f64,
}

/// One facet whose parts are bounded for one kind of error, with all that the parts have in common.
pub(crate) struct FacetParts<'a> {
    bounder: &'a ErrorBounder<'a>,
    kind: ErrorKind,
    view: Option<&'a ImagingTask>,
    corners: [DVec2; 3],
    diameter: f64,
    facets: FacetPair,
    /// h of the planes of the exact and the rounded facet on the rays of the exact corners, mm.
    h: [[f64; 3]; 2],
    /// The gradients of these.
    gradients: [DVec2; 2],
    /// Distance by which rounding moves the corners in the chart, mm.
    shift: f64,
    /// Whether the facet is as near to the mirror as the table's bounds of its contents ask for.
    is_near: bool,
}

impl<'a> FacetParts<'a> {
    /// The facet of the vertices `t`, whose errors of the given kind are asked for.
    pub(crate) fn new(
        bounder: &'a ErrorBounder<'a>,
        t: [&SurfaceVertex; 3],
        kind: ErrorKind,
    ) -> Self {
        let facets = FacetPair::new(t, bounder.precision);
        let chart = &bounder.problem.mirror.chart;
        let h = facets.heights(t, chart);
        let frame = bounder.table.frame(t.map(|v| v.q));
        let diameter = frame.triangle.diameter;
        let region = bounder.table.region(&bounder.problem, &frame, diameter, 0.0);
        let [quadratic, rest] = height_deviation(t, &frame, &region);
        Self {
            bounder,
            kind,
            view: bounder.problem.view.filter(|_| kind == ErrorKind::Facet),
            corners: t.map(|v| v.q),
            diameter,
            h,
            gradients: h.map(|h| gradient_of(t.map(|v| v.q), h)),
            shift: facets.corner_shift(t, chart),
            is_near: quadratic + rest <= bounder.problem.height_reach(),
            facets,
        }
    }

    fn vergence(&self) -> f64 {
        self.bounder.problem.mirror.chart.vergence
    }

    /// The corner of the facet at vertex `v`.
    pub(crate) fn corner(&self, weights: [f64; 3], v: &SurfaceVertex) -> FacetPoint {
        self.point(weights, v.q, [v.h, v.gradient.x, v.gradient.y], v.content)
    }

    /// The midpoint of two points.
    pub(crate) fn midpoint(&self, a: &FacetPoint, b: &FacetPoint) -> FacetPoint {
        let weights = std::array::from_fn(|i| 0.5 * (a.weights[i] + b.weights[i]));
        self.at(weights)
    }

    /// The point with the given barycentric coordinates.
    fn at(&self, weights: [f64; 3]) -> FacetPoint {
        let [a, b, c] = self.corners;
        let q = a * weights[0] + b * weights[1] + c * weights[2];
        let mirror = self.bounder.problem.mirror;
        let point = mirror.surface.at(q);
        if self.view.is_some() {
            let v = self.bounder.vertex(q, point);
            return self.point(weights, q, [v.h, v.gradient.x, v.gradient.y], v.content);
        }
        let (chart, k) = (&mirror.chart, self.vergence());
        let slope = if k == 0.0 { point.slope } else { point.slope * exp(k * point.f) };
        self.point(weights, q, [chart.projective_height(point.f), slope.x, slope.y], DVec2::ZERO)
    }

    /// The point at `q`, where the mirror has height and gradient `[h, x, y]` and this content.
    fn point(
        &self,
        weights: [f64; 3],
        q: DVec2,
        [h, x, y]: [f64; 3],
        content: DVec2,
    ) -> FacetPoint {
        let flat = self.h.map(|of| of[0] * weights[0] + of[1] * weights[1] + of[2] * weights[2]);
        let (mut shown, mut seen) = (0.0, 0.0f64);
        if let Some(view) = self.view {
            let camera = &self.bounder.problem.camera;
            let is_same = *camera == self.bounder.problem.mirror.chart;
            let facets = [Some(&self.facets.exact), self.facets.rounded.as_ref()];
            for (facet, h) in facets.into_iter().zip(flat) {
                let Some(facet) = facet else { continue };
                let at = self.position(q, h);
                let on_chart = if is_same { q } else { camera.coordinates(at).0 };
                let near = view.picture.image_point(on_chart);
                let found = self.bounder.content(view, at, facet.slope, near);
                shown = max_or_nan(shown, view.projection.image_distance(found, content));
                if !is_same && let Some(mirror) = self.content_seen(view, on_chart, near) {
                    seen = seen.max(view.projection.image_distance(found, mirror));
                }
            }
            if is_same {
                seen = shown;
            }
        }
        let over = flat.map(|flat| h - flat);
        FacetPoint { weights, q, h, gradient: DVec2::new(x, y), over, seen, shown }
    }

    /// The mirror's content at the coordinates `on_chart`, image point `near`, of a camera that is not the chart's, mm.
    fn content_seen(&self, view: &ImagingTask, on_chart: DVec2, near: DVec2) -> Option<DVec2> {
        let ImagingProblem { mirror, camera, .. } = &self.bounder.problem;
        let q = mirror.intersect_camera_ray(camera, on_chart)?;
        let point = mirror.surface.at(q);
        Some(self.bounder.content(view, mirror.position(q, &point), mirror.slope(q, &point), near))
    }

    /// The point over `q` of height `h`, in the part frame.
    fn position(&self, q: DVec2, h: f64) -> DVec3 {
        DVec3::from_array(self.bounder.problem.mirror.chart.position_at_h(q.to_array(), h))
    }

    /// Bound of the error over the part with the given corners, mm; `attained` is raised to what the part attains.
    pub(crate) fn bound(&self, corners: &[FacetPoint; 3], attained: &mut f64) -> f64 {
        let frame = self.bounder.table.frame(corners.map(|c| c.q));
        match self.kind {
            ErrorKind::Chord => self.chord_bound(corners, &frame, attained),
            ErrorKind::Facet => self.facet_bound(corners, &frame, attained),
        }
    }

    /// Bound of |L - h| over a part, mm, and the barycentric coordinates in it where that may be attained; `rest` is a
    /// bound of what the gradients leave out.
    fn deviation(
        &self,
        corners: &[FacetPoint; 3],
        frame: &FacetFrame,
        rest: f64,
    ) -> (f64, [f64; 3]) {
        let gradients = corners.map(|c| frame.turn.rotate(c.gradient));
        let curvatures = frame.triangle.edge_curvatures(gradients);
        let [exact, rounded] =
            [0, 1].map(|k| largest_quadratic(corners.map(|c| c.over[k]), curvatures));
        let (found, at) = if rounded.0 > exact.0 { rounded } else { exact };
        (found + rest, at)
    }

    /// Bound of the chord error over a part, mm.
    fn chord_bound(
        &self,
        corners: &[FacetPoint; 3],
        frame: &FacetFrame,
        attained: &mut f64,
    ) -> f64 {
        let k = self.vergence();
        let triangle = &frame.triangle;
        let [lo, hi] = triangle.bounding_box;
        let (table, problem) = (&self.bounder.table, &self.bounder.problem);
        let third = table.region(problem, frame, self.diameter, 0.0).h_third;
        let (mut rise, at) = self.deviation(corners, frame, triangle.cubic_remainder(third));
        if self.shift > 0.0 {
            // The rounded facet reaches a little beyond the exact one.
            let steep = corners
                .iter()
                .flat_map(|c| self.gradients.map(|gradient| (c.gradient - gradient).length()));
            let bend = third_derivative_norm(third) * triangle.diameter * triangle.diameter / 6.0;
            rise += self.shift * (steep.fold(0.0, max_or_nan) + bend);
        }
        let mut consider = |point: &FacetPoint| {
            let farthest = point.over.map(f64::abs).into_iter().fold(0.0, f64::max);
            *attained = attained.max(farthest * self.least_ray_per_h(point));
        };
        corners.iter().for_each(&mut consider);
        let inside = |k: usize| -> f64 { (0..3).map(|i| corners[i].weights[k] * at[i]).sum() };
        consider(&self.at([inside(0), inside(1), inside(2)]));
        if k == 0.0 {
            return rise;
        }
        let chart = &problem.mirror.chart;
        let steepest = k * lo.abs().max(hi.abs()).length() + chart.lean.length();
        let lowest = |c: &FacetPoint| 1.0 + k * (c.h - c.over[0].max(c.over[1]));
        let low = corners.iter().map(lowest).fold(f64::INFINITY, f64::min);
        let lower = low - k * rise;
        let ray = (1.0 + steepest * steepest).sqrt();
        if lower > 0.0 { rise * ray / (low * lower) } else { f64::INFINITY }
    }

    /// mm along the ray per mm of h between facet and mirror at a point, at least.
    fn least_ray_per_h(&self, point: &FacetPoint) -> f64 {
        let chart = &self.bounder.problem.mirror.chart;
        if chart.is_plan() {
            return 1.0;
        }
        let k = chart.vergence;
        let flat = point.h - point.over[0].min(point.over[1]);
        (1.0 + chart.tangent_at(point.q).length_squared()).sqrt()
            / ((1.0 + k * flat) * (1.0 + k * point.h))
    }

    /// Bound of the facet error over a part, mm.
    fn facet_bound(
        &self,
        corners: &[FacetPoint; 3],
        frame: &FacetFrame,
        attained: &mut f64,
    ) -> f64 {
        let (bounder, table, triangle) = (self.bounder, &self.bounder.table, &frame.triangle);
        let region = table.region(&bounder.problem, frame, self.diameter, 0.0);
        let chord = if region.parallax_rate == 0.0 {
            0.0
        } else {
            self.deviation(corners, frame, triangle.cubic_remainder(region.h_third)).0
        };
        let aside = bounder.parallax(&region, chord) + self.shift;
        let largest = corners.iter().map(|c| c.shown).fold(0.0, max_or_nan);
        *attained = corners.iter().map(|c| c.seen).fold(*attained, f64::max);
        let rest = triangle.interpolation_error(region.content_second);
        let is_covered = self.is_near
            && self.gradients.iter().all(|&gradient| frame.is_covered(&region, gradient));
        let beside = |first: f64| if aside == 0.0 { 0.0 } else { first * aside };
        let mut known = if is_covered && aside <= table.margin() {
            largest + rest + beside(region.content_first)
        } else {
            f64::INFINITY
        };
        if rest <= TUNING.small_remainder * largest && known < f64::INFINITY {
            return known;
        }
        let h = corners.map(|c| c.h - c.over[0]);
        let q = corners.map(|c| c.q);
        let is_axial = table.is_axial();
        if (is_axial || !is_covered) && !bounder.direction_only && aside <= table.margin() {
            let rest = bounder.remainder_by_table(q, h, &self.facets, (&region, aside));
            known = known.min(largest + rest + beside(region.content_first));
            if known < f64::INFINITY && (is_axial || rest <= TUNING.small_remainder * largest) {
                return known;
            }
        }
        let (contents, rest) = bounder.contents_over(q, h, &self.facets, aside);
        let close = largest + rest + beside(contents.first());
        let bound = if bounder.direction_only { close } else { close.min(contents.difference()) };
        bound.min(known)
    }
}
