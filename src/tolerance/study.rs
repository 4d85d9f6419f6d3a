//! The results of a tolerance study.

use super::allocation::{AllocatedLimits, AllocationError};
use super::blur::BlurAndScatter;
#[cfg(test)]
use super::compensate::figure_or_lost;
use super::compensate::{DisplacementPx, or_lost};
use super::engine::Engine;
use super::trials::{Statistics, Trial, deviation, quantile};
use super::yields::Yield;
use crate::num::sort_by_number;
use crate::parallel;
use crate::tolerance_terms::{Criterion, Distribution, FormMeasure, Reference};
use serde::Serialize;

/// Results of a tolerance study. Figures in px are those of the criterion, over the samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Study {
    /// Seed of the trials.
    pub seed: u64,
    /// Number of the first trial.
    pub first: u64,
    /// Number of trials.
    pub trials: u64,
    /// Places of the picture that stand for it, each for an equal area.
    pub samples: usize,
    /// Share of the picture of the mirror that they stand for: where they see the target.
    pub picture_share: f64,
    /// Figure that is held against the budget.
    pub criterion: Criterion,
    /// Picture that displacements are measured from.
    pub reference: Reference,
    /// Measure of the form errors' limits.
    pub form: FormMeasure,
    /// Largest value of the criterion, px.
    pub budget_px: f64,
    /// Largest blur by textures within a pixel, px.
    pub budget_blur_px: f64,
    /// The share of parts that must keep the budget.
    pub target_yield: f64,
    /// The design against the projection.
    pub nominal: DisplacementPx,
    /// The sources, that with the largest impact after adjustment first.
    pub sources: Vec<SourceFacts>,
    /// Blur by textures within a pixel, px: RMS over the picture, the root of the sum of the sources'
    /// squares.
    pub blur_px: f64,
    /// Share of the light that textures turn or scatter, in all.
    pub scattered: f64,
    /// Why no allocated limits meet the budget, if none do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_limit_joint: Option<AllocationError>,
    /// RMS of what all parts have in common after adjustment: the design's displacement and those of
    /// the systematic sources, added with their signs, by first derivatives.
    pub mean_px: f64,
    /// Root of the sum of its square and of the variances of the other sources.
    pub rss_px: f64,
    /// Root of the mean square of the trials' RMS, which it predicts; of those that lose no rays.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub rms_px: f64,
    /// Trials in which a sampled ray does not meet the mirror. They do not keep the budget.
    pub lost_trials: u64,
    /// Statistics of the first trials by first derivatives.
    pub linear: Statistics,
    /// Statistics of all trials, as made.
    pub as_made: Statistics,
    /// Statistics of all trials, after adjustment.
    pub adjusted: Statistics,
    /// The share that keeps the budget.
    #[serde(rename = "yield")]
    pub yields: Yield,
    /// First derivatives against the full trace.
    pub gap: LinearityGap,
    /// The adjustments.
    pub adjustments: Vec<AdjustmentFacts>,
    /// Whether the yield is the target or more, and the blur within its budget.
    pub passes: bool,
}

/// Results of one error source.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SourceFacts {
    /// Its key in the profile, with the unit of its limits.
    pub source: String,
    /// Unit of its limits.
    pub unit: &'static str,
    /// Its limit.
    pub limit: f64,
    /// Distribution of the error.
    pub distribution: Distribution,
    /// Its weight when the budget is allotted.
    pub weight: f64,
    /// Whether it is the same in every part, with its sign: fixed, and no texture.
    pub systematic: bool,
    /// Displacement by it alone at the negative limit, as made, px.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub minus_px: f64,
    /// Displacement by it alone at the positive limit, as made, px.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub plus_px: f64,
    /// Displacement at the negative limit, after adjustment, px.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub minus_adjusted_px: f64,
    /// Displacement at the positive limit, after adjustment, px.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub plus_adjusted_px: f64,
    /// Blur and scatter at its limit; of textures, others do neither.
    #[serde(flatten)]
    pub spread: BlurAndScatter,
    /// Its share of the variance after adjustment; 0 of a systematic source, which has none.
    pub share_of_variance: f64,
    /// The limit at which it alone uses up the budget; none where there is none.
    pub limit_alone: Option<f64>,
    /// Allocated limit: with those of all others it just reaches the target yield; its own of a systematic
    /// source.
    pub limit_joint: Option<f64>,
    /// Whether that is as wide as allocated limits are made, four times the own one: less than its share
    /// of the variance.
    pub limit_joint_widest: bool,
}

impl SourceFacts {
    /// Results of source `k`, which has this share of the variance.
    fn of(
        engine: &Engine,
        seed: u64,
        k: usize,
        share_of_variance: f64,
        allocated: Option<&AllocatedLimits>,
    ) -> Self {
        let source = &engine.spec.sources[k];
        let sensitivity = engine.sensitivity(source, seed, source.limit);
        let figure = |displacement: DisplacementPx| displacement.by(engine.spec.criterion);
        let [minus_px, plus_px] = sensitivity.before.map(figure);
        let [minus_adjusted_px, plus_adjusted_px] = sensitivity.after.map(figure);
        Self {
            source: source.kind.key().to_owned(),
            unit: source.kind.row().unit.label(),
            limit: source.limit,
            distribution: source.distribution,
            weight: source.weight,
            systematic: source.is_systematic(),
            minus_px,
            plus_px,
            minus_adjusted_px,
            plus_adjusted_px,
            spread: engine.blur_and_scatter(source),
            share_of_variance,
            limit_alone: engine.inverse_sensitivity(source, seed),
            limit_joint: allocated.map(|allocated| allocated.sources[k].limit),
            limit_joint_widest: allocated.is_some_and(|allocated| allocated.widest[k]),
        }
    }
}

/// First derivatives against the full trace, over the same trials.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LinearityGap {
    /// Over so many trials, those that lose no rays.
    pub trials: u64,
    /// Root of the mean square of the difference, px; lost without such trials.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub rms_px: f64,
    /// The same against the mean of the full trace.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub relative: f64,
}

/// Motion of an adjustment in the trials that lose no rays.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AdjustmentFacts {
    /// Its name.
    pub name: &'static str,
    /// Unit of the figures of this adjustment.
    pub unit: &'static str,
    /// Standard deviation over the trials; none of a single one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sigma: Option<f64>,
    /// 95th percentile of its size.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub p95: f64,
    /// Largest motion.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub farthest: f64,
}

/// Trials that the linear model repeats.
const REPEATED: u64 = 1000;

impl Study {
    /// The results of `trials` of `seed`, at least one, which follow each other.
    #[must_use]
    pub fn new(engine: &Engine, seed: u64, trials: &[Trial]) -> Self {
        let spec = &engine.spec;
        let figure = |pixels: DisplacementPx| pixels.by(spec.criterion);
        let first = trials.first().map_or(0, |trial| trial.index);
        let repeated = REPEATED.min(trials.len() as u64);
        let linear = engine.linear_trials(&spec.sources, seed, first..first + repeated);
        let full = engine.figures(trials);
        let by_linear = engine.figures(&linear);
        let gap = gap(&by_linear, &full);

        let variances: Vec<f64> = spec.sources.iter().map(|s| engine.variance(s)).collect();
        let variance: f64 = variances.iter().sum();
        let share = |k: usize| if variance > 0.0 { variances[k] / variance } else { 0.0 };
        let mean_px = DisplacementPx::of(&engine.mean_field(&spec.sources)).rms_px;
        let allocated = engine.allocate_limits(seed);
        let facts = |k: usize| SourceFacts::of(engine, seed, k, share(k), allocated.as_ref().ok());
        let mut sources = parallel::map(spec.sources.len(), 1, facts);
        let worst = |facts: &SourceFacts| facts.minus_adjusted_px.max(facts.plus_adjusted_px);
        sort_by_number(&mut sources, |facts| -worst(facts));

        let square = |trial: &&Trial| trial.after.rms_px * trial.after.rms_px;
        let kept: Vec<&Trial> = trials.iter().filter(|trial| trial.after.kept()).collect();
        let rms_px = (kept.iter().map(square).sum::<f64>() / kept.len() as f64).sqrt();
        let yields = engine.yields(trials);
        let blurs = sources.iter().map(|source| source.spread.blur_px);
        let blur_px = blurs.map(|px| px * px).sum::<f64>().sqrt();
        let specular: f64 = sources.iter().map(|source| 1.0 - source.spread.scattered).product();
        Self {
            seed,
            first,
            trials: trials.len() as u64,
            samples: engine.samples(),
            picture_share: engine.share(),
            criterion: spec.criterion,
            reference: spec.reference,
            form: spec.form,
            budget_px: spec.budget_px,
            budget_blur_px: spec.budget_blur_px,
            target_yield: spec.target_yield,
            nominal: engine.nominal(),
            sources,
            blur_px,
            scattered: 1.0 - specular,
            no_limit_joint: allocated.err(),
            mean_px,
            rss_px: (mean_px * mean_px + variance).sqrt(),
            rms_px,
            lost_trials: (trials.len() - kept.len()) as u64,
            linear: Statistics::of(by_linear),
            as_made: Statistics::of(trials.iter().map(|trial| figure(trial.before)).collect()),
            adjusted: Statistics::of(full),
            yields,
            gap,
            adjustments: adjustments(engine, &kept),
            passes: yields.share >= spec.target_yield && blur_px <= spec.budget_blur_px,
        }
    }
}

/// Differences of figures by first derivatives from those of the full traces that they repeat.
fn gap(linear: &[f64], full: &[f64]) -> LinearityGap {
    let pairs = || linear.iter().zip(full).filter(|(_, full)| full.is_finite());
    let trials = pairs().count() as f64;
    let off: f64 = pairs().map(|(a, b)| (a - b) * (a - b)).sum();
    let rms_px = (off / trials).sqrt();
    let mean = pairs().map(|pair| pair.1).sum::<f64>() / trials;
    // Where nothing moves, nothing is off.
    let relative = if rms_px == 0.0 { 0.0 } else { rms_px / mean };
    LinearityGap { trials: trials as u64, rms_px, relative }
}

fn adjustments(engine: &Engine, trials: &[&Trial]) -> Vec<AdjustmentFacts> {
    let facts = |(k, adjustment): (usize, &super::Adjustment)| {
        let steps = || trials.iter().map(|trial| trial.steps[k]);
        let mut far: Vec<f64> = steps().map(f64::abs).collect();
        far.sort_by(f64::total_cmp);
        AdjustmentFacts {
            name: adjustment.name,
            unit: adjustment.unit,
            sigma: deviation(steps()),
            p95: quantile(&far, 0.95),
            farthest: quantile(&far, 1.0),
        }
    };
    engine.adjustments().iter().enumerate().map(facts).collect()
}
