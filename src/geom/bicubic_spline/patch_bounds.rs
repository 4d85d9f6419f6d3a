//! Bounds of one patch of a spline: its derivatives are polynomials, bounded by their Bernstein coefficients.

use super::super::{DerivativeBounds, GridAxis};
use super::BicubicSpline;
use crate::num::Interval;

/// Rounding of a patch's Bernstein coefficients, as a share of the largest height.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Bounds look at whole such shares of a patch.
const SHARES: f64 = 32.0;

/// The intervals of an axis that `lo`..=`hi` touches, each with the share of it, a little widened.
pub(super) fn touched(
    axis: &GridAxis,
    lo: f64,
    hi: f64,
) -> impl Iterator<Item = (usize, [f64; 2])> {
    let ((first, from), (last, to)) = (axis.interval(lo), axis.interval(hi));
    (first..=last).map(move |k| {
        let from = if k == first { (from * SHARES).floor() / SHARES } else { 0.0 };
        let to = if k == last { (to * SHARES).ceil() / SHARES } else { 1.0 };
        (k, [from, if to > from { to } else { from + 1.0 / SHARES }])
    })
}

impl BicubicSpline {
    /// Bernstein coefficients of the patch from node (`i`, `j`): `net[b][a]` is that of number a along s, b along t.
    fn bernstein(&self, i: usize, j: usize) -> [[f64; 4]; 4] {
        let node = |i: usize, j: usize| &self.nodes[j * self.x.count + i];
        let corners = [[node(i, j), node(i + 1, j)], [node(i, j + 1), node(i + 1, j + 1)]];
        let (left, right) = ([0.0, 1.0 / 3.0], [0.0, -1.0 / 3.0]);
        let mut net = [[0.0; 4]; 4];
        for (b, line) in net.iter_mut().enumerate() {
            for (a, c) in line.iter_mut().enumerate() {
                let n = corners[b / 2][a / 2];
                let p = if a < 2 { left[a] } else { right[3 - a] };
                let q = if b < 2 { left[b] } else { right[3 - b] };
                *c = n[0] + p * n[1] + q * n[2] + p * q * n[3];
            }
        }
        net
    }

    /// Ranges of (f_xxx, f_xxy, f_xyy, f_yyy) over the whole patch from node (`i`, `j`), those of [`Self::bounds`] in a
    /// tenth of the time.
    #[must_use]
    pub fn third_of_patch(&self, i: usize, j: usize) -> [Interval; 4] {
        let net = self.bernstein(i, j);
        let size = net.iter().flatten().fold(0.0f64, |most, c| most.max(c.abs()));
        // Differences along t of order q, entry by entry of the lines.
        let along = |line: usize, p: usize| -> [f64; 4] {
            let [a, b, c, d] = net[line];
            match p {
                0 => [a, b, c, d],
                1 => [b - a, c - b, d - c, 0.0],
                2 => [c - 2.0 * b + a, d - 2.0 * c + b, 0.0, 0.0],
                _ => [d - 3.0 * (c - b) - a, 0.0, 0.0, 0.0],
            }
        };
        let (w, h) = (self.x.step_mm, self.y.step_mm);
        let scales = [6.0 / (w * w * w), 18.0 / (w * w * h), 18.0 / (w * h * h), 6.0 / (h * h * h)];
        std::array::from_fn(|q| {
            let lines = [0, 1, 2, 3].map(|line| along(line, 3 - q));
            // Entry by entry down the lines.
            let differences = (0..=q).flat_map(|k| {
                let [a, b, c, d] = lines.map(|line| line[k]);
                let all = match q {
                    0 => [a, b, c, d],
                    1 => [b - a, c - b, d - c, d - c],
                    2 => [c - 2.0 * b + a, d - 2.0 * c + b, d - 2.0 * c + b, d - 2.0 * c + b],
                    _ => [d - 3.0 * (c - b) - a; 4],
                };
                all.into_iter().take(4 - q)
            });
            let none = (f64::INFINITY, f64::NEG_INFINITY);
            let (lo, hi) = differences.fold(none, |(lo, hi), c| (lo.min(c), hi.max(c)));
            let slack = 8.0 * ROUNDING * size;
            Interval::new((lo - slack) * scales[q], (hi + slack) * scales[q])
        })
    }

    /// Bounds over the shares `s` and `t` of the patch from node (`i`, `j`).
    pub(super) fn patch_bounds(
        &self,
        i: usize,
        j: usize,
        s: [f64; 2],
        t: [f64; 2],
    ) -> DerivativeBounds {
        let mut net = self.bernstein(i, j);
        let size = net.iter().flatten().fold(0.0f64, |most, c| most.max(c.abs()));
        if s != [0.0, 1.0] {
            net = net.map(|line| restrict(line, s));
        }
        if t != [0.0, 1.0] {
            net = transpose(transpose(net).map(|line| restrict(line, t)));
        }
        let (w, h) = (self.x.step_mm * (s[1] - s[0]), self.y.step_mm * (t[1] - t[0]));
        let along = differences(&net);
        let up = along.map(|net| differences(&transpose(net)));
        // The derivative of order p along x and q along y: entries q of 4 - p lines, each of 4 - q.
        let range = |p: usize, q: usize| {
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for c in up[p][q][..4 - p].iter().flat_map(|line| &line[..4 - q]) {
                (lo, hi) = (lo.min(*c), hi.max(*c));
            }
            const FALLING: [f64; 4] = [1.0, 3.0, 6.0, 6.0];
            let power = |x: f64, n: usize| (0..n).fold(1.0, |power, _| power * x);
            let slack = ROUNDING * size * power(2.0, p + q);
            Interval::new(lo - slack, hi + slack)
                * (FALLING[p] * FALLING[q] / (power(w, p) * power(h, q)))
        };
        DerivativeBounds {
            f: range(0, 0),
            slope: [range(1, 0), range(0, 1)],
            hessian: [range(2, 0), range(1, 1), range(0, 2)],
            third: [range(3, 0), range(2, 1), range(1, 2), range(0, 3)],
        }
    }
}

/// Bernstein coefficients of a cubic on the part `from`..`to` of [0, 1] (its polar form).
fn restrict(c: [f64; 4], [from, to]: [f64; 2]) -> [f64; 4] {
    let polar = |ends: [f64; 3]| {
        let mut c = c;
        for (round, t) in ends.into_iter().enumerate() {
            for k in 0..3 - round {
                c[k] += t * (c[k + 1] - c[k]);
            }
        }
        c[0]
    };
    [[from; 3], [from, from, to], [from, to, to], [to; 3]].map(polar)
}

fn transpose(m: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// The differences of order 0 to 3 along each line; order n fills the first 4 - n entries.
fn differences(net: &[[f64; 4]; 4]) -> [[[f64; 4]; 4]; 4] {
    let mut orders = [*net; 4];
    for n in 1..4 {
        orders[n] = orders[n - 1].map(|c| [c[1] - c[0], c[2] - c[1], c[3] - c[2], 0.0]);
    }
    orders
}
