//! The bicubic spline through sag on a regular grid as a surface.

use super::bounds::BoundCells;
use super::height_field::{HeightAndSlope, HeightField, HeightRow, Hessian};
use crate::geom::{BicubicSpline, BicubicSplineRow, DVec2, DerivativeBounds};

impl HeightField for BicubicSpline {
    type Row<'a> = BicubicSplineRow<'a>;

    fn row(&self, y: f64) -> BicubicSplineRow<'_> {
        self.row(y)
    }

    fn hessian(&self, q: DVec2) -> Hessian {
        let [xx, xy, yy] = self.second(q);
        Hessian { xx, xy, yy }
    }

    fn reflected(&self, axis: usize) -> Self {
        self.reflected(axis)
    }

    fn cell_bounds(&self, cells: &BoundCells) -> Vec<DerivativeBounds> {
        cells.each(|lo, hi| self.bounds(lo, hi))
    }

    fn box_bounds(&self, lo: DVec2, hi: DVec2) -> Option<DerivativeBounds> {
        Some(self.bounds(lo, hi))
    }

    fn is_bicubic(&self) -> bool {
        true
    }

    fn breaks(&self, axis: usize, lo: f64, hi: f64) -> Vec<f64> {
        self.knots()[axis].breaks(lo, hi)
    }
}

impl HeightRow for BicubicSplineRow<'_> {
    #[inline]
    fn at(&self, x: f64) -> HeightAndSlope {
        let (f, slope) = self.value_and_slope(x);
        HeightAndSlope { f, slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::GridAxis;
    use crate::num::sample::Draws;
    use crate::num::{cos, sin};

    fn grid(x: GridAxis, y: GridAxis, f: impl Fn(DVec2) -> f64) -> BicubicSpline {
        let node = |k: usize| f(DVec2::new(x.at(k % x.count), y.at(k / x.count)));
        let values: Vec<f64> = (0..x.count * y.count).map(node).collect();
        BicubicSpline::new(x, y, &values).unwrap()
    }

    fn knots(first: f64, last: f64, count: usize) -> GridAxis {
        GridAxis { first_mm: first, step_mm: (last - first) / (count - 1) as f64, count }
    }

    fn rough(seed: u64) -> BicubicSpline {
        let mut r = Draws::new(seed);
        let values: Vec<f64> = (0..63).map(|_| r.inside([-1.0, 1.0])).collect();
        BicubicSpline::new(knots(-3.0, 2.0, 9), knots(1.0, 4.0, 7), &values).unwrap()
    }

    #[test]
    fn bicubics_are_given_back() {
        let f = |q: DVec2| {
            let (x, y) = (q.x, q.y);
            (1.0 + x * (0.5 - x * (0.3 + 0.2 * x))) * (0.7 - y * (0.2 + y * (0.4 - 0.1 * y)))
        };
        let mut r = Draws::new(5);
        for (nx, ny) in [(4, 4), (5, 9), (40, 7)] {
            let patches = grid(knots(-1.0, 2.0, nx), knots(-2.0, 1.0, ny), f);
            for _ in 0..200 {
                let q = DVec2::new(r.inside([-1.2, 2.2]), r.inside([-2.2, 1.2]));
                let HeightAndSlope { f: found, slope } = patches.at(q);
                assert!((found - f(q)).abs() < 1e-13, "{nx} {q}: {found} {}", f(q));
                let (x, y) = (q.x, q.y);
                let (g, h) =
                    (1.0 + x * (0.5 - x * (0.3 + 0.2 * x)), 0.7 - y * (0.2 + y * (0.4 - 0.1 * y)));
                let (g1, h1) = (0.5 - x * (0.6 + 0.6 * x), -0.2 - y * (0.8 - 0.3 * y));
                let (g2, h2) = (-0.6 - 1.2 * x, -0.8 + 0.6 * y);
                assert!((slope - DVec2::new(g1 * h, g * h1)).length() < 1e-12);
                let c = patches.hessian(q);
                let off = (c.xx - g2 * h).abs() + (c.xy - g1 * h1).abs() + (c.yy - g * h2).abs();
                assert!(off < 1e-10, "{off}");
            }
        }
    }

    #[test]
    fn the_hessian_goes_through_the_knots() {
        let patches = rough(1);
        let [x, y] = patches.knots();
        let mut r = Draws::new(2);
        for k in 1..x.count - 1 {
            let e = 1e-9;
            let (a, b) = (x.at(k), r.inside([y.first_mm, y.last_mm()]));
            let (c, d) = (r.inside([x.first_mm, x.last_mm()]), y.at(k.min(y.count - 2)));
            for (before, after) in [
                (DVec2::new(a - e, b), DVec2::new(a + e, b)),
                (DVec2::new(c, d - e), DVec2::new(c, d + e)),
            ] {
                let (l, r) = (patches.hessian(before), patches.hessian(after));
                let jump = (l.xx - r.xx).abs() + (l.xy - r.xy).abs() + (l.yy - r.yy).abs();
                assert!(jump < 1e-6, "{jump}");
            }
        }
    }

    #[test]
    fn sag_converges_at_fourth_order() {
        let f = |q: DVec2| sin(1.3 * q.x + 0.2) * cos(0.9 * q.y);
        let error = |n: usize| {
            let patches = grid(knots(-1.0, 2.0, n + 1), knots(-1.0, 1.0, n + 1), f);
            let at = |k: usize| {
                DVec2::new(
                    -1.0 + 3.0 * (k % 101) as f64 / 100.0,
                    -1.0 + 2.0 * (k / 101) as f64 / 100.0,
                )
            };
            (0..101 * 101).map(|k| (patches.at(at(k)).f - f(at(k))).abs()).fold(0.0, f64::max)
        };
        let ratio = error(20) / error(40);
        assert!((11.0..30.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn bounds_hold_and_are_tight() {
        for seed in 0..20 {
            let patches = rough(seed);
            let mut r = Draws::new(100 + seed);
            for _ in 0..20 {
                let ([x0, x1], [y0, y1]) = (r.range([-3.1, 2.1]), r.range([0.9, 4.1]));
                let (lo, hi) = (DVec2::new(x0, y0), DVec2::new(x1, y1));
                let bounds = patches.bounds(lo, hi);
                for _ in 0..50 {
                    let q = DVec2::new(r.inside([x0, x1]), r.inside([y0, y1]));
                    let (p, c) = (patches.at(q), patches.hessian(q));
                    assert!(bounds.f.contains(p.f), "{:?} {}", bounds.f, p.f);
                    assert!(
                        bounds.slope[0].contains(p.slope.x) && bounds.slope[1].contains(p.slope.y)
                    );
                    for (range, x) in bounds.hessian.iter().zip([c.xx, c.xy, c.yy]) {
                        assert!(range.contains(x), "{range:?} {x}");
                    }
                    // The third derivatives are constant along their own axis on a patch.
                    let e = DVec2::new(1e-4, 0.0);
                    let inside = |q: DVec2| lo.cmple(q).all() && q.cmple(hi).all();
                    let same = |q: DVec2| patches.knots()[0].interval(q.x).0;
                    if inside(q - e) && inside(q + e) && same(q - e) == same(q + e) {
                        let (a, b) = (patches.hessian(q + e), patches.hessian(q - e));
                        for (range, d) in
                            bounds.third.iter().zip([a.xx - b.xx, a.xy - b.xy, a.yy - b.yy])
                        {
                            let d = d / 2e-4;
                            assert!(range.lo - 1e-6 <= d && d <= range.hi + 1e-6, "{range:?} {d}");
                        }
                    }
                }
            }
            // A point's bounds are no wider than a share of the patch makes them.
            let q = DVec2::new(-0.3, 2.2);
            let width = patches.bounds(q, q).slope[0].width();
            let c = patches.hessian(q);
            assert!(width < 0.1 * (c.norm() + 1.0), "{width}");
        }
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        let k = knots(0.0, 1.0, 4);
        assert!(BicubicSpline::new(k, k, &[0.0; 16]).is_some());
        assert!(BicubicSpline::new(k, k, &[0.0; 15]).is_none());
        assert!(BicubicSpline::new(k, k, &[f64::NAN; 16]).is_none());
        assert!(BicubicSpline::new(knots(0.0, 1.0, 3), k, &[0.0; 12]).is_none());
        assert!(BicubicSpline::new(knots(1.0, 0.0, 4), k, &[0.0; 16]).is_none());
    }

    #[test]
    fn a_reflection_is_the_spline_at_reflected_places() {
        let patches = rough(7);
        for (axis, sign) in [DVec2::new(-1.0, 1.0), DVec2::new(1.0, -1.0)].into_iter().enumerate() {
            let reflected = patches.reflected(axis);
            for q in [DVec2::new(-2.3, 1.4), DVec2::new(0.1, 2.6), DVec2::new(1.9, 3.9)] {
                let (there, here) = (reflected.at(sign * q), patches.at(q));
                assert!((there.f - here.f).abs() < 1e-12, "{axis} {q}");
                assert!((there.slope - sign * here.slope).length() < 1e-12, "{axis} {q}");
                let (there, here) = (reflected.hessian(sign * q), patches.hessian(q));
                let off = [there.xx - here.xx, there.xy + here.xy, there.yy - here.yy];
                assert!(off.into_iter().all(|x| x.abs() < 1e-11), "{axis} {q}: {off:?}");
            }
        }
    }

    #[test]
    fn third_derivatives_of_a_patch_are_those_of_its_bounds() {
        let patches = rough(13);
        let [x, y] = patches.knots();
        for (i, j) in (0..x.count - 1).flat_map(|i| (0..y.count - 1).map(move |j| (i, j))) {
            let (lo, hi) = (DVec2::new(x.at(i), y.at(j)), DVec2::new(x.at(i + 1), y.at(j + 1)));
            let inside = 1e-6 * (hi - lo);
            let whole = patches.bounds(lo + inside, hi - inside).third;
            for (a, b) in patches.third_of_patch(i, j).into_iter().zip(whole) {
                let off = (a.lo - b.lo).abs().max((a.hi - b.hi).abs());
                assert!(off <= 1e-10 * (1.0 + a.magnitude()), "{i} {j}: {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn ends_go_on_smoothly_and_leave_the_grid_as_it_is() {
        let patches = rough(11);
        let [x, y] = patches.knots();
        let wide = patches.with_ends(2, [3, 2]);
        let (mut r, step) = (Draws::new(12), 1e-8);
        let edge = x.last_mm() + x.step_mm;
        for _ in 0..200 {
            // As far as one step beyond the grid.
            let q = DVec2::new(
                r.inside([x.first_mm - x.step_mm, edge]),
                r.inside([y.first_mm - y.step_mm, y.last_mm() + y.step_mm]),
            );
            assert!((wide.at(q).f - patches.at(q).f).abs() < 1e-12, "{q}");
            // Over two steps with the second derivative there, and from there on linear.
            let HeightAndSlope { f, slope } = patches.at(q.with_x(edge));
            let bend = patches.hessian(q.with_x(edge)).xx;
            let far = r.inside([0.0, 2.0]) * x.step_mm;
            let there = wide.at(q.with_x(edge + far));
            assert!((there.f - f - far * (slope.x + 0.5 * far * bend)).abs() < 1e-10, "{q} {far}");
            assert!((there.slope.x - slope.x - far * bend).abs() < 1e-10);
            let last = wide.at(q.with_x(edge + 2.0 * x.step_mm));
            let beyond = wide.at(q.with_x(edge + 2.0 * x.step_mm + far));
            assert!((beyond.f - last.f - far * last.slope.x).abs() < 1e-9, "{q} {far}");
            // No second derivative jumps along the upper edge, nor at the corner.
            let corner = DVec2::new(edge + far, y.last_mm() + y.step_mm);
            let (below, above) =
                (wide.hessian(corner - step * DVec2::Y), wide.hessian(corner + step * DVec2::Y));
            let jump = [below.xx - above.xx, below.xy - above.xy, below.yy - above.yy];
            let size = 1.0 + below.norm();
            assert!(jump.into_iter().all(|jump| jump.abs() < 1e-5 * size), "{corner} {jump:?}");
        }
    }
}
