//! Lower bounds on the number of triangles, with which the size of a mesh is compared (theory, T42 and T43).

use crate::geom::{Chart, DVec2, Outline};
use crate::mirror::{HeightAndSlope, Hessian, Mirror};
use crate::num::quadrature::gauss_legendre;
use crate::num::{Arithmetic, Dual, cos, exp, sin};
use crate::optics::ImagingTask;
use std::f64::consts::PI;

/// Integrals over the mirror from which the lower bounds follow, for vertices on the surface and tolerances that go to
/// zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimum {
    /// Integral of c sqrt |det H| dA, mm: c = 0.3849 on bowls (equilateral triangles), 0.2236 on
    /// saddles.
    curved: f64,
    /// Integral of |det D(c - c_T)| dA / A, mm^2: A = 1.299 on bowls, 1 on saddles. Under parallel
    /// rays and far targets c_T, what the tangent plane shows, is constant, and where the mirror is
    /// right c is the image point itself: the determinant is 1.
    weighted_area: f64,
    /// The two integrals for a mirror of the same curvatures in both directions, mm and mm^2.
    isotropic: [f64; 2],
}

/// Share of the isotropic integrals below which a mirror counts as bent in one direction alone. The number of long
/// facets that it then needs grows more slowly than these bounds say.
const DEVELOPABLE: f64 = 1e-3;

/// The constants C of T42 and 1 / A of T43 where det H > 0, and elsewhere.
const BOWL: [f64; 2] = [0.3849, 1.0 / 1.299];
const SADDLE: [f64; 2] = [0.2236, 1.0];
/// Quadrature nodes along each axis: more than the terms of a mirror's series that matter.
const NODES: usize = 24;

impl std::iter::Sum for Optimum {
    /// The bounds of several mirrors together.
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        let none = Self { curved: 0.0, weighted_area: 0.0, isotropic: [0.0; 2] };
        all.fold(none, |sum, one| Self {
            curved: sum.curved + one.curved,
            weighted_area: sum.weighted_area + one.weighted_area,
            isotropic: [0, 1].map(|k| sum.isotropic[k] + one.isotropic[k]),
        })
    }
}

impl Optimum {
    /// The integrals over all panels of `mirror`, in which the camera of chart `camera` is meant to see `view`.
    #[must_use]
    pub fn new(mirror: &Mirror, camera: &Chart, view: Option<&ImagingTask>) -> Self {
        let k = mirror.chart.vergence;
        let (mut total, mut isotropic) = ([0.0; 2], [0.0; 2]);
        for (q, area) in nodes(&mirror.outline) {
            let (point, c) = (mirror.surface.at(q), mirror.surface.hessian(q));
            let (s, grow) = (point.slope, exp(k * point.f));
            // T41 without its factor exp(k f), which one of the two in T39 takes out.
            let hessian = Hessian {
                xx: c.xx + k * s.x * s.x,
                xy: c.xy + k * s.x * s.y,
                yy: c.yy + k * s.y * s.y,
            };
            let stretch = (1.0 + mirror.chart.tangent_at(q).length_squared()).sqrt() / grow;
            let det = hessian.det();
            let [chord, facet] = if det > 0.0 { BOWL } else { SADDLE };
            total[0] += area * chord * det.abs().sqrt() * stretch;
            isotropic[0] += area * chord * hessian.norm() * stretch;
            let density = view.map(|view| facet_density(mirror, camera, view, q, &point, &c));
            total[1] += area * facet * density.unwrap_or(1.0);
            isotropic[1] += area * facet;
        }
        let panels = if mirror.folded { 2.0 } else { 1.0 };
        let [curved, weighted_area] = total.map(|sum| panels * sum);
        Self { curved, weighted_area, isotropic: isotropic.map(|sum| panels * sum) }
    }

    /// Least number of triangles for a chord error of `limit` mm; none for a mirror that bends in
    /// one direction alone.
    #[must_use]
    pub fn chord(&self, limit: f64) -> Option<f64> {
        (self.curved > DEVELOPABLE * self.isotropic[0]).then(|| self.curved / limit)
    }

    /// Least number of triangles for a facet error of `limit` mm on the mirror: where what a facet
    /// shows leaves what the mirror shows by `limit`, the facet ends. None for a mirror that bends
    /// in one direction alone.
    #[must_use]
    pub fn facet(&self, limit: f64) -> Option<f64> {
        (self.weighted_area > DEVELOPABLE * self.isotropic[1])
            .then(|| self.weighted_area / (limit * limit))
    }
}

/// |det D(c - c_T)| at the chart point `q`: c is the content of the mirror, c_T that of its tangent plane.
fn facet_density(
    mirror: &Mirror,
    camera: &Chart,
    view: &ImagingTask,
    q: DVec2,
    point: &HeightAndSlope,
    c: &Hessian,
) -> f64 {
    let near = view.image_at(camera, mirror.position(q, point));
    let s = point.slope;
    let variable = |value, slope| Dual::<2> { value, slope };
    let place = [variable(q.x, [1.0, 0.0]), variable(q.y, [0.0, 1.0])];
    let slope = [variable(s.x, [c.xx, c.xy]), variable(s.y, [c.xy, c.yy])];
    let at = mirror.chart.position(place, variable(point.f, s.to_array()));
    let curved = mirror.chart.slope(place, slope);
    let flat = curved.map(|p| Dual::constant(p.value));
    let [shown, plane] = [curved, flat].map(|p| view.image_of_seen(camera, at, p, near));
    let [[xx, xy], [yx, yy]] = [0, 1].map(|k| (shown[k] - plane[k]).slope);
    (xx * yy - xy * yx).abs()
}

/// Quadrature nodes of an outline (Gauss, and equidistant angles of a ring) and their weights, mm^2.
fn nodes(outline: &Outline) -> Vec<(DVec2, f64)> {
    let (nodes, weights) = gauss_legendre(NODES);
    let pairs = (0..NODES * NODES).map(|k| (k % NODES, k / NODES));
    match *outline {
        Outline::Rect(rect) => {
            let (centre, half) = (rect.centre(), 0.5 * rect.size());
            let node = |(i, j): (usize, usize)| {
                let q = centre + half * DVec2::new(nodes[i], nodes[j]);
                (q, weights[i] * weights[j] * half.x * half.y)
            };
            pairs.map(node).collect()
        }
        Outline::Ring { inner, outer } => {
            let (middle, half) = (0.5 * (inner + outer), 0.5 * (outer - inner));
            let node = |(i, j): (usize, usize)| {
                let (r, wedge) = (middle + half * nodes[i], 2.0 * PI / NODES as f64);
                let angle = wedge * j as f64;
                (DVec2::new(cos(angle), sin(angle)) * r, weights[i] * half * r * wedge)
            };
            pairs.map(node).collect()
        }
    }
}
