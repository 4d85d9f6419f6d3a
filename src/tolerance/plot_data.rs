//! Data of a study's plots, and the error sources that displace most.

#[cfg(test)]
use super::compensate::figure_or_lost;
use super::compensate::or_lost;
use super::engine::Engine;
use super::study::{SourceFacts, Study};
use super::trials::Trial;
use super::yields::Yield;
use crate::num::sort_by_number;
use serde::Serialize;

/// An error at the worse of its limits.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Offender {
    /// The source's key in the profile, with the unit of its limits.
    pub source: String,
    /// The limit, with its sign where it has one.
    pub value: f64,
    /// Displacement by it alone after adjustment, px; infinite where rays are lost.
    #[serde(serialize_with = "or_lost")]
    #[cfg_attr(test, schemars(schema_with = "figure_or_lost"))]
    pub adjusted_px: f64,
}

/// The errors that do most alone after adjustment, the worst first.
#[must_use]
pub fn worst_offenders(study: &Study) -> Vec<Offender> {
    const MOST: usize = 10;
    let worse = |s: &SourceFacts| {
        let [minus, plus] = [s.minus_adjusted_px, s.plus_adjusted_px];
        // What is the same in every part has the sign that it was given.
        let negative = if s.systematic { s.limit < 0.0 } else { minus > plus };
        let limit = s.limit.abs();
        let (value, adjusted_px) = if negative { (-limit, minus) } else { (limit, plus) };
        Offender { source: s.source.clone(), value, adjusted_px }
    };
    let mut all: Vec<Offender> = study.sources.iter().map(worse).collect();
    sort_by_number(&mut all, |offender| -offender.adjusted_px);
    all.truncate(MOST);
    all
}

/// Curves and points.
#[derive(Debug, Clone, PartialEq)]
pub struct PlotData {
    /// The figure that counts of each trial after adjustment, px, smallest first; lost rays make
    /// it infinite.
    pub figures: Vec<f64>,
    /// Figures of the first trials by the full trace and by first derivatives, px.
    pub pairs: Vec<[f64; 2]>,
    /// Budgets, px, and the share of the trials that keep them.
    pub yields: Vec<(f64, Yield)>,
}

/// Most trials of which first derivatives are shown.
const PAIRS: usize = 500;
/// Steps of the budget.
const STEPS: usize = 200;
/// Factor by which they go beyond the best and the worst figure, or the budget.
const BEYOND: f64 = 1.05;

impl PlotData {
    /// The data of `trials` of `seed`, at least one, which follow each other.
    #[must_use]
    pub fn new(engine: &Engine, seed: u64, trials: &[Trial]) -> Self {
        let first = trials.first().map_or(0, |trial| trial.index);
        let shown = first..first + trials.len().min(PAIRS) as u64;
        let linear = engine.linear_trials(&engine.spec.sources, seed, shown);
        let mut figures = engine.figures(trials);
        let pairs = figures.iter().zip(engine.figures(&linear)).map(|(a, b)| [*a, b]).collect();
        figures.sort_by(f64::total_cmp);
        let finite = figures.partition_point(|x| x.is_finite());
        let worst = figures[..finite].last().copied().unwrap_or(0.0);
        let asked = engine.spec.budget_px;
        let most = BEYOND * worst.max(asked);
        let least = figures.first().map_or(asked, |best| best.min(asked)) / BEYOND;
        let step = |k: usize| {
            let budget = least + (most - least) * k as f64 / STEPS as f64;
            let good = figures.partition_point(|x| *x <= budget);
            (budget, Yield::of(good as u64, figures.len() as u64))
        };
        let yields = (0..=STEPS).map(step).collect();
        Self { figures, pairs, yields }
    }
}
