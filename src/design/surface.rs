//! From the solver's coefficients to a mirror.

use super::basis::{Basis, Local, Places};
use super::cause::{Cause, Goal, Trouble};
use super::facts::{Facts, in_paper_units};
use super::layout::Plan;
use super::minimax::minimax;
use super::residual::{Distribution, FixedSurface, RayError, VectorField};
use super::solve::{Fit, Options, Residual, SolveError, solve};
use crate::geom::Outline;
use crate::mirror::{Mirror, RadialLegendre, Surface, TensorLegendre};
use crate::num::legendre::Series;
use crate::profile::{Method, MethodKind};

/// Solves the problem that `plan` states.
///
/// # Errors
/// [`Cause::Fit`], or [`Cause::At`] where the residual has no value, when it has no answer.
pub fn solved(plan: &Plan, method: &Method) -> Result<(Mirror, Facts), Cause> {
    let degree = method.degree;
    let (fit, residual) = fit(plan, method).map_err(|(goal, source)| match source {
        SolveError::Undefined { ref coefficients, .. } => {
            undefined(plan, degree, goal, coefficients).unwrap_or(Cause::Fit {
                degree,
                goal,
                source,
            })
        }
        source => Cause::Fit { degree, goal, source },
    })?;
    let mut facts = Facts::solved(method.kind.name(), method.minimax, degree, &fit);
    facts.gradient_residual = Some(in_paper_units(residual, plan));
    let mirror = Mirror {
        surface: surface(plan, &fit.coefficients, degree),
        chart: plan.camera.chart,
        outline: plan.outline,
        folded: plan.view.fold.is_some(),
        mirror_symmetric: plan.even,
    };
    Ok((mirror, facts))
}

fn basis(plan: &Plan, degree: usize, places: Places) -> Basis {
    match plan.domain {
        Outline::Rect(area) => {
            let whole = Basis::rectangle(area, plan.even[0], degree, places);
            match plan.cut {
                Some(panel) => whole.with_mean_zero_over(panel, area),
                None => whole,
            }
        }
        Outline::Ring { inner, outer } => Basis::radial([inner, outer], degree, places),
    }
}

/// Where and why the residual has no value at the mirror of `coefficients`.
fn undefined(plan: &Plan, degree: usize, goal: Goal, coefficients: &[f64]) -> Option<Cause> {
    let places = if goal == Goal::Minimax { Places::Extrema } else { Places::Quadrature };
    let nodes = basis(plan, degree, places);
    let (chart, view) = (&plan.camera.chart, &plan.view);
    let troubled = |(k, [f, x, y]): (usize, Local)| {
        let q = nodes.at(k);
        let place = chart.point(q, f);
        let slope = chart.slope(q.to_array(), [x, y]);
        let trouble = Trouble::at(chart, view, q, place, slope)
            .or_else(|| Trouble::of_slopes(chart, place, slope))?;
        Some(Cause::At { at: place.truncate(), trouble, goal: Some(goal) })
    };
    nodes.locals(coefficients).into_iter().enumerate().find_map(troubled)
}

/// The fit, and the integral of |grad F - s|^2 that it leaves, mm^2.
fn fit(plan: &Plan, method: &Method) -> Result<(Fit, f64), (Goal, SolveError)> {
    let at = |goal| move |error| (goal, error);
    let (chart, view) = (&plan.camera.chart, &plan.view);
    let nodes = basis(plan, method.degree, Places::Quadrature);
    let field = VectorField { chart, view };
    let first = solve(&nodes, &field, &Options::default()).map_err(at(Goal::Field))?;
    let from = |fit: &Fit| fit.coefficients.clone();
    let start = from(&first);
    let options = Options { start: Some(&start), ..Options::default() };
    let fixed = FixedSurface { chart, view };
    let distribution = Distribution { chart, view };
    let mut fit = match method.kind {
        MethodKind::VectorField => first.clone(),
        MethodKind::FixedSurface => solve(&nodes, &fixed, &options).map_err(at(Goal::Method))?,
        MethodKind::Distribution => {
            solve(&nodes, &distribution, &options).map_err(at(Goal::Method))?
        }
    };
    if method.minimax {
        let places = basis(plan, method.degree, Places::Extrema);
        let start = from(&fit);
        let found = match method.kind {
            MethodKind::VectorField => minimax(&places, &RayError { chart, view }, &start),
            MethodKind::FixedSurface => minimax(&places, &fixed, &start),
            MethodKind::Distribution => minimax(&places, &distribution, &start),
        }
        .map_err(at(Goal::Minimax))?;
        fit.coefficients = found.coefficients;
        fit.steps += found.steps;
    }
    fit.condition = first.condition;
    // A figure wants the field resolved to rounding; under a wide pinhole the fit does with less.
    let fine = basis(plan, method.degree, Places::Fine);
    let residual = integral(&fine, &field, &fit.coefficients);
    Ok((fit, residual))
}

/// The integral of |r|^2 over the domain, mm^2.
fn integral(nodes: &Basis, residual: &impl Residual<2>, coefficients: &[f64]) -> f64 {
    let square = |(k, [f, x, y]): (usize, Local)| {
        let r = residual.at(nodes.at(k), f, [x, y]);
        nodes.weight(k) * (r[0] * r[0] + r[1] * r[1])
    };
    nodes.locals(coefficients).into_iter().enumerate().map(square).sum()
}

fn surface(plan: &Plan, coefficients: &[f64], degree: usize) -> Surface {
    let scale_mm = plan.view.projection.scale_mm();
    let side = degree + 1;
    match plan.domain {
        Outline::Rect(area) => {
            let mut grid = vec![0.0; side * side];
            let basis = basis(plan, degree, Places::Quadrature);
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
            Surface::Round(RadialLegendre::new(series, [inner, outer], scale_mm))
        }
    }
}
