//! Exact first and second derivatives in two variables.

use super::plane_inverse;
use super::scalar::{Arithmetic, Base, PlaneFn, Scalar, SmoothFn};
use super::special::{AtanOverRoot, Ln1pOverX, OneMinusExpOverX, TanOverRoot};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A function's value, gradient and Hessian at a point (over [`f64`]), or bounds of them over a
/// box (over [`Interval`](super::Interval)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet2<T> {
    /// f.
    pub value: T,
    /// (f_x, f_y).
    pub gradient: [T; 2],
    /// (f_xx, f_xy, f_yy).
    pub hessian: [T; 3],
}

impl<T: Base> Jet2<T> {
    /// The variable x.
    #[must_use]
    pub fn variable_x(x: T) -> Self {
        Self { gradient: [T::constant(1.0), T::constant(0.0)], ..Self::flat(x) }
    }

    /// The variable y.
    #[must_use]
    pub fn variable_y(y: T) -> Self {
        Self { gradient: [T::constant(0.0), T::constant(1.0)], ..Self::flat(y) }
    }

    /// f, (f_x, f_y) and (f_xx, f_xy, f_yy).
    #[must_use]
    pub fn from_parts(value: T, gradient: [T; 2], hessian: [T; 3]) -> Self {
        Self { value, gradient, hessian }
    }

    /// A number that depends on neither variable.
    #[must_use]
    pub fn flat(value: T) -> Self {
        let zero = T::constant(0.0);
        Self { value, gradient: [zero; 2], hessian: [zero; 3] }
    }

    /// Chain rule: f of this, from f, f' and f'' at its value.
    #[inline]
    #[must_use]
    pub fn chain(self, [f, d, dd]: [T; 3]) -> Self {
        let [x, y] = self.gradient;
        let [xx, xy, yy] = self.hessian;
        Self {
            value: f,
            gradient: [d * x, d * y],
            hessian: [dd * x.square() + d * xx, dd * (x * y) + d * xy, dd * y.square() + d * yy],
        }
    }

    /// Every part through `f`.
    #[inline]
    fn each(self, f: impl Fn(T) -> T) -> Self {
        Self {
            value: f(self.value),
            gradient: self.gradient.map(&f),
            hessian: self.hessian.map(&f),
        }
    }

    /// Every part with its counterpart through `f`.
    #[inline]
    fn both(self, b: Self, f: impl Fn(T, T) -> T) -> Self {
        Self {
            value: f(self.value, b.value),
            gradient: std::array::from_fn(|k| f(self.gradient[k], b.gradient[k])),
            hessian: std::array::from_fn(|k| f(self.hessian[k], b.hessian[k])),
        }
    }
}

impl<T: Base> Neg for Jet2<T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.each(|p| -p)
    }
}

impl<T: Base> Add for Jet2<T> {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        self.both(b, |p, q| p + q)
    }
}

impl<T: Base> Sub for Jet2<T> {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        self.both(b, |p, q| p - q)
    }
}

impl<T: Base> Mul for Jet2<T> {
    type Output = Self;
    #[inline]
    fn mul(self, b: Self) -> Self {
        let (f, g) = (self.value, b.value);
        let ([fx, fy], [gx, gy]) = (self.gradient, b.gradient);
        let ([fxx, fxy, fyy], [gxx, gxy, gyy]) = (self.hessian, b.hessian);
        Self {
            value: f * g,
            gradient: [fx * g + f * gx, fy * g + f * gy],
            hessian: [
                fxx * g + fx * gx * 2.0 + f * gxx,
                fxy * g + (fx * gy + fy * gx) + f * gxy,
                fyy * g + fy * gy * 2.0 + f * gyy,
            ],
        }
    }
}

impl<T: Base> Div for Jet2<T> {
    type Output = Self;
    #[inline]
    fn div(self, b: Self) -> Self {
        // Derivatives of q b = a. (Products take less time than quotients.)
        let (q, g) = (self.value / b.value, T::constant(1.0) / b.value);
        let ([ax, ay], [bx, by]) = (self.gradient, b.gradient);
        let ([axx, axy, ayy], [bxx, bxy, byy]) = (self.hessian, b.hessian);
        let (qx, qy) = ((ax - q * bx) * g, (ay - q * by) * g);
        Self {
            value: q,
            gradient: [qx, qy],
            hessian: [
                (axx - qx * bx * 2.0 - q * bxx) * g,
                (axy - (qx * by + qy * bx) - q * bxy) * g,
                (ayy - qy * by * 2.0 - q * byy) * g,
            ],
        }
    }
}

impl<T: Base> Add<f64> for Jet2<T> {
    type Output = Self;
    #[inline]
    fn add(self, b: f64) -> Self {
        Self { value: self.value + b, ..self }
    }
}

impl<T: Base> Sub<f64> for Jet2<T> {
    type Output = Self;
    #[inline]
    fn sub(self, b: f64) -> Self {
        Self { value: self.value - b, ..self }
    }
}

impl<T: Base> Mul<f64> for Jet2<T> {
    type Output = Self;
    #[inline]
    fn mul(self, b: f64) -> Self {
        self.each(|p| p * b)
    }
}

impl<T: Base> Div<f64> for Jet2<T> {
    type Output = Self;
    #[inline]
    fn div(self, b: f64) -> Self {
        self.each(|p| p / b)
    }
}

impl<T: Base> Arithmetic for Jet2<T> {
    #[inline]
    fn constant(x: f64) -> Self {
        Self::flat(T::constant(x))
    }
}

impl<T: Base> Scalar for Jet2<T> {
    #[inline]
    fn mid(self) -> f64 {
        self.value.mid()
    }
    #[inline]
    fn square(self) -> Self {
        let v = self.value;
        self.chain([v.square(), v * 2.0, T::constant(2.0)])
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let d = T::constant(0.5) / root;
        self.chain([root, d, -d / (self.value * 2.0)])
    }
    fn exp(self) -> Self {
        self.chain([self.value.exp(); 3])
    }
    fn log(self) -> Self {
        let d = T::constant(1.0) / self.value;
        self.chain([self.value.log(), d, -d.square()])
    }
    fn sin(self) -> Self {
        let (s, c) = (self.value.sin(), self.value.cos());
        self.chain([s, c, -s])
    }
    fn cos(self) -> Self {
        let (s, c) = (self.value.sin(), self.value.cos());
        self.chain([c, -s, -c])
    }
    fn tan(self) -> Self {
        let t = self.value.tan();
        let d = t.square() + 1.0;
        self.chain([t, d, t * d * 2.0])
    }
    fn atan(self) -> Self {
        let d = T::constant(1.0) / (self.value.square() + 1.0);
        self.chain([self.value.atan(), d, self.value * d.square() * -2.0])
    }
    fn atan2(self, x: Self) -> Self {
        let (v, u) = (self, x);
        let squared = u.value.square() + v.value.square();
        let (c, s) = (u.value / squared, v.value / squared);
        let (bend, twist) = (c * s * 2.0, s.square() - c.square());
        // Indices of the two first derivatives that make each second one.
        let second = |k: usize, i: usize, j: usize| {
            let ([ui, uj], [vi, vj]) =
                ([u.gradient[i], u.gradient[j]], [v.gradient[i], v.gradient[j]]);
            c * v.hessian[k] - s * u.hessian[k]
                + bend * (ui * uj - vi * vj)
                + twist * (ui * vj + uj * vi)
        };
        Self {
            value: v.value.atan2(u.value),
            gradient: std::array::from_fn(|i| c * v.gradient[i] - s * u.gradient[i]),
            hessian: [second(0, 0, 0), second(1, 0, 1), second(2, 1, 1)],
        }
    }
    fn one_minus_exp_over_x(self) -> Self {
        self.map(&OneMinusExpOverX)
    }
    fn ln_1p_over_x(self) -> Self {
        self.map(&Ln1pOverX)
    }
    fn tan_over_root(self) -> Self {
        self.map(&TanOverRoot)
    }
    fn atan_over_root(self) -> Self {
        self.map(&AtanOverRoot)
    }
    fn map(self, curve: &impl SmoothFn) -> Self {
        self.chain(self.value.curve(curve))
    }
    fn of_plane(x: Self, y: Self, f: &impl PlaneFn) -> Self {
        let [value, fx, fy, fxx, fxy, fyy] = T::plane(x.value, y.value, f);
        // Indices of the two first derivatives that make each second one.
        let second = |k: usize, i: usize, j: usize| {
            let ([xi, xj], [yi, yj]) =
                ([x.gradient[i], x.gradient[j]], [y.gradient[i], y.gradient[j]]);
            let square = if i == j {
                fxx * xi.square() + fxy * (xi * yi) * 2.0 + fyy * yi.square()
            } else {
                fxx * (xi * xj) + fxy * (xi * yj + xj * yi) + fyy * (yi * yj)
            };
            square + fx * x.hessian[k] + fy * y.hessian[k]
        };
        Self {
            value,
            gradient: std::array::from_fn(|i| fx * x.gradient[i] + fy * y.gradient[i]),
            hessian: [second(0, 0, 0), second(1, 0, 1), second(2, 1, 1)],
        }
    }
    fn invert_plane(
        map: &[impl PlaneFn; 2],
        scale: f64,
        value: [Self; 2],
        near: [f64; 2],
    ) -> [Self; 2] {
        let at = T::invert_plane(map, scale, value.map(|v| v.value), near);
        let parts = [0, 1].map(|k: usize| T::plane(at[0], at[1], &map[k]));
        let inverse =
            plane_inverse::inverse(parts.map(|[_, along_x, along_y, ..]| [along_x, along_y]));
        let carried = |[a, b]: [T; 2]| inverse.map(|[p, q]| p * a + q * b);
        let [x, y] = value;
        // By the variable i, both coordinates of the point.
        let first = [0, 1].map(|i: usize| carried([x.gradient[i], y.gradient[i]]));
        // F' q'' = value'' - F''(q', q').
        let second = [(0, 0, 0), (1, 0, 1), (2, 1, 1)].map(|(k, i, j): (usize, usize, usize)| {
            let bend = parts.map(|[_, _, _, xx, xy, yy]| {
                let ([ui, vi], [uj, vj]) = (first[i], first[j]);
                xx * (ui * uj) + xy * (ui * vj + vi * uj) + yy * (vi * vj)
            });
            carried([x.hessian[k] - bend[0], y.hessian[k] - bend[1]])
        });
        [0, 1].map(|k: usize| Self {
            value: at[k],
            gradient: first.map(|by| by[k]),
            hessian: second.map(|by| by[k]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::Interval;
    use crate::num::sample::Draws;

    fn parts<T: Base>(j: Jet2<T>) -> [T; 6] {
        let ([x, y], [xx, xy, yy]) = (j.gradient, j.hessian);
        [j.value, x, y, xx, xy, yy]
    }

    /// Formulas over x, y in (-1, 1), by number; each function of `Scalar` has one.
    fn formula<S: Scalar>(k: usize, x: S, y: S) -> S {
        // Between 0.1 and 2.4, and bent.
        let p = x * x + y.square() * 0.3 + x * y * 0.2 + 0.15;
        match k {
            0 => p.square() - x * 3.0 + 1.0,
            1 => p.sqrt(),
            2 => (x * 2.0 - y * p).exp(),
            3 => p.log(),
            4 => (x * 3.0 + y * y).sin(),
            5 => (x * 3.0 - y * x).cos(),
            6 => (p * 0.6).tan(),
            7 => (x - y * 2.0).atan(),
            8 => (y - 0.3).atan2(x + 1.2),
            9 => (x + y * x).one_minus_exp_over_x(),
            10 => (x * 0.4 + y * 0.4).ln_1p_over_x(),
            11 => (p - 0.3).tan_over_root(),
            12 => (p - 0.3).atan_over_root(),
            13 => x / (p + y.square()) - (y - 2.0) / 7.0,
            14 => -(x + 2.0).log() * ((y * 2.0).sin() + 1.5).sqrt() / (x * y + 2.0),
            15 => {
                (x.one_minus_exp_over_x() * y.exp()).atan2(x.sin() - y)
                    + (x * x + y * y).tan_over_root().log()
            }
            16 => S::constant(2.0) * (x * y).map(&crate::num::special::OneMinusExpOverX),
            17 => (y * 4.0 + 5.0).ln_1p_over_x() + (x * 0.1 + 2.0).atan_over_root(),
            _ => (x * 0.4 + 1.1).tan_over_root() - (y * 2.0 + 3.5).one_minus_exp_over_x(),
        }
    }
    const FORMULAS: usize = 19;

    fn jet(k: usize, x: f64, y: f64) -> [f64; 6] {
        parts(formula(k, Jet2::variable_x(x), Jet2::variable_y(y)))
    }

    #[test]
    fn jets_agree_with_differences() {
        const H: f64 = 1e-4;
        for k in 0..FORMULAS {
            for mut r in (0..200).map(Draws::new) {
                let (x, y) = (r.inside([-0.9, 0.9]), r.inside([-0.9, 0.9]));
                let found = jet(k, x, y);
                // The value by plain numbers, the gradient by differences of it, the Hessian by
                // differences of the gradient.
                let plain = |i: f64, j: f64| formula::<f64>(k, x + i, y + j);
                let slope = |m: usize, i: f64, j: f64| {
                    (jet(k, x + i, y + j)[m] - jet(k, x - i, y - j)[m]) / (2.0 * H)
                };
                let expected = [
                    plain(0.0, 0.0),
                    (plain(H, 0.0) - plain(-H, 0.0)) / (2.0 * H),
                    (plain(0.0, H) - plain(0.0, -H)) / (2.0 * H),
                    slope(1, H, 0.0),
                    slope(1, 0.0, H),
                    slope(2, 0.0, H),
                ];
                let size = found.iter().fold(1.0, |m: f64, p| m.max(p.abs()));
                for m in 0..6 {
                    let tolerance = if m == 0 { 1e-14 } else { 3e-5 } * size * size;
                    let error = (found[m] - expected[m]).abs();
                    assert!(error < tolerance, "formula {k}, part {m}, at {x} {y}: {error:e}");
                }
                let mirrored = slope(2, H, 0.0);
                assert!((mirrored - found[4]).abs() < 3e-5 * size * size, "formula {k}");
            }
        }
    }

    #[test]
    fn bounds_over_a_box_hold_the_jets_inside() {
        for k in 0..FORMULAS {
            for mut r in (0..1500).map(Draws::new) {
                let (xs, ys) = (r.range([-1.0, 1.0]), r.range([-1.0, 1.0]));
                let [x, y] = [xs, ys].map(|[lo, hi]| Interval::new(lo, hi));
                let over = parts(formula(k, Jet2::variable_x(x), Jet2::variable_y(y)));
                for _ in 0..6 {
                    let found = jet(k, r.inside(xs), r.inside(ys));
                    for m in 0..6 {
                        let holds = over[m].contains(found[m]);
                        assert!(holds, "formula {k}, part {m}: {} {:?}", found[m], over[m]);
                    }
                }
                let plain = formula(k, x, y);
                assert!(plain.contains(formula(k, r.inside(xs), r.inside(ys))));
            }
        }
    }

    #[test]
    fn bounds_close_in_with_the_box() {
        for k in 0..FORMULAS {
            for mut r in (0..50).map(Draws::new) {
                let (x, y) = (r.inside([-0.9, 0.9]), r.inside([-0.9, 0.9]));
                let [x, y] = [x, y].map(|c| Interval::around(c, 1e-7));
                let over = parts(formula(k, Jet2::variable_x(x), Jet2::variable_y(y)));
                let size = over.iter().fold(1.0, |m: f64, p| m.max(p.magnitude()));
                for (m, part) in over.iter().enumerate() {
                    let width = part.width();
                    assert!(width < 1e-5 * size * size, "formula {k}, part {m}: {width:e}");
                }
            }
        }
    }

    #[test]
    fn known_derivatives() {
        let (x, y) = (Jet2::variable_x(0.5), Jet2::variable_y(-2.0));
        assert_eq!(parts(x * y * y), [2.0, 4.0, -2.0, 0.0, -4.0, 1.0]);
        assert_eq!(parts(x / y), [-0.25, -0.5, -0.125, 0.0, -0.25, -0.125]);
        assert_eq!(parts(x.square()), [0.25, 1.0, 0.0, 2.0, 0.0, 0.0]);
        let root = parts((x + 3.5).sqrt());
        assert_eq!(root, [2.0, 0.25, 0.0, -1.0 / 32.0, 0.0, 0.0]);
        let same = Jet2::from_parts(0.5, [1.0, 0.0], [0.0; 3]);
        assert_eq!(same, x);
    }
}
