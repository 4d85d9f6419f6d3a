//! Least squares of any pointwise residual by Gauss-Newton, sped up by Anderson's acceleration.
//!
//! A QR factorisation takes as long as tens of residuals and gradients. So the triangle of one step serves the next ones, with the gradient as
//! it is at each of them, as long as steps become smaller by it.
//!
//! The vector-field method, the fixed-surface method and the method of distributions (paper, section 3)
//! differ in nothing but the residual.

use super::anderson::AndersonAcceleration;
use super::basis::Basis;
use super::residual_sample::{
    PointwiseResidual, ResidualSample, descent, is_linear, linearised, magnitude_of_terms,
};
use crate::num::condition::{column_norms, condition_number};
use crate::num::least_squares::RankDeficient;
use crate::num::streaming_qr::StreamingQr;
use thiserror::Error;

/// Largest factor by which the integral may grow in an accepted step: near the minimum rounding makes it
/// grow.
const LARGEST_GROWTH: f64 = 1.0 + 1e-9;
/// Share of a step below which the line search gives up.
const LEAST_SHARE: f64 = 1e-9;
/// Steps by one triangle are to become smaller by `REUSE_GAIN` over so many of them: some of Anderson's steps are larger than the one before.
const REUSE_STEPS: usize = 3;
const REUSE_GAIN: f64 = 0.25;
/// Largest condition number of the first step's matrix with which triangles serve other steps: solving with R^T R squares it, and 1e-4 of a
/// step is then rounding.
const REUSE_CONDITION: f64 = 1e6;
/// Least unknowns for that, usually: a triangle of fewer takes no longer than a residual and its gradient.
const REUSE_UNKNOWNS: usize = 100;

/// Settings of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct SolverOptions<'a> {
    /// Coefficients to start from, mm; zero without.
    pub start: Option<&'a [f64]>,
    /// Largest change of F in the last step, in sizes of the domain.
    pub tolerance: f64,
    /// Largest number of steps.
    pub max_steps: usize,
    /// Least unknowns with which the triangle of one step serves others.
    pub reuse_unknowns: usize,
}

impl Default for SolverOptions<'_> {
    fn default() -> Self {
        Self { start: None, tolerance: 1e-12, max_steps: 200, reuse_unknowns: REUSE_UNKNOWNS }
    }
}

/// Mirror fitted by least squares.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquaresFit {
    /// Coefficients of the basis' functions, mm.
    pub coefficients: Vec<f64>,
    /// Integral of |r|^2 over the domain, mm^2 times the residual's unit squared.
    pub integral: f64,
    /// Condition number (2-norm) of the first step's matrix, its columns scaled to unit length.
    pub condition: f64,
    /// Number of steps.
    pub steps: usize,
    /// Largest change of F in the last step, mm.
    pub last_step_mm: f64,
}

/// Reason why there is no fit.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SolveError {
    /// The unknowns are not determined.
    #[error(transparent)]
    Undetermined(#[from] RankDeficient),
    /// The residual has no value at a mirror that the search starts from or cannot get around.
    #[error("the residual has no value after {steps} steps")]
    Undefined {
        /// Steps taken.
        steps: usize,
        /// Coefficients of that mirror, mm.
        coefficients: Vec<f64>,
    },
    /// The steps did not become small.
    #[error(
        "no convergence in {steps} steps (the last changed the mirror by {})",
        super::by(*last_step_mm, " mm")
    )]
    NotConverged {
        /// Steps taken.
        steps: usize,
        /// Largest change of F in the last step, mm.
        last_step_mm: f64,
    },
}

/// The coefficients with the smallest integral of |r|^2 over the basis' domain.
///
/// A problem linear in F takes one step. Others are iterated, faster the smaller their residual;
/// steps that make the integral larger are shortened.
///
/// # Errors
/// [`SolveError`] when the unknowns are not determined or the steps do not become small.
pub(super) fn solve<const N: usize>(
    basis: &Basis,
    residual: &impl PointwiseResidual<N>,
    options: &SolverOptions,
) -> Result<LeastSquaresFit, SolveError> {
    let start = options.start.map_or_else(|| vec![0.0; basis.unknowns()], <[f64]>::to_vec);
    let mut search = GaussNewton {
        basis,
        residual,
        tolerance_mm: options.tolerance * basis.size_mm(),
        now: Iterate::new(basis, residual, start),
        acceleration: AndersonAcceleration::new(Vec::new()),
        may_reuse: basis.unknowns() >= options.reuse_unknowns,
        triangle: None,
        sizes_mm: Vec::new(),
        condition: 0.0,
        last_step_mm: f64::NAN,
    };
    for steps in 1..=options.max_steps {
        if let Some(fit) = search.advance(steps)? {
            return Ok(fit);
        }
    }
    let last_step_mm = search.last_step_mm;
    Err(SolveError::NotConverged { steps: options.max_steps, last_step_mm })
}

/// State of the search.
struct GaussNewton<'a, R, const N: usize> {
    basis: &'a Basis,
    residual: &'a R,
    /// Change of F in a step that ends the search, mm.
    tolerance_mm: f64,
    now: Iterate<N>,
    acceleration: AndersonAcceleration,
    /// Whether the triangle of one step serves others.
    may_reuse: bool,
    /// Triangle of the last factorisation, if the next step may be by it.
    triangle: Option<StreamingQr>,
    /// Largest changes of F in the steps since that factorisation, mm.
    sizes_mm: Vec<f64>,
    /// Condition number of the first step.
    condition: f64,
    /// Largest change of F in the last step, mm.
    last_step_mm: f64,
}

impl<R: PointwiseResidual<N>, const N: usize> GaussNewton<'_, R, N> {
    /// Step number `steps`, counted from 1; the fit where the search ends.
    fn advance(&mut self, steps: usize) -> Result<Option<LeastSquaresFit>, SolveError> {
        let GaussNewtonStep { step, own_gain } = self.gauss_newton_step(steps)?;
        let is_own = own_gain.is_some();
        let change = self.basis.locals(&step);
        let size_mm = change.iter().fold(0.0, |most: f64, d| most.max(d[0].abs()));
        self.last_step_mm = size_mm;
        self.sizes_mm.push(size_mm);
        // A step by another triangle leaves as much as it goes: the last one is by its own.
        if size_mm <= self.tolerance_mm || !self.becomes_smaller() {
            self.triangle = None;
        }
        if self.accelerate(&step) {
            return Ok(None);
        }
        let whole = self.along(&step, 1.0);
        let ends =
            size_mm <= self.tolerance_mm || is_linear(&self.now.samples, &change, &whole.samples);
        if whole.integral.is_finite() && ends && is_own {
            return Ok(Some(self.fit(&whole, steps)));
        }
        // Near targets magnify rounding errors: at the answer, steps wander instead of becoming
        // small, and what they would gain is less than the integral's own noise.
        if !self.accepts(&whole) {
            let Some(gain) = own_gain else {
                // Only a step by its own triangle is worth shortening.
                self.triangle = None;
                return Ok(None);
            };
            if gain <= self.now.noise(self.basis) {
                return Ok(Some(self.fit(&self.now, steps)));
            }
        }
        self.line_search(&step, whole, steps)?;
        Ok(None)
    }

    /// Whether the steps by one triangle become smaller.
    fn becomes_smaller(&self) -> bool {
        let [first, .., last] = self.sizes_mm[..] else { return true };
        let before = self.sizes_mm.iter().rev().nth(REUSE_STEPS);
        last <= first && before.is_none_or(|before| last <= REUSE_GAIN * before)
    }

    /// The step from where the search is.
    fn gauss_newton_step(&mut self, steps: usize) -> Result<GaussNewtonStep, SolveError> {
        let undefined = || SolveError::Undefined {
            steps: steps - 1,
            coefficients: self.now.coefficients.clone(),
        };
        if !self.now.integral.is_finite() {
            return Err(undefined());
        }
        if let Some(triangle) = &self.triangle {
            let mut step = descent(self.basis, &self.now.samples);
            triangle.forward(&mut step);
            triangle.back(&mut step);
            if step.iter().all(|x| x.is_finite()) {
                return Ok(GaussNewtonStep { step, own_gain: None });
            }
        }
        let samples = self.now.samples.iter().enumerate();
        let weighted: Vec<_> = samples.map(|(k, s)| (k, self.basis.weight(k), *s)).collect();
        let qr = linearised(self.basis, &weighted);
        let step = match qr.solve() {
            // The residual has no derivative somewhere: more or fewer unknowns would not help.
            Err(RankDeficient { pivot, .. }) if pivot.is_nan() => return Err(undefined()),
            step => step?,
        };
        if steps == 1 {
            self.condition = condition_number(&qr);
            self.acceleration = AndersonAcceleration::new(column_norms(&qr));
        }
        let gain = self.now.integral - qr.residual_squared();
        if self.may_reuse && self.condition < REUSE_CONDITION {
            // Steps so far were by another triangle.
            self.acceleration.reset();
            self.sizes_mm.clear();
            self.triangle = Some(qr);
        }
        Ok(GaussNewtonStep { step, own_gain: Some(gain) })
    }

    /// Goes where the acceleration proposes, if the integral is no larger there; whether it went.
    fn accelerate(&mut self, step: &[f64]) -> bool {
        let proposal = self.acceleration.propose(&self.now.coefficients, step);
        let Some(coefficients) = proposal.filter(|_| self.last_step_mm > self.tolerance_mm) else {
            return false;
        };
        let then = Iterate::new(self.basis, self.residual, coefficients);
        let is_better = then.integral <= self.now.integral;
        if is_better {
            self.now = then;
        }
        is_better
    }

    /// Halves the step until the integral does not grow; `then` is the end of the whole step.
    fn line_search(
        &mut self,
        step: &[f64],
        mut then: Iterate<N>,
        steps: usize,
    ) -> Result<(), SolveError> {
        let (mut share, size_mm) = (1.0, self.last_step_mm);
        while !self.accepts(&then) {
            share *= 0.5;
            self.last_step_mm = share * size_mm;
            if share < LEAST_SHARE && !then.integral.is_finite() {
                return Err(SolveError::Undefined { steps, coefficients: then.coefficients });
            }
            if share < LEAST_SHARE {
                let last_step_mm = self.last_step_mm;
                return Err(SolveError::NotConverged { steps, last_step_mm });
            }
            then = self.along(step, share);
            self.acceleration.reset();
        }
        self.now = then;
        Ok(())
    }

    fn accepts(&self, then: &Iterate<N>) -> bool {
        then.integral <= self.now.integral * LARGEST_GROWTH
    }

    /// The mirror after a share of a step.
    fn along(&self, step: &[f64], share: f64) -> Iterate<N> {
        let now = self.now.coefficients.iter().zip(step);
        let coefficients = now.map(|(x, d)| x + share * d).collect();
        Iterate::new(self.basis, self.residual, coefficients)
    }

    fn fit(&self, at: &Iterate<N>, steps: usize) -> LeastSquaresFit {
        LeastSquaresFit {
            coefficients: at.coefficients.clone(),
            integral: at.integral,
            condition: self.condition,
            steps,
            last_step_mm: self.last_step_mm,
        }
    }
}

/// A step of Gauss and Newton, or nearly one.
struct GaussNewtonStep {
    /// Change of the coefficients, mm.
    step: Vec<f64>,
    /// What the integral would fall by, were the problem linear; none of a step by an earlier triangle.
    own_gain: Option<f64>,
}

/// Mirror at one step of the search, with its residuals.
struct Iterate<const N: usize> {
    /// Coefficients of the basis' functions, mm.
    coefficients: Vec<f64>,
    samples: Vec<ResidualSample<N>>,
    /// Integral of |r|^2 over the domain.
    integral: f64,
}

impl<const N: usize> Iterate<N> {
    fn new(basis: &Basis, residual: &impl PointwiseResidual<N>, coefficients: Vec<f64>) -> Self {
        let samples = ResidualSample::all(basis, residual, &basis.locals(&coefficients));
        let weighted = |(k, s): (usize, &ResidualSample<N>)| basis.weight(k) * s.square();
        let integral = samples.iter().enumerate().map(weighted).sum();
        Self { coefficients, samples, integral }
    }

    /// Uncertainty of the integral by rounding.
    fn noise(&self, basis: &Basis) -> f64 {
        let area: f64 = (0..basis.len()).map(|k| basis.weight(k)).sum();
        let terms = magnitude_of_terms(&self.samples, &basis.locals(&self.coefficients));
        let rounding = 1e-15 * terms;
        area * rounding * rounding + 2.0 * rounding * f64::sqrt(self.integral * area)
    }
}

#[cfg(test)]
mod tests {
    use super::super::basis::NodeSet;
    use super::*;
    use crate::geom::{DVec2, Rect};
    use crate::num::Scalar;
    use crate::num::streaming_qr::dot;

    /// grad F - s for a given field.
    struct GradientOf(fn(DVec2) -> DVec2);
    impl PointwiseResidual<2> for GradientOf {
        fn at<S: Scalar>(&self, q: DVec2, _: S, [x, y]: [S; 2]) -> [S; 2] {
            let s = (self.0)(q);
            [x - s.x, y - s.y]
        }
    }

    /// Riccati's equation F' + F^2 = 1 + (r - 2)^2, which F = r - 2 satisfies.
    struct Riccati;
    impl PointwiseResidual<1> for Riccati {
        fn at<S: Scalar>(&self, q: DVec2, f: S, [x, _]: [S; 2]) -> [S; 1] {
            [x + f.square() - (1.0 + (q.x - 2.0) * (q.x - 2.0))]
        }
    }

    struct CircleRoot;
    impl PointwiseResidual<1> for CircleRoot {
        fn at<S: Scalar>(&self, _: DVec2, f: S, [x, _]: [S; 2]) -> [S; 1] {
            [(x.square() + f.square() - 4.0).sqrt()]
        }
    }

    fn square() -> Rect {
        Rect { min: DVec2::splat(-1.0), max: DVec2::splat(1.0) }
    }

    #[test]
    fn a_gradient_is_met_in_one_step() {
        // F = x^2 y^2 - 1/9.
        let field = GradientOf(|q| DVec2::new(2.0 * q.x * q.y * q.y, 2.0 * q.x * q.x * q.y));
        for even in [[false; 2], [true, false], [true; 2]] {
            let basis = Basis::rectangle(square(), even, 4, NodeSet::Quadrature);
            let fit = solve(&basis, &field, &SolverOptions::default()).unwrap();
            assert_eq!(fit.steps, 1);
            assert!(fit.integral < 1e-29 && fit.condition < 20.0, "{fit:?}");
            for (k, [f, ..]) in basis.locals(&fit.coefficients).into_iter().enumerate() {
                let q = basis.at(k);
                assert!((f - (q.x * q.x * q.y * q.y - 1.0 / 9.0)).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn one_radius_is_enough_for_a_paraboloid() {
        // Nayar's mirror: F' = -r / h, zero at the rim.
        let basis = Basis::radial([0.0, 2.0], 5, NodeSet::Quadrature);
        let field = GradientOf(|q| DVec2::new(-q.x / 3.0, 0.0));
        let fit = solve(&basis, &field, &SolverOptions::default()).unwrap();
        assert!(fit.steps == 1 && fit.integral < 1e-29, "{fit:?}");
        for (k, [f, ..]) in basis.locals(&fit.coefficients).into_iter().enumerate() {
            let r = basis.at(k).x;
            assert!((f - (4.0 - r * r) / 6.0).abs() < 1e-14);
        }
    }

    #[test]
    fn what_no_gradient_meets_remains() {
        // (-y, x) is divergence-free and along the rim of a disc; on the square its best gradient
        // is not zero, but its integral is at most that of |q|^2, 8/3, and the residual is
        // orthogonal to every gradient.
        let basis = Basis::rectangle(square(), [false; 2], 6, NodeSet::Quadrature);
        let fit = solve(&basis, &GradientOf(|q| DVec2::new(-q.y, q.x)), &SolverOptions::default())
            .unwrap();
        let locals = basis.locals(&fit.coefficients);
        let energy: f64 = (0..basis.len())
            .map(|k| basis.weight(k) * (dot(&locals[k][1..], &locals[k][1..])))
            .sum();
        assert!((fit.integral + energy - 8.0 / 3.0).abs() < 1e-13);
    }

    #[test]
    fn a_problem_that_depends_on_f_converges() {
        let basis = Basis::radial([1.0, 2.0], 4, NodeSet::Quadrature);
        let fit = solve(&basis, &Riccati, &SolverOptions::default()).unwrap();
        assert!(fit.steps > 1 && fit.steps < 12 && fit.integral < 1e-28, "{fit:?}");
        for (k, [f, ..]) in basis.locals(&fit.coefficients).into_iter().enumerate() {
            assert!((f - (basis.at(k).x - 2.0)).abs() < 1e-13);
        }
    }

    #[test]
    fn triangles_that_serve_other_steps_lead_to_the_same_answer() {
        let basis = Basis::radial([1.0, 2.0], 4, NodeSet::Quadrature);
        let [own, reused] = [usize::MAX, 0].map(|reuse_unknowns| {
            let options = SolverOptions { reuse_unknowns, ..SolverOptions::default() };
            solve(&basis, &Riccati, &options).unwrap()
        });
        // (Steps without a triangle of their own are more.)
        assert!(reused.steps > own.steps && reused.steps < 20, "{own:?} {reused:?}");
        assert!(reused.integral < 1e-28, "{reused:?}");
        for (a, b) in own.coefficients.iter().zip(&reused.coefficients) {
            assert!((a - b).abs() < 1e-13, "{own:?} {reused:?}");
        }
    }

    #[test]
    fn failures_are_typed() {
        let basis = Basis::radial([1.0, 2.0], 4, NodeSet::Quadrature);
        let nan = solve(&basis, &CircleRoot, &SolverOptions::default()).unwrap_err();
        assert!(matches!(nan, SolveError::Undefined { steps: 0, .. }));
        let hurried = SolverOptions { max_steps: 1, ..SolverOptions::default() };
        let error = solve(&basis, &Riccati, &hurried).unwrap_err();
        assert!(matches!(error, SolveError::NotConverged { steps: 1, .. }));
    }

    /// |F'|, which has no derivative where the search starts.
    struct AbsoluteSlope;
    impl PointwiseResidual<1> for AbsoluteSlope {
        fn at<S: Scalar>(&self, _: DVec2, _: S, [x, _]: [S; 2]) -> [S; 1] {
            [x.square().sqrt()]
        }
    }

    #[test]
    fn a_residual_without_derivatives_is_not_called_undetermined() {
        let basis = Basis::radial([1.0, 2.0], 4, NodeSet::Quadrature);
        let error = solve(&basis, &AbsoluteSlope, &SolverOptions::default()).unwrap_err();
        assert!(matches!(error, SolveError::Undefined { steps: 0, .. }), "{error}");
    }
}
