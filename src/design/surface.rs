//! From the solver's coefficients to a mirror.

use super::basis::{Basis, LocalValues, NodeSet};
use super::cause::{FailureCause, FitStage, LocalFailure};
use super::facts::{DesignFacts, in_paper_units};
use super::layout::DesignProblem;
use super::minimax::minimax;
use super::residual::{GradientResidual, ImageResidual, NormalResidual, RayResidual};
use super::residual_sample::PointwiseResidual;
use super::solve::{LeastSquaresFit, SolveError, SolverOptions, solve};
use crate::geom::Outline;
use crate::mirror::{Mirror, RadialLegendre, Surface, TensorLegendre};
use crate::num::legendre::Series;
use crate::profile::{Method, MethodKind};

/// Solves the problem that `problem` states.
///
/// # Errors
/// [`FailureCause::Fit`], or [`FailureCause::At`] where the residual has no value, when it has no answer.
pub(super) fn solved(
    problem: &DesignProblem,
    method: &Method,
) -> Result<(Mirror, DesignFacts), FailureCause> {
    let degree = method.degree;
    let (fit, residual) = fit(problem, method).map_err(|(stage, source)| match source {
        SolveError::Undefined { ref coefficients, .. } => {
            undefined(problem, degree, stage, coefficients).unwrap_or(FailureCause::Fit {
                degree,
                stage,
                source,
            })
        }
        source => FailureCause::Fit { degree, stage, source },
    })?;
    let mut facts = DesignFacts::solved(method.kind.name(), method.minimax, degree, &fit);
    facts.gradient_residual = Some(in_paper_units(residual, problem));
    let mirror = Mirror {
        surface: surface(problem, &fit.coefficients, degree),
        chart: problem.camera.chart,
        outline: problem.outline,
        folded: problem.view.fold.is_some(),
        mirror_symmetric: problem.mirror_symmetric,
    };
    Ok((mirror, facts))
}

fn basis(problem: &DesignProblem, degree: usize, places: NodeSet) -> Basis {
    match problem.domain {
        Outline::Rect(area) => {
            let (even, view) = (problem.mirror_symmetric, &problem.view);
            if let Some(picture) = problem.picture {
                return Basis::over_picture((area, picture), even, degree, places, view);
            }
            let whole = Basis::rectangle(area, even, degree, places);
            match problem.section {
                Some(panel) => whole.with_mean_zero_over(panel, area),
                None => whole,
            }
        }
        Outline::Ring { inner, outer } => Basis::radial([inner, outer], degree, places),
    }
}

/// Place and reason of a residual without a value at the mirror of `coefficients`.
fn undefined(
    problem: &DesignProblem,
    degree: usize,
    stage: FitStage,
    coefficients: &[f64],
) -> Option<FailureCause> {
    let places = if stage == FitStage::Minimax { NodeSet::Extrema } else { NodeSet::Quadrature };
    let nodes = basis(problem, degree, places);
    let (chart, view) = (&problem.camera.chart, &problem.view);
    let failing = |(k, [f, x, y]): (usize, LocalValues)| {
        let q = nodes.at(k);
        let place = chart.point(q, f);
        let slope = chart.slope(q.to_array(), [x, y]);
        let failure = LocalFailure::at(chart, view, q, place, slope)
            .or_else(|| LocalFailure::of_slopes(chart, place, slope))?;
        Some(FailureCause::At { at: place.truncate(), failure, stage: Some(stage) })
    };
    nodes.locals(coefficients).into_iter().enumerate().find_map(failing)
}

/// The fit, and the integral of |grad F - s|^2 that it leaves, mm^2.
fn fit(
    problem: &DesignProblem,
    method: &Method,
) -> Result<(LeastSquaresFit, f64), (FitStage, SolveError)> {
    let at = |stage| move |error| (stage, error);
    let (chart, view) = (&problem.camera.chart, &problem.view);
    let nodes = basis(problem, method.degree, NodeSet::Quadrature);
    let field = GradientResidual { chart, view };
    let first = solve(&nodes, &field, &SolverOptions::default()).map_err(at(FitStage::Field))?;
    let from = |fit: &LeastSquaresFit| fit.coefficients.clone();
    let start = from(&first);
    let options = SolverOptions { start: Some(&start), ..SolverOptions::default() };
    let fixed = ImageResidual { chart, view };
    let distribution = NormalResidual { chart, view };
    let mut fit = match method.kind {
        MethodKind::VectorField => first.clone(),
        MethodKind::FixedSurface => {
            solve(&nodes, &fixed, &options).map_err(at(FitStage::Method))?
        }
        MethodKind::Distribution => {
            solve(&nodes, &distribution, &options).map_err(at(FitStage::Method))?
        }
    };
    if method.minimax {
        let places = basis(problem, method.degree, NodeSet::Extrema);
        let start = from(&fit);
        let found = match method.kind {
            MethodKind::VectorField => minimax(&places, &RayResidual { chart, view }, &start),
            MethodKind::FixedSurface => minimax(&places, &fixed, &start),
            MethodKind::Distribution => minimax(&places, &distribution, &start),
        }
        .map_err(at(FitStage::Minimax))?;
        fit.coefficients = found.coefficients;
        fit.steps += found.steps;
    }
    fit.condition = first.condition;
    // A figure wants the field resolved to rounding; under a wide pinhole the fit does with less.
    let fine = basis(problem, method.degree, NodeSet::Fine);
    let residual = integral(&fine, &field, &fit.coefficients);
    Ok((fit, residual))
}

/// The integral of |r|^2 over the domain, mm^2.
fn integral(nodes: &Basis, residual: &impl PointwiseResidual<2>, coefficients: &[f64]) -> f64 {
    let square = |(k, [f, x, y]): (usize, LocalValues)| {
        let r = residual.at(nodes.at(k), f, [x, y]);
        nodes.weight(k) * (r[0] * r[0] + r[1] * r[1])
    };
    nodes.locals(coefficients).into_iter().enumerate().map(square).sum()
}

fn surface(problem: &DesignProblem, coefficients: &[f64], degree: usize) -> Surface {
    let scale_mm = problem.view.projection.scale_mm();
    let side = degree + 1;
    match problem.domain {
        Outline::Rect(area) => {
            let mut grid = vec![0.0; side * side];
            let basis = basis(problem, degree, NodeSet::Quadrature);
            for ((&(i, j), level), c) in basis.terms().iter().zip(basis.levels()).zip(coefficients)
            {
                grid[i * side + j] = c / scale_mm;
                grid[0] -= level * c / scale_mm;
            }
            let series = Series::from_fn(side, side, |i, j| grid[i * side + j]);
            let (centre, half) = (area.centre(), 0.5 * area.size());
            Surface::Tensor(TensorLegendre { series, centre, half, scale_mm })
        }
        Outline::Ring { inner, outer } => {
            // The functions are P_k - 1: zero at the outer rim.
            let sum: f64 = coefficients.iter().sum();
            let coefficient = |k: usize| if k == 0 { -sum } else { coefficients[k - 1] };
            let series = Series::from_fn(side, 1, |k, _| coefficient(k) / scale_mm);
            Surface::Radial(RadialLegendre::new(series, [inner, outer], scale_mm))
        }
    }
}
