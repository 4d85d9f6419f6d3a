//! From a budget back to limits: of each source alone, and of all together.

use super::compensate::Pixels;
use super::engine::Engine;
use super::source::Source;
use super::yardstick::Yardstick;
use crate::num::random::Stream;
use crate::num::{exp, log};

/// A source at its limit, px after adjustment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// At the negative and the positive limit, as made. A texture has no sign: both are its root
    /// mean square over some patterns.
    pub before: [Pixels; 2],
    /// The same after adjustment.
    pub after: [Pixels; 2],
}

impl Impact {
    /// The worse of both signs after adjustment.
    #[must_use]
    pub fn worst(&self) -> Pixels {
        self.after[0].worst(self.after[1])
    }
}

/// Patterns of a texture that its impact is the mean of.
const PATTERNS: u64 = 16;
/// Most steps towards a limit, and how near to the budget is enough.
const MOST_STEPS: usize = 40;
const NEAR: f64 = 1e-6;
/// An impact below this, px, is none.
const NOTHING_PX: f64 = 1e-9;
/// A texture's figures are means over patterns, which change with its limit: this is near enough.
const NEAR_TEXTURE: f64 = 5e-3;
/// How often a limit may lead to lost rays before there is none.
const MOST_LOST: usize = 3;
/// Rounds of full traces by which joint limits are found, and trials of each.
const FULL_ROUNDS: usize = 4;
const FEW: u64 = 500;
/// Trials by first derivatives that the quantile is taken of: their yield is known to a quarter of
/// a percent.
const MANY: u64 = 10_000;
/// How near to the budget these come, and which change by full traces is the last.
const EXACT: f64 = 1e-4;
const FINE: f64 = 2e-3;
/// Trials from this share of them below the target on say how far first derivatives are off there.
const BELOW_TARGET: f64 = 0.2;
/// A joint limit is at most so many times the source's own: far from it nothing is known of what
/// samples do not see, such as the rim, and what is adjusted would seem to need no limit.
const WIDEST: f64 = 4.0;

/// Limits that go together.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// The sources with these limits.
    pub sources: Vec<Source>,
    /// Which of them are as wide as limits are made, four times their own, and so have less than
    /// their share of the variance.
    pub widest: Vec<bool>,
}

impl Engine {
    /// What a source does alone at `limit`.
    #[must_use]
    pub fn impact(&self, source: &Source, seed: u64, limit: f64) -> Impact {
        if source.kind.is_texture() {
            let made = |trial| self.make(&[(source.kind, limit)], Stream { seed, trial });
            let made: Vec<_> = (0..PATTERNS).map(made).collect();
            let judged: Vec<_> =
                self.displacements(&made).into_iter().map(|d| self.judge(d)).collect();
            let mean = |of: &dyn Fn(usize) -> Pixels| {
                let square = |pick: fn(Pixels) -> f64| {
                    let sum: f64 = (0..judged.len()).map(|k| pick(of(k)) * pick(of(k))).sum();
                    (sum / judged.len() as f64).sqrt()
                };
                Pixels { rms_px: square(|p| p.rms_px), p95_px: square(|p| p.p95_px) }
            };
            let (before, after) = (mean(&|k| judged[k].0), mean(&|k| judged[k].1));
            return Impact { before: [before; 2], after: [after; 2] };
        }
        let stream = Stream { seed, trial: 0 };
        let made = [-limit, limit].map(|value| self.make(&[(source.kind, value)], stream));
        let judged: Vec<_> = self.displacements(&made).into_iter().map(|d| self.judge(d)).collect();
        Impact { before: [0, 1].map(|k| judged[k].0), after: [0, 1].map(|k| judged[k].1) }
    }

    /// The figure without errors.
    #[must_use]
    pub fn unperturbed(&self) -> f64 {
        self.judge(self.base.clone()).1.by(self.question.criterion)
    }

    /// The limit at which a source alone, at the worse of its signs, uses up the budget; none where
    /// the design has done so already, where the source does nothing, or where no limit is found.
    #[must_use]
    pub fn limit_alone(&self, source: &Source, seed: u64) -> Option<f64> {
        let (budget, start) = (self.question.budget_px, self.unperturbed());
        let room = (budget * budget - start * start).sqrt();
        if !(room > 0.0) {
            return None;
        }
        let near = if source.kind.is_texture() { NEAR_TEXTURE } else { NEAR };
        let (mut limit, mut lost) = (source.limit, 0);
        // As which power of the limit the figure grows, by its last two values: adjustments leave
        // quadratic rests.
        let (mut power, mut last) = (1.0, None);
        for _ in 0..MOST_STEPS {
            let figure = self.impact(source, seed, limit).worst().by(self.question.criterion);
            if (figure / budget - 1.0).abs() < near {
                return Some(limit);
            }
            let more = (figure * figure - start * start).max(0.0).sqrt();
            if !(more > NOTHING_PX * (limit / source.limit)) {
                return None;
            }
            if !more.is_finite() {
                // Lost rays: back by halves.
                lost += 1;
                if lost == MOST_LOST {
                    return None;
                }
                (limit, last) = (0.5 * limit, None);
                continue;
            }
            if let Some((limit_before, more_before)) = last.replace((limit, more)) {
                let found: f64 = log(more / more_before) / log(limit / limit_before);
                power = if found.is_finite() { found.clamp(0.5, 4.0) } else { 1.0 };
            }
            limit *= exp(log(room / more) / power);
        }
        None
    }

    /// Limits that together just reach the target yield: the variance of all is shared by the
    /// sources' weights (in equal parts where these are equal), and the whole scaled until the
    /// budget is the figure's quantile. The figure is a root of a sum of many squares, far from
    /// normal, so the quantile is that of thousands of trials, from 0 on of `seed`, by first
    /// derivatives; some hundred traced in full correct it. No limit is more than four times the
    /// source's own, and sources that do nothing keep theirs; none where there is no room.
    #[must_use]
    pub fn joint(&self, seed: u64) -> Option<Joint> {
        let variances: Vec<f64> =
            self.question.sources.iter().map(|source| self.variance(source)).collect();
        let acts = |variance: f64| variance.sqrt() > NOTHING_PX;
        let pairs = || self.question.sources.iter().zip(&variances);
        let weights: f64 = pairs().filter(|p| acts(*p.1)).map(|p| p.0.weight).sum();
        let (budget, start) = (self.question.budget_px, self.unperturbed());
        let room = (budget * budget - start * start).sqrt();
        if !(room > 0.0 && weights > 0.0) {
            return None;
        }
        // How much wider than its own each limit is.
        let factors = |scale: f64| -> Vec<f64> {
            let factor = |(source, &variance): (&Source, &f64)| {
                let share = (source.weight / weights / variance).sqrt();
                if acts(variance) { (scale * share).min(WIDEST) } else { 1.0 }
            };
            pairs().map(factor).collect()
        };
        let joint = |scale: f64| -> Joint {
            let all = self.question.sources.iter().zip(factors(scale));
            let (sources, widest) = all
                .map(|(source, f)| (Source { limit: f * source.limit, ..*source }, f == WIDEST))
                .unzip();
            Joint { sources, widest }
        };
        let target = self.question.target_yield;
        let yardstick = Yardstick::new(self, seed, MANY);
        let solved = |goal: f64, mut scale: f64| {
            let (mut power, mut last): (f64, Option<(f64, f64)>) = (1.0, None);
            for _ in 0..MOST_STEPS {
                let figure = yardstick.reached(&factors(scale), target);
                // All as wide as they are made, and still within the budget.
                let ended = figure < goal && last.is_some_and(|(_, before)| figure == before);
                if ended || (figure / goal - 1.0).abs() < EXACT {
                    break;
                }
                if let Some((scale_before, figure_before)) = last.replace((scale, figure)) {
                    let found: f64 = log(figure / figure_before) / log(scale / scale_before);
                    power = if found.is_finite() { found.clamp(0.1, 1.0) } else { 1.0 };
                }
                scale *= exp(log(goal / figure) / power);
            }
            scale
        };
        // At first so that the root of the mean square is the budget.
        let (mut scale, mut gap) = (room, 1.0);
        for _ in 0..FULL_ROUNDS {
            scale = solved(room / gap, scale);
            let full = self.trials(&joint(scale).sources, seed, 0..FEW, None);
            let more = |figure: f64| (figure * figure - start * start).max(0.0);
            let full: Vec<f64> = self.figures(&full).into_iter().map(more).collect();
            let found = gap_at(target, &full, &yardstick.added(&factors(scale), FEW as usize));
            // Away from lost rays by halves.
            let step = if found.is_finite() { found / gap } else { 2.0 };
            gap *= step;
            if (step - 1.0).abs() < FINE {
                break;
            }
        }
        Some(joint(solved(room / gap, scale)))
    }
}

/// Root of the ratio of mean squares, of full traces to first derivatives, of the trials about and
/// beyond the share `target`. These are picked by both alike: what they do not have in common, such
/// as noise from sample to sample, favours neither.
fn gap_at(target: f64, full: &[f64], linear: &[f64]) -> f64 {
    let mut order: Vec<usize> = (0..full.len()).collect();
    order.sort_by(|&a, &b| (full[a] * linear[a]).total_cmp(&(full[b] * linear[b])));
    let from = ((target - BELOW_TARGET).max(0.0) * order.len() as f64) as usize;
    let sum = |of: &[f64]| order[from..].iter().map(|&k| of[k]).sum::<f64>();
    (sum(full) / sum(linear)).sqrt()
}
