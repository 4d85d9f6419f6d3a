//! Upper bounds of the errors of a facet over its whole area, from values at its vertices and a table of derivatives.
//!
//! *Chord.* In the chart's (q, h) a facet is flat: linear interpolation of h over a triangle in q (`deviation`). A step
//! of h moves the point on its ray by sqrt(1 + k^2 q^2) / (1 + k h)^2 as much.
//!
//! *Facet error.* Let c(q) be the image point whose wanted direction the mirror shows at q, and c_T(q) the one that the
//! facet shows on the same ray. |c_T - c| is at most what it is at the corners and what linear interpolation of both
//! leaves out. Under parallel rays and with targets at infinity c_T is one point. Where second derivatives have no
//! bound (above the pole of a target's cylinder c_T is only continuous), the ranges of c_T and c over the facet bound
//! their difference.
//!
//! *Rounding.* In single precision the facet through the exact vertices and the one through their roundings are both
//! bounded. Under parallel rays X and Y are single-precision numbers already. Otherwise rounding moves the facet along
//! the ray by at most |delta . n| / |d . n| at its corners (normal n, ray d), and its corners in the image by dq: there
//! c, taken at the exact vertex, is off by |c'| dq.
//!
//! *Another camera.* When the chart is that of parallel rays and the camera is not, mirror and facet are compared along
//! Z, and the camera sees the mirror a little beside: by the parallax rate times the chord, by which c moves |c'| times
//! as much.
//!
//! These bounds are quick, and near the truth where facets are small against the mirror; `branch_and_bound` divides a
//! facet where they are not.

use super::bound_table::{BoundTable, FacetFrame, TableResolution};
use super::content_bounds::{ContentBounds, FacetPlanes, ranges, second_derivatives};
use super::deviation::largest_deviation;
use super::error_bound::ErrorBound;
use super::flat_facet::{FacetPair, FlatFacet};
use super::imaging_problem::ImagingProblem;
use super::region::RegionBounds;
use super::tuning::TUNING;
use super::vertex::SurfaceVertex;
use crate::geom::{Chart, DVec2, DVec3, Precision, Rect, turn};
use crate::mirror::{HeightAndSlope, Mirror};
use crate::num::{Interval, exp, max_or_nan};
use crate::optics::ImagingTask;

/// Proves upper bounds of the errors of facets of one panel.
#[derive(Debug, Clone)]
pub struct ErrorBounder<'a> {
    pub(crate) problem: ImagingProblem<'a>,
    /// Whether only directions count, so that a facet has one content.
    pub(crate) direction_only: bool,
    pub(crate) precision: Precision,
    /// Part of the panel in which the facets are.
    pub(crate) part: Rect,
    pub(crate) table: BoundTable,
    pub(crate) resolution: TableResolution,
}

impl<'a> ErrorBounder<'a> {
    /// A bounder for the designed panel of `mirror`, whose vertices are written in `precision`.
    ///
    /// The camera has the chart `camera`: the mirror's own, or any where the mirror's is that of parallel rays. Its
    /// image must show `view`; without a view there are no bounds of the facet error.
    #[must_use]
    pub fn new(
        mirror: &'a Mirror,
        camera: &Chart,
        view: Option<&'a ImagingTask>,
        precision: Precision,
    ) -> Self {
        let problem = ImagingProblem { mirror, camera: *camera, view };
        let resolution = TableResolution::finest(&problem);
        Self::for_part(mirror.outline.bounds(), problem, precision, resolution)
    }

    /// A bounder for facets inside `part` of the panel.
    pub(crate) fn for_part(
        part: Rect,
        problem: ImagingProblem<'a>,
        precision: Precision,
        resolution: TableResolution,
    ) -> Self {
        let table = BoundTable::new(&problem, part, resolution);
        let direction_only = problem.is_direction_only();
        Self { problem, direction_only, precision, part, table, resolution }
    }

    /// The mirror.
    #[must_use]
    pub fn mirror(&self) -> &'a Mirror {
        self.problem.mirror
    }

    /// The mirror's chart.
    fn chart(&self) -> &'a Chart {
        &self.problem.mirror.chart
    }

    /// The vertex at `q` of the mirror's chart.
    #[inline]
    #[must_use]
    pub fn vertex_at(&self, q: DVec2) -> SurfaceVertex {
        self.vertex(q, self.problem.mirror.surface.at(q))
    }

    /// The vertex at `q` of the mirror's chart, where the surface is `point`.
    #[inline]
    pub(crate) fn vertex(&self, q: DVec2, point: HeightAndSlope) -> SurfaceVertex {
        let ImagingProblem { mirror, camera, view } = &self.problem;
        let chart = &mirror.chart;
        let at = mirror.position(q, &point);
        let (h, gradient) = if chart.vergence == 0.0 {
            (point.f, point.slope)
        } else {
            (chart.projective_height(point.f), point.slope * exp(chart.vergence * point.f))
        };
        let image = match view {
            Some(view) if camera == chart => view.picture.image_point(q),
            Some(view) => view.image_at(camera, at),
            None => q,
        };
        let content =
            view.map_or(DVec2::ZERO, |view| self.content(view, at, mirror.slope(q, &point), image));
        let vertex = SurfaceVertex { q, at, h, rounding: 0.0, gradient, image, content };
        match self.precision {
            Precision::Single => vertex.with_rounding(chart),
            Precision::Double => vertex,
        }
    }

    /// Bounds over the facet `t`, counter-clockwise seen from above; infinite for a triangle that is not.
    #[must_use]
    pub fn bound(&self, t: [&SurfaceVertex; 3]) -> ErrorBound {
        self.enclose(t).0
    }

    /// Bounds over the facet `t`, and the chord and facet errors (mm) that it attains somewhere.
    #[inline]
    pub(crate) fn enclose(&self, t: [&SurfaceVertex; 3]) -> (ErrorBound, [f64; 2]) {
        let corners = t.map(|v| v.q);
        if !(turn(corners[0], corners[1], corners[2]) > 0.0) {
            return (ErrorBound::INFINITE, [0.0; 2]);
        }
        let frame = self.table.frame(corners);
        let triangle = &frame.triangle;
        let region = self.table.region(&self.problem, &frame, triangle.diameter, 0.0);
        let [quadratic, rest] = height_deviation(t, &frame, &region);
        let chord = (quadratic + rest) * region.ray_per_h;
        let attained = (quadratic - rest) * self.least_ray_per_h(t, quadratic + rest);

        let facets = FacetPair::new(t, self.precision);
        let moved = facets.chord_by_rounding(t, (triangle, &region), self.chart());
        let chord_mm = chord + moved;
        let Some(view) = self.problem.view else {
            return (ErrorBound { chord_mm, ..ErrorBound::default() }, [attained, 0.0]);
        };
        let (largest, rounding_mm, facet_mm) = if self.direction_only {
            let [largest, rounding_mm] = self.one_content(view, t, &facets);
            let facet_mm = largest + triangle.interpolation_error(region.content_second);
            (largest, rounding_mm, facet_mm)
        } else {
            let [largest, rounding_mm] = self.contents_at_corners(view, t, &facets);
            let known = CornerErrors { largest, chord_mm, deviation_mm: quadratic + rest };
            (largest, rounding_mm, self.facet_error(t, &frame, &facets, &region, known))
        };
        (ErrorBound { chord_mm, facet_mm, rounding_mm }, [attained, largest])
    }

    /// The largest facet error at the corners, and the displacement by rounding, mm, where a facet has one content.
    #[inline]
    fn one_content(
        &self,
        view: &ImagingTask,
        t: [&SurfaceVertex; 3],
        facets: &FacetPair,
    ) -> [f64; 2] {
        let apart = |a: DVec2, b: DVec2| view.projection.image_distance(a, b);
        let off = |shown: DVec2| t.iter().map(|v| apart(shown, v.content)).fold(0.0, max_or_nan);
        let exact = self.facet_content(view, &facets.exact, t, 0);
        let largest = off(exact);
        let Some(rounded) = &facets.rounded else { return [largest, 0.0] };
        let shown = self.facet_content(view, rounded, t, 0);
        [max_or_nan(largest, off(shown)), apart(shown, exact)]
    }

    /// The largest facet error at the corners, and the displacement by rounding, mm.
    #[inline]
    fn contents_at_corners(
        &self,
        view: &ImagingTask,
        t: [&SurfaceVertex; 3],
        facets: &FacetPair,
    ) -> [f64; 2] {
        let shown = |facet: &FlatFacet| [0, 1, 2].map(|i| self.facet_content(view, facet, t, i));
        let farthest = |a: [DVec2; 3], b: [DVec2; 3]| {
            let apart = |(a, b): (DVec2, DVec2)| view.projection.image_distance(a, b);
            a.into_iter().zip(b).map(apart).fold(0.0, max_or_nan)
        };
        let (exact, own) = (shown(&facets.exact), t.map(|v| v.content));
        let largest = farthest(exact, own);
        let Some(rounded) = &facets.rounded else { return [largest, 0.0] };
        let shown = shown(rounded);
        [max_or_nan(largest, farthest(shown, own)), farthest(shown, exact)]
    }

    /// mm along the camera's ray per mm of h, at least, where the mirror is within `off` mm of a facet.
    #[inline]
    fn least_ray_per_h(&self, t: [&SurfaceVertex; 3], off: f64) -> f64 {
        let k = self.chart().vergence;
        if k == 0.0 {
            return 1.0;
        }
        let most = 1.0 + k * t.iter().map(|v| v.h).fold(f64::NEG_INFINITY, f64::max);
        1.0 / (most * (most + k * off))
    }

    /// Bound of a facet error (mm) that varies over the facet and is known at its corners.
    fn facet_error(
        &self,
        t: [&SurfaceVertex; 3],
        frame: &FacetFrame,
        facets: &FacetPair,
        region: &RegionBounds,
        known: CornerErrors,
    ) -> f64 {
        let CornerErrors { largest: at_corners, chord_mm: chord, deviation_mm } = known;
        let shift = facets.corner_shift(t, self.chart());
        let aside = self.parallax(region, chord) + shift;
        // The bounds must hold there, too.
        let wider = (aside > self.table.margin())
            .then(|| self.table.region(&self.problem, frame, frame.triangle.diameter, 2.0 * aside));
        let covered = self.table.margin().max(2.0 * aside);
        let region = wider.as_ref().unwrap_or(region);
        let aside = self.parallax(region, chord) + shift;
        let is_covered = deviation_mm <= self.problem.height_reach()
            && facets
                .gradients(t, self.chart())
                .iter()
                .all(|&gradient| frame.is_covered(region, gradient));
        let quick = if is_covered && aside <= covered {
            at_corners
                + frame.triangle.interpolation_error(region.content_second)
                + product_or_zero(region.content_first, aside)
        } else {
            f64::INFINITY
        };
        if quick <= TUNING.quick_ratio * at_corners {
            return quick;
        }
        let (q, h) = (t.map(|v| v.q), t.map(|v| v.h));
        let by_table = if aside <= covered {
            let rest = self.remainder_by_table(q, h, facets, (region, aside));
            let known = at_corners + rest + product_or_zero(region.content_first, aside);
            quick.min(known)
        } else {
            quick
        };
        let enough = if self.table.is_axial() { f64::MAX } else { TUNING.quick_ratio * at_corners };
        if by_table <= enough {
            return by_table;
        }
        let (contents, rest) = self.contents_over(q, h, facets, aside);
        let close = at_corners + rest + product_or_zero(contents.first(), aside);
        by_table.min(close).min(contents.difference())
    }

    /// Distance in the chart (mm) beside a facet at which a camera that is not the chart's sees the mirror.
    #[inline]
    pub(crate) fn parallax(&self, region: &RegionBounds, chord: f64) -> f64 {
        product_or_zero(region.parallax_rate, chord)
    }

    /// Bounds of the contents over the box of (a part of) one facet with heights `h` at its corners, and around it up
    /// to `aside` mm; and a bound of what linear interpolation of them leaves out, mm.
    pub(crate) fn contents_over(
        &self,
        corners: [DVec2; 3],
        h: [f64; 3],
        facets: &FacetPair,
        aside: f64,
    ) -> (ContentBounds, f64) {
        let view = self.problem.view.expect("an image to prove something of");
        let frame = self.table.frame(corners);
        let [lo, hi] = frame.triangle.bounding_box;
        let part = [lo - aside, hi + aside];
        let bounds = self.problem.narrowed(&self.table.mirror_bounds(part), part);
        let planes = (!self.direction_only).then(|| self.planes(&frame, part, h, facets));
        let contents = self.problem.content_bounds(view, part, &bounds, planes);
        (contents, frame.triangle.interpolation_error(contents.second()))
    }

    /// Bound of what linear interpolation of the contents of (a part of) one facet leaves out, mm, with the mirror's
    /// share taken from the table's region, up to `aside` mm around.
    pub(crate) fn remainder_by_table(
        &self,
        corners: [DVec2; 3],
        h: [f64; 3],
        facets: &FacetPair,
        (region, aside): (&RegionBounds, f64),
    ) -> f64 {
        let view = self.problem.view.expect("an image to prove something of");
        let frame = self.table.frame(corners);
        let [lo, hi] = frame.triangle.bounding_box;
        let part = [lo - aside, hi + aside];
        let planes = self.planes(&frame, part, h, facets);
        let chart = self.chart();
        let middle = chart.point(0.5 * (part[0] + part[1]), (h[0] + h[1] + h[2]) / 3.0);
        let near = view.image_at(&self.problem.camera, middle);
        let facet = second_derivatives(&self.problem.facet_content(view, part, planes, near));
        let both = std::array::from_fn(|k| facet[k] + region.mirror_second[k]);
        frame.triangle.interpolation_error(both)
    }

    /// The planes of a facet, of which a part has heights `h` at its corners, in the coordinates of `frame`.
    fn planes(
        &self,
        frame: &FacetFrame,
        part: [DVec2; 2],
        h: [f64; 3],
        facets: &FacetPair,
    ) -> FacetPlanes {
        let chart = self.chart();
        let most = h.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let least = h.into_iter().fold(f64::INFINITY, f64::min);
        let grow = 1.0 + chart.vergence * most;
        let rounded = facets.rounded.as_ref().unwrap_or(&facets.exact);
        let slack = 4.0 * rounded.corner_offset * grow * grow;
        let h = Interval::new(least - slack, most + slack);
        let [exact, rounded] = [&facets.exact, rounded]
            .map(|facet| frame.turn.rotate(facet.slope).to_array().map(Interval::point));
        let slope = [exact[0].hull(rounded[0]), exact[1].hull(rounded[1])];
        FacetPlanes::of_slope(chart, ranges(part), h, slope)
    }

    /// The content of `facet` at its corner `i`, mm.
    #[inline]
    fn facet_content(
        &self,
        view: &ImagingTask,
        facet: &FlatFacet,
        t: [&SurfaceVertex; 3],
        i: usize,
    ) -> DVec2 {
        self.content(view, facet.corners[i], facet.slope, t[i].image)
    }

    /// The content (mm) of a point `at` of this `slope` that the camera sees at the image point `near`.
    #[inline]
    pub(crate) fn content(
        &self,
        view: &ImagingTask,
        at: DVec3,
        slope: DVec2,
        near: DVec2,
    ) -> DVec2 {
        DVec2::from_array(if self.direction_only {
            // A shorter formula for parallel rays and far targets.
            view.projection.image_of((-slope).to_array(), near)
        } else {
            view.image_of_seen(&self.problem.camera, at.to_array(), slope.to_array(), near)
        })
    }
}

/// What is known of a facet's errors before its interior is looked at, mm.
struct CornerErrors {
    /// Largest facet error at its corners.
    largest: f64,
    /// Bound of the chord error.
    chord_mm: f64,
    /// Bound of the distance between facet and mirror in h.
    deviation_mm: f64,
}

/// Bounds of the two parts of the distance between a facet and the mirror in h, mm: what the gradients at its corners tell, and the rest.
#[inline]
pub(crate) fn height_deviation(
    t: [&SurfaceVertex; 3],
    frame: &FacetFrame,
    region: &RegionBounds,
) -> [f64; 2] {
    let gradients = t.map(|v| frame.turn.rotate(v.gradient));
    let [ab, bc, ca] = frame.triangle.edge_curvatures(gradients);
    [largest_deviation(ab, bc, ca), frame.triangle.cubic_remainder(region.h_third)]
}

/// The product, with 0 times infinity equal to 0: a rate without a bound does not matter over no distance.
#[inline]
fn product_or_zero(rate: f64, distance: f64) -> f64 {
    if rate == 0.0 || distance == 0.0 { 0.0 } else { rate * distance }
}
