//! The mean square of the picture's displacement, by first derivatives, for very many trials: of
//! each a quadratic form of its sources' factors, whatever the number of pixels.

use super::engine::Engine;
use super::error_source::ErrorSource;
use super::trials::quantile;
use super::work_counts::{WorkCounter, WorkKind};
use crate::num::random::RandomStream;
use crate::num::{Arithmetic, Lanes};
use crate::parallel;
use crate::tolerance_terms::Perturbation;
use std::array::from_fn;
use std::sync::Arc;

/// Mean square displacement of each of many trials as a quadratic form of factors on the sources' limits.
#[derive(Debug, Clone)]
pub(super) struct QuadraticYieldModel {
    sources: usize,
    trials: usize,
    /// Coefficients of the trials, px^2, several trials side by side: twice the mean product of each source with
    /// the displacement without errors, then for each source its mean products with itself and (twice) with
    /// those after it.
    forms: Vec<Vec<Lanes<TOGETHER>>>,
    /// Mean square without errors, px^2.
    base: f64,
    counter: Arc<WorkCounter>,
}

/// Trials whose forms are evaluated side by side.
const TOGETHER: usize = 8;

/// Columns of derivatives after adjustment, and what quadratic forms of trials need of them.
struct AdjustedColumns<'a> {
    engine: &'a Engine,
    /// Mean products of the columns with each other, px^2 per unit of both.
    products: Vec<Vec<f64>>,
    /// Twice their mean products with the displacement without errors.
    with_base: Vec<f64>,
    /// Mean square without errors, px^2.
    base: f64,
    /// Mean square of each source, px^2, by the square of its error.
    units: Vec<f64>,
}

impl<'a> AdjustedColumns<'a> {
    fn new(engine: &'a Engine) -> Self {
        let samples = engine.samples() as f64;
        let adjusted = |column: &Vec<f64>| {
            let mut column = column.clone();
            engine.compensation.apply(&mut column);
            column
        };
        let columns: Vec<Vec<f64>> = parallel::map_slice(engine.linear.columns(), 1, adjusted);
        let base = adjusted(&engine.base);
        let mean =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / samples;
        // The others are the same the other way round.
        let row = |k: usize| columns[..=k].iter().map(|b| mean(&columns[k], b)).collect();
        let half: Vec<Vec<f64>> = parallel::map(columns.len(), 1, row);
        let product = |i: usize, j: usize| half[i.max(j)][i.min(j)];
        let all = 0..columns.len();
        let products = all.clone().map(|i| all.clone().map(|j| product(i, j)).collect()).collect();
        // Of the limit's square: what is finer than pixels grows faster than its limit, and full traces
        // correct that.
        let unit = |source: &ErrorSource| {
            engine.mean_square(&source.fixed(source.limit)) / (source.limit * source.limit)
        };
        Self {
            engine,
            products,
            with_base: columns.iter().map(|a| 2.0 * mean(a, &base)).collect(),
            base: mean(&base, &base),
            units: engine.spec.sources.iter().map(unit).collect(),
        }
    }

    /// Columns that an error acts through, and its amplitudes of them; none of what is independent from
    /// sample to sample.
    fn pattern(&self, kind: Perturbation, value: f64, stream: RandomStream) -> Vec<(usize, f64)> {
        if kind.is_fine() {
            return Vec::new();
        }
        let made = self.engine.make(&[(kind, value)], stream);
        let all = self.engine.linear.amplitudes(&made.state).into_iter().enumerate();
        // A measured form error has no column where there is none.
        all.take(self.with_base.len()).filter(|(_, a)| *a != 0.0).collect()
    }

    /// The quadratic form of a trial: see [`QuadraticYieldModel::forms`].
    fn form(&self, stream: RandomStream) -> Vec<f64> {
        let drawn = self.engine.draw(&self.engine.spec.sources, &stream);
        let patterns: Vec<Vec<(usize, f64)>> =
            drawn.iter().map(|&(kind, value)| self.pattern(kind, value, stream)).collect();
        let along = |of: &[f64], pattern: &[(usize, f64)]| -> f64 {
            pattern.iter().map(|&(column, a)| a * of[column]).sum()
        };
        let mut form: Vec<f64> = patterns.iter().map(|p| along(&self.with_base, p)).collect();
        for (s, pattern) in patterns.iter().enumerate() {
            let mut by = vec![0.0; self.with_base.len()];
            for &(column, a) in pattern {
                by.iter_mut().zip(&self.products[column]).for_each(|(by, p)| *by += a * p);
            }
            let (kind, value) = drawn[s];
            let noise = if kind.is_fine() { value * value * self.units[s] } else { 0.0 };
            form.push(along(&by, pattern) + noise);
            form.extend(patterns[s + 1..].iter().map(|other| 2.0 * along(&by, other)));
        }
        form
    }
}

impl QuadraticYieldModel {
    /// Trials 0 to `count` of `seed`.
    #[must_use]
    pub(super) fn new(engine: &Engine, seed: u64, count: u64) -> Self {
        let columns = AdjustedColumns::new(engine);
        let trials = count as usize;
        let together = |group: usize| {
            let form = |k: usize| {
                // (What fills the last group up is not asked for.)
                let trial = (group * TOGETHER + k).min(trials - 1) as u64;
                columns.form(RandomStream { seed, trial })
            };
            let forms: [Vec<f64>; TOGETHER] = from_fn(form);
            (0..forms[0].len()).map(|i| Lanes(from_fn(|k| forms[k][i]))).collect()
        };
        Self {
            sources: engine.spec.sources.len(),
            trials,
            forms: parallel::map(trials.div_ceil(TOGETHER), 1, together),
            base: columns.base,
            counter: Arc::clone(&engine.system.counter),
        }
    }

    /// The mean squares, px^2, of the first `count` trials, where each source's limit is multiplied
    /// by its one of `factors`.
    #[must_use]
    pub(super) fn squares(&self, factors: &[f64], count: usize) -> Vec<f64> {
        let of = |form: &Vec<Lanes<TOGETHER>>| {
            let (with_base, mut rest) = form.split_at(self.sources);
            let mut sum = Lanes::constant(self.base);
            for (s, (&factor, &b)) in factors.iter().zip(with_base).enumerate() {
                let (row, others) = rest.split_at(self.sources - s);
                let pairs = row.iter().zip(&factors[s..]);
                let row = pairs.fold(Lanes::constant(0.0), |sum, (&q, &f)| sum + q * f);
                sum = sum + (b + row) * factor;
                rest = others;
            }
            sum.0.map(|sum| sum.max(0.0))
        };
        let count = count.min(self.trials);
        self.counter.count(WorkKind::LimitTrials, [0, count]);
        let forms = &self.forms[..count.div_ceil(TOGETHER)];
        let mut squares = parallel::map_slice(forms, 1, of).into_flattened();
        squares.truncate(count);
        squares
    }

    /// Quantile of the RMS over all trials at the share `target`, px.
    #[must_use]
    pub(super) fn reached(&self, factors: &[f64], target: f64) -> f64 {
        let mut squares = self.squares(factors, self.trials);
        squares.sort_unstable_by(f64::total_cmp);
        quantile(&squares, target).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerance::full_trace::tests::engine;

    #[test]
    fn quadratic_forms_are_the_mean_squares_of_first_derivatives() {
        let mut engine = engine("hyperbolic");
        // What is independent from sample to sample has a mean square alone.
        engine.spec.sources.retain(|source| !source.kind.is_fine());
        let sources = engine.spec.sources.clone();
        let model = QuadraticYieldModel::new(&engine, 4, 21);
        let factors: Vec<f64> = (0..sources.len()).map(|k| 0.3 + 0.2 * (k % 7) as f64).collect();
        let squares = model.squares(&factors, 100);
        assert_eq!(squares.len(), 21);
        let scaled = sources.iter().zip(&factors);
        let scaled: Vec<ErrorSource> =
            scaled.map(|(s, factor)| ErrorSource { limit: factor * s.limit, ..*s }).collect();
        for (trial, square) in engine.linear_trials(&scaled, 4, 0..21).iter().zip(&squares) {
            let exact = trial.after.rms_px * trial.after.rms_px;
            assert!((square / exact - 1.0).abs() < 1e-9, "{}: {square} {exact}", trial.index);
        }
        let first = model.squares(&factors, 13);
        assert!(first.iter().eq(&squares[..13]));
        let mut sorted = squares.clone();
        sorted.sort_by(f64::total_cmp);
        assert_eq!(model.reached(&factors, 0.5), quantile(&sorted, 0.5).sqrt());
    }
}
