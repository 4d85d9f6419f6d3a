//! Flat facets: the one through exact vertices and the one through rounded vertices, and how far these are apart.

use super::deviation::Triangle;
use super::region::RegionBounds;
use super::vertex::SurfaceVertex;
use crate::geom::{Chart, DVec2, DVec3, Precision};
use crate::num::{Interval, max_or_nan};

/// A flat facet in the part frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlatFacet {
    /// Corners, mm.
    pub corners: [DVec3; 3],
    /// Slope (Z_X, Z_Y) of its plane.
    pub slope: DVec2,
    /// Largest distance of a corner from the exact vertex, mm.
    pub corner_offset: f64,
}

impl FlatFacet {
    #[inline]
    fn new(corners: [DVec3; 3], corner_offset: f64) -> Self {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        Self { corners, slope: -normal.truncate() / normal.z, corner_offset }
    }

    /// h of the facet's plane, in `chart`, on the ray of `q` near its corner `i`, mm.
    pub(crate) fn height_on_ray(&self, chart: &Chart, i: usize, q: DVec2) -> f64 {
        let (at, p) = (self.corners[i].truncate(), self.slope);
        let up = self.corners[i].z - chart.plane_mm;
        if chart.lean == DVec2::ZERO {
            return (up + p.dot(q - at)) / (1.0 - chart.vergence * (up - p.dot(at)));
        }
        // The plane's height over the origin, and the height at which the ray meets it.
        let base = up - p.dot(at);
        let [fall, rise] = [chart.fall(q.to_array(), p.to_array()), base + p.dot(q)];
        let up = rise / fall;
        up / (1.0 - chart.vergence * up)
    }
}

/// The facet through the exact vertices and, where the file is single precision, the one through their roundings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetPair {
    /// The facet through the exact vertices.
    pub exact: FlatFacet,
    /// The facet through the rounded vertices.
    pub rounded: Option<FlatFacet>,
}

impl FacetPair {
    /// The facets of the vertices `t` in a file of `precision`.
    #[inline]
    pub(crate) fn new(t: [&SurfaceVertex; 3], precision: Precision) -> Self {
        let corners = t.map(|v| v.at);
        let rounded = (precision == Precision::Single).then(|| {
            let rounded = corners.map(|p| p.as_vec3().as_dvec3());
            let offset = (0..3).map(|i| (rounded[i] - corners[i]).length()).fold(0.0, max_or_nan);
            FlatFacet::new(rounded, offset)
        });
        Self { exact: FlatFacet::new(corners, 0.0), rounded }
    }

    /// h of the planes of the exact and the rounded facet, in `chart`, on the rays of the vertices `t`, mm.
    #[inline]
    pub(crate) fn heights(&self, t: [&SurfaceVertex; 3], chart: &Chart) -> [[f64; 3]; 2] {
        let exact = t.map(|v| v.h);
        let rounded = self.rounded.as_ref().map_or(exact, |rounded| {
            std::array::from_fn(|i| rounded.height_on_ray(chart, i, t[i].q))
        });
        [exact, rounded]
    }

    /// The gradients of h of the exact facet and of the rounded one, in `chart`.
    #[inline]
    pub(crate) fn gradients(&self, t: [&SurfaceVertex; 3], chart: &Chart) -> [DVec2; 2] {
        let q = t.map(|v| v.q);
        self.heights(t, chart).map(|h| gradient_of(q, h))
    }

    /// Distance by which rounding moves a corner in `chart`, at most, mm: q = (1 + k h) (X, Y), sheared by the lean, has
    /// the differential (1 + k h) (d(X, Y) + t dZ) with the ray's tangent t.
    #[inline]
    pub(crate) fn corner_shift(&self, t: [&SurfaceVertex; 3], chart: &Chart) -> f64 {
        let Some(rounded) = &self.rounded else { return 0.0 };
        let shift = |(v, corner): (&&SurfaceVertex, &DVec3)| {
            let delta = *corner - v.at;
            let aside = delta.truncate() + chart.tangent_at(v.q) * delta.z;
            (1.0 + chart.vergence * v.h) * aside.length()
        };
        t.iter().zip(&rounded.corners).map(shift).fold(0.0, max_or_nan)
    }

    /// Distance by which rounding moves the facet along the rays of `chart`, at most, mm.
    #[inline]
    pub(crate) fn chord_by_rounding(
        &self,
        t: [&SurfaceVertex; 3],
        (triangle, region): (&Triangle, &RegionBounds),
        chart: &Chart,
    ) -> f64 {
        let Self { exact, rounded: Some(rounded) } = self else { return 0.0 };
        let (mut off, mut fall, mut ray) = (0.0, f64::INFINITY, 1.0f64);
        for (i, v) in t.iter().enumerate() {
            let delta = rounded.corners[i] - exact.corners[i];
            off = max_or_nan(off, (delta.z - exact.slope.dot(delta.truncate())).abs());
            if !chart.is_plan() {
                fall = f64::min(fall, chart.fall(v.q.to_array(), exact.slope.to_array()));
                ray = ray.max(1.0 + chart.tangent_at(v.q).length_squared());
            }
        }
        if chart.is_plan() {
            off
        } else if fall > 0.0 {
            // The rounded facet reaches a little beyond the exact facet, too.
            let flat = gradient_of(t.map(|v| v.q), t.map(|v| v.h));
            let steep = t.iter().map(|v| (v.gradient - flat).length()).fold(0.0, max_or_nan);
            let third = third_derivative_norm(region.h_third);
            let bend = third * triangle.diameter * triangle.diameter / 6.0;
            off * ray.sqrt() / fall
                + self.corner_shift(t, chart) * (steep + bend) * region.ray_per_h
        } else {
            f64::INFINITY
        }
    }
}

/// The gradient of the function that is linear and has the values `h` at the corners `q`.
#[inline]
pub(crate) fn gradient_of(q: [DVec2; 3], h: [f64; 3]) -> DVec2 {
    let [ab, ac] = [q[1] - q[0], q[2] - q[0]];
    (ab.perp() * (h[2] - h[0]) - ac.perp() * (h[1] - h[0])) / ab.perp_dot(ac)
}

/// A bound of a third derivative along any directions of unit length.
pub(crate) fn third_derivative_norm(third: [Interval; 4]) -> f64 {
    let [xxx, xxy, xyy, yyy] = third.map(Interval::magnitude);
    (xxx * xxx + 3.0 * (xxy * xxy + xyy * xyy) + yyy * yyy).sqrt()
}
