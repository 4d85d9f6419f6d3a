//! Proof of a facet: upper bounds of its errors over its whole area.
//!
//! *Chord.* In the chart's (q, h) a facet is flat: linear interpolation of h over a triangle in q
//! (`deviation`). A step of h moves the point on its ray by sqrt(1 + k^2 q^2) / (1 + k h)^2 as much.
//!
//! *Facet error.* Let c(q) be the image point whose wanted direction the mirror shows at q, and
//! c_T(q) the one that the facet shows on the same ray. |c_T - c| is at most what it is at the
//! corners and what linear interpolation of both leaves out. Under parallel rays and with targets at
//! infinity c_T is one point. Where second derivatives have no bound (above the pole of a target's
//! cylinder c_T is only continuous), the ranges of c_T and c over the facet bound their difference.
//!
//! *Rounding.* In single precision the facet through the exact corners and the one through their
//! roundings are both bounded. Under parallel rays X and Y are single-precision numbers already;
//! otherwise rounding moves the facet along the ray by at most |delta . n| / |d . n| at its
//! corners (normal n, ray d), and its corners in the image by dq: there c, taken at the exact
//! corner, is off by |c'| dq.
//!
//! *Another camera.* When the chart is that of parallel rays and the camera is not, mirror and
//! facet are compared along Z, and what the camera sees in the mirror is a little aside: drift
//! times chord (`RegionBounds::drift`), by which c moves |c'| times as much.
//!
//! These bounds are quick, and near the truth where facets are small against the mirror; `tight`
//! takes a facet apart where they are not.

use super::bound_table::{BoundTable, FacetFrame};
use super::deviation::{Triangle, largest_deviation};
use super::region::{ContentBounds, FacetPlanes, ImagingProblem, RegionBounds, second, sides};
use crate::geom::{Chart, DVec2, DVec3, Precision, Rect, turn};
use crate::mirror::{HeightAndSlope, Mirror};
use crate::num::{Interval, exp, max_or_nan};
use crate::optics::ImagingTask;

/// A corner of a facet with what the mirror does there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceVertex {
    /// Place in the mirror's chart, mm.
    pub q: DVec2,
    /// Position, mm.
    pub at: DVec3,
    /// h of the chart, mm.
    pub h: f64,
    /// By how much h is more on the mirror moved to the corner's rounding to single precision, mm, where
    /// the file is of that; at the corner's own ray.
    pub rounding: f64,
    /// The gradient of h over q.
    pub gradient: DVec2,
    /// The camera's image point, mm.
    pub image: DVec2,
    /// The image point (mm) whose wanted direction the mirror shows here; 0 without a view.
    pub content: DVec2,
}

impl SurfaceVertex {
    /// The mirror's slope (Z_X, Z_Y) there.
    pub(crate) fn slope(&self, chart: &Chart) -> DVec2 {
        let along = self.gradient / (1.0 + chart.vergence * self.h);
        DVec2::from_array(chart.slope(self.q.to_array(), along.to_array()))
    }

    /// The same with [`Self::rounding`], where the mirror of this chart comes to lie by it.
    fn rounded(self, chart: &Chart) -> Self {
        let (k, slope) = (chart.vergence, self.slope(chart));
        let off = self.at.as_vec3().as_dvec3() - self.at;
        let up = (off.z - slope.dot(off.truncate())) / (1.0 + k * self.q.dot(slope));
        let grow = 1.0 + k * self.h;
        Self { rounding: up * grow * grow, ..self }
    }
}

/// Upper bounds of the errors of one facet, or of all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorBound {
    /// Distance between facet and mirror along the rays of the mirror's chart, mm.
    pub chord_mm: f64,
    /// Displacement of the image against the smooth mirror, mm on the mirror.
    pub facet_mm: f64,
    /// How far rounding the corners to single precision moves the image, mm on the mirror.
    pub rounding_mm: f64,
}

impl ErrorBound {
    pub(crate) const NEVER: Self =
        Self { chord_mm: f64::INFINITY, facet_mm: f64::INFINITY, rounding_mm: f64::INFINITY };

    /// What holds for both.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            chord_mm: max_or_nan(self.chord_mm, other.chord_mm),
            facet_mm: max_or_nan(self.facet_mm, other.facet_mm),
            rounding_mm: max_or_nan(self.rounding_mm, other.rounding_mm),
        }
    }
}

/// Bounds the errors of facets of one panel.
#[derive(Debug, Clone)]
pub struct ErrorBounder<'a> {
    pub(crate) sight: ImagingProblem<'a>,
    pub(crate) plain: bool,
    pub(crate) precision: Precision,
    /// The part of the panel in which the facets are.
    pub(crate) part: Rect,
    pub(crate) ground: BoundTable,
}

impl<'a> ErrorBounder<'a> {
    /// A prover for the designed panel of `mirror`, as the camera with chart `camera` sees it;
    /// what its image must show is `view`'s. The camera's chart is the mirror's, or the mirror's
    /// is that of parallel rays. Without a view there are no bounds of the image.
    /// In `precision` the corners will be written.
    #[must_use]
    pub fn new(
        mirror: &'a Mirror,
        camera: &Chart,
        view: Option<&'a ImagingTask>,
        precision: Precision,
    ) -> Self {
        Self::over(
            mirror.outline.bounds(),
            ImagingProblem { mirror, camera: *camera, view },
            precision,
        )
    }

    /// The same for facets inside `part` of the panel.
    pub(crate) fn over(part: Rect, sight: ImagingProblem<'a>, precision: Precision) -> Self {
        let ground = BoundTable::new(&sight, part);
        Self { sight, plain: sight.is_plain(), precision, part, ground }
    }

    /// The mirror.
    #[must_use]
    pub fn mirror(&self) -> &'a Mirror {
        self.sight.mirror
    }

    /// The corner at `q` of the mirror's chart, over which the mirror's point is `point`.
    #[inline]
    #[must_use]
    pub fn vertex(&self, q: DVec2, point: HeightAndSlope) -> SurfaceVertex {
        let ImagingProblem { mirror, camera, view } = &self.sight;
        let chart = &mirror.chart;
        let at = mirror.position(q, &point);
        let (h, gradient) = if chart.vergence == 0.0 {
            (point.f, point.slope)
        } else {
            (chart.projective_height(point.f), point.slope * exp(chart.vergence * point.f))
        };
        let image = if camera == chart { q } else { camera.coordinates(at).0 };
        let content =
            view.map_or(DVec2::ZERO, |view| self.content(view, at, mirror.slope(q, &point), image));
        let vertex = SurfaceVertex { q, at, h, rounding: 0.0, gradient, image, content };
        match self.precision {
            Precision::Single => vertex.rounded(chart),
            Precision::Double => vertex,
        }
    }

    /// Bounds over the facet `t`, counter-clockwise seen from above; infinite for a facet that is
    /// not.
    #[must_use]
    pub fn bound(&self, t: [&SurfaceVertex; 3]) -> ErrorBound {
        self.estimate(t).0
    }

    /// The same, and how large the chord and the facet error surely become somewhere on it.
    #[inline]
    pub(crate) fn estimate(&self, t: [&SurfaceVertex; 3]) -> (ErrorBound, [f64; 2]) {
        let corners = t.map(|v| v.q);
        if !(turn(corners[0], corners[1], corners[2]) > 0.0) {
            return (ErrorBound::NEVER, [0.0; 2]);
        }
        let local = self.ground.local(corners);
        let triangle = &local.triangle;
        let region = self.ground.region(&self.sight, &local, triangle.diameter, 0.0);
        let [ab, bc, ca] = triangle.curves(t.map(|v| local.turn.rotate(v.gradient)));
        let quadratic = largest_deviation(ab, bc, ca);
        let rest = triangle.twist(region.third);
        let chord = (quadratic + rest) * region.stretch;
        let surely = (quadratic - rest) * self.least_stretch(t, quadratic + rest);

        let facets = FacetPair::new(t, self.precision);
        let chord_mm = chord + self.moved(t, (triangle, &region), &facets);
        let Some(view) = self.sight.view else {
            return (ErrorBound { chord_mm, ..ErrorBound::default() }, [surely, 0.0]);
        };
        let apart = |a: DVec2, b: DVec2| view.projection.image_distance(a, b);
        let (largest, rounding_mm, facet_mm) = if self.plain {
            let off =
                |shown: DVec2| t.iter().map(|v| apart(shown, v.content)).fold(0.0, max_or_nan);
            let exact = self.shown(view, &facets.exact, t, 0);
            let (mut largest, mut rounding) = (off(exact), 0.0);
            if let Some(single) = &facets.single {
                let shown = self.shown(view, single, t, 0);
                (largest, rounding) = (max_or_nan(largest, off(shown)), apart(shown, exact));
            }
            (largest, rounding, largest + triangle.bend(region.second))
        } else {
            let shown = |facet: &FlatFacet| [0, 1, 2].map(|i| self.shown(view, facet, t, i));
            let farthest = |a: [DVec2; 3], b: [DVec2; 3]| {
                a.into_iter().zip(b).map(|(a, b)| apart(a, b)).fold(0.0, max_or_nan)
            };
            let (exact, own) = (shown(&facets.exact), t.map(|v| v.content));
            let (mut largest, mut rounding) = (farthest(exact, own), 0.0);
            if let Some(single) = &facets.single {
                let shown = shown(single);
                largest = max_or_nan(largest, farthest(shown, own));
                rounding = farthest(shown, exact);
            }
            (largest, rounding, self.in_image(t, &local, &facets, &region, [largest, chord_mm]))
        };
        (ErrorBound { chord_mm, facet_mm, rounding_mm }, [surely, largest])
    }

    /// mm along the camera's ray per mm of h, at least, where the mirror is within `off` of a facet.
    #[inline]
    fn least_stretch(&self, t: [&SurfaceVertex; 3], off: f64) -> f64 {
        let k = self.sight.mirror.chart.vergence;
        if k == 0.0 {
            return 1.0;
        }
        let most = 1.0 + k * t.iter().map(|v| v.h).fold(f64::NEG_INFINITY, f64::max);
        1.0 / (most * (most + k * off))
    }

    /// Facet error where it varies over the facet, and is at most `corners` at its corners.
    fn in_image(
        &self,
        t: [&SurfaceVertex; 3],
        local: &FacetFrame,
        facets: &FacetPair,
        region: &RegionBounds,
        [corners, chord]: [f64; 2],
    ) -> f64 {
        let shift = self.shift(t, facets);
        let aside = self.aside(region, chord) + shift;
        // What is known must hold there, too.
        let wider = (aside > self.ground.margin())
            .then(|| self.ground.region(&self.sight, local, local.triangle.diameter, 2.0 * aside));
        let reached = 2.0 * aside;
        let region = wider.as_ref().unwrap_or(region);
        let aside = self.aside(region, chord) + shift;
        let known = self.gradients(t, facets).iter().all(|&g| local.is_known(region, g));
        let quick = if known && aside <= self.ground.margin().max(reached) {
            corners + local.triangle.bend(region.second) + times(region.first, aside)
        } else {
            f64::INFINITY
        };
        // Few facets need more: near poles, and where they are as large as cells.
        if quick <= 1.5 * corners {
            quick
        } else {
            let (q, h) = (t.map(|v| v.q), t.map(|v| v.h));
            if self.ground.is_fine() && aside <= self.ground.margin().max(reached) {
                let bend = self.bend_closely(q, h, facets, (region, aside));
                if bend < f64::INFINITY {
                    return quick.min(corners + bend + times(region.first, aside));
                }
            }
            let (contents, bend) = self.closely(q, h, facets, aside);
            let close = corners + bend + times(contents.first(), aside);
            quick.min(close).min(contents.apart())
        }
    }

    /// How far from a facet's place, in the chart, a camera that is not the chart's sees the mirror.
    #[inline]
    pub(crate) fn aside(&self, region: &RegionBounds, chord: f64) -> f64 {
        times(region.drift, chord)
    }

    /// Contents over the box of (a part of) one facet with heights `h` at its corners, and as far
    /// around it as `aside`; and what linear interpolation of them leaves out.
    pub(crate) fn closely(
        &self,
        corners: [DVec2; 3],
        h: [f64; 3],
        facets: &FacetPair,
        aside: f64,
    ) -> (ContentBounds, f64) {
        let view = self.sight.view.expect("an image to prove something of");
        let local = self.ground.local(corners);
        let [lo, hi] = local.triangle.reach;
        let part = [lo - aside, hi + aside];
        let bounds = self.sight.narrow(&self.ground.bounds(part), part);
        let plane = (!self.plain).then(|| self.plane(&local, part, h, facets));
        let contents = self.sight.contents(view, part, &bounds, plane);
        (contents, local.triangle.bend(contents.second()))
    }

    /// What linear interpolation of the contents of (a part of) one facet leaves out, where for the
    /// mirror what is known of the region serves, as far around as `aside`.
    pub(crate) fn bend_closely(
        &self,
        corners: [DVec2; 3],
        h: [f64; 3],
        facets: &FacetPair,
        (region, aside): (&RegionBounds, f64),
    ) -> f64 {
        let view = self.sight.view.expect("an image to prove something of");
        let local = self.ground.local(corners);
        let [lo, hi] = local.triangle.reach;
        let part = [lo - aside, hi + aside];
        let plane = self.plane(&local, part, h, facets);
        let chart = &self.sight.mirror.chart;
        let middle = chart.point(0.5 * (part[0] + part[1]), (h[0] + h[1] + h[2]) / 3.0);
        let near = self.sight.camera.coordinates(middle).0;
        let facet = second(&self.sight.facet_contents(view, part, plane, near));
        local.triangle.bend(std::array::from_fn(|k| facet[k] + region.mirror[k]))
    }

    /// The planes of a facet, of which a part has heights `h` at its corners, where it is looked at.
    fn plane(
        &self,
        local: &FacetFrame,
        part: [DVec2; 2],
        h: [f64; 3],
        facets: &FacetPair,
    ) -> FacetPlanes {
        let k = self.sight.mirror.chart.vergence;
        let most = h.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let least = h.into_iter().fold(f64::INFINITY, f64::min);
        let grow = 1.0 + k * most;
        let single = facets.single.as_ref().unwrap_or(&facets.exact);
        let slack = 4.0 * single.moved * grow * grow;
        let h = Interval::new(least - slack, most + slack);
        let [exact, single] = [&facets.exact, single]
            .map(|facet| local.turn.rotate(facet.slope).to_array().map(Interval::point));
        let slope = [exact[0].hull(single[0]), exact[1].hull(single[1])];
        FacetPlanes::of_slope(k, sides(part), h, slope)
    }

    /// What corner `i` of a facet shows.
    #[inline]
    fn shown(
        &self,
        view: &ImagingTask,
        facet: &FlatFacet,
        t: [&SurfaceVertex; 3],
        i: usize,
    ) -> DVec2 {
        self.content(view, facet.corners[i], facet.slope, t[i].image)
    }

    /// The image point whose wanted direction is seen at `near` where the mirror has `slope`.
    #[inline]
    pub(crate) fn content(
        &self,
        view: &ImagingTask,
        at: DVec3,
        slope: DVec2,
        near: DVec2,
    ) -> DVec2 {
        DVec2::from_array(if self.plain {
            // The same, without what parallel rays and infinity leave out.
            view.projection.image_of((-slope).to_array(), near)
        } else {
            view.image_of_seen(&self.sight.camera, at.to_array(), slope.to_array(), near)
        })
    }

    /// How far rounding moves the facet along the rays, mm.
    #[inline]
    fn moved(
        &self,
        t: [&SurfaceVertex; 3],
        on: (&Triangle, &RegionBounds),
        facets: &FacetPair,
    ) -> f64 {
        let (triangle, region) = on;
        let FacetPair { exact, single: Some(single) } = facets else { return 0.0 };
        let k = self.sight.mirror.chart.vergence;
        let (mut off, mut lean, mut ray) = (0.0, f64::INFINITY, 1.0f64);
        for (i, v) in t.iter().enumerate() {
            let delta = single.corners[i] - exact.corners[i];
            off = max_or_nan(off, (delta.z - exact.slope.dot(delta.truncate())).abs());
            if k != 0.0 {
                lean = lean.min(1.0 + k * v.q.dot(exact.slope));
                ray = ray.max(1.0 + k * k * v.q.length_squared());
            }
        }
        if k == 0.0 {
            off
        } else if lean > 0.0 {
            // It then reaches a little beyond the exact facet, too.
            let flat = gradient(t);
            let steep = t.iter().map(|v| (v.gradient - flat).length()).fold(0.0, max_or_nan);
            let bend = size_of(region.third) * triangle.diameter * triangle.diameter / 6.0;
            off * ray.sqrt() / lean + self.shift(t, facets) * (steep + bend) * region.stretch
        } else {
            f64::INFINITY
        }
    }

    /// h of the facet's plane on the ray of `q`, near its corner `i`.
    pub(crate) fn height(&self, facet: &FlatFacet, i: usize, q: DVec2) -> f64 {
        let chart = &self.sight.mirror.chart;
        let (at, p) = (facet.corners[i].truncate(), facet.slope);
        let up = facet.corners[i].z - chart.plane_mm;
        (up + p.dot(q - at)) / (1.0 - chart.vergence * (up - p.dot(at)))
    }

    /// The gradients of h of the exact facet and of the rounded one.
    #[inline]
    pub(crate) fn gradients(&self, t: [&SurfaceVertex; 3], facets: &FacetPair) -> [DVec2; 2] {
        let q = t.map(|v| v.q);
        let rounded = facets
            .single
            .as_ref()
            .map_or(t.map(|v| v.h), |single| std::array::from_fn(|i| self.height(single, i, q[i])));
        [gradient_of(q, t.map(|v| v.h)), gradient_of(q, rounded)]
    }

    /// How far rounding moves a corner in the chart: q = (1 + k h) (X, Y) has the differential
    /// (1 + k h) (d(X, Y) + k q dZ).
    #[inline]
    pub(crate) fn shift(&self, t: [&SurfaceVertex; 3], facets: &FacetPair) -> f64 {
        let Some(single) = &facets.single else { return 0.0 };
        let k = self.sight.mirror.chart.vergence;
        let shift = |(v, corner): (&&SurfaceVertex, &DVec3)| {
            let delta = *corner - v.at;
            (1.0 + k * v.h) * (delta.truncate() + v.q * (k * delta.z)).length()
        };
        t.iter().zip(&single.corners).map(shift).fold(0.0, max_or_nan)
    }

    /// Whether the facet, of which nothing can be said, lies where the mirror may look at a place
    /// that the image does not have.
    #[must_use]
    pub fn sees_the_pole(&self, t: &[SurfaceVertex; 3]) -> bool {
        let local = self.ground.local(t.each_ref().map(|v| v.q));
        self.ground.region(&self.sight, &local, local.triangle.diameter, 0.0).pole
            && !self.is_bounded(t.each_ref())
    }
}

/// A flat facet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlatFacet {
    pub corners: [DVec3; 3],
    /// (Z_X, Z_Y).
    pub slope: DVec2,
    /// How far its corners are from the mirror's, at most, mm.
    pub moved: f64,
}

impl FlatFacet {
    #[inline]
    fn new(corners: [DVec3; 3], moved: f64) -> Self {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Self { corners, slope: -normal.truncate() / normal.z, moved }
    }
}

/// The facet through the exact corners, and where the file is single precision the one through
/// their roundings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetPair {
    pub exact: FlatFacet,
    pub single: Option<FlatFacet>,
}

impl FacetPair {
    #[inline]
    pub fn new(t: [&SurfaceVertex; 3], precision: Precision) -> Self {
        let corners = t.map(|v| v.at);
        let single = (precision == Precision::Single).then(|| {
            let rounded = corners.map(|p| p.as_vec3().as_dvec3());
            let moved = (0..3).map(|i| (rounded[i] - corners[i]).length()).fold(0.0, max_or_nan);
            FlatFacet::new(rounded, moved)
        });
        Self { exact: FlatFacet::new(corners, 0.0), single }
    }
}

/// The gradient of the facet's h.
#[inline]
fn gradient(t: [&SurfaceVertex; 3]) -> DVec2 {
    gradient_of(t.map(|v| v.q), t.map(|v| v.h))
}

/// The gradient of what is linear and `h` at the corners `q`.
#[inline]
pub(crate) fn gradient_of(q: [DVec2; 3], h: [f64; 3]) -> DVec2 {
    let [ab, ac] = [q[1] - q[0], q[2] - q[0]];
    (ab.perp() * (h[2] - h[0]) - ac.perp() * (h[1] - h[0])) / ab.perp_dot(ac)
}

/// A bound of a third derivative along any ways of unit length.
pub(crate) fn size_of(third: [Interval; 4]) -> f64 {
    let [xxx, xxy, xyy, yyy] = third.map(Interval::magnitude);
    (xxx * xxx + 3.0 * (xxy * xxy + xyy * xyy) + yyy * yyy).sqrt()
}

/// The product, where nothing of what has no bound is nothing.
#[inline]
fn times(rate: f64, way: f64) -> f64 {
    if rate == 0.0 || way == 0.0 { 0.0 } else { rate * way }
}
