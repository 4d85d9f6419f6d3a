//! The position at which a figure that grows with it meets a target.

use crate::num::{exp, log};

/// Evaluations of the figure at most.
const MOST_STEPS: usize = 40;
/// Change of the figure, as a share of the goal, below which it counts as constant.
const LEAST_CHANGE: f64 = 1e-7;
/// Ratio of the nearest position without a finite figure to the farthest with one below the goal at which
/// the search between them ends: no goal lies there.
const LEAST_BRACKET: f64 = 1.05;

/// Value that a figure is to have.
#[derive(Debug, Clone, Copy)]
pub(super) struct TargetFigure {
    /// The figure at 0.
    pub start: f64,
    /// The figure that is wanted.
    pub goal: f64,
    /// Relative accuracy with which it has to be met.
    pub accuracy: f64,
}

/// The position where `figure`, which grows with the position before long, meets `target`. The search
/// begins at `first`: the figure's square is taken to grow over that of the start by a power of the
/// position, fitted to the last two evaluations and kept inside the bracket of positions that are known to
/// be too near and too far. None where the figure does not change, where it stops being finite below the
/// goal, and where the position would be more than `most`.
pub(super) fn solve_for_target(
    target: TargetFigure,
    first: f64,
    most: f64,
    figure: impl Fn(f64) -> f64,
) -> Option<f64> {
    let TargetFigure { start, goal, accuracy } = target;
    let room = goal * goal - start * start;
    let (mut low, mut high, mut x) = (0.0, f64::INFINITY, first);
    let mut lost = false;
    let (mut power, mut last): (f64, Option<(f64, f64)>) = (2.0, None);
    for step in 0..MOST_STEPS {
        let found = figure(x);
        if (found / goal - 1.0).abs() < accuracy {
            return Some(x);
        }
        let more = found * found - start * start;
        if high == f64::INFINITY && more.abs() <= LEAST_CHANGE * goal * LEAST_CHANGE * goal {
            return None;
        }
        if found < goal {
            low = x;
        } else {
            (high, lost) = (x, !found.is_finite());
        }
        if low >= most || lost && high < LEAST_BRACKET * low {
            return None;
        }
        let mut next = f64::NAN;
        if more > 0.0 && more.is_finite() {
            if let Some((x_before, more_before)) = last.replace((x, more)) {
                let found: f64 = log(more / more_before) / log(x / x_before);
                power = if found.is_finite() { found.clamp(0.2, 8.0) } else { 2.0 };
            }
            next = x * exp(log(room / more) / power);
        } else {
            last = None;
        }
        x = match (high.is_finite(), low < next && next < high) {
            (false, true) => next.min(8.0 * low).min(most),
            (false, false) => (2.0 * low).min(most),
            // Every fifth step bisects: the bracket shrinks from both sides.
            (true, true) if step % 5 != 4 => next,
            (true, _) if low > 0.0 => (low * high).sqrt(),
            (true, _) => 0.25 * high,
        };
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_are_found_and_what_has_none_ends_soon() {
        let count = std::cell::Cell::new(0);
        let counted = |f: fn(f64) -> f64| {
            let count = &count;
            move |x: f64| {
                count.set(count.get() + 1);
                f(x)
            }
        };
        type Case = (fn(f64) -> f64, f64, Option<f64>);
        let cases: [Case; 8] = [
            (|x| 0.25 * x, 0.0, Some(4.0)),
            (|x| 0.01 * x * x, 0.0, Some(10.0)),
            (|x| (0.64 + 0.04 * x * x).sqrt(), 0.8, Some(3.0)),
            // Better at first, as where one systematic error mends another.
            (|x| (0.64 - 0.8 * x + x * x).sqrt(), 0.8, Some(1.121_110_255_092_797_9)),
            // Rays are lost beyond 50, and before.
            (|x| if x < 50.0 { 0.03 * x } else { f64::INFINITY }, 0.0, Some(33.333_333_333)),
            (|x| if x < 30.0 { 0.03 * x } else { f64::NAN }, 0.0, None),
            (|_| 0.5, 0.5, None),
            (|x| 0.6 + 0.1 * x / (x + 1.0), 0.6, None),
        ];
        for first in [1e-6, 1.0, 40.0, 1e6] {
            for (k, (f, start, exact)) in cases.into_iter().enumerate() {
                count.set(0);
                let target = TargetFigure { start, goal: 1.0, accuracy: 1e-9 };
                let found = solve_for_target(target, first, 1e6, counted(f));
                let right = match (found, exact) {
                    (Some(found), Some(exact)) => (found / exact - 1.0).abs() < 1e-7,
                    (found, exact) => found == exact,
                };
                // (No change is seen where the first is far too little.)
                assert!(right || first < 1e-3, "{k} from {first}: {found:?} {exact:?}");
                assert!(count.get() < MOST_STEPS, "{k} from {first}: {}", count.get());
            }
        }
    }
}
