//! The mirror whose worst residual is smallest, with a proof of how close to the best it is.
//!
//! Minimises t subject to |r| < t at every place by a logarithmic barrier: Newton's method on
//! k t - sum of log(t^2 - |r|^2) for growing k. Where the barrier is least its weights
//! w = 1 / (t^2 - |r|^2) are Lawson's: the least squares they define cannot be improved on, so no
//! mirror has a worst residual below the root of their weighted mean (of the problem linearised
//! at the answer; of the problem itself where that is linear). Begins with the coarse places and
//! takes in those of the others that come near the limit.

use super::barrier_hessian::{Cholesky, CholeskyRoot, ColumnBlocks, root};
use super::basis::{Basis, LocalValues};
use super::residual_sample::{PointwiseResidual, ResidualSample, linearised, magnitude_of_terms};
use super::solve::SolveError;
use crate::num::log;
use crate::num::streaming_qr::{StreamingQr, dot};
use crate::parallel;

/// Relative distance from the optimum to stop at.
const GAP: f64 = 3e-3;
/// Largest relative distance of the proven bound from the answer.
const BOUND_GAP: f64 = 0.01;
/// Growth of k from stage to stage.
const GROWTH: f64 = 10.0;
/// A place becomes active when its residual is within this part of the limit.
const NEAR: f64 = 0.01;
/// Newton's decrement (of the barrier, whose scale is 1 per place) that ends a stage.
const LAST_DECREMENT: f64 = 0.5;
/// Stages without any change after which the search is given up.
const MOST_IDLE: usize = 3;
/// Most Newton steps of a stage.
const MOST_NEWTON_STEPS: usize = 40;
/// Most stages.
const MOST_STAGES: usize = 20;
/// Places fewer than which the threads cost more than they bring.
const WORTH_THREADS: usize = 8;

/// A mirror with the smallest worst residual.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MinimaxFit {
    /// Coefficients of the basis' functions, mm.
    pub coefficients: Vec<f64>,
    /// Largest |r| over the basis' places.
    pub worst: f64,
    /// No coefficients have a smaller worst |r| (see the module's account of nonlinear problems).
    pub bound: f64,
    /// Newton steps taken.
    pub steps: usize,
}

/// The coefficients with the smallest largest |r| over the basis' places, to 0.5 %, searched from
/// `start` (the least-squares fit, say).
///
/// # Errors
/// [`SolveError`] when the residual is not finite at the start, does not determine the unknowns,
/// or the search stalls.
pub(super) fn minimax<const N: usize>(
    basis: &Basis,
    residual: &impl PointwiseResidual<N>,
    start: &[f64],
) -> Result<MinimaxFit, SolveError> {
    let locals = basis.locals(start);
    let samples = ResidualSample::all(basis, residual, &locals);
    let worst = largest(&samples);
    if !worst.is_finite() {
        return Err(SolveError::Undefined { steps: 0, coefficients: start.to_vec() });
    }
    let rounding = 1e-12 * magnitude_of_terms(&samples, &locals);
    if worst <= rounding {
        return Ok(MinimaxFit { coefficients: start.to_vec(), worst, bound: 0.0, steps: 0 });
    }
    let mut search = BarrierSearch::new(basis, residual, start, &samples)?;
    search.limit = 1.1 * worst;
    let coarse: Vec<usize> = (0..basis.len()).filter(|&k| basis.coarse(k)).collect();
    search.activate(&coarse, &locals, &samples);
    let mut pressure =
        search.samples.iter().map(|s| 2.0 * search.limit / search.slack(s)).sum::<f64>();
    let mut idle = 0;
    for _ in 0..MOST_STAGES {
        search.centre(pressure);
        idle = if search.last_step_mm > 0.0 { 0 } else { idle + 1 };
        if idle == MOST_IDLE {
            break;
        }
        let gap = search.active.len() as f64 / (pressure * search.limit);
        let locals = basis.locals(&search.coefficients);
        let samples = ResidualSample::all(basis, residual, &locals);
        let worst = largest(&samples);
        if let Some(bound) = search.proven_bound(gap, worst, rounding) {
            let (coefficients, steps) = (search.coefficients, search.steps);
            return Ok(MinimaxFit { coefficients, worst, bound, steps });
        }
        search.activate(&search.near_the_limit(&samples), &locals, &samples);
        let needed = largest(&search.samples) * (1.0 + 0.3 * gap);
        search.limit = search.limit.max(needed);
        if gap > GAP {
            let enough = 1.1 * search.active.len() as f64 / (GAP * search.limit);
            pressure = (pressure * GROWTH).min(enough);
        }
    }
    Err(SolveError::NotConverged { steps: search.steps, last_step_mm: search.last_step_mm })
}

/// The largest |r|, not a number if one is not.
fn largest<const N: usize>(samples: &[ResidualSample<N>]) -> f64 {
    // A NaN must not lose against a number.
    let square = samples
        .iter()
        .map(ResidualSample::square)
        .fold(0.0, |most: f64, s| if s <= most { most } else { s });
    f64::sqrt(square)
}

/// State of the search: a mirror, and the places that are active.
struct BarrierSearch<'a, R, const N: usize> {
    basis: &'a Basis,
    residual: &'a R,
    /// Coordinates of the search: the coefficients times this triangle.
    metric: StreamingQr,
    coefficients: Vec<f64>,
    blocks: ColumnBlocks,
    active: Vec<usize>,
    locals: Vec<LocalValues>,
    samples: Vec<ResidualSample<N>>,
    /// t.
    limit: f64,
    steps: usize,
    last_step_mm: f64,
}

/// Newton's step with its model of the slacks along it: s0 + a s1 + a^2 s2.
struct NewtonStep {
    change: Vec<f64>,
    locals: Vec<LocalValues>,
    limit: f64,
    decrement: f64,
    slacks: Vec<[f64; 3]>,
}

impl<'a, R: PointwiseResidual<N>, const N: usize> BarrierSearch<'a, R, N> {
    /// The search from the coefficients `start`, where the residuals are `samples`; no place is active yet.
    fn new(
        basis: &'a Basis,
        residual: &'a R,
        start: &[f64],
        samples: &[ResidualSample<N>],
    ) -> Result<Self, SolveError> {
        let coarse = (0..basis.len()).filter(|&k| basis.coarse(k));
        let metric = linearised(basis, &coarse.map(|k| (k, 1.0, samples[k])).collect::<Vec<_>>());
        metric.solve()?;
        Ok(Self {
            basis,
            residual,
            metric,
            coefficients: start.to_vec(),
            blocks: ColumnBlocks::new(basis.unknowns()),
            active: Vec::new(),
            locals: Vec::new(),
            samples: Vec::new(),
            limit: f64::NAN,
            steps: 0,
            last_step_mm: f64::NAN,
        })
    }

    /// t^2 - |r|^2.
    fn slack(&self, s: &ResidualSample<N>) -> f64 {
        self.limit * self.limit - s.square()
    }

    /// The bound of the worst residual, where it is near enough to the `worst` over all places; `gap` is the
    /// relative distance of the barrier's least from the optimum.
    fn proven_bound(&self, gap: f64, worst: f64, rounding: f64) -> Option<f64> {
        let is_exact = worst <= rounding;
        let seen = largest(&self.samples);
        let met = gap <= GAP && worst <= seen * (1.0 + 0.5 * GAP);
        if !(met || is_exact) {
            return None;
        }
        let bound = self.bound();
        // Short of the barrier's least, where its weights prove nothing, it is searched on.
        (bound >= (1.0 - BOUND_GAP) * worst || is_exact).then_some(bound)
    }

    /// The places that are not active yet and whose residuals are near the limit.
    fn near_the_limit(&self, samples: &[ResidualSample<N>]) -> Vec<usize> {
        let mut is_active = vec![false; self.basis.len()];
        self.active.iter().for_each(|&k| is_active[k] = true);
        let near = (1.0 - NEAR) * self.limit;
        (0..self.basis.len())
            .filter(|&k| !is_active[k] && !(samples[k].square() <= near * near))
            .collect()
    }

    /// Makes more places active.
    fn activate(
        &mut self,
        places: &[usize],
        locals: &[LocalValues],
        samples: &[ResidualSample<N>],
    ) {
        // All local values from the same sum, also those of the places already in.
        self.active.extend(places);
        self.locals = self.active.iter().map(|&k| locals[k]).collect();
        self.samples = self.active.iter().map(|&k| samples[k]).collect();
        let rows = |&k: &usize| -> [Vec<f64>; 3] {
            std::array::from_fn(|c| {
                let mut row: Vec<f64> = self.basis.row(k).map(|b| b[c]).collect();
                self.metric.forward(&mut row);
                row
            })
        };
        self.blocks.extend(&parallel::map_slice(places, WORTH_THREADS, rows));
    }

    /// Newton's method to the least of the barrier at this pressure k.
    fn centre(&mut self, pressure: f64) {
        for _ in 0..MOST_NEWTON_STEPS {
            let step = self.newton(pressure);
            let moved = self.advance(&step, pressure);
            self.steps += 1;
            if !moved || !(step.decrement >= LAST_DECREMENT) {
                return;
            }
        }
    }

    fn newton(&self, pressure: f64) -> NewtonStep {
        let t = self.limit;
        let count = self.samples.len();
        let (mut roots, mut slopes, mut mixed): (
            Vec<CholeskyRoot>,
            Vec<LocalValues>,
            Vec<LocalValues>,
        ) = (Vec::with_capacity(count), Vec::with_capacity(count), Vec::with_capacity(count));
        let (mut slope_t, mut curve_t) = (pressure, 0.0);
        for s in &self.samples {
            let per = 1.0 / self.slack(s);
            let back: LocalValues =
                std::array::from_fn(|c| (0..N).map(|k| s.by[k][c] * s.r[k]).sum::<f64>());
            let bend = |a: usize, b: usize| {
                let plain: f64 = (0..N).map(|k| s.by[k][a] * s.by[k][b]).sum();
                2.0 * per * plain + 4.0 * per * per * back[a] * back[b]
            };
            roots.push(root(std::array::from_fn(|a| std::array::from_fn(|b| bend(a, b)))));
            slopes.push(back.map(|b| 2.0 * per * b));
            mixed.push(back.map(|b| -4.0 * t * per * per * b));
            slope_t -= 2.0 * t * per;
            curve_t += 4.0 * t * t * per * per - 2.0 * per;
        }
        let factor = Cholesky::new(self.blocks.curvature(&roots));
        let (slope, border) = (self.blocks.gather(&slopes), self.blocks.gather(&mixed));
        let (mut y, mut z) = (slope.clone(), border.clone());
        factor.solve(&mut y);
        factor.solve(&mut z);
        let schur = (curve_t - dot(&border, &z)).max(1e-14 * curve_t);
        let limit = (dot(&border, &y) - slope_t) / schur;
        let change: Vec<f64> = y.iter().zip(&z).map(|(y, z)| -y - z * limit).collect();
        let decrement = -(dot(&slope, &change) + slope_t * limit);
        let locals = self.blocks.apply(&change);
        let slacks = self
            .samples
            .iter()
            .zip(&locals)
            .map(|(s, d)| {
                let (mut first, mut second) = (2.0 * t * limit, limit * limit);
                for (after, r) in s.after(d).iter().zip(s.r) {
                    first -= 2.0 * r * (after - r);
                    second -= (after - r) * (after - r);
                }
                [self.slack(s), first, second]
            })
            .collect();
        NewtonStep { change, locals, limit, decrement, slacks }
    }

    /// Line search along the step as far as the barrier falls, first by its model, then by its values; whether
    /// any share of the step was taken.
    fn advance(&mut self, step: &NewtonStep, pressure: f64) -> bool {
        let mut share = step.share(pressure);
        for _ in 0..30 {
            let limit = self.limit + share * step.limit;
            let locals: Vec<LocalValues> = self
                .locals
                .iter()
                .zip(&step.locals)
                .map(|(l, d)| std::array::from_fn(|c| l[c] + share * d[c]))
                .collect();
            let samples: Vec<ResidualSample<N>> = self
                .active
                .iter()
                .zip(&locals)
                .map(|(&k, &l)| ResidualSample::new(self.residual, self.basis.at(k), l))
                .collect();
            let mut rise = pressure * share * step.limit;
            for (s, before) in samples.iter().zip(&step.slacks) {
                let slack = limit * limit - s.square();
                rise -= if slack > 0.0 { log(slack / before[0]) } else { f64::NEG_INFINITY };
            }
            if limit > 0.0 && rise <= 0.0 {
                let mut change = step.change.clone();
                self.metric.back(&mut change);
                self.coefficients.iter_mut().zip(&change).for_each(|(c, d)| *c += share * d);
                self.last_step_mm =
                    step.locals.iter().fold(0.0, |most: f64, d| most.max(share * d[0].abs()));
                (self.limit, self.locals, self.samples) = (limit, locals, samples);
                return true;
            }
            share *= 0.5;
        }
        false
    }

    /// The lower bound that the barrier's weights prove.
    fn bound(&self) -> f64 {
        let weights: Vec<f64> = self.samples.iter().map(|s| 1.0 / self.slack(s)).collect();
        let total: f64 = weights.iter().sum();
        let weighted: Vec<_> = self
            .active
            .iter()
            .zip(&weights)
            .zip(&self.samples)
            .map(|((&k, w), s)| (k, w / total, *s))
            .collect();
        f64::sqrt(linearised(self.basis, &weighted).residual_squared())
    }
}

impl NewtonStep {
    /// The share of the step at which the model of the barrier is least.
    fn share(&self, pressure: f64) -> f64 {
        let slope = |a: f64| -> Option<f64> {
            let mut sum = pressure * self.limit;
            for &[s0, s1, s2] in &self.slacks {
                let slack = s0 + a * (s1 + a * s2);
                if !(slack > 0.0) {
                    return None;
                }
                sum -= (s1 + 2.0 * a * s2) / slack;
            }
            Some(sum)
        };
        let falls = |a: f64| slope(a).is_some_and(|s| s <= 0.0);
        if self.decrement < 0.1 && falls(1.0) {
            return 1.0;
        }
        let (mut low, mut high) = (0.0, 1.0);
        while high < 8.0 && falls(high) {
            (low, high) = (high, 2.0 * high);
        }
        // Between a place where the barrier still falls and one where it rises or ends.
        for _ in 0..40 {
            if high - low <= 0.02 * high && low > 0.0 {
                break;
            }
            let middle = 0.5 * (low + high);
            if falls(middle) { low = middle } else { high = middle }
        }
        low
    }
}

#[cfg(test)]
mod tests {
    use super::super::basis::NodeSet;
    use super::super::solve::{SolverOptions, solve};
    use super::*;
    use crate::geom::DVec2;
    use crate::num::Scalar;

    /// F' = (r - 2)^power.
    struct ShiftedPower(i32);
    impl PointwiseResidual<1> for ShiftedPower {
        fn at<S: Scalar>(&self, q: DVec2, _: S, [x, _]: [S; 2]) -> [S; 1] {
            [x - (0..self.0).fold(1.0, |p, _| p * (q.x - 2.0))]
        }
    }

    fn fitted(power: i32, degree: usize) -> MinimaxFit {
        let basis = |places| Basis::radial([1.0, 3.0], degree, places);
        let fit =
            solve(&basis(NodeSet::Quadrature), &ShiftedPower(power), &SolverOptions::default())
                .unwrap();
        minimax(&basis(NodeSet::Extrema), &ShiftedPower(power), &fit.coefficients).unwrap()
    }

    #[test]
    fn finds_what_chebyshev_found() {
        // The best approximation of t^n by lower degrees is off by 2^(1-n).
        for n in 2..9 {
            let best = f64::sqrt(f64::from(1u32 << (2 * n - 2))).recip();
            let found = fitted(n, n as usize);
            assert!(found.bound <= best, "{n}: {found:?}");
            assert!(found.worst <= 1.003 * best && found.bound >= 0.99 * best, "{n}: {found:?}");
            assert!(found.worst <= 1.0035 * found.bound, "{n}: {found:?}");
        }
    }

    #[test]
    fn an_exact_answer_is_left_alone() {
        let found = fitted(3, 6);
        assert!(found.steps == 0 && found.worst < 1e-14);
    }

    struct SlopeRoot;
    impl PointwiseResidual<1> for SlopeRoot {
        fn at<S: Scalar>(&self, _: DVec2, _: S, [x, _]: [S; 2]) -> [S; 1] {
            [(x - 1.0).sqrt()]
        }
    }

    #[test]
    fn a_residual_that_is_no_number_fails() {
        let basis = Basis::radial([0.0, 3.0], 4, NodeSet::Extrema);
        let error = minimax(&basis, &SlopeRoot, &[0.0; 4]).unwrap_err();
        assert!(matches!(error, SolveError::Undefined { steps: 0, .. }));
    }
}
