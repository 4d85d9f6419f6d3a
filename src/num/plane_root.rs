//! Two equations for a point of the plane: Newton's method for numbers, and its proof for intervals.

use super::scalar::{Base, PlaneEquations, Scalar};
use super::{Arithmetic, Dual, Interval, Jet2};

/// Most steps, halved ones included: quadratic convergence takes three from a pixel away.
const MOST_STEPS: usize = 60;
/// Largest step, as a share of the point, that rounding alone may make.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Most boxes that are tried: each is the one before, enlarged by what its own derivatives ask for.
const MOST_BOXES: usize = 6;
/// Enlargement of a box over what the derivatives of the last one ask for.
const ROOM: f64 = 1.25;

/// The root near `near`; not finite where Newton's method finds none.
pub(super) fn at<const N: usize>(
    equations: &impl PlaneEquations<N>,
    parameters: [f64; N],
    near: [f64; 2],
) -> [f64; 2] {
    let parameters = parameters.map(Dual::<2>::constant);
    let (mut from, mut step, mut last) = (near, [0.0; 2], f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let at = [from[0] + step[0], from[1] + step[1]];
        let [a, b] =
            equations.residuals([Dual::variable(at[0], 0), Dual::variable(at[1], 1)], parameters);
        let taken = largest(step);
        let size = largest(at) + equations.scale();
        let settled = ROUNDING * size;
        let residual = a.value * a.value + b.value * b.value;
        if !(residual <= last) && taken > settled {
            // Not there, or too far: half the way.
            step = step.map(|s| 0.5 * s);
            continue;
        }
        (from, last) = (at, residual);
        let [[p, q], [r, s]] = [a.slope, b.slope];
        let determinant = p * s - q * r;
        step =
            [(q * b.value - s * a.value) / determinant, (r * a.value - p * b.value) / determinant];
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

/// The inverse of the residuals' derivatives by the point.
pub(super) fn inverse_jacobian<T: Base, const N: usize>(
    equations: &impl PlaneEquations<N>,
    at: [T; 2],
    parameters: [T; N],
) -> [[T; 2]; 2] {
    let point = [Jet2::variable_x(at[0]), Jet2::variable_y(at[1])];
    let [a, b] = equations.residuals(point, parameters.map(Jet2::flat));
    let ([p, q], [r, s]) = (a.gradient, b.gradient);
    let per = T::constant(1.0) / (p * s - q * r);
    [[s * per, -(q * per)], [-(r * per), p * per]]
}

/// A box that holds the root near `near` for each value of the parameters, and no other: the interval Newton method.
/// The whole plane where that is not proven.
pub(super) fn within<const N: usize>(
    equations: &impl PlaneEquations<N>,
    parameters: [Interval; N],
    near: [f64; 2],
) -> [Interval; 2] {
    let whole = [Interval::WHOLE; 2];
    let middles = parameters.map(Scalar::mid);
    let middle = at(equations, middles, near);
    if !middle.into_iter().all(f64::is_finite) {
        return whole;
    }
    let residuals = equations.residuals(middle.map(Interval::point), parameters);
    // What is to be taken from the middle, by the Jacobians of a box.
    let asked = |of: [Interval; 2]| {
        inverse_jacobian(equations, of, parameters)
            .map(|[a, b]| a * residuals[0] + b * residuals[1])
    };
    let mut tried = middle.map(Interval::point);
    for _ in 0..MOST_BOXES {
        let steps = asked(tried);
        if !steps.into_iter().all(Interval::is_finite) {
            return whole;
        }
        let found = [0, 1].map(|k| Interval::point(middle[k]) - steps[k]);
        let is_inside = |k: usize| tried[k].lo < found[k].lo && found[k].hi < tried[k].hi;
        if is_inside(0) && is_inside(1) {
            return found;
        }
        tried = [0, 1].map(|k| {
            let room = ROUNDING * (middle[k].abs() + steps[k].magnitude());
            Interval::around(middle[k], ROOM * steps[k].magnitude() + room + f64::MIN_POSITIVE)
        });
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;

    /// x + 0.1 y^2 = a exp(b), y - 0.2 x y = b + 0.1 a.
    struct Bent;

    impl PlaneEquations<2> for Bent {
        fn scale(&self) -> f64 {
            1.0
        }
        fn residuals<S: Scalar>(&self, [x, y]: [S; 2], [a, b]: [S; 2]) -> [S; 2] {
            [x + y.square() * 0.1 - a * b.exp(), y - x * y * 0.2 - b - a * 0.1]
        }
    }

    fn root<S: Scalar>(a: S, b: S) -> [S; 2] {
        S::solve_plane(&Bent, [a, b], [0.1, 0.0])
    }

    #[test]
    fn a_root_solves_the_equations_and_has_their_derivatives() {
        const H: f64 = 1e-4;
        for mut r in (0..100).map(Draws::new) {
            let (a, b) = (r.inside([-0.8, 0.8]), r.inside([-0.5, 0.5]));
            let found = root(a, b);
            let off = Bent.residuals(found, [a, b]);
            assert!(largest(off) < 4e-16, "{off:?}");
            let jets = root(Jet2::variable_x(a), Jet2::variable_y(b));
            let duals = root(Dual::<2>::variable(a, 0), Dual::variable(b, 1));
            let gradient = |a: f64, b: f64, k: usize| {
                root(Jet2::variable_x(a), Jet2::variable_y(b))[k].gradient
            };
            for k in 0..2 {
                assert_eq!((jets[k].value, duals[k].value), (found[k], found[k]));
                let by_a = (root(a + H, b)[k] - root(a - H, b)[k]) / (2.0 * H);
                let by_b = (root(a, b + H)[k] - root(a, b - H)[k]) / (2.0 * H);
                for (i, exact) in [by_a, by_b].into_iter().enumerate() {
                    assert!((jets[k].gradient[i] - exact).abs() < 1e-7);
                    assert!((duals[k].slope[i] - jets[k].gradient[i]).abs() < 1e-14);
                }
                let (ahead, behind) = (gradient(a + H, b, k), gradient(a - H, b, k));
                let (above, below) = (gradient(a, b + H, k), gradient(a, b - H, k));
                let second = [ahead[0] - behind[0], ahead[1] - behind[1], above[1] - below[1]];
                for (found, exact) in jets[k].hessian.into_iter().zip(second) {
                    assert!((found - exact / (2.0 * H)).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn a_box_holds_the_roots_of_its_parameters() {
        let mut most = 0.0f64;
        for mut r in (0..200).map(Draws::new) {
            let [a, b] = [0, 1].map(|_| {
                let low = r.inside([-0.5, 0.4]);
                Interval::new(low, low + r.inside([0.0, 0.1]))
            });
            let bounds = root(Jet2::variable_x(a), Jet2::variable_y(b));
            for _ in 0..20 {
                let at = [a, b].map(|range| r.inside([range.lo, range.hi]));
                let found = root(Jet2::variable_x(at[0]), Jet2::variable_y(at[1]));
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
    fn without_a_root_there_is_no_number() {
        struct Circle;
        impl PlaneEquations<1> for Circle {
            fn scale(&self) -> f64 {
                1.0
            }
            fn residuals<S: Scalar>(&self, [x, y]: [S; 2], [r]: [S; 1]) -> [S; 2] {
                [x.square() + y.square() - r, x - 2.0]
            }
        }
        assert!(f64::solve_plane(&Circle, [1.0], [0.3, 0.2])[0].is_nan());
        assert_eq!(
            Interval::solve_plane(&Circle, [Interval::point(1.0)], [0.3, 0.2])[0],
            Interval::WHOLE
        );
        assert_eq!(f64::solve_plane(&Circle, [4.25], [0.3, 0.2]), [2.0, 0.5]);
    }
}
