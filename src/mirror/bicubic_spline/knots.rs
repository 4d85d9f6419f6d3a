//! Even knots along one axis.

/// Evenly spaced places along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knots {
    /// The first, mm.
    pub first: f64,
    /// From one to the next, mm.
    pub step: f64,
    /// How many.
    pub count: usize,
}

/// Bounds look at whole such shares of a patch.
const SHARES: f64 = 32.0;

impl Knots {
    /// The interval that `x` is in (the end ones reach to infinity), and where in it.
    #[inline]
    pub(super) fn find(&self, x: f64) -> (usize, f64) {
        let steps = (x - self.first) / self.step;
        // Saturates, and takes what is not a number to the first.
        let k = (steps.max(0.0) as usize).min(self.count - 2);
        (k, steps - k as f64)
    }

    /// The last one, mm.
    #[must_use]
    pub fn last(&self) -> f64 {
        self.at(self.count - 1)
    }

    pub(super) fn at(&self, k: usize) -> f64 {
        self.first + self.step * k as f64
    }

    /// `lo`, the knots between, `hi`.
    #[must_use]
    pub fn breaks(&self, lo: f64, hi: f64) -> Vec<f64> {
        let (from, _) = self.find(lo);
        let (to, _) = self.find(hi);
        let inner = (from..=to + 1).map(|k| self.at(k)).filter(|&x| lo < x && x < hi);
        std::iter::once(lo).chain(inner).chain([hi]).collect()
    }

    /// The intervals that `lo`..=`hi` touches, each with the share of it, a little widened.
    pub(super) fn touched(&self, lo: f64, hi: f64) -> impl Iterator<Item = (usize, [f64; 2])> {
        let ((first, from), (last, to)) = (self.find(lo), self.find(hi));
        (first..=last).map(move |k| {
            let from = if k == first { (from * SHARES).floor() / SHARES } else { 0.0 };
            let to = if k == last { (to * SHARES).ceil() / SHARES } else { 1.0 };
            (k, [from, if to > from { to } else { from + 1.0 / SHARES }])
        })
    }
}
