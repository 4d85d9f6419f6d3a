//! Bounds of the deviation of a smooth function from its linear interpolation over a triangle (theory, T45 to T47).
//!
//! With l the barycentric coordinates of a place, d_ij the edges, r_i the ways to the corners and
//! L the linear interpolation of h, Taylor's theorem about the place gives
//!
//! ```text
//! L - h = 1/2 sum over i < j of l_i l_j d_ij' H d_ij + sum of l_i R_i,    |R_i| <= |h'''| |r_i|^3 / 6
//! ```
//!
//! as sum l_i r_i = 0 and sum l_i r_i r_i' = sum l_i l_j d_ij d_ij'. Differences of the gradient
//! along the edges give d_ij' H d_ij for a mean Hessian of each edge; what that leaves out is
//!
//! - for a third derivative T that is constant, a cubic that is known exactly: its Bernstein
//!   coefficients are +- T[d, d, d] / 36 on the edges and one in the middle;
//! - for one that is somewhere within R of T, at most (1/9 + 1/18) R[d, d, d] for the largest d:
//!   mean distances from a place to the ends of an edge are at most (|r_i| + |r_j|) / 2,
//!   |r_i| <= (1 - l_i) |d|, and l (1 - l)^2 <= 4/27, l (1 - l)^3 <= 27/256.
//!
//! A function of which only the second derivative K is known is off by at most
//! K/2 sum l_i |r_i|^2 <= K D^2 / 6 (Jung: a triangle of diameter D fits a circle of radius
//! D / sqrt 3), and along an axis sum l_i x_i^2 <= X^2 / 4 for a triangle X wide.

use crate::geom::DVec2;
use crate::num::Interval;

/// Edges, bounding box and diameter of a triangle in the chart.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    /// From corner 0 to 1, 1 to 2 and 2 to 0, mm.
    pub edges: [DVec2; 3],
    /// Opposite corners of its bounding box, mm.
    pub bounding_box: [DVec2; 2],
    /// Longest edge, mm.
    pub diameter: f64,
}

impl Triangle {
    /// The triangle with the given corners, mm.
    #[inline]
    pub(crate) fn new([a, b, c]: [DVec2; 3]) -> Self {
        let edges = [b - a, c - b, a - c];
        let longest = edges.map(DVec2::length_squared).into_iter().fold(0.0, f64::max);
        Self { edges, bounding_box: [a.min(b).min(c), a.max(b).max(c)], diameter: longest.sqrt() }
    }

    /// Second derivatives d_ij' H d_ij along the edges, from the gradients `g` at the corners.
    #[inline]
    pub(crate) fn edge_curvatures(&self, g: [DVec2; 3]) -> [f64; 3] {
        let [ab, bc, ca] = self.edges;
        [(g[1] - g[0]).dot(ab), (g[2] - g[1]).dot(bc), (g[0] - g[2]).dot(ca)]
    }

    /// Bound of the deviation of a function from its interpolation, when its second derivatives (xx, xy, yy) are at
    /// most these in size (T47).
    #[inline]
    pub(crate) fn interpolation_error(&self, [xx, xy, yy]: [f64; 3]) -> f64 {
        let size = self.bounding_box[1] - self.bounding_box[0];
        let boxed = (xx * size.x + 2.0 * xy * size.y) * size.x + yy * size.y * size.y;
        let all = (xx * xx + 2.0 * xy * xy + yy * yy).sqrt() * self.diameter * self.diameter;
        (boxed / 8.0).min(all / 6.0)
    }

    /// Bound of what values and gradients at the corners leave out of a function with third derivatives
    /// (xxx, xxy, xyy, yyy) in `third`.
    #[inline]
    pub(crate) fn cubic_remainder(&self, third: [Interval; 4]) -> f64 {
        let mean = third.map(|t| 0.5 * (t.lo + t.hi));
        let slack = third.map(|t| 0.5 * (t.hi - t.lo));
        let along = |u: DVec2, v: DVec2| {
            // T[u, u, v].
            let (xx, xy, yy) = (u.x * u.x, u.x * u.y, u.y * u.y);
            (mean[0] * xx + 2.0 * mean[1] * xy + mean[2] * yy) * v.x
                + (mean[1] * xx + 2.0 * mean[2] * xy + mean[3] * yy) * v.y
        };
        let [ab, bc, ca] = self.edges;
        let edges = [along(ab, ab), along(bc, bc), along(ca, ca)];
        // With T odd, T[ca, ca, ca] = -T[ac, ac, ac].
        let middle = 2.0 * (edges[0] - edges[2]) - 3.0 * (along(ab, -ca) + along(ca, ab));
        let largest = edges[0].abs().max(edges[1].abs()).max(edges[2].abs());
        // The sum of l_i l_j |l_i - l_j| stays under 0.118, 6 l_0 l_1 l_2 under 2/9.
        let known = 0.118 / 12.0 * largest + 2.0 / 9.0 * middle.abs() / 72.0;

        let size = self.bounding_box[1] - self.bounding_box[0];
        let (x, y) = (size.x, size.y);
        let [xxx, xxy, xyy, yyy] = slack;
        let boxed = xxx * x * x * x + 3.0 * x * y * (xxy * x + xyy * y) + yyy * y * y * y;
        let square = xxx * xxx + 3.0 * (xxy * xxy + xyy * xyy) + yyy * yyy;
        let all = square.sqrt() * self.diameter * self.diameter * self.diameter;
        known + boxed.min(all) / 6.0
    }
}

/// Largest |1/2 (l0 l1 h01 + l1 l2 h12 + l2 l0 h20)| over the triangle (T46), or a little more where rounding hides
/// it.
#[inline]
pub(crate) fn largest_deviation(h01: f64, h12: f64, h20: f64) -> f64 {
    let [a, b, c] = [h01.abs(), h12.abs(), h20.abs()];
    let longest = a.max(b).max(c);
    let edges = longest / 8.0;
    // The stationary point inside the triangle, if there is one.
    let weights = [h12 * (h01 + h20 - h12), h20 * (h01 + h12 - h20), h01 * (h12 + h20 - h01)];
    let sum = weights[0] + weights[1] + weights[2];
    let slack = 8.0 * f64::EPSILON * longest * longest;
    if weights.iter().all(|w| w * sum.signum() > -slack) {
        // On slivers the weights cancel; but one edge's share is at most an eighth.
        let most = edges + a.min(b).min(c) / 8.0;
        let rest = sum.abs() - slack;
        if rest > 0.0 { edges.max((0.5 * a * b * c / rest).min(most)) } else { most }
    } else {
        edges
    }
}

/// Largest |sum of l_i e_i - 1/2 (l0 l1 h01 + l1 l2 h12 + l2 l0 h20)| over the triangle, exactly, and the barycentric
/// coordinates where it is attained.
pub(crate) fn largest_quadratic(e: [f64; 3], h: [f64; 3]) -> (f64, [f64; 3]) {
    let value = |l: [f64; 3]| {
        let bend = l[0] * l[1] * h[0] + l[1] * l[2] * h[1] + l[2] * l[0] * h[2];
        (e[0] * l[0] + e[1] * l[1] + e[2] * l[2] - 0.5 * bend).abs()
    };
    let mut best = (-1.0, [1.0, 0.0, 0.0]);
    let mut consider = |l: [f64; 3]| {
        let found = value(l);
        if !(found <= best.0) {
            best = (found, l);
        }
    };
    for i in 0..3 {
        let j = (i + 1) % 3;
        let mut l = [0.0; 3];
        l[i] = 1.0;
        consider(l);
        let t = 0.5 - (e[j] - e[i]) / h[i];
        if 0.0 < t && t < 1.0 {
            (l[i], l[j]) = (1.0 - t, t);
            consider(l);
        }
    }
    // Where both derivatives vanish; a saddle is no extremum.
    let cross = 0.5 * (h[0] + h[2] - h[1]);
    let det = h[0] * h[2] - cross * cross;
    if det > 0.0 {
        let (p, q) = (0.5 * h[0] - (e[1] - e[0]), 0.5 * h[2] - (e[2] - e[0]));
        let (s, t) = ((p * h[2] - q * cross) / det, (q * h[0] - p * cross) / det);
        if s > 0.0 && t > 0.0 && s + t < 1.0 {
            consider([1.0 - s - t, s, t]);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;

    /// Barycentric coordinates all over a triangle.
    fn places(n: u32) -> impl Iterator<Item = [f64; 3]> {
        let place = move |i: u32, j: u32| [i, j, n - i - j].map(|k| f64::from(k) / f64::from(n));
        (0..=n).flat_map(move |i| (0..=n - i).map(move |j| place(i, j)))
    }

    #[test]
    fn largest_values_are_the_largest_of_many_samples() {
        let mut r = Draws::new(3);
        for k in 0..60 {
            let draw = |r: &mut Draws| [0; 3].map(|_| r.inside([-1.0, 1.0]));
            let e = if k % 3 == 0 { [0.0; 3] } else { draw(&mut r).map(|e| 0.2 * e) };
            let h = match k {
                0 => [1.0; 3],
                3 => [4.0, 1.0, 1.0],
                6 => [0.0, 1.0, 1.0],
                _ => draw(&mut r),
            };
            let value = |l: [f64; 3]| {
                let bend = l[0] * l[1] * h[0] + l[1] * l[2] * h[1] + l[2] * l[0] * h[2];
                (e[0] * l[0] + e[1] * l[1] + e[2] * l[2] - 0.5 * bend).abs()
            };
            let sampled = places(200).map(value).fold(0.0, f64::max);
            let (found, at) = largest_quadratic(e, h);
            assert!(found >= sampled - 1e-15 && found <= sampled + 1e-4, "{e:?} {h:?}");
            assert!((value(at) - found).abs() < 1e-15);
            if e == [0.0; 3] {
                let over = largest_deviation(h[0], h[1], h[2]) - found;
                assert!(over > -1e-15 && over < 1e-13, "{h:?}: {over:e}");
            }
        }
    }

    #[test]
    fn deviations_of_slivers_are_not_lost_in_rounding() {
        // In exact arithmetic.
        let found = largest_deviation(1.025532179755809, 1.391284298961979e-8, 1.0255321801302242);
        assert!((0.12819152292797..0.1281915247).contains(&found), "{found}");
    }

    /// |x|^3 / 6 about `at` in direction `way`: its third derivative is +-1 along it.
    fn kink(p: DVec2, at: DVec2, way: DVec2) -> (f64, DVec2) {
        let x = way.dot(p - at);
        (x.abs() * x * x / 6.0, way * (0.5 * x * x.abs()))
    }

    #[test]
    fn what_edges_do_not_tell_is_within_the_bound() {
        let mut r = Draws::new(8);
        let (mut cubic_share, mut kink_share) = (0.0f64, 0.0f64);
        for _ in 0..400 {
            let thin = if r.unit() < 0.3 { 0.05 } else { 1.0 };
            let corners = [0; 3].map(|_| DVec2::new(r.unit(), thin * r.unit()));
            let triangle = Triangle::new(corners);
            let c = [0; 4].map(|_| r.inside([-1.0, 1.0]));
            let cubic = |p: DVec2| {
                let (x, y) = (p.x, p.y);
                let f = c[0] * x * x * x + 3.0 * x * y * (c[1] * x + c[2] * y) + c[3] * y * y * y;
                let slope = DVec2::new(
                    c[0] * x * x + 2.0 * c[1] * x * y + c[2] * y * y,
                    c[1] * x * x + 2.0 * c[2] * x * y + c[3] * y * y,
                );
                (f / 6.0, slope * 0.5)
            };
            let angle = r.inside([0.0, 3.2]);
            let way = DVec2::new(crate::num::cos(angle), crate::num::sin(angle));
            let at = corners[0] * 0.3 + corners[1] * r.unit() + corners[2] * (0.7 - r.unit());
            let size = [
                way.x * way.x * way.x,
                way.x * way.x * way.y,
                way.x * way.y * way.y,
                way.y * way.y * way.y,
            ];
            let deviation = |f: &dyn Fn(DVec2) -> (f64, DVec2)| {
                let known = corners.map(f);
                let h = triangle.edge_curvatures(known.map(|k| k.1));
                let off = |l: [f64; 3]| {
                    let p = corners[0] * l[0] + corners[1] * l[1] + corners[2] * l[2];
                    let line = known[0].0 * l[0] + known[1].0 * l[1] + known[2].0 * l[2];
                    let bend = l[0] * l[1] * h[0] + l[1] * l[2] * h[1] + l[2] * l[0] * h[2];
                    (line - f(p).0 - 0.5 * bend).abs()
                };
                places(24).map(off).fold(0.0, f64::max)
            };
            let share = deviation(&cubic) / triangle.cubic_remainder(c.map(Interval::point));
            assert!(share <= 1.0 + 1e-9, "{share}");
            cubic_share = cubic_share.max(share);
            let either = size.map(|t| Interval::new(-t.abs(), t.abs()));
            let share = deviation(&|p| kink(p, at, way)) / triangle.cubic_remainder(either);
            assert!(share <= 1.0, "{share}");
            kink_share = kink_share.max(share);
        }
        assert!(cubic_share > 0.8 && kink_share > 0.05, "{cubic_share} {kink_share}");
    }

    #[test]
    fn interpolation_is_within_the_bound_of_second_derivatives() {
        let mut r = Draws::new(9);
        let mut most = 0.0f64;
        for _ in 0..300 {
            let corners = [0; 3].map(|_| DVec2::new(r.unit(), 0.3 * r.unit()));
            let c = [0; 3].map(|_| r.inside([-1.0, 1.0]));
            let f = |p: DVec2| 0.5 * (c[0] * p.x * p.x + c[2] * p.y * p.y) + c[1] * p.x * p.y;
            let off = |l: [f64; 3]| {
                let p = corners[0] * l[0] + corners[1] * l[1] + corners[2] * l[2];
                (0..3).map(|i| f(corners[i]) * l[i]).sum::<f64>() - f(p)
            };
            let found = places(30).map(off).fold(0.0, |a: f64, b| a.max(b.abs()));
            let bound = Triangle::new(corners).interpolation_error(c.map(f64::abs));
            assert!(found <= bound * (1.0 + 1e-12), "{found} {bound}");
            most = most.max(found / bound);
        }
        assert!(most > 0.9, "{most}");
    }
}
