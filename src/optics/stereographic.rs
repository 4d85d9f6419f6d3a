//! Directions as stereographic coordinates, where reflection is rational.
//!
//! A unit direction U is sigma = (U_x, U_y) / (1 + U_z), a complex number: 0 looks up the axis,
//! |sigma| = 1 at the horizon, infinite straight down; |sigma| = tan(psi / 2) = exp(-m) for the
//! polar angle psi and the isometric latitude m (tan(elevation) = sinh m). Reflection turns the
//! direction to the camera by half a turn about the normal, which in these coordinates is a Moebius
//! map (docs/theory.md, T6); under a vertical ray it is sigma = -slope (T7). No form here cancels
//! near either pole.

use crate::geom::DVec3;
use crate::num::{Arithmetic, Lanes, Scalar};

#[inline(always)]
fn add<S: Arithmetic>(a: [S; 2], b: [S; 2]) -> [S; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
fn times<S: Arithmetic>(a: [S; 2], b: [S; 2]) -> [S; 2] {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

#[inline(always)]
fn conjugate<S: Arithmetic>(a: [S; 2]) -> [S; 2] {
    [a[0], -a[1]]
}

/// |a|^2.
#[inline]
pub fn norm_squared<S: Scalar>(a: [S; 2]) -> S {
    a[0].square() + a[1].square()
}

/// The direction to the camera from a point whose ray makes the angle with tangent `view` to the
/// axis.
#[inline]
pub fn towards_camera<S: Scalar>(view: [S; 2]) -> [S; 2] {
    let half = (norm_squared(view) + 1.0).sqrt() + 1.0;
    view.map(|v| -v / half)
}

/// The direction seen in a surface of slope `p` = (Z_X, Z_Y) from a camera in direction `camera`:
/// -(p + camera) / (1 - conj(p) camera).
#[inline]
pub fn reflect<S: Scalar>(camera: [S; 2], p: [S; 2]) -> [S; 2] {
    let above = add(p, camera);
    let product = times(conjugate(p), camera);
    let below = [-product[0] + 1.0, -product[1]];
    let size = norm_squared(below);
    times(above, conjugate(below)).map(|x| -x / size)
}

/// The slope that shows a camera in direction `camera` the direction `seen`: the solution p of
/// [`reflect`]. Infinite where the two directions are opposite: no mirror does that.
#[inline]
pub fn slope_between<S: Scalar>(camera: [S; 2], seen: [S; 2]) -> [S; 2] {
    let product = times(camera, seen);
    let sum = add(camera, seen);
    let turned = times(product, conjugate(sum));
    let size = -norm_squared(product) + 1.0;
    [-(sum[0] + turned[0]) / size, -(sum[1] + turned[1]) / size]
}

/// The unit vector of `sigma`.
#[inline]
pub fn unit<S: Scalar>(sigma: [S; 2]) -> [S; 3] {
    let w = norm_squared(sigma);
    let size = w + 1.0;
    [sigma[0] * 2.0 / size, sigma[1] * 2.0 / size, S::constant(2.0) / size - 1.0]
}

/// A vector of length (1 + |sigma|^2) / 2 in direction `sigma`: without a division, which would
/// widen intervals.
#[inline]
pub fn vector<S: Scalar>(sigma: [S; 2]) -> [S; 3] {
    [sigma[0], sigma[1], (-norm_squared(sigma) + 1.0) * 0.5]
}

/// sigma of a vector of any length.
#[inline]
pub fn sigma<S: Scalar>(v: [S; 3]) -> [S; 2] {
    let across = norm_squared([v[0], v[1]]);
    let length = (across + v[2].square()).sqrt();
    if v[2].mid() >= 0.0 {
        let below = length + v[2];
        [v[0] / below, v[1] / below]
    } else {
        // 1 / (length + z) = (length - z) / across: no cancellation below the horizon.
        let above = (length - v[2]) / across;
        [v[0] * above, v[1] * above]
    }
}

/// The unit vector of `sigma`, for plain numbers.
#[inline]
#[must_use]
pub fn direction(sigma: [f64; 2]) -> DVec3 {
    DVec3::from_array(unit(sigma))
}

/// Steps in isometric latitude and azimuth (from Y towards X), radians, from directions to others near them: the logarithm
/// of their quotient by its series (docs/theory.md, T125), to rounding of the steps. None where two of them are some
/// 1 / 32 radian or more apart.
#[inline(always)]
#[must_use]
pub fn step_between<const L: usize>(
    from: [Lanes<L>; 2],
    to: [Lanes<L>; 2],
) -> Option<[Lanes<L>; 2]> {
    /// With it the sixth term is below a rounding of the first.
    const NEAR: f64 = 1.0 / 4096.0;
    const TERMS: [f64; 5] = [1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0, 1.0];
    let size = |[x, y]: [Lanes<L>; 2]| x * x + y * y;
    let (way, sum) = ([to[0] - from[0], to[1] - from[1]], add(from, to));
    let per = Lanes::constant(1.0) / size(sum);
    let u = times(way, conjugate(sum)).map(|x| x * per);
    let square = times(u, u);
    let first = [Lanes::constant(TERMS[0]), Lanes::constant(0.0)];
    let rest = TERMS[1..].iter().fold(first, |rest, term| {
        let [x, y] = times(square, rest);
        [x + *term, y]
    });
    let is_near = size(u).0.iter().all(|size| *size < NEAR);
    is_near.then(|| times(u, rest).map(|x| x * -2.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec2;
    use crate::optics::reflect as by_law;

    const SLOPES: [[f64; 2]; 5] =
        [[0.3, -1.7], [0.0, 0.0], [-5.0, 40.0], [1e-7, 2e-3], [-0.6, -0.4]];

    #[test]
    fn reflection_is_that_of_the_vector_law() {
        for p in SLOPES {
            for view in [[0.0, 0.0], [0.4, -0.1], [-1.5, 2.0], [1e-9, 0.0]] {
                let ray = DVec2::from_array(view).extend(-1.0).normalize();
                let normal = DVec3::new(-p[0], -p[1], 1.0);
                if normal.dot(ray) >= 0.0 {
                    continue;
                }
                let camera = towards_camera(view);
                assert!((direction(camera) + ray).length() < 1e-15);
                let seen = reflect(camera, p);
                assert!((direction(seen) - by_law(ray, normal)).length() < 2e-15, "{p:?} {view:?}");
                let back = DVec2::from_array(slope_between(camera, seen));
                let p = DVec2::from_array(p);
                assert!((back - p).length() < 1e-13 * (1.0 + p.length()), "{p} {back}");
            }
        }
    }

    #[test]
    fn sigma_undoes_unit_without_loss_near_both_poles() {
        for size in [1e-8, 1e-3, 1.0, 1146.0, 1e7] {
            let exact = [0.6 * size, -0.8 * size];
            let back = sigma(unit(exact));
            // Below the horizon the unit vector itself has lost digits of 1 + U_z, not of U_xy.
            let off = DVec2::from_array(back).distance(DVec2::from_array(exact));
            assert!(off < 4e-16 * size, "{size}: {off}");
        }
    }
}
