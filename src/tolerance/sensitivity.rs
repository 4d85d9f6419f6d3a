//! Sensitivities: the displacement by each source alone at its limit, and the limit at which it alone uses
//! up the budget.

use super::compensate::DisplacementPx;
use super::engine::Engine;
use super::error_source::ErrorSource;
use super::solve_for_target::{TargetFigure, solve_for_target};
use crate::num::random::RandomStream;

/// Displacement by one source alone at its limit.
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

/// Patterns of a texture that its sensitivity is the mean of.
const PATTERNS: u64 = 16;
/// Relative accuracy with which a limit meets the budget.
const ACCURACY: f64 = 1e-6;
/// Relative accuracy of a texture's limit: its figures are means over patterns that change with its limit.
const TEXTURE_ACCURACY: f64 = 5e-3;
/// Largest limit: profiles have no larger ones.
const MOST: f64 = 1e6;
/// Displacement as made, in budgets, by the limit at which the search begins at most.
const FIRST_BUDGETS: f64 = 30.0;

impl Engine {
    /// Displacement by a source alone at `limit`.
    #[must_use]
    pub fn sensitivity(&self, source: &ErrorSource, seed: u64, limit: f64) -> Sensitivity {
        if source.kind.is_texture() {
            let made = |trial| self.make(&[(source.kind, limit)], RandomStream { seed, trial });
            let made: Vec<_> = (0..PATTERNS).map(made).collect();
            let figures: Vec<_> =
                self.displacements(&made).into_iter().map(|d| self.compensate(d)).collect();
            let mean = |of: &dyn Fn(usize) -> DisplacementPx| {
                let square = |pick: fn(DisplacementPx) -> f64| {
                    let sum: f64 = (0..figures.len()).map(|k| pick(of(k)) * pick(of(k))).sum();
                    (sum / figures.len() as f64).sqrt()
                };
                DisplacementPx { rms_px: square(|p| p.rms_px), p95_px: square(|p| p.p95_px) }
            };
            let (before, after) = (mean(&|k| figures[k].0), mean(&|k| figures[k].1));
            return Sensitivity { before: [before; 2], after: [after; 2] };
        }
        let stream = RandomStream { seed, trial: 0 };
        let made = [-limit.abs(), limit.abs()];
        let made = made.map(|value| self.make(&[(source.kind, value)], stream));
        let figures: Vec<_> =
            self.displacements(&made).into_iter().map(|d| self.compensate(d)).collect();
        Sensitivity { before: [0, 1].map(|k| figures[k].0), after: [0, 1].map(|k| figures[k].1) }
    }

    /// The criterion's figure without errors, px.
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
            let sensitivity = self.sensitivity(source, seed, limit);
            let own = usize::from(source.limit >= 0.0);
            let worst =
                if source.is_systematic() { sensitivity.after[own] } else { sensitivity.worst() };
            worst.by(self.spec.criterion)
        };
        let texture = source.kind.is_texture();
        let room = (budget * budget - start * start).sqrt();
        let mut first = room / self.mean_square(&source.fixed(1.0)).sqrt();
        if !texture {
            let made = self.make(&[(source.kind, 1.0)], RandomStream { seed, trial: 0 });
            let moved = self.linear_displacement(&made);
            let moved: Vec<f64> = moved.iter().zip(&self.base).map(|(a, b)| a - b).collect();
            first = first.min(FIRST_BUDGETS * budget / DisplacementPx::of(&moved).rms_px);
        }
        let first = if first.is_finite() && first > 0.0 { first } else { source.limit.abs() };
        let accuracy = if texture { TEXTURE_ACCURACY } else { ACCURACY };
        let target = TargetFigure { start, goal: budget, accuracy };
        let found = solve_for_target(target, first.min(MOST), MOST, figure)?;
        Some(found.copysign(source.limit))
    }
}
