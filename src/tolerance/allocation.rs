//! Allocation of a budget: limits of all sources at which the yield is just the target.

use super::compensate::DisplacementPx;
use super::engine::Engine;
use super::error_source::ErrorSource;
use super::quadratic_yield_model::QuadraticYieldModel;
use super::solve_for_target::{TargetFigure, solve_for_target};
use super::trials::quantile;
use super::work_counts::WorkKind;
use crate::num::sort_by_number;
use crate::tolerance_terms::Criterion;
use serde::Serialize;

/// Standard deviation of a displacement, px, below which a source does nothing.
const LEAST_DEVIATION_PX: f64 = 1e-9;
/// Rounds of full traces at most: each corrects the ratio of full traces to first derivatives.
const FULL_ROUNDS: usize = 4;
/// Trials of a round of full traces.
const FULL_TRIALS: u64 = 500;
/// Rounds of first derivatives before, where P95 counts.
const P95_ROUNDS: usize = 2;
/// Trials by first derivatives that the quantile of an RMS is taken of: their quadratic forms know the
/// yield to a quarter of a percent.
const RMS_TRIALS: u64 = 10_000;
/// The same of a P95, which needs the pixels of each trial.
const P95_TRIALS: u64 = 4000;
/// Relative accuracy with which the RMS of the quadratic forms meets its goal.
const GOAL_ACCURACY: f64 = 1e-4;
/// Relative change of the limits by a round of full traces after which no other follows.
const LAST_CHANGE: f64 = 4e-3;
/// Share of the trials below the target quantile that, with those above it, say how far first derivatives
/// are off there.
const BELOW_TARGET: f64 = 0.2;
/// Largest allocated limit, as a multiple of the source's own: far from it nothing is known of what
/// samples do not see, such as the rim, and what is adjusted would seem to need no limit.
const WIDEST: f64 = 4.0;

/// Limits of all sources at which the yield is just the target.
#[derive(Debug, Clone, PartialEq)]
pub struct AllocatedLimits {
    /// The sources with these limits.
    pub sources: Vec<ErrorSource>,
    /// Which of them are as wide as limits are made, four times their own, and so have less than
    /// their share of the variance.
    pub widest: Vec<bool>,
}

/// Reason why no allocated limits meet the budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AllocationError {
    /// The system as designed uses up the budget.
    Design,
    /// With the errors that keep their limits it does.
    Systematic,
    /// No other error does anything.
    NothingToShare,
    /// Where the budget is used up by first derivatives, rays are lost.
    RaysLost,
}

impl Engine {
    /// Limits that together just reach the target yield: the variance of all that are no systematic
    /// errors is shared by the sources' weights (in equal parts where these are equal), and the whole
    /// scaled until the budget is the figure's quantile. The figure is a root of a sum of many
    /// squares, far from normal, so the quantile is that of thousands of trials, from 0 on of
    /// `seed`, by first derivatives; some hundred traced in full correct it. No limit is more than
    /// four times the source's own; systematic sources, tool tracks and facets, and those that do nothing
    /// keep theirs.
    ///
    /// # Errors
    /// [`AllocationError`] where there are none.
    pub fn allocate_limits(&self, seed: u64) -> Result<AllocatedLimits, AllocationError> {
        Allocation::new(self, seed)?.solve()
    }
}

/// Search for the scale of all limits at which the yield is just the target.
struct Allocation<'a> {
    engine: &'a Engine,
    seed: u64,
    /// Factor on each source's own limit at a scale of 1; none of sources that keep their limits.
    shares: Vec<Option<f64>>,
    /// Scale at which all limits are as wide as limits are made.
    widest_scale: f64,
    /// Figures of what all parts have in common.
    mean: DisplacementPx,
    model: QuadraticYieldModel,
}

impl<'a> Allocation<'a> {
    fn new(engine: &'a Engine, seed: u64) -> Result<Self, AllocationError> {
        let spec = &engine.spec;
        if !(engine.unperturbed() < spec.budget_px) {
            return Err(AllocationError::Design);
        }
        let mean = DisplacementPx::of(&engine.mean_field(&spec.sources));
        if !(mean.by(spec.criterion) < spec.budget_px) {
            return Err(AllocationError::Systematic);
        }
        // What is finer than pixels does not displace as its limit: it keeps that.
        let shared = |source: &ErrorSource| {
            let variance = if source.kind.is_fine() { 0.0 } else { engine.variance(source) };
            (variance.sqrt() > LEAST_DEVIATION_PX).then_some(variance)
        };
        let variances: Vec<Option<f64>> = spec.sources.iter().map(shared).collect();
        let pairs = || spec.sources.iter().zip(&variances);
        let weights: f64 = pairs().filter(|p| p.1.is_some()).map(|p| p.0.weight).sum();
        if !(weights > 0.0) {
            return Err(AllocationError::NothingToShare);
        }
        let share = |(source, variance): (&ErrorSource, &Option<f64>)| {
            variance.map(|variance| (source.weight / weights / variance).sqrt())
        };
        let shares: Vec<Option<f64>> = pairs().map(share).collect();
        let least = shares.iter().flatten().copied().reduce(f64::min);
        let widest_scale = 1.001 * WIDEST / least.unwrap_or(1.0);
        let model = QuadraticYieldModel::new(engine, seed, RMS_TRIALS);
        Ok(Self { engine, seed, shares, widest_scale, mean, model })
    }

    /// Factor on each source's own limit.
    fn factors(&self, scale: f64) -> Vec<f64> {
        let factor = |share: &Option<f64>| share.map_or(1.0, |share| (scale * share).min(WIDEST));
        self.shares.iter().map(factor).collect()
    }

    fn limits(&self, scale: f64) -> AllocatedLimits {
        let all = self.engine.spec.sources.iter().zip(self.factors(scale));
        let (sources, widest) = all
            .map(|(source, f)| (ErrorSource { limit: f * source.limit, ..*source }, f == WIDEST))
            .unzip();
        AllocatedLimits { sources, widest }
    }

    /// RMS, px, that the target share of the trials does not exceed, by first derivatives.
    fn rms_at_target(&self, scale: f64) -> f64 {
        self.model.reached(&self.factors(scale), self.engine.spec.target_yield)
    }

    /// Largest scale at which this RMS is `goal_px`; the search begins at `first`.
    fn scale_of(&self, goal_px: f64, first: f64) -> Result<f64, AllocationError> {
        let widest = self.widest_scale;
        if self.rms_at_target(widest) <= goal_px {
            return Ok(widest);
        }
        let start = self.rms_at_target(0.0);
        if !(start < goal_px) {
            return Err(AllocationError::Systematic);
        }
        let target = TargetFigure { start, goal: goal_px, accuracy: GOAL_ACCURACY };
        solve_for_target(target, first.min(widest), widest, |scale| self.rms_at_target(scale))
            .ok_or(AllocationError::RaysLost)
    }

    /// Square, px^2, that errors add to that of the criterion's figure of the mean field.
    fn added(&self, figure: f64) -> f64 {
        let mean = self.mean.by(self.engine.spec.criterion);
        figure * figure - mean * mean
    }

    /// The same at the target quantile of trials' figures.
    fn added_at_target(&self, mut figures: Vec<f64>) -> f64 {
        figures.sort_unstable_by(f64::total_cmp);
        self.added(quantile(&figures, self.engine.spec.target_yield))
    }

    /// The same of the RMS by its quadratic form, which is quick.
    fn added_to_rms(&self, scale: f64) -> f64 {
        let figure = self.rms_at_target(scale);
        figure * figure - self.mean.rms_px * self.mean.rms_px
    }

    /// The RMS by quadratic forms at which the criterion's figure uses up the budget, where that adds
    /// `ratio` times as much as the RMS.
    fn goal_px(&self, ratio: f64) -> f64 {
        let room = self.added(self.engine.spec.budget_px);
        (self.mean.rms_px * self.mean.rms_px + room / ratio).sqrt()
    }

    /// The criterion's figures of the first `count` trials by first derivatives.
    fn linear_figures(&self, scale: f64, count: u64) -> Vec<f64> {
        match self.engine.spec.criterion {
            Criterion::Rms => {
                let squares = self.model.squares(&self.factors(scale), count as usize);
                squares.into_iter().map(f64::sqrt).collect()
            }
            Criterion::P95 => {
                let counter = &self.engine.system.counter;
                counter.count(WorkKind::LimitTrials, [0, count as usize]);
                let sources = self.limits(scale).sources;
                let trials = self.engine.linear_trials(&sources, self.seed, 0..count);
                self.engine.figures(&trials)
            }
        }
    }

    fn solve(&self) -> Result<AllocatedLimits, AllocationError> {
        let spec = &self.engine.spec;
        let (mut ratio, mut scale) = (1.0, self.added(spec.budget_px).sqrt());
        if spec.criterion == Criterion::P95 {
            for _ in 0..P95_ROUNDS {
                scale = self.scale_of(self.goal_px(ratio), scale)?;
                let figures = self.linear_figures(scale, FULL_TRIALS);
                ratio = self.added_at_target(figures) / self.added_to_rms(scale);
            }
        }
        scale = self.scale_of(self.goal_px(ratio), scale)?;
        self.corrected_by_full_traces(ratio, scale).map(|scale| self.limits(scale))
    }

    /// The scale at which the budget is the figure's quantile in full traces, near `scale`, at which it is
    /// by first derivatives.
    fn corrected_by_full_traces(
        &self,
        mut ratio: f64,
        mut scale: f64,
    ) -> Result<f64, AllocationError> {
        let spec = &self.engine.spec;
        let wide = self.engine.widened(&self.limits(scale).sources);
        let wide = wide.as_ref().unwrap_or(self.engine);
        let many = match spec.criterion {
            Criterion::Rms => RMS_TRIALS,
            Criterion::P95 => P95_TRIALS,
        };
        let mut lost = false;
        for _ in 0..FULL_ROUNDS {
            let counter = &self.engine.system.counter;
            counter.count(WorkKind::LimitTrials, [FULL_TRIALS as usize, 0]);
            let sources = self.limits(scale).sources;
            let full = self.engine.figures(&wide.trials(&sources, self.seed, 0..FULL_TRIALS, None));
            let kept = full.iter().filter(|figure| figure.is_finite()).count();
            lost = (kept as f64) < spec.target_yield * FULL_TRIALS as f64;
            let linear = self.linear_figures(scale, many);
            let gap = self.full_to_linear(&full, &linear);
            // Away from lost rays by halves.
            let found = if lost || !(gap > 0.0) {
                4.0 * ratio
            } else {
                gap * self.added_at_target(linear) / self.added_to_rms(scale)
            };
            let step = (found / ratio).sqrt();
            ratio = found;
            let before = scale;
            scale = self.scale_of(self.goal_px(ratio), scale)?;
            if scale == before || (step - 1.0).abs() < LAST_CHANGE {
                break;
            }
        }
        if lost { Err(AllocationError::RaysLost) } else { Ok(scale) }
    }

    /// Ratio of what errors add to the figures' squares, in full to first derivatives, by the trials about
    /// and beyond the target quantile. These are picked by both alike: what they do not have in common,
    /// such as noise from sample to sample, favours neither. Lost ones say nothing.
    fn full_to_linear(&self, full: &[f64], linear: &[f64]) -> f64 {
        let mut order: Vec<usize> = (0..full.len()).filter(|&k| full[k].is_finite()).collect();
        sort_by_number(&mut order, |&k| full[k] * linear[k]);
        let below = (self.engine.spec.target_yield - BELOW_TARGET).max(0.0);
        let from = (below * order.len() as f64) as usize;
        let sum = |of: &[f64]| order[from..].iter().map(|&k| self.added(of[k])).sum::<f64>();
        sum(full) / sum(linear)
    }
}
