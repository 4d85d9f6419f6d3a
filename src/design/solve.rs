//! Least squares for any design method: Gauss-Newton on a pointwise residual, each step a QR.
//!
//! Paper, section 3: the vector-field method, the fixed-surface method and the method of
//! distributions differ in nothing but the residual.

use super::anderson::AndersonAcceleration;
use super::basis::{Basis, LocalValues, variables};
use crate::geom::DVec2;
use crate::num::Scalar;
use crate::num::condition::{column_norms, condition_number};
use crate::num::least_squares::RankDeficient;
use crate::num::streaming_qr::{RowBlock, StreamingQr};
use crate::parallel;
use thiserror::Error;

/// Places whose rows enter the QR together.
const BLOCK: usize = 96;
/// What an integral may grow by in a step that is not shortened.
const LARGEST_GROWTH: f64 = 1.0 + 1e-9;

/// How far a mirror F(q) is from what is wanted, at one image point.
pub trait PointwiseResidual<const N: usize>: Sync {
    /// The residual at `q` (mm) of a mirror that has there the value `f` (mm) and the slopes dF/dx
    /// and dF/dy.
    fn at<S: Scalar>(&self, q: DVec2, f: S, slope: [S; 2]) -> [S; N];
}

/// How to search.
#[derive(Debug, Clone, Copy)]
pub struct SolverOptions<'a> {
    /// Coefficients to start from; zero without.
    pub start: Option<&'a [f64]>,
    /// Largest change of F in the last step, in sizes of the domain.
    pub tolerance: f64,
    /// Steps before giving up.
    pub max_steps: usize,
}

impl Default for SolverOptions<'_> {
    fn default() -> Self {
        Self { start: None, tolerance: 1e-12, max_steps: 200 }
    }
}

/// A fitted mirror.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquaresFit {
    /// Coefficients of the basis' functions, mm.
    pub coefficients: Vec<f64>,
    /// Integral of |r|^2 over the domain, mm^2 times the residual's unit squared.
    pub integral: f64,
    /// Condition number (2-norm) of the first step's matrix, its columns scaled to unit length.
    pub condition: f64,
    /// Steps taken.
    pub steps: usize,
    /// Largest change of F in the last step, mm.
    pub last_step_mm: f64,
}

/// Why there is no fit.
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
        /// That mirror's coefficients, mm.
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
pub fn solve<const N: usize>(
    basis: &Basis,
    residual: &impl PointwiseResidual<N>,
    options: &SolverOptions,
) -> Result<LeastSquaresFit, SolveError> {
    let start = options.start.map_or_else(|| vec![0.0; basis.unknowns()], <[f64]>::to_vec);
    let mut now = Iterate::new(basis, residual, start);
    let mut anderson = AndersonAcceleration::new(Vec::new());
    let (mut condition, mut last_step_mm) = (0.0, f64::NAN);
    let goal = options.tolerance * basis.size_mm();
    for steps in 1..=options.max_steps {
        if !now.integral.is_finite() {
            return Err(SolveError::Undefined { steps: steps - 1, coefficients: now.x });
        }
        let weighted: Vec<_> =
            now.samples.iter().enumerate().map(|(k, s)| (k, basis.weight(k), *s)).collect();
        let qr = linearised(basis, &weighted);
        let step = match qr.solve() {
            // The residual has no derivative somewhere: more or fewer unknowns would not help.
            Err(RankDeficient { pivot, .. }) if pivot.is_nan() => {
                return Err(SolveError::Undefined { steps: steps - 1, coefficients: now.x });
            }
            step => step?,
        };
        if steps == 1 {
            condition = condition_number(&qr);
            anderson = AndersonAcceleration::new(column_norms(&qr));
        }
        let change = basis.locals(&step);
        let reach = change.iter().fold(0.0, |most: f64, d| most.max(d[0].abs()));
        last_step_mm = reach;
        let along = |share: f64| {
            let x = now.x.iter().zip(&step).map(|(x, d)| x + share * d).collect();
            Iterate::new(basis, residual, x)
        };
        let proposal = anderson.propose(&now.x, &step);
        if let (Some(to), true) = (proposal, reach > goal) {
            let then = Iterate::new(basis, residual, to);
            if then.integral <= now.integral {
                now = then;
                continue;
            }
        }
        let whole = along(1.0);
        if whole.integral.is_finite()
            && (reach <= goal || is_linear(&now.samples, &change, &whole.samples))
        {
            let Iterate { x, integral, .. } = whole;
            return Ok(LeastSquaresFit {
                coefficients: x,
                integral,
                condition,
                steps,
                last_step_mm,
            });
        }
        // Near targets magnify rounding errors: at the answer, steps wander instead of becoming
        // small, and what they would gain is less than the integral's own noise.
        let gain = now.integral - qr.residual_squared();
        if !(whole.integral <= now.integral * LARGEST_GROWTH) && gain <= now.noise(basis) {
            let Iterate { x, integral, .. } = now;
            return Ok(LeastSquaresFit {
                coefficients: x,
                integral,
                condition,
                steps,
                last_step_mm,
            });
        }
        let (mut share, mut then) = (1.0, whole);
        while !(then.integral <= now.integral * LARGEST_GROWTH) {
            share *= 0.5;
            last_step_mm = share * reach;
            if share < 1e-9 && !then.integral.is_finite() {
                return Err(SolveError::Undefined { steps, coefficients: then.x });
            }
            if share < 1e-9 {
                return Err(SolveError::NotConverged { steps, last_step_mm });
            }
            then = along(share);
            anderson.reset();
        }
        now = then;
    }
    Err(SolveError::NotConverged { steps: options.max_steps, last_step_mm })
}

/// The magnitude of the terms that cancel in the residual.
pub fn scale<const N: usize>(samples: &[ResidualSample<N>], locals: &[LocalValues]) -> f64 {
    let term = |(s, l): (&ResidualSample<N>, &LocalValues)| {
        s.by.iter().flat_map(|by| by.iter().zip(l)).map(|(b, l)| (b * l).abs()).sum::<f64>()
    };
    samples.iter().zip(locals).map(term).fold(0.0, f64::max)
}

/// A mirror under trial.
struct Iterate<const N: usize> {
    x: Vec<f64>,
    samples: Vec<ResidualSample<N>>,
    integral: f64,
}

impl<const N: usize> Iterate<N> {
    fn new(basis: &Basis, residual: &impl PointwiseResidual<N>, x: Vec<f64>) -> Self {
        let samples = ResidualSample::all(basis, residual, &basis.locals(&x));
        let weighted = |(k, s): (usize, &ResidualSample<N>)| basis.weight(k) * s.square();
        let integral = samples.iter().enumerate().map(weighted).sum();
        Self { x, samples, integral }
    }

    /// How uncertain the integral is by rounding.
    fn noise(&self, basis: &Basis) -> f64 {
        let area: f64 = (0..basis.len()).map(|k| basis.weight(k)).sum();
        let rounding = 1e-15 * scale(&self.samples, &basis.locals(&self.x));
        area * rounding * rounding + 2.0 * rounding * f64::sqrt(self.integral * area)
    }
}

/// A residual with its derivatives by F, dF/dx and dF/dy.
#[derive(Debug, Clone, Copy)]
pub struct ResidualSample<const N: usize> {
    /// r.
    pub r: [f64; N],
    /// Derivatives of each component.
    pub by: [LocalValues; N],
}

impl<const N: usize> ResidualSample<N> {
    /// The residual of a mirror with the given local values at `q`.
    pub fn new(residual: &impl PointwiseResidual<N>, q: DVec2, local: LocalValues) -> Self {
        let (f, slope) = variables(local);
        let r = residual.at(q, f, slope);
        Self { r: r.map(|r| r.value), by: r.map(|r| r.slope) }
    }

    /// The residual at every place.
    pub fn all(
        basis: &Basis,
        residual: &impl PointwiseResidual<N>,
        locals: &[LocalValues],
    ) -> Vec<Self> {
        let at = |k: usize| Self::new(residual, basis.at(k), locals[k]);
        parallel::map(locals.len(), BLOCK, at)
    }

    /// |r|^2.
    pub fn square(&self) -> f64 {
        self.r.iter().map(|r| r * r).sum()
    }

    /// The residual after a change of the local values, were it linear in them.
    pub fn after(&self, change: &LocalValues) -> [f64; N] {
        std::array::from_fn(|k| {
            let [f, x, y] = self.by[k];
            self.r[k] + f * change[0] + x * change[1] + y * change[2]
        })
    }

    /// At most three rows (derivatives; right side) with the same least squares.
    fn rows(&self) -> ([[f64; 4]; N], usize) {
        let mut rows: [[f64; 4]; N] = std::array::from_fn(|k| {
            let [f, x, y] = self.by[k];
            [f, x, y, -self.r[k]]
        });
        if N <= 2 {
            return (rows, N);
        }
        let mut used = 0;
        for column in 0..3 {
            for k in used + 1..N {
                let (a, b) = (rows[used][column], rows[k][column]);
                if b != 0.0 {
                    let length = f64::sqrt(a * a + b * b);
                    let (cos, sin) = (a / length, b / length);
                    let (upper, lower) = rows.split_at_mut(k);
                    for (a, b) in upper[used].iter_mut().zip(&mut lower[0]) {
                        (*a, *b) = (cos * *a + sin * *b, cos * *b - sin * *a);
                    }
                    rows[k][column] = 0.0;
                }
            }
            if used < N && rows[used][column] != 0.0 {
                used += 1;
            }
        }
        (rows, used)
    }
}

/// Whether the residual went where its derivatives said, to rounding: the problem is linear.
fn is_linear<const N: usize>(
    before: &[ResidualSample<N>],
    change: &[LocalValues],
    after: &[ResidualSample<N>],
) -> bool {
    let (mut gap, mut went) = (0.0f64, 0.0f64);
    for ((s, d), then) in before.iter().zip(change).zip(after) {
        for ((foreseen, was), is) in s.after(d).iter().zip(s.r).zip(then.r) {
            gap = gap.max((foreseen - is).abs());
            went = went.max((foreseen - was).abs());
        }
    }
    gap <= 1e-13 * went
}

/// The triangle of the linearised problem of the samples, each of (place, weight, residual).
pub fn linearised<const N: usize>(
    basis: &Basis,
    samples: &[(usize, f64, ResidualSample<N>)],
) -> StreamingQr {
    let mut qr = StreamingQr::new(basis.unknowns());
    for part in samples.chunks(BLOCK) {
        let condensed: Vec<_> = part.iter().map(|s| s.2.rows()).collect();
        let mut rows = RowBlock::zeros(condensed.iter().map(|c| c.1).sum(), basis.unknowns());
        let mut row = 0;
        for (&(place, weight, _), (local, used)) in part.iter().zip(&condensed) {
            let root = f64::sqrt(weight);
            for &[f, x, y, b] in &local[..*used] {
                let [f, x, y] = [root * f, root * x, root * y];
                let a = basis.row(place).map(|[b, b_x, b_y]| f * b + x * b_x + y * b_y);
                rows.set(row, a, root * b);
                row += 1;
            }
        }
        qr.absorb(rows);
    }
    qr
}

#[cfg(test)]
mod tests {
    use super::super::basis::NodeSet;
    use super::*;
    use crate::geom::Rect;
    use crate::num::streaming_qr::dot;

    /// grad F - s for a given field.
    struct GradientOf(fn(DVec2) -> DVec2);
    impl PointwiseResidual<2> for GradientOf {
        fn at<S: Scalar>(&self, q: DVec2, _: S, [x, y]: [S; 2]) -> [S; 2] {
            let s = (self.0)(q);
            [x - s.x, y - s.y]
        }
    }

    /// F' + F^2 = 1 + (r - 2)^2, which F = r - 2 satisfies: a problem that depends on F.
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
        for even in [false, true] {
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
        let basis = Basis::rectangle(square(), false, 6, NodeSet::Quadrature);
        let fit = solve(&basis, &GradientOf(|q| DVec2::new(-q.y, q.x)), &SolverOptions::default())
            .unwrap();
        let locals = basis.locals(&fit.coefficients);
        let energy: f64 = (0..basis.len())
            .map(|k| basis.weight(k) * (dot(&locals[k][1..], &locals[k][1..])))
            .sum();
        assert!((fit.integral + energy - 8.0 / 3.0).abs() < 1e-13);
    }

    #[test]
    fn a_bent_problem_converges() {
        let basis = Basis::radial([1.0, 2.0], 4, NodeSet::Quadrature);
        let fit = solve(&basis, &Riccati, &SolverOptions::default()).unwrap();
        assert!(fit.steps > 1 && fit.steps < 12 && fit.integral < 1e-28, "{fit:?}");
        for (k, [f, ..]) in basis.locals(&fit.coefficients).into_iter().enumerate() {
            assert!((f - (basis.at(k).x - 2.0)).abs() < 1e-13);
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
