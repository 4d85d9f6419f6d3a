//! The mean square that errors add to the picture's displacement, by first derivatives, for very
//! many trials: a quadratic form of the errors, whatever the number of pixels.

use super::compensate::Compensation;
use super::engine::{Engine, Made};
use super::source::{Distribution, Kind, Source};
use super::trials::quantile;
use crate::num::random::Stream;
use rayon::prelude::*;

/// Trials, and what any factors on their sources' limits make of them.
#[derive(Debug, Clone)]
pub struct Yardstick {
    trials: Vec<Errors>,
    /// Mean products of the columns after adjustment, px^2.
    products: Vec<Vec<f64>>,
    /// Twice those of the columns and the displacement without errors.
    with_base: Vec<f64>,
}

/// The errors of a trial.
#[derive(Debug, Clone, Default)]
struct Errors {
    /// Source, column and amplitude.
    patterns: Vec<(usize, usize, f64)>,
    /// Source and mean square, px^2, of what is independent from sample to sample.
    noise: Vec<(usize, f64)>,
}

impl Yardstick {
    /// Trials 0 to `count` of `seed`.
    #[must_use]
    pub fn new(engine: &Engine, seed: u64, count: u64) -> Self {
        let samples = engine.samples() as f64;
        let (compensation, linear): (&Compensation, _) = (&engine.compensation, &engine.linear);
        let adjusted = |column: &Vec<f64>| {
            let mut column = column.clone();
            compensation.apply(&mut column);
            column
        };
        let columns: Vec<Vec<f64>> = linear.columns().par_iter().map(adjusted).collect();
        let base = adjusted(&engine.base);
        let mean =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / samples;
        let row = |a: &Vec<f64>| columns.iter().map(|b| mean(a, b)).collect();
        let products = columns.par_iter().map(row).collect();
        let with_base = columns.iter().map(|a| 2.0 * mean(a, &base)).collect();
        let sources = &engine.question.sources;
        let unit = |source: &Source| {
            engine.variance(&Source { limit: 1.0, distribution: Distribution::Fixed, ..*source })
        };
        let units: Vec<f64> = sources.iter().map(unit).collect();
        let errors = |trial: u64| {
            let stream = Stream { seed, trial };
            let mut errors = Errors::default();
            for (s, (kind, value)) in engine.draw(sources, &stream).into_iter().enumerate() {
                if matches!(kind, Kind::ToolMarks | Kind::Facets) {
                    errors.noise.push((s, value * value * units[s]));
                    continue;
                }
                let Made { state, .. } = engine.make(&[(kind, value)], stream);
                let amplitudes = linear.amplitudes(&state).into_iter().enumerate();
                let acting = amplitudes.filter(|(_, a)| *a != 0.0);
                errors.patterns.extend(acting.map(|(column, a)| (s, column, a)));
            }
            errors
        };
        let trials = (0..count).into_par_iter().map(errors).collect();
        Self { trials, products, with_base }
    }

    /// The mean squares, px^2, that errors add in the first `count` trials, where each source's
    /// limit is multiplied by its one of `factors`.
    #[must_use]
    pub fn added(&self, factors: &[f64], count: usize) -> Vec<f64> {
        let of = |errors: &Errors| {
            let mut a = vec![0.0; self.with_base.len()];
            for &(source, column, amplitude) in &errors.patterns {
                // A measured form error has no column where there is none.
                if let Some(a) = a.get_mut(column) {
                    *a += factors[source] * amplitude;
                }
            }
            let acting: Vec<usize> = (0..a.len()).filter(|&k| a[k] != 0.0).collect();
            let row = |&k: &usize| {
                let products = &self.products[k];
                let sum: f64 = acting.iter().map(|&j| a[j] * products[j]).sum();
                a[k] * (sum + self.with_base[k])
            };
            let noise = errors.noise.iter().map(|(s, square)| factors[*s] * factors[*s] * square);
            (acting.iter().map(row).sum::<f64>() + noise.sum::<f64>()).max(0.0)
        };
        self.trials[..count.min(self.trials.len())].par_iter().map(of).collect()
    }

    /// What the share `target` of all trials does not exceed, px.
    #[must_use]
    pub fn reached(&self, factors: &[f64], target: f64) -> f64 {
        let mut squares = self.added(factors, self.trials.len());
        squares.sort_by(f64::total_cmp);
        quantile(&squares, target).sqrt()
    }
}
