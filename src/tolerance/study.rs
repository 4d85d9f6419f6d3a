//! Everything that is asked, answered.

use super::compensate::{Criterion, Pixels};
use super::engine::{Engine, Reference};
use super::field::Measure;
use super::source::{Distribution, Source};
use super::trials::{Statistics, Trial, quantile};
use super::yields::Yield;
use rayon::prelude::*;
use serde::Serialize;

/// The answers. Figures in px are those of the criterion, over the samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Study {
    /// Seed of the trials.
    pub seed: u64,
    /// Number of the first trial.
    pub first: u64,
    /// Number of trials.
    pub trials: u64,
    /// Pixels that stand for the picture.
    pub samples: usize,
    /// Which figure counts.
    pub criterion: Criterion,
    /// What displacements are measured from.
    pub reference: Reference,
    /// What the limits of form errors are.
    pub form: Measure,
    /// The most that it may be.
    pub budget_px: f64,
    /// The share of parts that must keep the budget.
    pub target_yield: f64,
    /// The design against the projection.
    pub nominal: Pixels,
    /// The sources, that with the largest impact after adjustment first.
    pub sources: Vec<SourceFacts>,
    /// Root of the sum of mean squares, the design's included, by first derivatives.
    pub rss_px: f64,
    /// Root of the mean square of the trials' RMS, which it predicts.
    pub rms_px: f64,
    /// What first derivatives make of the first trials.
    pub linear: Statistics,
    /// All trials, as made.
    pub as_made: Statistics,
    /// All trials, after adjustment.
    pub adjusted: Statistics,
    /// The share that keeps the budget.
    #[serde(rename = "yield")]
    pub yields: Yield,
    /// First derivatives against the full trace.
    pub gap: Gap,
    /// The adjustments.
    pub adjustments: Vec<AdjustmentFacts>,
    /// Whether the yield is the target or more.
    pub passes: bool,
}

/// What is known of a source.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SourceFacts {
    /// Its key in the profile, with the unit of its limits.
    pub source: String,
    /// That unit.
    pub unit: &'static str,
    /// Its limit.
    pub limit: f64,
    /// How likely errors are.
    pub distribution: Distribution,
    /// Its weight when the budget is allotted.
    pub weight: f64,
    /// What it does alone at the negative limit, as made, px.
    pub minus_px: f64,
    /// At the positive limit.
    pub plus_px: f64,
    /// At the negative limit, after adjustment.
    pub minus_adjusted_px: f64,
    /// At the positive limit.
    pub plus_adjusted_px: f64,
    /// Its share of the mean square after adjustment.
    pub share_of_variance: f64,
    /// The limit at which it alone uses up the budget; none where there is none.
    pub limit_alone: Option<f64>,
    /// The limit that goes with those of all others at the target yield.
    pub limit_joint: Option<f64>,
    /// Whether it is as wide as joint limits are made, four times the own one: less than its share
    /// of the variance.
    pub limit_joint_widest: bool,
}

/// First derivatives against the full trace, over the same trials.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// Over so many trials.
    pub trials: u64,
    /// Root of the mean square of the difference, px.
    pub rms_px: f64,
    /// The same against the mean of the full trace.
    pub relative: f64,
}

/// How far an adjustment was moved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AdjustmentFacts {
    /// Its name.
    pub name: &'static str,
    /// The unit of what follows.
    pub unit: &'static str,
    /// Standard deviation over the trials.
    pub sigma: f64,
    /// What 95 % of the trials stay within.
    pub p95: f64,
    /// The farthest.
    pub farthest: f64,
}

/// Trials that the linear model repeats.
const REPEATED: u64 = 1000;

impl Study {
    /// Of `trials`, which follow each other and are not none, of `seed`.
    #[must_use]
    pub fn new(engine: &Engine, seed: u64, trials: &[Trial]) -> Self {
        let question = &engine.question;
        let figure = |pixels: Pixels| pixels.by(question.criterion);
        let first = trials.first().map_or(0, |trial| trial.index);
        let repeated = REPEATED.min(trials.len() as u64);
        let linear = engine.linear_trials(&question.sources, seed, first..first + repeated);
        let full = engine.figures(trials);
        let by_linear = engine.figures(&linear);
        let off: f64 = by_linear.iter().zip(&full).map(|(a, b)| (a - b) * (a - b)).sum();
        let rms_px = (off / repeated as f64).sqrt();
        let mean = full.iter().take(by_linear.len()).sum::<f64>() / repeated as f64;
        let gap = Gap { trials: repeated, rms_px, relative: rms_px / mean };

        let variances: Vec<f64> = question.sources.iter().map(|s| engine.variance(s)).collect();
        let variance: f64 = variances.iter().sum();
        let start = engine.judge(engine.base.clone()).1.rms_px;
        let joint = engine.joint(seed);
        let facts = |(k, source): (usize, &Source)| {
            let impact = engine.impact(source, seed, source.limit);
            let [minus_px, plus_px] = impact.before.map(figure);
            let [minus_adjusted_px, plus_adjusted_px] = impact.after.map(figure);
            SourceFacts {
                source: source.kind.key(),
                unit: source.kind.unit(),
                limit: source.limit,
                distribution: source.distribution,
                weight: source.weight,
                minus_px,
                plus_px,
                minus_adjusted_px,
                plus_adjusted_px,
                share_of_variance: if variance > 0.0 { variances[k] / variance } else { 0.0 },
                limit_alone: engine.limit_alone(source, seed),
                limit_joint: joint.as_ref().map(|joint| joint.sources[k].limit),
                limit_joint_widest: joint.as_ref().is_some_and(|joint| joint.widest[k]),
            }
        };
        let mut sources: Vec<SourceFacts> =
            question.sources.par_iter().enumerate().map(facts).collect();
        let worst = |facts: &SourceFacts| facts.minus_adjusted_px.max(facts.plus_adjusted_px);
        sources.sort_by(|a, b| worst(b).total_cmp(&worst(a)));

        let square = |trial: &Trial| trial.after.rms_px * trial.after.rms_px;
        let yields = engine.yields(trials);
        Self {
            seed,
            first,
            trials: trials.len() as u64,
            samples: engine.samples(),
            criterion: question.criterion,
            reference: question.reference,
            form: question.form,
            budget_px: question.budget_px,
            target_yield: question.target_yield,
            nominal: engine.nominal(),
            sources,
            rss_px: (start * start + variance).sqrt(),
            rms_px: (trials.iter().map(square).sum::<f64>() / trials.len() as f64).sqrt(),
            linear: Statistics::of(by_linear),
            as_made: Statistics::of(trials.iter().map(|trial| figure(trial.before)).collect()),
            adjusted: Statistics::of(full),
            yields,
            gap,
            adjustments: adjustments(engine, trials),
            passes: yields.share >= question.target_yield,
        }
    }
}

fn adjustments(engine: &Engine, trials: &[Trial]) -> Vec<AdjustmentFacts> {
    let facts = |(k, adjustment): (usize, &super::Adjustment)| {
        let steps = || trials.iter().map(|trial| trial.steps[k]);
        let count = trials.len() as f64;
        let mean = steps().sum::<f64>() / count;
        let square = steps().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        let mut far: Vec<f64> = steps().map(f64::abs).collect();
        far.sort_by(f64::total_cmp);
        AdjustmentFacts {
            name: adjustment.name,
            unit: adjustment.unit,
            sigma: (square / (count - 1.0)).sqrt(),
            p95: quantile(&far, 0.95),
            farthest: quantile(&far, 1.0),
        }
    };
    engine.adjustments().iter().enumerate().map(facts).collect()
}
