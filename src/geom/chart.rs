//! Charts: image coordinates and a height along the camera's rays instead of X, Y, Z.
//!
//! A camera is known to the geometry by its *vergence* k = 1 / distance (1/mm) of the pinhole from
//! a reference plane; an orthographic camera is the one with k = 0. With q = (x, y) mm where a ray
//! crosses the reference plane and the logarithmic height f mm along it,
//!
//! ```text
//! X, Y = q exp(-k f)        Z = plane + (1 - exp(-k f)) / k        (k = 0: X, Y = q, Z = plane + f)
//! ```
//!
//! which is o + exp(F) d with F = -k f (docs/theory.md, T9): one formula for both cameras. In
//! (q, h) with h = (exp(k f) - 1) / k the map is projective, so a plane stays a plane and a flat
//! facet is linear interpolation of h.

use super::{DVec2, DVec3, Ray};
use crate::num::Scalar;

/// Image coordinates of a camera on the axis, looking along -Z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chart {
    /// k, 1/mm: the inverse distance of the pinhole from the reference plane, 0 for parallel rays.
    pub vergence: f64,
    /// Z of the reference plane, mm.
    pub plane_mm: f64,
}

impl Chart {
    /// The chart of parallel rays on the same reference plane: X, Y and the height over the plane.
    #[must_use]
    pub fn parallel(&self) -> Self {
        Self { vergence: 0.0, plane_mm: self.plane_mm }
    }

    /// The point at height `f` on the ray of image point `q`.
    #[inline]
    pub fn position<S: Scalar>(&self, q: [S; 2], f: S) -> [S; 3] {
        let k = self.vergence;
        let shrink = (f * -k).exp();
        [q[0] * shrink, q[1] * shrink, f * (f * k).one_minus_exp_over_x() + self.plane_mm]
    }

    /// [`Chart::position`] for plain numbers.
    #[inline]
    #[must_use]
    pub fn point(&self, q: DVec2, f: f64) -> DVec3 {
        if self.vergence == 0.0 {
            return q.extend(f + self.plane_mm);
        }
        DVec3::from_array(self.position(q.to_array(), f))
    }

    /// Image point and height of a point nearer than the pinhole.
    #[inline]
    #[must_use]
    pub fn coordinates(&self, p: DVec3) -> (DVec2, f64) {
        let up = p.z - self.plane_mm;
        (p.truncate() / self.view_scale(p.z), up * (-self.vergence * up).ln_1p_over_x())
    }

    /// How wide the view is at a height, by its width in the chart's plane.
    #[inline]
    #[must_use]
    pub fn view_scale(&self, z: f64) -> f64 {
        1.0 - self.vergence * (z - self.plane_mm)
    }

    /// h of height `f`, mm.
    #[inline]
    pub fn projective_height<S: Scalar>(&self, f: S) -> S {
        f * (f * -self.vergence).one_minus_exp_over_x()
    }

    /// f of `h`.
    #[inline]
    pub fn from_projective_height<S: Scalar>(&self, h: S) -> S {
        h * (h * self.vergence).ln_1p_over_x()
    }

    /// The surface's slope (Z_X, Z_Y) where its chart slope is (f_x, f_y).
    #[inline]
    pub fn slope<S: Scalar>(&self, q: [S; 2], s: [S; 2]) -> [S; 2] {
        let lean = (s[0] * q[0] + s[1] * q[1]) * -self.vergence + 1.0;
        s.map(|s| s / lean)
    }

    /// The chart slope (f_x, f_y) of a surface of slope (Z_X, Z_Y): the slope field
    /// s_k = -(W . d_k) / (W . d) of every camera for W = (-Z_X, -Z_Y, 1).
    #[inline]
    pub fn chart_slope<S: Scalar>(&self, q: [S; 2], p: [S; 2]) -> [S; 2] {
        let lean = (p[0] * q[0] + p[1] * q[1]) * self.vergence + 1.0;
        p.map(|p| p / lean)
    }

    /// Tangent of the angle between the axis and the camera's ray through a point, as a vector away
    /// from the axis.
    #[inline]
    pub fn view<S: Scalar>(&self, p: [S; 3]) -> [S; 2] {
        let k = self.vergence;
        let shrink = (p[2] - self.plane_mm) * -k + 1.0;
        [p[0] * k / shrink, p[1] * k / shrink]
    }

    /// Z of the pinhole, mm; none for parallel rays.
    #[inline]
    #[must_use]
    pub fn pupil_mm(&self) -> Option<f64> {
        (self.vergence != 0.0).then(|| self.plane_mm + 1.0 / self.vergence)
    }

    /// The camera's ray through image point `q`: from the pinhole, or from height `top_mm`.
    #[inline]
    #[must_use]
    pub fn ray(&self, q: DVec2, top_mm: f64) -> Ray {
        let Some(pupil_mm) = self.pupil_mm() else {
            return Ray { origin: q.extend(top_mm), direction: DVec3::NEG_Z };
        };
        let origin = DVec3::new(0.0, 0.0, pupil_mm);
        Ray { origin, direction: (q * self.vergence).extend(-1.0).normalize() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_undo_place_and_planes_are_linear_in_h() {
        for vergence in [0.0, 1e-9, 1e-3, 0.02] {
            let chart = Chart { vergence, plane_mm: 7.0 };
            let plane = |q: DVec2| {
                // The plane Z = 9 + 0.3 X - 0.2 Y met along the ray of q, by hand.
                let lean = (0.3 * q.x - 0.2 * q.y) * vergence;
                let up = (2.0 + 0.3 * q.x - 0.2 * q.y) / (1.0 + lean);
                (q * (1.0 - vergence * up)).extend(7.0 + up)
            };
            let h = |q: DVec2| {
                let (back, f) = chart.coordinates(plane(q));
                assert!((back - q).length() < 1e-12);
                assert!((chart.point(q, f) - plane(q)).length() < 1e-12);
                assert!(
                    (chart.from_projective_height(chart.projective_height(f)) - f).abs() < 1e-12
                );
                chart.projective_height(f)
            };
            let (a, b) = (DVec2::new(-12.0, 5.0), DVec2::new(17.0, 9.0));
            assert!((0.5 * (h(a) + h(b)) - h(0.5 * (a + b))).abs() < 1e-12, "{vergence}");
        }
    }

    #[test]
    fn slopes_convert_both_ways_and_agree_with_differences() {
        let chart = Chart { vergence: 0.015, plane_mm: -3.0 };
        let (q, p) = ([9.0, -4.0], [0.4, 0.7]);
        let s = chart.chart_slope(q, p);
        let back = chart.slope(q, s);
        assert!((back[0] - p[0]).abs() + (back[1] - p[1]).abs() < 1e-15);
        // Moving along the surface by (f_x, f_y) stays in the plane of slope p.
        let e = 1e-6;
        for (dx, dy, df) in [(e, 0.0, s[0] * e), (0.0, e, s[1] * e)] {
            let a = chart.point(DVec2::from_array(q), 1.5);
            let b = chart.point(DVec2::new(q[0] + dx, q[1] + dy), 1.5 + df);
            let d = b - a;
            assert!((d.z - p[0] * d.x - p[1] * d.y).abs() < 1e-11);
        }
    }

    #[test]
    fn the_ray_of_an_image_point_passes_through_its_places() {
        for vergence in [0.0, 0.01] {
            let chart = Chart { vergence, plane_mm: 2.0 };
            let q = DVec2::new(11.0, -6.0);
            let (ray, p) = (chart.ray(q, 50.0), chart.point(q, -4.0));
            let off = (p - ray.origin).cross(ray.direction).length();
            assert!(off < 1e-13 && (p - ray.origin).dot(ray.direction) > 0.0);
            let view = chart.view(p.to_array());
            assert!((DVec2::from_array(view) - q * vergence).length() < 1e-15);
        }
    }
}
