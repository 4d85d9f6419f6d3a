//! Proof of a facet: upper bounds of its errors over its whole area.
//!
//! *Chord.* In the chart's (q, h) a facet is flat: linear interpolation of h over a triangle in q.
//! With d_ij the triangle's edges and H the Hessian of h, the interpolation error of a quadratic h
//! is -1/2 sum over i < j of l_i l_j d_ij' H d_ij at barycentric coordinates l; its largest value
//! is known in closed form. Differences of h's gradient along the edges give d_ij' H d_ij for a
//! mean Hessian; the third derivative M over a facet of diameter D bounds what that leaves out by
//! M D^3 / 3. A step of h moves the point on its ray by sqrt(1 + k^2 q^2) / (1 + k h)^2 as much.
//!
//! *Facet error.* Let c(q) be the image point whose wanted direction the mirror shows at q, and
//! c_T(q) the one that the facet shows on the same ray. Linear interpolation of e = c_T - c over
//! the facet is off by at most K D^2 / 6, K bounding the second derivatives of both (Jung: the
//! facet fits a circle of radius D / sqrt 3), so |e| <= max over corners |e| + K D^2 / 6. Under
//! parallel rays and with targets at infinity c_T is one point. Where K has no bound (above the
//! pole of a target's cylinder c_T is only continuous), the ranges of c_T and c over the facet
//! bound their difference.
//!
//! *Rounding.* The facet through the exact corners and the one through their single-precision
//! roundings are both bounded. Under parallel rays X and Y are single-precision numbers already;
//! otherwise rounding moves the facet along the ray by at most |delta . n| / |d . n| at its
//! corners (normal n, ray d), and its corners in the image by dq: there c, taken at the exact
//! corner, is off by |c'| dq.
//!
//! *Another camera.* When the chart is that of parallel rays and the camera is not, mirror and
//! facet are compared along Z, and what the camera sees in the mirror is a little aside: drift
//! times chord (`Region::drift`), by which c moves |c'| times as much.

use super::region::{Contents, Plane, Region, Sight, beyond, sides};
use crate::geom::{Chart, DVec2, DVec3, Rect, turn};
use crate::mirror::{Bounds, Cells, Mirror, Point};
use crate::num::{Interval, exp};
use crate::optics::View;

/// A corner of a facet with what the mirror does there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Place in the mirror's chart, mm.
    pub q: DVec2,
    /// Position, mm.
    pub at: DVec3,
    /// h of the chart, mm.
    pub h: f64,
    /// The gradient of h over q.
    pub gradient: DVec2,
    /// The camera's image point, mm.
    pub image: DVec2,
    /// The image point (mm) whose wanted direction the mirror shows here; 0 without a view.
    pub content: DVec2,
}

/// Upper bounds of the errors of one facet, or of all.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bound {
    /// Distance between facet and mirror along the rays of the mirror's chart, mm.
    pub chord_mm: f64,
    /// Displacement of the image against the smooth mirror, mm on the mirror.
    pub facet_mm: f64,
    /// How far rounding the corners to single precision moves the image, mm on the mirror.
    pub rounding_mm: f64,
}

impl Bound {
    const NEVER: Self =
        Self { chord_mm: f64::INFINITY, facet_mm: f64::INFINITY, rounding_mm: f64::INFINITY };

    /// What holds for both.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            chord_mm: larger(self.chord_mm, other.chord_mm),
            facet_mm: larger(self.facet_mm, other.facet_mm),
            rounding_mm: larger(self.rounding_mm, other.rounding_mm),
        }
    }
}

/// Bounds the errors of facets of one panel.
#[derive(Debug, Clone)]
pub struct Prover<'a> {
    sight: Sight<'a>,
    plain: bool,
    bounds: Cells<Bounds>,
    cells: Cells<Region>,
}

impl<'a> Prover<'a> {
    /// A prover for the designed panel of `mirror`, as the camera with chart `camera` sees it;
    /// what its image must show is `view`'s. The camera's chart is the mirror's, or the mirror's
    /// is that of parallel rays. Without a view there are no bounds of the image.
    #[must_use]
    pub fn new(mirror: &'a Mirror, camera: &Chart, view: Option<&'a View>) -> Self {
        Self::over(mirror.outline.bounds(), mirror, camera, view)
    }

    /// The same for facets inside `part` of the panel.
    pub(super) fn over(
        part: Rect,
        mirror: &'a Mirror,
        camera: &Chart,
        view: Option<&'a View>,
    ) -> Self {
        let sight = Sight { mirror, camera: *camera, view };
        let bounds = Cells::new(&mirror.surface, part);
        let parts = sight.parts();
        let cells = bounds.map(parts, |part, bounds| {
            if beyond(&mirror.outline, part) {
                Region::NOTHING
            } else if parts == 1 {
                sight.region(part, bounds)
            } else {
                sight.region(part, &sight.narrow(bounds, part))
            }
        });
        Self { sight, plain: sight.is_plain(), bounds, cells }
    }

    /// The mirror.
    #[must_use]
    pub fn mirror(&self) -> &'a Mirror {
        self.sight.mirror
    }

    /// The camera's chart.
    pub(super) fn camera(&self) -> &Chart {
        &self.sight.camera
    }

    /// What the image must show.
    pub(super) fn view(&self) -> Option<&'a View> {
        self.sight.view
    }

    /// The corner at `q` of the mirror's chart, over which the mirror's point is `point`.
    #[inline]
    #[must_use]
    pub fn vertex(&self, q: DVec2, point: Point) -> Vertex {
        let Sight { mirror, camera, view } = &self.sight;
        let chart = &mirror.chart;
        let at = mirror.place(q, &point);
        let (h, gradient) = if chart.vergence == 0.0 {
            (point.f, point.slope)
        } else {
            (chart.flat(point.f), point.slope * exp(chart.vergence * point.f))
        };
        let image = if camera == chart { q } else { camera.coordinates(at).0 };
        let content =
            view.map_or(DVec2::ZERO, |view| self.content(view, at, mirror.slope(q, &point), image));
        Vertex { q, at, h, gradient, image, content }
    }

    /// Bounds over the facet `t`, counter-clockwise seen from above; infinite for a facet that is
    /// not.
    #[must_use]
    pub fn bound(&self, t: [&Vertex; 3]) -> Bound {
        let [a, b, c] = t.map(|v| v.q);
        let double_area = turn(a, b, c);
        if !(double_area > 0.0) {
            return Bound::NEVER;
        }
        let region = self.cells.over(a.min(b).min(c), a.max(b).max(c));
        let [ab, bc, ca] = [b - a, c - b, a - c];
        let diameter = ab.length().max(bc.length()).max(ca.length());

        let curve = |i: usize, j: usize, edge: DVec2| (t[j].gradient - t[i].gradient).dot(edge);
        let quadratic = largest_deviation(curve(0, 1, ab), curve(1, 2, bc), curve(2, 0, ca));
        let cubic = region.third * diameter * diameter * diameter / 3.0;
        let chord = (quadratic + cubic) * region.stretch;

        let facets = Facet::both(t);
        let chord_mm = chord + self.moved(t, &facets);
        let Some(view) = self.sight.view else {
            return Bound { chord_mm, ..Bound::default() };
        };
        let image = if self.plain {
            let shown = facets.map(|facet| self.shown(view, &facet, t, 0));
            let apart = |a: DVec2, b: DVec2| view.projection.apart(a, b);
            let off = |shown: DVec2| t.iter().map(|v| apart(shown, v.content)).fold(0.0, larger);
            let between = region.second * diameter * diameter / 6.0;
            let rounding = apart(shown[1], shown[0]);
            [larger(off(shown[0]), off(shown[1])) + between, rounding]
        } else {
            self.in_image(view, t, &facets, &region, [diameter, chord_mm])
        };
        Bound { chord_mm, facet_mm: image[0], rounding_mm: image[1] }
    }

    /// Facet error and rounding where they vary over the facet.
    fn in_image(
        &self,
        view: &View,
        t: [&Vertex; 3],
        facets: &[Facet; 2],
        region: &Region,
        [diameter, chord]: [f64; 2],
    ) -> [f64; 2] {
        let shown = facets.map(|facet| [0, 1, 2].map(|i| self.shown(view, &facet, t, i)));
        let own = t.map(|v| v.content);
        let apart = |a: &[DVec2; 3], b: &[DVec2; 3]| {
            a.iter().zip(b).map(|(a, b)| view.projection.apart(*a, *b)).fold(0.0, larger)
        };
        let drift = if region.drift == 0.0 { 0.0 } else { region.drift * chord };
        let aside = drift + self.shift(t, &facets[1]);
        let corners = larger(apart(&shown[0], &own), apart(&shown[1], &own));
        let bound = |first: f64, second: f64| {
            let aside = if aside == 0.0 { 0.0 } else { first * aside };
            corners + second * diameter * diameter / 6.0 + aside
        };
        let [ab, ac] = [t[1].q - t[0].q, t[2].q - t[0].q];
        let (up_b, up_c) = (t[1].h - t[0].h, t[2].h - t[0].h);
        let gradient = (ab.perp() * up_c - ac.perp() * up_b) / ab.perp_dot(ac);
        let [least, most] = region.gradient;
        let quick = if gradient.cmpge(least).all() && gradient.cmple(most).all() {
            bound(region.first, region.second)
        } else {
            f64::INFINITY
        };
        // Few facets need more: near poles, and where they are as large as cells.
        let facet = if quick <= 1.5 * corners {
            quick
        } else {
            let contents = self.closely(view, t, facets, aside);
            quick.min(bound(contents.first(), contents.second())).min(contents.apart())
        };
        [facet, apart(&shown[0], &shown[1])]
    }

    /// Contents over the box of one facet, and as far around it as `aside`.
    fn closely(&self, view: &View, t: [&Vertex; 3], facets: &[Facet; 2], aside: f64) -> Contents {
        let [a, b, c] = t.map(|v| v.q);
        let part = [a.min(b).min(c) - aside, a.max(b).max(c) + aside];
        let bounds = self.sight.narrow(&self.bounds.over(part[0], part[1]), part);
        let k = self.sight.mirror.chart.vergence;
        let most = t.iter().map(|v| v.h).fold(f64::NEG_INFINITY, f64::max);
        let least = t.iter().map(|v| v.h).fold(f64::INFINITY, f64::min);
        let grow = 1.0 + k * most;
        let slack = 4.0 * facets[1].moved * grow * grow;
        let h = Interval::new(least - slack, most + slack);
        let [exact, single] = facets.map(|facet| facet.slope.to_array().map(Interval::point));
        let slope = [exact[0].hull(single[0]), exact[1].hull(single[1])];
        let plane = Plane::of_slope(k, sides(part), h, slope);
        self.sight.contents(view, part, &bounds, Some(plane))
    }

    /// What corner `i` of a facet shows.
    #[inline]
    fn shown(&self, view: &View, facet: &Facet, t: [&Vertex; 3], i: usize) -> DVec2 {
        self.content(view, facet.corners[i], facet.slope, t[i].image)
    }

    #[inline]
    fn content(&self, view: &View, at: DVec3, slope: DVec2, near: DVec2) -> DVec2 {
        DVec2::from_array(if self.plain {
            // The same, without what parallel rays and infinity leave out.
            view.projection.locate((-slope).to_array(), near)
        } else {
            view.content(&self.sight.camera, at.to_array(), slope.to_array(), near)
        })
    }

    /// How far rounding moves the facet along the rays, mm.
    fn moved(&self, t: [&Vertex; 3], [exact, single]: &[Facet; 2]) -> f64 {
        let k = self.sight.mirror.chart.vergence;
        let (mut off, mut lean, mut ray) = (0.0, f64::INFINITY, 1.0f64);
        for (i, v) in t.iter().enumerate() {
            let delta = single.corners[i] - exact.corners[i];
            off = larger(off, (delta.z - exact.slope.dot(delta.truncate())).abs());
            if k != 0.0 {
                lean = lean.min(1.0 + k * v.q.dot(exact.slope));
                ray = ray.max(1.0 + k * k * v.q.length_squared());
            }
        }
        if k == 0.0 {
            off
        } else if lean > 0.0 {
            off * ray.sqrt() / lean
        } else {
            f64::INFINITY
        }
    }

    /// How far rounding moves a corner in the chart: q = (1 + k h) (X, Y) has the differential
    /// (1 + k h) (d(X, Y) + k q dZ).
    fn shift(&self, t: [&Vertex; 3], single: &Facet) -> f64 {
        let k = self.sight.mirror.chart.vergence;
        let shift = |(v, corner): (&&Vertex, &DVec3)| {
            let delta = *corner - v.at;
            (1.0 + k * v.h) * (delta.truncate() + v.q * (k * delta.z)).length()
        };
        t.iter().zip(&single.corners).map(shift).fold(0.0, larger)
    }

    /// Whether the facet, of which nothing can be said, lies where the mirror may look at a place
    /// that the image does not have.
    #[must_use]
    pub fn sees_the_pole(&self, t: &[Vertex; 3]) -> bool {
        let [a, b, c] = t.map(|v| v.q);
        self.cells.over(a.min(b).min(c), a.max(b).max(c)).pole
            && !(self.bound(t.each_ref()).facet_mm < f64::INFINITY)
    }
}

/// A flat facet.
#[derive(Debug, Clone, Copy)]
struct Facet {
    corners: [DVec3; 3],
    slope: DVec2,
    /// How far its corners are from the mirror's, at most, mm.
    moved: f64,
}

impl Facet {
    /// Through the exact corners, and through their single-precision roundings.
    #[inline]
    fn both(t: [&Vertex; 3]) -> [Self; 2] {
        let exact = t.map(|v| v.at);
        let single = exact.map(|p| p.as_vec3().as_dvec3());
        [exact, single].map(|corners| {
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            let moved = (0..3).map(|i| (corners[i] - exact[i]).length()).fold(0.0, larger);
            Self { corners, slope: -normal.truncate() / normal.z, moved }
        })
    }
}

/// The larger of two errors; one that is no number is larger than all.
fn larger(a: f64, b: f64) -> f64 {
    if b <= a { a } else { b }
}

/// Largest |1/2 (l0 l1 h01 + l1 l2 h12 + l2 l0 h20)| over the triangle, exactly.
pub(super) fn largest_deviation(h01: f64, h12: f64, h20: f64) -> f64 {
    let edges = h01.abs().max(h12.abs()).max(h20.abs()) / 8.0;
    // The stationary point inside the triangle, if there is one.
    let weights = [h12 * (h01 + h20 - h12), h20 * (h01 + h12 - h20), h01 * (h12 + h20 - h01)];
    let sum = weights[0] + weights[1] + weights[2];
    if weights.iter().all(|w| w * sum > 0.0) {
        edges.max((0.5 * h01 * h12 * h20 / sum).abs())
    } else {
        edges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn largest_deviation_is_the_largest_of_many_samples() {
        let shapes = [
            [1.0, 1.0, 1.0],
            [2.0, -1.0, 0.3],
            [-0.2, -1.0, -1.1],
            [4.0, 1.0, 1.0],
            [0.0, 1.0, 1.0],
            [1.0, 0.6, 0.9],
        ];
        for [h01, h12, h20] in shapes {
            let mut sampled: f64 = 0.0;
            for i in 0..=400 {
                for j in 0..=400 - i {
                    let (l0, l1) = (f64::from(i) / 400.0, f64::from(j) / 400.0);
                    let l2 = 1.0 - l0 - l1;
                    sampled =
                        sampled.max((0.5 * (l0 * l1 * h01 + l1 * l2 * h12 + l2 * l0 * h20)).abs());
                }
            }
            let found = largest_deviation(h01, h12, h20);
            assert!(found >= sampled - 1e-15 && found <= sampled * 1.001, "{h01} {h12} {h20}");
        }
    }
}
