//! From a budget back to limits: of each source alone, and of all together.

use super::compensate::{Criterion, DisplacementPx};
use super::engine::Engine;
use super::error_source::ErrorSource;
use super::quadratic_yield_model::QuadraticYieldModel;
use super::solve_for_target::solve_for_target;
use super::trials::quantile;
use super::work_counts::WorkKind;
use crate::num::random::RandomStream;
use serde::Serialize;

/// A source at its limit, px after adjustment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity {
    /// At the negative and the positive limit, as made. A texture has no sign: both are its root
    /// mean square over some patterns.
    pub before: [DisplacementPx; 2],
    /// The same after adjustment.
    pub after: [DisplacementPx; 2],
}

impl Sensitivity {
    /// The worse of both signs after adjustment.
    #[must_use]
    pub fn worst(&self) -> DisplacementPx {
        self.after[0].worst(self.after[1])
    }
}

/// Patterns of a texture that its impact is the mean of.
const PATTERNS: u64 = 16;
/// How near to the budget is enough.
const NEAR: f64 = 1e-6;
/// A texture's figures are means over patterns, which change with its limit: this is near enough.
const NEAR_TEXTURE: f64 = 5e-3;
/// A variance below this square of a length, px, is none.
const NOTHING_PX: f64 = 1e-9;
/// Profiles have no larger limits.
const MOST: f64 = 1e6;
/// The search for a limit begins no farther than where the error, as made, displaces by so many
/// budgets.
const FAR: f64 = 30.0;
/// Rounds of full traces by which joint limits are found, and trials of each.
const FULL_ROUNDS: usize = 4;
/// Rounds of first derivatives before, where P95 counts.
const P95_ROUNDS: usize = 2;
const FEW: u64 = 500;
/// Trials by first derivatives that the quantile is taken of: quadratic forms of an RMS know their
/// yield to a quarter of a percent; a P95 needs the pixels of each.
const MANY: u64 = 10_000;
const MANY_P95: u64 = 4000;
/// How near to the budget these come, and which change by full traces is the last.
const EXACT: f64 = 1e-4;
const FINE: f64 = 4e-3;
/// Trials from this share of them below the target on say how far first derivatives are off there.
const BELOW_TARGET: f64 = 0.2;
/// A joint limit is at most so many times the source's own: far from it nothing is known of what
/// samples do not see, such as the rim, and what is adjusted would seem to need no limit.
const WIDEST: f64 = 4.0;

/// Limits that go together.
#[derive(Debug, Clone, PartialEq)]
pub struct AllocatedLimits {
    /// The sources with these limits.
    pub sources: Vec<ErrorSource>,
    /// Which of them are as wide as limits are made, four times their own, and so have less than
    /// their share of the variance.
    pub widest: Vec<bool>,
}

/// Why there are no limits that go together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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
    /// What a source does alone at `limit`.
    #[must_use]
    pub fn sensitivity(&self, source: &ErrorSource, seed: u64, limit: f64) -> Sensitivity {
        if source.kind.is_texture() {
            let made = |trial| self.make(&[(source.kind, limit)], RandomStream { seed, trial });
            let made: Vec<_> = (0..PATTERNS).map(made).collect();
            let judged: Vec<_> =
                self.displacements(&made).into_iter().map(|d| self.compensate(d)).collect();
            let mean = |of: &dyn Fn(usize) -> DisplacementPx| {
                let square = |pick: fn(DisplacementPx) -> f64| {
                    let sum: f64 = (0..judged.len()).map(|k| pick(of(k)) * pick(of(k))).sum();
                    (sum / judged.len() as f64).sqrt()
                };
                DisplacementPx { rms_px: square(|p| p.rms_px), p95_px: square(|p| p.p95_px) }
            };
            let (before, after) = (mean(&|k| judged[k].0), mean(&|k| judged[k].1));
            return Sensitivity { before: [before; 2], after: [after; 2] };
        }
        let stream = RandomStream { seed, trial: 0 };
        let made = [-limit.abs(), limit.abs()];
        let made = made.map(|value| self.make(&[(source.kind, value)], stream));
        let judged: Vec<_> =
            self.displacements(&made).into_iter().map(|d| self.compensate(d)).collect();
        Sensitivity { before: [0, 1].map(|k| judged[k].0), after: [0, 1].map(|k| judged[k].1) }
    }

    /// The figure without errors.
    #[must_use]
    pub fn unperturbed(&self) -> f64 {
        self.compensate(self.base.clone()).1.by(self.spec.criterion)
    }

    /// The limit at which a source alone, at the worse of its signs, or at its own if it is
    /// systematic, uses up the budget, whatever limit it has now; none where the design has done so
    /// already, where the source does nothing, or where rays are lost or a million of its unit is
    /// reached before.
    #[must_use]
    pub fn inverse_sensitivity(&self, source: &ErrorSource, seed: u64) -> Option<f64> {
        let (budget, start) = (self.spec.budget_px, self.unperturbed());
        if !(start < budget) {
            return None;
        }
        let figure = |limit: f64| {
            let impact = self.sensitivity(source, seed, limit);
            let own = usize::from(source.limit >= 0.0);
            let worst = if source.is_systematic() { impact.after[own] } else { impact.worst() };
            worst.by(self.spec.criterion)
        };
        let texture = source.kind.is_texture();
        let room = (budget * budget - start * start).sqrt();
        let mut first = room / self.mean_square(&source.fixed(1.0)).sqrt();
        if !texture {
            let made = self.make(&[(source.kind, 1.0)], RandomStream { seed, trial: 0 });
            let moved = self.linear_displacement(&made);
            let moved: Vec<f64> = moved.iter().zip(&self.base).map(|(a, b)| a - b).collect();
            first = first.min(FAR * budget / DisplacementPx::of(&moved).rms_px);
        }
        let first = if first.is_finite() && first > 0.0 { first } else { source.limit.abs() };
        let near = if texture { NEAR_TEXTURE } else { NEAR };
        let found = solve_for_target(first.min(MOST), MOST, [start, budget], near, figure)?;
        Some(found.copysign(source.limit))
    }

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
        let own = &self.spec.sources;
        let (budget, criterion) = (self.spec.budget_px, self.spec.criterion);
        if !(self.unperturbed() < budget) {
            return Err(AllocationError::Design);
        }
        let fixed = DisplacementPx::of(&self.mean_field(own));
        if !(fixed.by(criterion) < budget) {
            return Err(AllocationError::Systematic);
        }
        // What is finer than pixels does not displace as its limit: it keeps that.
        let shared =
            |source: &ErrorSource| if source.kind.is_fine() { 0.0 } else { self.variance(source) };
        let variances: Vec<f64> = own.iter().map(shared).collect();
        let acts = |variance: f64| variance.sqrt() > NOTHING_PX;
        let pairs = || own.iter().zip(&variances);
        let weights: f64 = pairs().filter(|p| acts(*p.1)).map(|p| p.0.weight).sum();
        if !(weights > 0.0) {
            return Err(AllocationError::NothingToShare);
        }
        let share =
            |source: &ErrorSource, variance: f64| (source.weight / weights / variance).sqrt();
        // How much wider than its own each limit is.
        let factors = |scale: f64| -> Vec<f64> {
            let factor = |(source, &variance): (&ErrorSource, &f64)| {
                if acts(variance) { (scale * share(source, variance)).min(WIDEST) } else { 1.0 }
            };
            pairs().map(factor).collect()
        };
        // Where all are as wide as they are made.
        let least = pairs().filter(|p| acts(*p.1)).map(|(s, v)| share(s, *v)).reduce(f64::min);
        let widest = 1.001 * WIDEST / least.unwrap_or(1.0);
        let joint = |scale: f64| -> AllocatedLimits {
            let all = own.iter().zip(factors(scale));
            let (sources, widest) = all
                .map(|(source, f)| {
                    (ErrorSource { limit: f * source.limit, ..*source }, f == WIDEST)
                })
                .unzip();
            AllocatedLimits { sources, widest }
        };
        let target = self.spec.target_yield;
        let model = QuadraticYieldModel::new(self, seed, MANY);
        // The largest scale at which the share `target` has an RMS of `goal` by first derivatives.
        let solved = |goal: f64, first: f64| {
            let reached = |scale: f64| model.reached(&factors(scale), target);
            if reached(widest) <= goal {
                return Ok(widest);
            }
            let least = reached(0.0);
            if !(least < goal) {
                return Err(AllocationError::Systematic);
            }
            let found = solve_for_target(first.min(widest), widest, [least, goal], EXACT, reached);
            found.ok_or(AllocationError::RaysLost)
        };
        // What errors add to the square of the figure that counts, by first derivatives: of the first
        // trials, and of the share `target` of many.
        let added = |figure: f64| figure * figure - fixed.by(criterion) * fixed.by(criterion);
        let linear = |scale: f64, count: u64| -> Vec<f64> {
            if criterion == Criterion::Rms {
                let squares = model.squares(&factors(scale), count as usize);
                return squares.into_iter().map(f64::sqrt).collect();
            }
            self.system.counter.count(WorkKind::LimitTrials, [0, count as usize]);
            self.figures(&self.linear_trials(&joint(scale).sources, seed, 0..count))
        };
        let reached = |mut figures: Vec<f64>| {
            figures.sort_unstable_by(f64::total_cmp);
            added(quantile(&figures, target))
        };
        // The same of the RMS by its quadratic form, which is quick: by their ratio the figure that
        // counts, in full, leads to a goal for it.
        let quick = |scale: f64| {
            let figure = model.reached(&factors(scale), target);
            figure * figure - fixed.rms_px * fixed.rms_px
        };
        let room = added(budget);
        let goal = |ratio: f64| (fixed.rms_px * fixed.rms_px + room / ratio).sqrt();
        let (mut ratio, mut scale) = (1.0, room.sqrt());
        if criterion == Criterion::P95 {
            for _ in 0..P95_ROUNDS {
                scale = solved(goal(ratio), scale)?;
                ratio = reached(linear(scale, FEW)) / quick(scale);
            }
        }
        scale = solved(goal(ratio), scale)?;
        let wide = self.widened(&joint(scale).sources);
        let wide = wide.as_ref().unwrap_or(self);
        let mut lost = false;
        for _ in 0..FULL_ROUNDS {
            self.system.counter.count(WorkKind::LimitTrials, [FEW as usize, 0]);
            let full = self.figures(&wide.trials(&joint(scale).sources, seed, 0..FEW, None));
            let kept = full.iter().filter(|figure| figure.is_finite()).count();
            lost = (kept as f64) < target * FEW as f64;
            let many = linear(scale, if criterion == Criterion::Rms { MANY } else { MANY_P95 });
            let gap = gap_at(target, added, &full, &many);
            // Away from lost rays by halves.
            let found =
                if lost || !(gap > 0.0) { 4.0 * ratio } else { gap * reached(many) / quick(scale) };
            let step = (found / ratio).sqrt();
            ratio = found;
            let before = scale;
            scale = solved(goal(ratio), scale)?;
            if scale == before || (step - 1.0).abs() < FINE {
                break;
            }
        }
        if lost {
            return Err(AllocationError::RaysLost);
        }
        Ok(joint(scale))
    }
}

/// Ratio of what is `added` by figures, in full to first derivatives, by the trials about and beyond
/// the share `target`. These are picked by both alike: what they do not have in common, such as noise
/// from sample to sample, favours neither. Lost ones say nothing.
fn gap_at(target: f64, added: impl Fn(f64) -> f64, full: &[f64], linear: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..full.len()).filter(|&k| full[k].is_finite()).collect();
    order.sort_by(|&a, &b| (full[a] * linear[a]).total_cmp(&(full[b] * linear[b])));
    let from = ((target - BELOW_TARGET).max(0.0) * order.len() as f64) as usize;
    let sum = |of: &[f64]| order[from..].iter().map(|&k| added(of[k])).sum::<f64>();
    sum(full) / sum(linear)
}
