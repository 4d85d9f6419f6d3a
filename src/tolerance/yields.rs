//! The share of good parts, and how well a number of trials knows it.

use serde::Serialize;

/// A share with its 95 % confidence interval: E. Wilson's, 1927.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Yield {
    /// Share of the trials that is good, 0 to 1.
    pub share: f64,
    /// Lower end of the interval, 0 to 1.
    pub low: f64,
    /// Upper end of the interval, 0 to 1.
    pub high: f64,
}

/// 97.5 % of the standard normal distribution lie below.
const Z: f64 = 1.959_963_984_540_054;

impl Yield {
    /// Of `good` ones among `trials`; anything is possible without trials.
    #[must_use]
    pub fn of(good: u64, trials: u64) -> Self {
        if trials == 0 {
            return Self { share: f64::NAN, low: 0.0, high: 1.0 };
        }
        let (good, n) = (good as f64, trials as f64);
        let share = good / n;
        let middle = (good + 0.5 * Z * Z) / (n + Z * Z);
        let half = Z / (n + Z * Z) * (n * share * (1.0 - share) + 0.25 * Z * Z).sqrt();
        // At the ends both halves are the same but for rounding.
        let low = if good == 0.0 { 0.0 } else { (middle - half).max(0.0) };
        let high = if good == n { 1.0 } else { (middle + half).min(1.0) };
        Self { share, low, high }
    }

    /// Width of the interval.
    #[must_use]
    pub fn width(&self) -> f64 {
        self.high - self.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::RandomStream;

    #[test]
    fn the_interval_covers_the_truth_in_95_of_100_runs() {
        for (k, (truth, trials)) in
            [(0.5, 200), (0.8, 500), (0.9, 1000), (0.95, 2000), (0.99, 2000)]
                .into_iter()
                .enumerate()
        {
            let run = |run: u64| {
                let good = |t: &u64| {
                    RandomStream { seed: 11 + k as u64, trial: *t }.pair(run as u32, 0)[0] < truth
                };
                let found = Yield::of((0..trials).filter(good).count() as u64, trials);
                found.low <= truth && truth <= found.high
            };
            let covered = (0..1000).filter(|&r| run(r)).count();
            assert!((930..=970).contains(&covered), "{truth} of {trials}: {covered}");
        }
    }

    #[test]
    fn ends_stay_shares() {
        let all = Yield::of(50, 50);
        assert!(all.share == 1.0 && all.high == 1.0 && all.low > 0.92 && all.low < 0.94);
        // Rounding once left 1e-19.
        for trials in 1..2000 {
            assert!(Yield::of(0, trials).low == 0.0 && Yield::of(trials, trials).high == 1.0);
        }
        let none = Yield::of(0, 50);
        assert!(none.low == 0.0 && (none.high - (1.0 - all.low)).abs() < 1e-15);
        assert_eq!(Yield::of(0, 0).width(), 1.0);
        // Wilson's for 8 of 10, by hand.
        let some = Yield::of(8, 10);
        assert!((some.low - 0.490_162).abs() < 1e-6 && (some.high - 0.943_318).abs() < 1e-6);
    }
}
