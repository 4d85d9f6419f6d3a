//! Search among sorted numbers in constant time, where they are spread evenly enough.

/// Finds how many of some sorted numbers are at most x: even slots tell between which of them x may be.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct KnotSearch {
    knots: Vec<f64>,
    /// Slots per unit.
    scale: f64,
    /// Number of knots before each slot, and of all.
    before: Vec<usize>,
}

impl KnotSearch {
    /// A search among `knots`, finite and rising strictly, with a slot for each.
    pub(super) fn new(knots: Vec<f64>) -> Self {
        let range = knots.last().zip(knots.first()).map_or(0.0, |(last, first)| last - first);
        let scale = knots.len() as f64 / range;
        let mut search = Self { knots, scale, before: Vec::new() };
        let slots: Vec<usize> = search.knots.iter().map(|&knot| search.slot(knot)).collect();
        search.before =
            (0..=search.knots.len()).map(|slot| slots.partition_point(|&at| at < slot)).collect();
        search
    }

    pub(super) fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The slot of `x`, which never falls where `x` rises.
    #[inline]
    fn slot(&self, x: f64) -> usize {
        // (What is no number, or before the first knot, is in the first.)
        let slot = ((x - self.knots[0]) * self.scale) as usize;
        slot.min(self.knots.len() - 1)
    }

    /// Number of knots that are at most `x`: in less time where that is `guess`, and some are.
    #[inline]
    pub(super) fn up_to_near(&self, x: f64, guess: usize) -> usize {
        let is_right = guess > 0
            && self.knots[guess - 1] <= x
            && self.knots.get(guess).is_some_and(|next| x < *next);
        if is_right { guess } else { self.up_to(x) }
    }

    /// Number of knots that are at most `x`.
    #[inline]
    pub(super) fn up_to(&self, x: f64) -> usize {
        let slot = self.slot(x);
        let (from, to) = (self.before[slot], self.before[slot + 1]);
        from + self.knots[from..to].partition_point(|&knot| knot <= x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::exp;
    use crate::num::sample::Draws;

    /// Even, uneven and few knots; at them, beside them, anywhere and nowhere.
    #[test]
    fn counts_are_those_of_a_search_by_halves() {
        for (count, power) in [(2, 0.0), (9, 0.0), (129, 0.0), (50, 4.0), (200, -30.0)] {
            let knots: Vec<f64> = (0..count)
                .map(|k| -0.3 + f64::from(k) * exp(power * f64::from(k) / f64::from(count)))
                .scan(f64::NEG_INFINITY, |last, knot| {
                    *last = if knot > *last { knot } else { last.next_up() };
                    Some(*last)
                })
                .collect();
            let search = KnotSearch::new(knots.clone());
            let mut r = Draws::new(3);
            let (lo, hi) = (knots[0], knots[knots.len() - 1]);
            let beside = knots.iter().flat_map(|x| [x.next_down(), *x, x.next_up()]);
            let anywhere = (0..1000).map(|_| r.inside([lo - 1.0, hi + 1.0]));
            let nowhere = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
            for x in beside.chain(anywhere).chain(nowhere) {
                let exact = knots.partition_point(|&knot| knot <= x);
                assert_eq!(search.up_to(x), exact, "{x}");
                for guess in [exact, 0, 1, exact.saturating_sub(1), knots.len()] {
                    assert_eq!(search.up_to_near(x, guess), exact, "{x}");
                }
            }
        }
    }
}
