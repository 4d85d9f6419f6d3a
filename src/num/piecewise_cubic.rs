//! Cubics side by side, and what they range over.

use super::interval::Interval;
use super::knot_search::KnotSearch;

/// Rounding of an evaluation, as a share of the sum of the terms' sizes.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Cubics side by side. Piece k lies between the `borders` k - 1 and k, the outermost without end,
/// and has the coefficients `terms[k]` of the powers of x - `anchors[k]`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PiecewiseCubic {
    pub(super) borders: KnotSearch,
    pub(super) anchors: Vec<f64>,
    pub(super) terms: Vec<[f64; 4]>,
}

/// f and its first three derivatives at `t`.
#[inline]
pub(super) fn cubic([a, b, c, d]: [f64; 4], t: f64) -> [f64; 4] {
    [
        a + t * (b + t * (c + t * d)),
        b + t * (2.0 * c + t * (3.0 * d)),
        2.0 * c + t * (6.0 * d),
        6.0 * d,
    ]
}

/// Ranges of f, f' and f'' over `from`..=`to`.
fn cubic_over(terms: [f64; 4], from: f64, to: f64) -> [Interval; 3] {
    let [_, b, c, d] = terms;
    // Where f' is 0 (in the form that does not cancel), and f''.
    let spread = f64::sqrt(c * c - 3.0 * b * d);
    let q = -(c + spread.copysign(c));
    let flat = [q / (3.0 * d), b / q];
    let bend = [-c / (3.0 * d)];
    let sizes = cubic(terms.map(f64::abs), from.abs().max(to.abs()));
    let range = |order: usize, inner: &[f64]| {
        let inside = |t: &f64| from < *t && *t < to;
        [from, to]
            .into_iter()
            .chain(inner.iter().copied().filter(inside))
            .map(|t| Interval::around(cubic(terms, t)[order], ROUNDING * sizes[order]))
            .reduce(Interval::hull)
            .unwrap_or(Interval::WHOLE)
    };
    [range(0, &flat), range(1, &bend), range(2, &[])]
}

impl PiecewiseCubic {
    /// f and its first three derivatives at `x`: at a border, those of the piece that begins there.
    #[inline]
    pub(super) fn evaluate(&self, x: f64) -> [f64; 4] {
        let k = self.borders.up_to(x);
        cubic(self.terms[k], x - self.anchors[k])
    }

    /// Each piece's share of the range, and the ranges of f, f' and f'' on it; both sides of a border count.
    pub(super) fn parts(
        &self,
        [lo, hi]: [f64; 2],
    ) -> impl Iterator<Item = (Interval, [Interval; 3])> {
        let borders = self.borders.knots();
        let first = borders.partition_point(|&border| border < lo);
        let last = self.borders.up_to(hi).max(first);
        (first..=last).map(move |k| {
            let from = if k > 0 { lo.max(borders[k - 1]) } else { lo };
            let to = borders.get(k).map_or(hi, |&border| hi.min(border));
            let anchor = self.anchors[k];
            (Interval::new(from, to), cubic_over(self.terms[k], from - anchor, to - anchor))
        })
    }
}

pub(super) fn hulls(parts: impl Iterator<Item = [Interval; 3]>) -> [[f64; 2]; 3] {
    parts
        .reduce(|a, b| std::array::from_fn(|k| a[k].hull(b[k])))
        .unwrap_or([Interval::WHOLE; 3])
        .map(|range| [range.lo, range.hi])
}

/// Knots (strictly rising), values at them, and both finite, in equal numbers of at least two?
pub(super) fn fit_to_use(knots: &[f64], values: &[f64]) -> bool {
    knots.len() >= 2
        && knots.len() == values.len()
        && knots.iter().chain(values).all(|x| x.is_finite())
        && knots.windows(2).all(|k| k[0] < k[1])
}

/// Lengths of the pieces and slopes of the chords.
pub(super) fn chords(knots: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let h: Vec<f64> = knots.windows(2).map(|k| k[1] - k[0]).collect();
    let slopes = values.windows(2).zip(&h).map(|(y, h)| (y[1] - y[0]) / h).collect();
    (h, slopes)
}

#[cfg(test)]
pub(super) mod tests {
    use crate::num::SmoothFn;
    use crate::num::sample::Draws;
    use crate::num::sin;

    /// Knots from -1 up, unevenly spaced.
    pub fn knots(count: u64, r: &mut Draws) -> Vec<f64> {
        let grow = |x: &mut f64, _| {
            *x += r.inside([0.05, 0.5]);
            Some(*x)
        };
        (0..count).scan(-1.0, grow).collect()
    }

    /// Do the ranges over parts of [lo, hi] hold what is at points inside?
    pub fn holds(curve: &impl SmoothFn, [lo, hi]: [f64; 2], r: &mut Draws) {
        for _ in 0..100 {
            let range = r.range([lo, hi]);
            let over = curve.over(range);
            for _ in 0..8 {
                let x = r.inside(range);
                for (k, (over, at)) in over.iter().zip(curve.at(x)).enumerate() {
                    assert!(over[0] <= at && at <= over[1], "order {k} at {x}: {at} {over:?}");
                }
            }
        }
    }

    /// Largest distance from sin(1.5 x) on [-1, 1] of the curve through `n` + 1 even points of it.
    pub fn error<C: SmoothFn>(n: u32, through: impl Fn(&[f64], &[f64]) -> Option<C>) -> f64 {
        let f = |x: f64| sin(1.5 * x);
        let even = |n: u32| (0..=n).map(move |k| 2.0 * f64::from(k) / f64::from(n) - 1.0);
        let knots: Vec<f64> = even(n).collect();
        let values: Vec<f64> = knots.iter().map(|&x| f(x)).collect();
        let curve = through(&knots, &values).unwrap();
        even(999).map(|x| (curve.at(x)[0] - f(x)).abs()).fold(0.0, f64::max)
    }
}
