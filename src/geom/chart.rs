//! Charts: image coordinates and a height along the camera's rays instead of X, Y, Z.
//!
//! A camera is known to the geometry by its *vergence* k = 1 / distance (1/mm) of the pinhole from
//! a reference plane, an orthographic camera being the one with k = 0, and by its *lean* b, the tangent of the
//! angle between the plane's normal and the direction from the plane's origin to the camera. With q = (x, y) mm
//! where a ray crosses the reference plane and the logarithmic height f mm along it,
//!
//! ```text
//! Z = plane + u     X, Y = q exp(-k f) + b u     u = (1 - exp(-k f)) / k        (k = 0: u = f)
//! ```
//!
//! which is o + exp(F) d with F = -k f (docs/theory.md, T9 and T95): one formula for all cameras. A lean shears space
//! along the reference plane. In (q, h) with h = (exp(k f) - 1) / k the map is projective, so a plane stays a
//! plane and a flat facet is linear interpolation of h.

use super::{DVec2, DVec3, Ray};
use crate::num::Scalar;

/// Image coordinates of a camera on the reference plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chart {
    /// k, 1/mm: the inverse height of the pinhole over the reference plane, 0 for parallel rays.
    pub vergence: f64,
    /// Z of the reference plane, mm.
    pub plane_mm: f64,
    /// b, mm of X and Y for a mm of Z: 0 where the camera stands over the plane's origin.
    pub lean: DVec2,
}

impl Chart {
    /// The chart of a camera over the plane's origin.
    #[must_use]
    pub const fn on_axis(vergence: f64, plane_mm: f64) -> Self {
        Self { vergence, plane_mm, lean: DVec2::ZERO }
    }

    /// The chart of vertical rays on the same reference plane: X, Y and the height over the plane.
    #[must_use]
    pub fn parallel(&self) -> Self {
        Self::on_axis(0.0, self.plane_mm)
    }

    /// Whether image coordinates are X and Y themselves.
    #[must_use]
    pub fn is_plan(&self) -> bool {
        self.vergence == 0.0 && self.lean == DVec2::ZERO
    }

    /// Tangent of the angle between the vertical and the ray of image point `q`, as a vector in the direction in
    /// which the ray moves as it falls: k q - b.
    #[inline]
    pub fn tangent<S: Scalar>(&self, q: [S; 2]) -> [S; 2] {
        let k = self.vergence;
        if self.lean == DVec2::ZERO {
            return q.map(|q| q * k);
        }
        [q[0] * k - self.lean.x, q[1] * k - self.lean.y]
    }

    /// [`Chart::tangent`] for plain numbers.
    #[inline]
    #[must_use]
    pub fn tangent_at(&self, q: DVec2) -> DVec2 {
        DVec2::from_array(self.tangent(q.to_array()))
    }

    /// The point whose image point, shrunk as it is seen at the height `up` over the plane, is `shrunk`.
    #[inline]
    fn sheared<S: Scalar>(&self, shrunk: [S; 2], up: S) -> [S; 3] {
        let [x, y] = if self.lean == DVec2::ZERO {
            shrunk
        } else {
            [shrunk[0] + up * self.lean.x, shrunk[1] + up * self.lean.y]
        };
        [x, y, up + self.plane_mm]
    }

    /// The point at height `f` on the ray of image point `q`.
    #[inline]
    pub fn position<S: Scalar>(&self, q: [S; 2], f: S) -> [S; 3] {
        let k = self.vergence;
        let shrink = (f * -k).exp();
        self.sheared([q[0] * shrink, q[1] * shrink], f * (f * k).one_minus_exp_over_x())
    }

    /// [`Chart::position`] for plain numbers.
    #[inline]
    #[must_use]
    pub fn point(&self, q: DVec2, f: f64) -> DVec3 {
        if self.is_plan() {
            return q.extend(f + self.plane_mm);
        }
        DVec3::from_array(self.position(q.to_array(), f))
    }

    /// The point on the ray of image point `q` whose projective height is `h`.
    #[inline]
    pub fn position_at_h<S: Scalar>(&self, q: [S; 2], h: S) -> [S; 3] {
        let grow = h * self.vergence + 1.0;
        self.sheared([q[0] / grow, q[1] / grow], h / grow)
    }

    /// Image point and height of a point nearer than the pinhole.
    #[inline]
    #[must_use]
    pub fn coordinates(&self, p: DVec3) -> (DVec2, f64) {
        let up = p.z - self.plane_mm;
        let upright =
            if self.lean == DVec2::ZERO { p.truncate() } else { p.truncate() - self.lean * up };
        (upright / self.view_scale(p.z), up * (-self.vergence * up).ln_1p_over_x())
    }

    /// How wide the view is at a height, by its width in the chart's plane.
    #[inline]
    #[must_use]
    pub fn view_scale(&self, z: f64) -> f64 {
        1.0 - self.vergence * (z - self.plane_mm)
    }

    /// X and Y, mm, at which the ray through a point passes the height `z`.
    #[inline]
    #[must_use]
    pub fn passing(&self, p: DVec3, z: f64) -> DVec2 {
        self.ray_at(self.coordinates(p).0, z)
    }

    /// X and Y, mm, at which the ray of image point `q` passes the height `z`.
    #[inline]
    #[must_use]
    pub fn ray_at(&self, q: DVec2, z: f64) -> DVec2 {
        q * self.view_scale(z) + self.lean * (z - self.plane_mm)
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

    /// 1 - s . t, by which the normal (-Z_X, -Z_Y, 1) is divided where the chart slope is `s`: t is the ray's
    /// tangent.
    #[inline]
    pub fn normal_scale<S: Scalar>(&self, q: [S; 2], s: [S; 2]) -> S {
        let k = self.vergence;
        let upright = (s[0] * q[0] + s[1] * q[1]) * -k + 1.0;
        if self.lean == DVec2::ZERO {
            return upright;
        }
        upright + (s[0] * self.lean.x + s[1] * self.lean.y)
    }

    /// The surface's slope (Z_X, Z_Y) where its chart slope is (f_x, f_y).
    #[inline]
    pub fn slope<S: Scalar>(&self, q: [S; 2], s: [S; 2]) -> [S; 2] {
        let scale = self.normal_scale(q, s);
        s.map(|s| s / scale)
    }

    /// 1 + p . t for a surface of slope `p`: how far its height falls behind along the ray of `q`, for a mm that
    /// the ray falls.
    #[inline]
    pub fn fall<S: Scalar>(&self, q: [S; 2], p: [S; 2]) -> S {
        let upright = (p[0] * q[0] + p[1] * q[1]) * self.vergence + 1.0;
        if self.lean == DVec2::ZERO {
            return upright;
        }
        upright - (p[0] * self.lean.x + p[1] * self.lean.y)
    }

    /// The chart slope (f_x, f_y) of a surface of slope (Z_X, Z_Y): the slope field
    /// s_k = -(W . d_k) / (W . d) of every camera for W = (-Z_X, -Z_Y, 1).
    #[inline]
    pub fn chart_slope<S: Scalar>(&self, q: [S; 2], p: [S; 2]) -> [S; 2] {
        let fall = self.fall(q, p);
        p.map(|p| p / fall)
    }

    /// Tangent of the angle between the vertical and the camera's ray through a point, as [`Chart::tangent`].
    #[inline]
    pub fn view<S: Scalar>(&self, p: [S; 3]) -> [S; 2] {
        let k = self.vergence;
        let shrink = (p[2] - self.plane_mm) * -k + 1.0;
        if self.lean == DVec2::ZERO {
            return [p[0] * k / shrink, p[1] * k / shrink];
        }
        [(p[0] * k - self.lean.x) / shrink, (p[1] * k - self.lean.y) / shrink]
    }

    /// The pinhole, mm; none for parallel rays.
    #[inline]
    #[must_use]
    pub fn pupil(&self) -> Option<DVec3> {
        let k = self.vergence;
        (k != 0.0).then(|| (self.lean / k).extend(self.plane_mm + 1.0 / k))
    }

    /// The camera's ray through image point `q`: from the pinhole, or from height `top_mm`.
    #[inline]
    #[must_use]
    pub fn ray(&self, q: DVec2, top_mm: f64) -> Ray {
        let Some(origin) = self.pupil() else {
            if self.lean == DVec2::ZERO {
                return Ray { origin: q.extend(top_mm), direction: DVec3::NEG_Z };
            }
            let from = q + self.lean * (top_mm - self.plane_mm);
            let direction = (-self.lean).extend(-1.0).normalize();
            return Ray { origin: from.extend(top_mm), direction };
        };
        Ray { origin, direction: self.tangent_at(q).extend(-1.0).normalize() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Charts of these vergences, on the axis and leaning.
    fn charts<const N: usize>(vergences: [f64; N], plane_mm: f64) -> impl Iterator<Item = Chart> {
        let leans = [DVec2::ZERO, DVec2::new(0.5, -0.3)];
        let chart = move |(vergence, lean)| Chart { vergence, plane_mm, lean };
        vergences.into_iter().flat_map(move |k| leans.map(|lean| (k, lean))).map(chart)
    }

    #[test]
    fn coordinates_undo_place_and_planes_are_linear_in_h() {
        for chart in charts([0.0, 1e-9, 1e-3, 0.02], 7.0) {
            let plane = |q: DVec2| {
                // The plane Z = 9 + 0.3 X - 0.2 Y met along the ray of q, by hand.
                let tangent = q * chart.vergence - chart.lean;
                let up = (2.0 + 0.3 * q.x - 0.2 * q.y) / (1.0 + 0.3 * tangent.x - 0.2 * tangent.y);
                (q - tangent * up).extend(7.0 + up)
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
            assert!((0.5 * (h(a) + h(b)) - h(0.5 * (a + b))).abs() < 1e-12, "{chart:?}");
        }
    }

    #[test]
    fn slopes_convert_both_ways_and_agree_with_differences() {
        for chart in charts([0.0, 0.015], -3.0) {
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
    }

    #[test]
    fn the_ray_of_an_image_point_passes_through_its_places() {
        for chart in charts([0.0, 0.01], 2.0) {
            let q = DVec2::new(11.0, -6.0);
            let (ray, p) = (chart.ray(q, 50.0), chart.point(q, -4.0));
            let off = (p - ray.origin).cross(ray.direction).length();
            assert!(off < 1e-13 && (p - ray.origin).dot(ray.direction) > 0.0);
            assert!(
                (chart.passing(p, 9.0).extend(9.0) - ray.origin).cross(ray.direction).length()
                    < 1e-13
            );
            let view = chart.view(p.to_array());
            assert!((DVec2::from_array(view) - chart.tangent_at(q)).length() < 1e-15);
            let h = chart.projective_height(-4.0);
            let same = DVec3::from_array(chart.position_at_h(q.to_array(), h));
            assert!((same - p).length() < 1e-13);
        }
    }
}
