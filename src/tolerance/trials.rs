//! Monte Carlo: many made systems, each a function of the seed and its own number.

#[cfg(test)]
use super::compensate::figure_or_lost;
use super::compensate::{DisplacementPx, or_lost};
use super::engine::Engine;
use super::error_source::ErrorSource;
use super::perturbed_system::PerturbedSystem;
use super::yields::Yield;
use crate::num::random::RandomStream;
use crate::parallel;
use serde::Serialize;
use std::ops::Range;

/// Displacements of one Monte Carlo trial, and its adjustments.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Its number.
    pub index: u64,
    /// Displacement as made.
    pub before: DisplacementPx,
    /// Displacement after adjustment.
    pub after: DisplacementPx,
    /// Motion of each adjustment, in its unit; empty where rays are lost.
    pub steps: Vec<f64>,
}

/// Mean, scatter and percentiles of a figure over the trials. Mean and scatter are of the trials that
/// lose no rays; those that do are the worst, infinite ones among the percentiles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Statistics {
    /// Mean.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub mean_px: f64,
    /// Standard deviation; none of a single trial.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma_px: Option<f64>,
    /// Median.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p50_px: f64,
    /// 80th percentile of the trials.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p80_px: f64,
    /// 90th percentile.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p90_px: f64,
    /// 95th percentile.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p95_px: f64,
    /// 98th percentile.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p98_px: f64,
    /// 99th percentile.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p99_px: f64,
    /// The worst of all.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub worst_px: f64,
}

impl Statistics {
    /// Statistics of one figure a trial; not a number without trials.
    #[must_use]
    pub fn of(mut figures: Vec<f64>) -> Self {
        let kept = || figures.iter().copied().filter(|x| x.is_finite());
        let count = kept().count() as f64;
        let mean_px = if count > 0.0 { kept().sum::<f64>() / count } else { f64::INFINITY };
        let sigma_px = deviation(kept());
        figures.sort_by(f64::total_cmp);
        let at = |share: f64| quantile(&figures, share);
        Self {
            mean_px,
            sigma_px,
            p50_px: at(0.5),
            p80_px: at(0.8),
            p90_px: at(0.9),
            p95_px: at(0.95),
            p98_px: at(0.98),
            p99_px: at(0.99),
            worst_px: at(1.0),
        }
    }
}

/// Standard deviation of a sample; none of fewer than two.
pub(super) fn deviation(sample: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let count = sample.clone().count() as f64;
    let mean = sample.clone().sum::<f64>() / count;
    let squares: f64 = sample.map(|x| (x - mean) * (x - mean)).sum();
    (count > 1.0).then(|| (squares / (count - 1.0)).sqrt())
}

/// Empirical quantile of sorted values: the smallest that the share `share` of them does not exceed; not a
/// number without values.
#[must_use]
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let rank = ((share * sorted.len() as f64).ceil() as usize).saturating_sub(1);
    sorted.get(rank.min(sorted.len().saturating_sub(1))).copied().unwrap_or(f64::NAN)
}

/// Trials that a thread traces at a time: what belongs to a sample stays in the cache for all of them. (A
/// multiple of what is traced side by side.)
const BATCH: u64 = 16;
/// Trials between two looks at the width of the yield's interval.
const CHECKED: u64 = 500;

impl Engine {
    /// The system of trial `index`.
    #[must_use]
    pub fn trial(&self, sources: &[ErrorSource], seed: u64, index: u64) -> PerturbedSystem {
        let stream = RandomStream { seed, trial: index };
        self.make(&self.draw(sources, &stream), stream)
    }

    /// The trials of `range`, traced in full. With `until` they end after a multiple of 500 from
    /// the first where the 95 % interval of the yield is no wider than it.
    #[must_use]
    pub fn trials(
        &self,
        sources: &[ErrorSource],
        seed: u64,
        range: Range<u64>,
        until: Option<f64>,
    ) -> Vec<Trial> {
        let mut all = Vec::new();
        let mut from = range.start;
        while from < range.end {
            // All at once where nobody looks.
            let checked = if until.is_some() { CHECKED } else { u64::MAX };
            let to = range.end.min(from.saturating_add(checked));
            all.extend(self.block(from..to, |made| self.displacements(made), sources, seed));
            from = to;
            if until.is_some_and(|until| self.yields(&all).width() <= until) {
                break;
            }
        }
        all
    }

    /// The trials of `range` by first derivatives alone.
    #[must_use]
    pub fn linear_trials(
        &self,
        sources: &[ErrorSource],
        seed: u64,
        range: Range<u64>,
    ) -> Vec<Trial> {
        let linear =
            |made: &[PerturbedSystem]| made.iter().map(|m| self.linear_displacement(m)).collect();
        self.block(range, linear, sources, seed)
    }

    fn block(
        &self,
        range: Range<u64>,
        displacements: impl Fn(&[PerturbedSystem]) -> Vec<Vec<f64>> + Sync,
        sources: &[ErrorSource],
        seed: u64,
    ) -> Vec<Trial> {
        let batches: Vec<Range<u64>> = (range.start..range.end)
            .step_by(BATCH as usize)
            .map(|from| from..range.end.min(from.saturating_add(BATCH)))
            .collect();
        let batch = |batch: &Range<u64>| {
            let made: Vec<PerturbedSystem> =
                batch.clone().map(|index| self.trial(sources, seed, index)).collect();
            let figures = displacements(&made).into_iter().map(|d| self.compensate(d));
            let trial = |(index, (before, after, steps))| Trial { index, before, after, steps };
            batch.clone().zip(figures).map(trial).collect::<Vec<Trial>>()
        };
        parallel::gather(batches.len(), 1, |part| batches[part].iter().flat_map(batch).collect())
    }

    /// The figures that count, of each trial.
    #[must_use]
    pub fn figures(&self, trials: &[Trial]) -> Vec<f64> {
        trials.iter().map(|trial| trial.after.by(self.spec.criterion)).collect()
    }

    /// The share of the trials that keep the budget; those that lose rays do not.
    #[must_use]
    pub fn yields(&self, trials: &[Trial]) -> Yield {
        let figures = self.figures(trials);
        let good = figures.iter().filter(|x| **x <= self.spec.budget_px).count();
        Yield::of(good as u64, figures.len() as u64)
    }
}
