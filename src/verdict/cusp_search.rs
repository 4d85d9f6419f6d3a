//! Cusps of a cut: places in which the cuts of two moves meet, by search along a line of the plan.

use crate::geom::DVec2;
use crate::program::{SweptCutter, SweptPlace};

/// Halvings of the interval in which a cusp is searched for.
const HALVINGS: usize = 24;

/// Search for cusps across lines that are nearly even.
pub(super) struct CuspSearch<'a> {
    pub swept: &'a SweptCutter,
    /// Unit vectors along the lines and across them.
    pub ways: [DVec2; 2],
    /// Distance of the lines, mm.
    pub apart_mm: f64,
    /// Length of the interval that is searched, mm.
    pub pitch_mm: f64,
}

impl CuspSearch<'_> {
    /// y of the cusp within half an interval of the place (`x`, `y`), x along the lines; none where there is none.
    pub(super) fn near(&self, x: f64, y: f64) -> Option<f64> {
        let [along, across] = self.ways;
        let at = |y: f64| along * x + across * y;
        let half = 0.5 * self.pitch_mm;
        let lowest = |y: f64| self.swept.lowest(at(y));
        let (before, after) = (lowest(y - half)?, lowest(y + half)?);
        let rises = |place: &SweptPlace| place.slope.dot(across);
        // Up to a cusp the cut rises and beyond it falls, by about half a stepover over the radius each.
        let least = 0.25 * self.apart_mm / self.swept.cutter().radius_mm;
        if before.step == after.step || !(rises(&before) - rises(&after) > least) {
            return None;
        }
        let [mut low, mut high] = [y - half, y + half];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let of = |place: &SweptPlace| self.swept.of_step(place.step, at(middle));
            // Beyond its ball a move cuts nothing.
            let is_before = match (of(&before), of(&after)) {
                (Some((a, _)), Some((b, _))) => a < b,
                (a, _) => a.is_some(),
            };
            if is_before { low = middle } else { high = middle }
        }
        Some(0.5 * (low + high))
    }
}
