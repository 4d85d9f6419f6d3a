//! The inverse of a map of the plane by Newton's method; `Interval` has its proof.

use super::scalar::{Arithmetic, PlaneFn};

/// Most steps, halved ones included: quadratic convergence takes three from a pixel away.
const MOST_STEPS: usize = 60;
/// Largest step, as a share of the point, that rounding alone may make.
pub(super) const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// The point near `near` that `map` carries to `value`; not finite where Newton's method finds none.
pub(super) fn at(map: &[impl PlaneFn; 2], scale: f64, value: [f64; 2], near: [f64; 2]) -> [f64; 2] {
    let (mut from, mut step, mut last) = (near, [0.0; 2], f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let at = [from[0] + step[0], from[1] + step[1]];
        let [[f, p, q], [g, r, s]] = [0, 1].map(|k: usize| map[k].first(at));
        let off = [f - value[0], g - value[1]];
        let taken = largest(step);
        let size = largest(at) + scale;
        let settled = ROUNDING * size;
        let residual = off[0] * off[0] + off[1] * off[1];
        if !(residual <= last) && taken > settled {
            // Not there, or too far: half the way.
            step = step.map(|s| 0.5 * s);
            continue;
        }
        (from, last) = (at, residual);
        step = inverse([[p, q], [r, s]]).map(|[a, b]| -(a * off[0] + b * off[1]));
        let next = largest(step);
        if !next.is_finite() {
            break;
        }
        // By quadratic convergence; the first step has none before it.
        let after = next * (next / taken) * (next / taken);
        let is_last = taken > 0.0 && after <= f64::EPSILON * size;
        if next <= settled || is_last {
            return [at[0] + step[0], at[1] + step[1]];
        }
    }
    [f64::NAN; 2]
}

fn largest(v: [f64; 2]) -> f64 {
    let [a, b] = v.map(f64::abs);
    // (Of a number and none it is none.)
    if a >= b || a.is_nan() { a } else { b }
}

/// The inverse of a matrix, by its rows.
#[inline]
pub(super) fn inverse<T: Arithmetic>([[p, q], [r, s]]: [[T; 2]; 2]) -> [[T; 2]; 2] {
    let per = T::constant(1.0) / (p * s - q * r);
    [[s * per, -(q * per)], [-(r * per), p * per]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;
    use crate::num::{Dual, Interval, Jet2, Scalar};

    /// x exp(y / 5), and 2 y - 0.3 x y.
    enum Bent {
        First,
        Second,
    }

    const MAP: [Bent; 2] = [Bent::First, Bent::Second];

    fn all<S: Scalar>(of: &Bent, [x, y]: [S; 2]) -> S {
        match of {
            Bent::First => x * (y / 5.0).exp(),
            Bent::Second => y * 2.0 - x * y * 0.3,
        }
    }

    fn jet<T: crate::num::Base>(of: &Bent, [x, y]: [T; 2]) -> [T; 6] {
        let Jet2 { value, gradient: [fx, fy], hessian: [xx, xy, yy] } =
            all(of, [Jet2::variable_x(x), Jet2::variable_y(y)]);
        [value, fx, fy, xx, xy, yy]
    }

    impl PlaneFn for Bent {
        fn first(&self, at: [f64; 2]) -> [f64; 3] {
            let [f, x, y, ..] = jet(self, at);
            [f, x, y]
        }
        fn second(&self, at: [f64; 2]) -> [f64; 3] {
            let [_, _, _, xx, xy, yy] = jet(self, at);
            [xx, xy, yy]
        }
        fn over(&self, ranges: [[f64; 2]; 2]) -> [[f64; 2]; 6] {
            let over = jet(self, ranges.map(|[lo, hi]| Interval::new(lo, hi)));
            over.map(|range| [range.lo, range.hi])
        }
    }

    fn point<S: Scalar>(a: S, b: S) -> [S; 2] {
        S::invert_plane(&MAP, 1.0, [a, b], [0.1, 0.0])
    }

    #[test]
    fn the_point_is_carried_to_the_values_and_has_their_derivatives() {
        const H: f64 = 1e-4;
        for mut r in (0..100).map(Draws::new) {
            let (a, b) = (r.inside([-0.8, 0.8]), r.inside([-0.5, 0.5]));
            let found = point(a, b);
            for (of, value) in MAP.iter().zip([a, b]) {
                assert!((all(of, found) - value).abs() < 4e-16);
            }
            let jets = |a: f64, b: f64| point(Jet2::variable_x(a), Jet2::variable_y(b));
            let duals = point(Dual::<2>::variable(a, 0), Dual::variable(b, 1));
            for k in 0..2 {
                let jet = jets(a, b)[k];
                assert_eq!((jet.value, duals[k].value), (found[k], found[k]));
                let by_a = (point(a + H, b)[k] - point(a - H, b)[k]) / (2.0 * H);
                let by_b = (point(a, b + H)[k] - point(a, b - H)[k]) / (2.0 * H);
                for (i, exact) in [by_a, by_b].into_iter().enumerate() {
                    assert!((jet.gradient[i] - exact).abs() < 1e-7);
                    assert!((duals[k].slope[i] - jet.gradient[i]).abs() < 1e-14);
                }
                let gradient = |a: f64, b: f64| jets(a, b)[k].gradient;
                let (ahead, behind) = (gradient(a + H, b), gradient(a - H, b));
                let (above, below) = (gradient(a, b + H), gradient(a, b - H));
                let second = [ahead[0] - behind[0], ahead[1] - behind[1], above[1] - below[1]];
                for (found, exact) in jet.hessian.into_iter().zip(second) {
                    assert!((found - exact / (2.0 * H)).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn a_box_holds_the_points_of_its_values() {
        let mut most = 0.0f64;
        for mut r in (0..200).map(Draws::new) {
            let [a, b] = [0, 1].map(|_| {
                let low = r.inside([-0.5, 0.4]);
                Interval::new(low, low + r.inside([0.0, 0.1]))
            });
            let bounds = point(Jet2::variable_x(a), Jet2::variable_y(b));
            for _ in 0..20 {
                let at = [a, b].map(|range| r.inside([range.lo, range.hi]));
                let found = point(Jet2::variable_x(at[0]), Jet2::variable_y(at[1]));
                for (bounds, found) in bounds.into_iter().zip(found) {
                    assert!(bounds.value.contains(found.value));
                    let pairs = bounds.gradient.into_iter().zip(found.gradient);
                    for (bound, found) in pairs.chain(bounds.hessian.into_iter().zip(found.hessian))
                    {
                        assert!(bound.contains(found), "{bound:?} {found}");
                    }
                }
            }
            most = most.max(bounds[0].value.width() / (a.width() + b.width()));
        }
        assert!(most < 4.0, "{most}");
    }

    #[test]
    fn a_value_that_is_nowhere_has_no_point() {
        struct Square;
        impl PlaneFn for Square {
            fn first(&self, [x, _]: [f64; 2]) -> [f64; 3] {
                [x * x, 2.0 * x, 0.0]
            }
            fn second(&self, _: [f64; 2]) -> [f64; 3] {
                [2.0, 0.0, 0.0]
            }
            fn over(&self, [[lo, hi], _]: [[f64; 2]; 2]) -> [[f64; 2]; 6] {
                let square = Interval::new(lo, hi).square();
                [
                    [square.lo, square.hi],
                    [2.0 * lo, 2.0 * hi],
                    [0.0; 2],
                    [2.0; 2],
                    [0.0; 2],
                    [0.0; 2],
                ]
            }
        }
        let map = [Square, Square];
        assert!(f64::invert_plane(&map, 1.0, [-1.0, 2.0], [0.3, 0.2])[0].is_nan());
        let values = [-1.0, 2.0].map(Interval::point);
        assert_eq!(Interval::invert_plane(&map, 1.0, values, [0.3, 0.2])[0], Interval::WHOLE);
        assert!(point(f64::NAN, 1.0)[0].is_nan());
    }
}
