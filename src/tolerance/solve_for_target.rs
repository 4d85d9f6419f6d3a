//! How far something must go until a figure has a given size.

use crate::num::{exp, log};

/// Most steps.
const MOST_STEPS: usize = 40;
/// A figure that changes by less than this share of the goal does not change.
const NOTHING: f64 = 1e-7;
/// Between a place with a figure and one without, no farther apart than this, there is no other.
const AT_LOSS: f64 = 1.05;

/// Where `figure`, which is `start` at 0 and grows with x before long, is `goal` to the share `near`:
/// by the power of x with which its square grows over that of the start, inside what is known to be
/// too little and too much. None where it does not change, where it is not finite before, and where
/// x would be more than `most`.
pub fn solve_for_target(
    first: f64,
    most: f64,
    [start, goal]: [f64; 2],
    near: f64,
    figure: impl Fn(f64) -> f64,
) -> Option<f64> {
    let room = goal * goal - start * start;
    let (mut low, mut high, mut x) = (0.0, f64::INFINITY, first);
    let mut lost = false;
    let (mut power, mut last): (f64, Option<(f64, f64)>) = (2.0, None);
    for step in 0..MOST_STEPS {
        let found = figure(x);
        if (found / goal - 1.0).abs() < near {
            return Some(x);
        }
        let more = found * found - start * start;
        if high == f64::INFINITY && more.abs() <= NOTHING * goal * NOTHING * goal {
            return None;
        }
        if found < goal {
            low = x;
        } else {
            (high, lost) = (x, !found.is_finite());
        }
        if low >= most || lost && high < AT_LOSS * low {
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
            // Not for ever from one side.
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
                let found = solve_for_target(first, 1e6, [start, 1.0], 1e-9, counted(f));
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
