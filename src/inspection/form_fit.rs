//! Measured points to form terms with their uncertainty, beyond what a better pose would take away.

use crate::align::PointAlignment;
use crate::geom::DVec3;
use crate::mirror::Mirror;
use crate::tolerance::{FormBasis, Perturbation};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// A term of the form error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedTerm {
    /// Its error source.
    pub term: Perturbation,
    /// Its size from peak to valley along Z, mm.
    pub pv_mm: f64,
    /// Its standard uncertainty from the points' noise and number, mm.
    pub uncertainty_mm: f64,
}

/// Low form terms of a made mirror, and what they leave.
#[derive(Debug, Clone, PartialEq)]
pub struct FormFit {
    /// The terms.
    pub terms: Vec<FittedTerm>,
    /// Points that they rest on: those on the mirror that are no outliers.
    pub points: usize,
    /// Standard deviation of what the terms leave, mm: finer form errors, texture and the machine's noise.
    pub rest_mm: f64,
}

/// Freedoms of a rigid motion.
const MOTIONS: usize = 6;
/// Share of the largest motion across the surface below which a motion is free, and what the fit of the terms leaves
/// to rounding.
const FREE: f64 = 1e-3;
const ROUNDING: f64 = 1e-6;

/// Fits the low terms of `mirror` to points that were aligned with it, by least squares; none where there are too few.
///
/// The pose is fitted first, to the points alone, so the terms are those of the form beyond the best pose. Their
/// covariance is that of this order of fits under independent noise, whose variance is what both leave together.
#[must_use]
pub fn fit_form(mirror: &Mirror, found: &PointAlignment) -> Option<FormFit> {
    let basis = FormBasis::new(mirror);
    let count = basis.terms().count();
    let near = found.residuals.iter().flatten().filter(|r| r.distance.abs() < found.reach_mm);
    let points = near.clone().count();
    if points <= MOTIONS + count {
        return None;
    }
    let centre = near.clone().map(|r| r.at).sum::<DVec3>() / points as f64;
    let square = |r: &crate::align::PointResidual| (r.at - centre).length_squared();
    let gyration = (near.clone().map(square).sum::<f64>() / points as f64).sqrt();
    // The products of all columns: six motions, the terms, the distances.
    let width = MOTIONS + count + 1;
    let mut products = DMatrix::<f64>::zeros(width, width);
    let mut row = Vec::with_capacity(width);
    for residual in near {
        let (n, lever) =
            (residual.normal, (residual.at - centre).cross(residual.normal) / gyration);
        row.clear();
        row.extend([n.x, n.y, n.z, lever.x, lever.y, lever.z]);
        row.extend(basis.heights([residual.at.x, residual.at.y]).map(|height| height * n.z));
        row.push(residual.distance);
        for (j, b) in row.iter().enumerate() {
            for (i, a) in row.iter().enumerate().take(j + 1) {
                products[(i, j)] += a * b;
            }
        }
    }
    products.fill_lower_triangle_with_upper_triangle();
    let fit = TermEquations { products, count }.solve(points);
    let terms = basis.terms().enumerate().map(|(k, term)| FittedTerm {
        term,
        pv_mm: fit.terms[k],
        uncertainty_mm: fit.uncertainties[k],
    });
    Some(FormFit { terms: terms.collect(), points, rest_mm: fit.rest })
}

/// Normal equations of motions, `count` terms and the distances.
struct TermEquations {
    products: DMatrix<f64>,
    count: usize,
}

/// Their solution.
struct SolvedTerms {
    terms: DVector<f64>,
    uncertainties: Vec<f64>,
    rest: f64,
}

impl TermEquations {
    /// Solves for the motions, and then for the terms of what these leave of so many points.
    fn solve(self, points: usize) -> SolvedTerms {
        let (m, n) = (MOTIONS, self.count);
        let block = |at: (usize, usize), size: (usize, usize)| -> DMatrix<f64> {
            self.products.view(at, size).into_owned()
        };
        let (motions, free) = pseudo_inverse(block((0, 0), (m, m)), FREE);
        // What the best motion leaves of terms and distances.
        let beyond = |at: (usize, usize), left: usize, right: usize, size: (usize, usize)| {
            block(at, size)
                - block((left, 0), (size.0, m)) * &motions * block((0, right), (m, size.1))
        };
        let terms = beyond((m, m), m, m, (n, n));
        let side = beyond((m, m + n), m, m + n, (n, 1));
        let squares = beyond((m + n, m + n), m + n, m + n, (1, 1))[(0, 0)];
        let (gram, _) = pseudo_inverse(block((m, m), (n, n)), ROUNDING);
        let found = &gram * &side;
        // Both together leave the noise, whatever they share.
        let (joint, lost) = pseudo_inverse(terms.clone(), ROUNDING);
        let left = squares - (side.transpose() * joint * &side)[(0, 0)];
        let freedom = points - (m - free) - (n - lost);
        let variance = left.max(0.0) / freedom as f64;
        let covariance = &gram * terms * &gram * variance;
        SolvedTerms {
            terms: found.column(0).into_owned(),
            uncertainties: covariance.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect(),
            rest: variance.sqrt(),
        }
    }
}

/// The inverse of a Gram matrix over the directions whose length is more than `floor` of the largest, and the number
/// of the others.
fn pseudo_inverse(gram: DMatrix<f64>, floor: f64) -> (DMatrix<f64>, usize) {
    let size = gram.nrows();
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(gram);
    let least = floor * floor * eigenvalues.max();
    let mut inverse = DMatrix::zeros(size, size);
    let mut left_out = 0;
    for (k, &value) in eigenvalues.iter().enumerate() {
        if value > least {
            let direction = eigenvectors.column(k);
            inverse += direction * direction.transpose() / value;
        } else {
            left_out += 1;
        }
    }
    (inverse, left_out)
}
