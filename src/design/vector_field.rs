//! The vector-field method (paper, sections 3.2 and 4): the f whose gradient is nearest to the
//! slope field s, in the sense of the integral of |grad f - s|^2 over the domain.

use super::layout::Plan;
use crate::geom::DVec2;
use crate::num::least_squares::{RankDeficient, solve};
use crate::num::legendre::{Series, derivatives, values};
use crate::num::quadrature::gauss_legendre;
use nalgebra::{DMatrix, DVector};

/// A fitted sheet in the paper's units over (u, v) in [-1, 1]^2.
pub struct Fit {
    /// f, with mean zero over the domain.
    pub series: Series,
    /// Coefficients solved for.
    pub unknowns: usize,
    /// The integral that was minimised.
    pub residual: f64,
}

/// Fits a tensor Legendre series of the given degree in each variable; odd degrees in X are left
/// out where the problem is even.
pub fn fit(plan: &Plan, degree: usize) -> Result<Fit, RankDeficient> {
    let stride = if plan.even_x { 2 } else { 1 };
    let terms: Vec<(usize, usize)> = (0..=degree)
        .step_by(stride)
        .flat_map(|i| (0..=degree).map(move |j| (i, j)))
        .filter(|&term| term != (0, 0))
        .collect();

    // The polynomial part needs degree + 1 nodes; the rest resolves the field itself, whose
    // nearest singularity is a law coordinate of +-i away.
    let nodes = gauss_legendre(2 * degree + 24);
    let along_u = basis(&nodes, degree, plan.even_x);
    let along_v = basis(&nodes, degree, false);
    let half = 0.5 * plan.domain.size();
    let half_paper = half / plan.strip.scale_mm;

    let rows = 2 * along_u.len() * along_v.len();
    let mut matrix = DMatrix::zeros(rows, terms.len());
    let mut wanted = DVector::zeros(rows);
    for (k, (a, b)) in along_u.iter().flat_map(|a| along_v.iter().map(move |b| (a, b))).enumerate()
    {
        let weight = (a.weight * b.weight * half_paper.x * half_paper.y).sqrt();
        let slope = plan.strip.slope(plan.domain.centre() + half * DVec2::new(a.node, b.node));
        wanted[2 * k] = weight * slope.x;
        wanted[2 * k + 1] = weight * slope.y;
        for (column, &(i, j)) in terms.iter().enumerate() {
            matrix[(2 * k, column)] = weight * a.d[i] * b.p[j] / half_paper.x;
            matrix[(2 * k + 1, column)] = weight * a.p[i] * b.d[j] / half_paper.y;
        }
    }
    // Columns of unit length: the derivative of P_k grows like k^(3/2).
    let lengths: Vec<f64> = matrix.column_iter().map(|c| c.norm()).collect();
    for (mut column, length) in matrix.column_iter_mut().zip(&lengths) {
        column /= *length;
    }
    let solution = solve(matrix, wanted)?;
    let mut coefficients = vec![0.0; (degree + 1) * (degree + 1)];
    for ((x, length), (i, j)) in solution.x.iter().zip(&lengths).zip(&terms) {
        coefficients[i * (degree + 1) + j] = x / length;
    }
    Ok(Fit {
        series: Series::from_fn(degree + 1, degree + 1, |i, j| coefficients[i * (degree + 1) + j]),
        unknowns: terms.len(),
        residual: solution.residual_squared,
    })
}

/// Legendre values and derivatives at one quadrature node.
struct Node {
    node: f64,
    weight: f64,
    p: Vec<f64>,
    d: Vec<f64>,
}

/// The nodes along one direction; an even integrand needs only the positive half, twice.
fn basis((nodes, weights): &(Vec<f64>, Vec<f64>), degree: usize, even: bool) -> Vec<Node> {
    let half = if even { nodes.len() / 2 } else { 0 };
    let times = if even { 2.0 } else { 1.0 };
    let make = |(&node, &weight): (&f64, &f64)| {
        let p = values(degree, node);
        Node { node, weight: times * weight, d: derivatives(&p), p }
    };
    nodes[half..].iter().zip(&weights[half..]).map(make).collect()
}
