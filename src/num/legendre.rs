//! Tensor Legendre series: value, derivatives and integrals.
//!
//! A series is f(u, v) = sum of c_ij P_i(u) P_j(v) on the square [-1, 1]^2. Arguments a rounding
//! error outside the square are welcome; far outside it the terms grow without bound.

use super::{Arithmetic, Lanes};

/// Coefficients c_ij of a tensor Legendre series, `rows` of u-degree by `columns` of v-degree.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    rows: usize,
    columns: usize,
    coefficients: Vec<f64>,
}

/// Value, gradient and Hessian of a series at a point, in its own (u, v).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet {
    /// f.
    pub f: f64,
    /// (f_u, f_v).
    pub gradient: [f64; 2],
    /// (f_uu, f_uv, f_vv).
    pub hessian: [f64; 3],
}

impl Jet {
    /// One for each lane of (f, f_u, f_v).
    #[inline]
    fn each<const N: usize>(sums: [Lanes<N>; 3]) -> [Self; N] {
        let [f, f_u, f_v] = sums.map(|sum| sum.0);
        std::array::from_fn(|k| Self { f: f[k], gradient: [f_u[k], f_v[k]], hessian: [0.0; 3] })
    }
}

/// P_0(x) ... P_degree(x).
#[must_use]
pub fn values(degree: usize, x: f64) -> Vec<f64> {
    let mut p = Vec::with_capacity(degree + 1);
    p.push(1.0);
    for k in 0..degree {
        let before = if k == 0 { 0.0 } else { p[k - 1] };
        p.push(next(k, x, p[k], before));
    }
    p
}

/// P_0'(x) ... P_degree'(x), from the values.
#[must_use]
pub fn derivatives(values: &[f64]) -> Vec<f64> {
    let mut d = vec![0.0; values.len()];
    for k in 1..values.len() {
        let before = if k < 2 { 0.0 } else { d[k - 2] };
        d[k] = before + (2 * k - 1) as f64 * values[k - 1];
    }
    d
}

/// Degrees of which the constants of [`step`] are at hand, and for whose terms there is room without
/// asking for memory.
const ROOM: usize = 32;

/// (2k + 1) / (k + 1), k / (k + 1) and 2k + 1: P_{k+1} = grow x P_k - shrink P_{k-1} and
/// P_{k+1}' = odd P_k + P_{k-1}'.
#[inline]
fn step(k: usize) -> [f64; 3] {
    const fn of(k: usize) -> [f64; 3] {
        let (odd, after) = ((2 * k + 1) as f64, (k + 1) as f64);
        [odd / after, k as f64 / after, odd]
    }
    const STEPS: [[f64; 3]; ROOM] = {
        let mut steps = [[0.0; 3]; ROOM];
        let mut k = 0;
        while k < ROOM {
            steps[k] = of(k);
            k += 1;
        }
        steps
    };
    if k < ROOM { STEPS[k] } else { of(k) }
}

/// Three-term recurrence: P_{k+1}.
#[inline]
fn next(k: usize, x: f64, p: f64, before: f64) -> f64 {
    let k = k as f64;
    ((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0)
}

impl Series {
    /// A series from a function giving c_ij for i < `rows`, j < `columns`.
    #[must_use]
    pub fn from_fn(rows: usize, columns: usize, mut c: impl FnMut(usize, usize) -> f64) -> Self {
        let coefficients = (0..rows * columns).map(|k| c(k / columns, k % columns)).collect();
        Self { rows, columns, coefficients }
    }

    /// Number of u-degrees and of v-degrees.
    #[must_use]
    pub fn shape(&self) -> (usize, usize) {
        (self.rows, self.columns)
    }

    /// c_ij.
    #[must_use]
    pub fn coefficient(&self, i: usize, j: usize) -> f64 {
        self.coefficients[i * self.columns + j]
    }

    /// The same without the highest degrees, as far as their coefficients are 0.
    #[must_use]
    pub fn trimmed(&self) -> Self {
        let (mut rows, mut columns) = (1, 1);
        for (k, _) in self.coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            (rows, columns) = (rows.max(k / self.columns + 1), columns.max(k % self.columns + 1));
        }
        Self::from_fn(rows, columns, |i, j| self.coefficient(i, j))
    }

    /// df/du, exactly, as a series.
    #[must_use]
    pub fn derivative_u(&self) -> Self {
        // P_i' = sum of (2k+1) P_k over k < i with i - k odd.
        Self::from_fn(self.rows, self.columns, |k, j| {
            (2 * k + 1) as f64
                * (k + 1..self.rows).step_by(2).map(|i| self.coefficient(i, j)).sum::<f64>()
        })
    }

    /// df/dv, exactly, as a series.
    #[must_use]
    pub fn derivative_v(&self) -> Self {
        Self::from_fn(self.rows, self.columns, |i, k| {
            (2 * k + 1) as f64
                * (k + 1..self.columns).step_by(2).map(|j| self.coefficient(i, j)).sum::<f64>()
        })
    }

    /// f on the line of constant `v`, ready for many values of u.
    #[must_use]
    pub fn row(&self, v: f64) -> Row {
        let mut terms = Vec::with_capacity(self.rows);
        self.fold(v, |i, [f, f_v, f_vv]| {
            let [grow, shrink, odd] = step(i);
            terms.push(Term { grow, shrink, odd, f, f_v, f_vv });
        });
        Row { terms }
    }

    /// The value at one point, with the bits of [`Row::gradient`].
    #[must_use]
    pub fn value(&self, u: f64, v: f64) -> f64 {
        let (mut p, mut p0, mut f) = (1.0, 0.0, 0.0);
        self.fold(v, |i, [fold]| {
            f += fold * p;
            let [grow, shrink, _] = step(i);
            (p, p0) = (grow * u * p - shrink * p0, p);
        });
        f
    }

    /// Value and gradient at one point, with the bits of [`Row::gradient`].
    #[must_use]
    pub fn gradient(&self, u: f64, v: f64) -> Jet {
        let [f, f_u, f_v] = self.sums(u, v);
        Jet { f, gradient: [f_u, f_v], hessian: [0.0; 3] }
    }

    /// Value, gradient and Hessian at one point, with the bits of [`Row::jet`].
    #[must_use]
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        let mut sum = JetSum::new();
        self.fold(v, |i, folds| sum.add(u, step(i), folds));
        sum.jet
    }

    /// [`Series::gradient`] at several points at once, with its bits.
    #[inline]
    #[must_use]
    pub fn gradients<const N: usize>(&self, u: [f64; N], v: [f64; N]) -> [Jet; N] {
        Jet::each(self.sums(Lanes(u), Lanes(v)))
    }

    /// (f, f_u, f_v) at (`u`, `v`).
    #[inline]
    fn sums<A: Arithmetic>(&self, u: A, v: A) -> [A; 3] {
        let [one, zero] = [1.0, 0.0].map(A::constant);
        let (mut p, mut p0, mut d, mut d0) = (one, zero, zero, zero);
        let mut sums = [zero; 3];
        self.fold(v, |i, [fold, fold_v]| {
            sums = [sums[0] + fold * p, sums[1] + fold * d, sums[2] + fold_v * p];
            let [grow, shrink, odd] = step(i);
            (d, d0) = (d0 + p * odd, d);
            (p, p0) = (u * grow * p - p0 * shrink, p);
        });
        sums
    }

    /// Hands on, for every u-degree, the sum over its c_ij times (P_j, P_j', P_j'')(`v`), as many of
    /// these as are wanted.
    #[inline]
    fn fold<A: Arithmetic, const N: usize>(&self, v: A, mut take: impl FnMut(usize, [A; N])) {
        let [one, zero] = [1.0, 0.0].map(A::constant);
        let mut room = [[zero; N]; ROOM];
        let mut more;
        let basis = if self.columns <= ROOM {
            &mut room[..self.columns]
        } else {
            more = vec![[zero; N]; self.columns];
            &mut more[..]
        };
        let (mut now, mut before) = ([one, zero, zero], [zero; 3]);
        for (j, basis) in basis.iter_mut().enumerate() {
            basis.copy_from_slice(&now[..N]);
            let [grow, shrink, odd] = step(j);
            let [p, d, dd] = now;
            let next =
                [v * grow * p - before[0] * shrink, before[1] + p * odd, before[2] + d * odd];
            (now, before) = (next, [p, d, dd]);
        }
        // Two rows at a time: the additions of one do not wait for those of the other.
        let mut pairs = self.coefficients.chunks_exact(2 * self.columns);
        for (i, pair) in pairs.by_ref().enumerate() {
            let (first, second) = pair.split_at(self.columns);
            let mut sums = [[zero; N]; 2];
            for ((c, d), basis) in first.iter().zip(second).zip(&*basis) {
                for (k, basis) in basis.iter().enumerate() {
                    sums[0][k] = sums[0][k] + *basis * *c;
                    sums[1][k] = sums[1][k] + *basis * *d;
                }
            }
            take(2 * i, sums[0]);
            take(2 * i + 1, sums[1]);
        }
        if self.rows % 2 == 1 {
            let mut sums = [zero; N];
            for (c, basis) in pairs.remainder().iter().zip(&*basis) {
                for (sum, basis) in sums.iter_mut().zip(basis) {
                    *sum = *sum + *basis * *c;
                }
            }
            take(self.rows - 1, sums);
        }
    }

    /// Integral of f over the rectangle [u0, u1] x [v0, v1].
    #[must_use]
    pub fn integral(&self, u: [f64; 2], v: [f64; 2]) -> f64 {
        // The antiderivative of P_k is (P_{k+1} - P_{k-1}) / (2k+1), and u for P_0.
        let definite = |count: usize, [lo, hi]: [f64; 2]| -> Vec<f64> {
            let (a, b) = (values(count, lo), values(count, hi));
            let step = |k: usize| {
                if k == 0 {
                    hi - lo
                } else {
                    ((b[k + 1] - b[k - 1]) - (a[k + 1] - a[k - 1])) / (2 * k + 1) as f64
                }
            };
            (0..count).map(step).collect()
        };
        let (along_u, along_v) = (definite(self.rows, u), definite(self.columns, v));
        self.coefficients
            .chunks_exact(self.columns)
            .zip(&along_u)
            .map(|(c, iu)| iu * c.iter().zip(&along_v).map(|(c, iv)| c * iv).sum::<f64>())
            .sum()
    }
}

#[derive(Debug, Clone, Copy)]
struct Term {
    grow: f64,
    shrink: f64,
    odd: f64,
    f: f64,
    f_v: f64,
    f_vv: f64,
}

/// A series on one line of constant v: evaluation costs one pass over the u-degrees.
#[derive(Debug, Clone)]
pub struct Row {
    terms: Vec<Term>,
}

impl Row {
    /// Value and gradient at `u` (the Hessian is left zero).
    #[inline]
    #[must_use]
    pub fn gradient(&self, u: f64) -> Jet {
        let [f, f_u, f_v] = self.sums(u);
        Jet { f, gradient: [f_u, f_v], hessian: [0.0; 3] }
    }

    /// [`Row::gradient`] at several places at once, with its bits.
    #[inline]
    #[must_use]
    pub fn gradients<const N: usize>(&self, u: [f64; N]) -> [Jet; N] {
        Jet::each(self.sums(Lanes(u)))
    }

    /// (f, f_u, f_v) at `u`.
    #[inline]
    fn sums<A: Arithmetic>(&self, u: A) -> [A; 3] {
        let [one, zero] = [1.0, 0.0].map(A::constant);
        let (mut p, mut p0, mut d, mut d0) = (one, zero, zero, zero);
        let mut sums = [zero; 3];
        for t in &self.terms {
            sums = [sums[0] + p * t.f, sums[1] + d * t.f, sums[2] + p * t.f_v];
            (d, d0) = (d0 + p * t.odd, d);
            (p, p0) = (u * t.grow * p - p0 * t.shrink, p);
        }
        sums
    }

    /// Value, gradient and Hessian at `u`; value and gradient have the bits of [`Row::gradient`].
    #[must_use]
    pub fn jet(&self, u: f64) -> Jet {
        let mut sum = JetSum::new();
        for t in &self.terms {
            sum.add(u, [t.grow, t.shrink, t.odd], [t.f, t.f_v, t.f_vv]);
        }
        sum.jet
    }
}

/// A jet in the course of summing up its terms over the u-degrees.
struct JetSum {
    jet: Jet,
    /// P_i, P_i' and P_i'' of the degree that comes next, and those before.
    now: [f64; 3],
    before: [f64; 3],
}

impl JetSum {
    fn new() -> Self {
        Self { jet: Jet::default(), now: [1.0, 0.0, 0.0], before: [0.0; 3] }
    }

    /// Adds the terms of the next degree: by its constants of [`step`] and the sums over the v-degrees of f, f_v and f_vv.
    #[inline]
    fn add(&mut self, u: f64, [grow, shrink, odd]: [f64; 3], [f, f_v, f_vv]: [f64; 3]) {
        let ([p, d, dd], [p0, d0, dd0]) = (self.now, self.before);
        let Jet { f: value, gradient, hessian } = &mut self.jet;
        *value += f * p;
        gradient[0] += f * d;
        gradient[1] += f_v * p;
        hessian[0] += f * dd;
        hessian[1] += f_v * d;
        hessian[2] += f_vv * p;
        self.now = [grow * u * p - shrink * p0, d0 + odd * p, dd0 + odd * d];
        self.before = [p, d, dd];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// u^3 v^2 + u in Legendre form: u^3 = (2 P3 + 3 P1)/5, v^2 = (2 P2 + P0)/3.
    fn cubic() -> Series {
        Series::from_fn(4, 3, |i, j| {
            let u3 = [0.0, 0.6, 0.0, 0.4][i];
            let v2 = [1.0 / 3.0, 0.0, 2.0 / 3.0][j];
            u3 * v2 + if (i, j) == (1, 0) { 1.0 } else { 0.0 }
        })
    }

    #[test]
    fn values_have_the_bits_of_rows() {
        let series = Series::from_fn(40, 35, |i, j| ((i * 35 + j) as f64).sqrt() - 18.7);
        for k in 0..200 {
            let [u, v] = [0.37, 0.61].map(|by| 2.0 * (by * f64::from(k)).fract() - 1.0);
            assert_eq!(series.value(u, v).to_bits(), series.row(v).gradient(u).f.to_bits());
        }
    }

    #[test]
    fn jets_match_the_monomials() {
        for (u, v) in [(0.3, -0.7), (1.0, 1.0), (-1.0, 0.2), (0.0, 0.0)] {
            let jet = cubic().row(v).jet(u);
            let exact = [
                u * u * u * v * v + u,
                3.0 * u * u * v * v + 1.0,
                2.0 * u * u * u * v,
                6.0 * u * v * v,
                6.0 * u * u * v,
                2.0 * u * u * u,
            ];
            let found = [
                jet.f,
                jet.gradient[0],
                jet.gradient[1],
                jet.hessian[0],
                jet.hessian[1],
                jet.hessian[2],
            ];
            for (a, b) in exact.iter().zip(found) {
                assert!((a - b).abs() < 1e-14, "({u}, {v}): {a} {b}");
            }
        }
    }

    #[test]
    fn a_point_is_what_its_row_says_of_it() {
        for degrees in [3, ROOM - 1, ROOM, ROOM + 8] {
            let c = |i: usize, j: usize| ((7 * i + 3 * j) % 11) as f64 - 5.0;
            let series = Series::from_fn(degrees, degrees + 1, c);
            for (u, v) in [(0.3, -0.7), (-0.9, 0.4), (1.0, 1.0)] {
                assert_eq!(series.gradient(u, v), series.row(v).gradient(u));
                assert_eq!(series.jet(u, v), series.row(v).jet(u));
                let several = [u, v, -u, 0.5];
                let one_by_one = several.map(|u| series.row(v).gradient(u));
                assert_eq!(series.row(v).gradients(several), one_by_one);
                // P_k(1) = 1.
                let sum: f64 = series.coefficients.iter().sum();
                assert!((series.gradient(1.0, 1.0).f - sum).abs() < 1e-9 * series.rows as f64);
            }
        }
    }

    #[test]
    fn derivative_series_agree_with_the_jet() {
        let (f_uv, f_vv) =
            (cubic().derivative_u().derivative_v(), cubic().derivative_v().derivative_v());
        for (u, v) in [(0.3, -0.7), (-0.9, 0.4)] {
            let jet = cubic().row(v).jet(u);
            assert!((f_uv.row(v).gradient(u).f - jet.hessian[1]).abs() < 1e-14);
            assert!((f_vv.row(v).gradient(u).f - jet.hessian[2]).abs() < 1e-14);
        }
    }

    #[test]
    fn integral_over_a_part_is_exact() {
        // Over [0, 1] x [-1, 1/2]: 1/4 * (1/8 + 1)/3 + 1/2 * 3/2.
        let found = cubic().integral([0.0, 1.0], [-1.0, 0.5]);
        assert!((found - (0.25 * 0.375 + 0.75)).abs() < 1e-15);
    }
}
