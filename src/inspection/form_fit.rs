//! Measured points to form terms with their uncertainty, beyond what a better pose would take away.

use crate::align::{OUTLIER, PointAlignment, PointResidual};
use crate::geom::DVec3;
use crate::mirror::Mirror;
use crate::tolerance::{LowFormTerms, Perturbation};
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
    /// Which of the points they rest on: those on the mirror that are no outliers of this form.
    pub used: Vec<bool>,
    /// Standard deviation of what the terms leave, mm: finer form errors, texture and the machine's noise.
    pub rest_mm: f64,
}

/// Freedoms of a rigid motion.
const MOTIONS: usize = 6;
/// Share of the largest motion across the surface below which a motion is free, and what the fit of the terms leaves
/// to rounding.
const FREE: f64 = 1e-3;
const ROUNDING: f64 = 1e-6;
/// Least standard deviation from which outliers are told, mm.
const ROUNDING_MM: f64 = 1e-9;

/// Rounds in which points are told from outliers of the form found so far.
const ROUNDS: usize = 8;

/// Fits the low terms of `mirror` to points that were aligned with it, by least squares; none where there are too few.
///
/// The pose is fitted first, to the points alone, so the terms are those of the form beyond the best pose. Their
/// covariance is that of this order of fits under independent noise, whose variance is what both leave together.
/// Outliers are those of what both leave, more than 4.685 standard deviations off by the median: a form that is large
/// at the rim is none.
#[must_use]
pub fn fit_form(mirror: &Mirror, found: &PointAlignment) -> Option<FormFit> {
    let basis = LowFormTerms::new(mirror);
    let count = basis.terms().count();
    let rows = columns(&basis, found)?;
    let mut used: Vec<bool> = found
        .residuals
        .iter()
        .map(|r| r.is_some_and(|r| r.distance.abs() < found.reach_mm))
        .collect();
    let mut equations = TermEquations::of(&rows, &used, count)?;
    for _ in 0..ROUNDS {
        let left = equations.left(&rows);
        let mut known: Vec<f64> =
            left.iter().zip(&used).filter(|(_, used)| **used).map(|(left, _)| left.abs()).collect();
        let middle = known.len() / 2;
        let median = *known.select_nth_unstable_by(middle, f64::total_cmp).1;
        // (Rounding is no outlier.)
        let reach = OUTLIER * (1.4826 * median).max(ROUNDING_MM);
        let again: Vec<bool> = left.iter().map(|left| left.abs() < reach).collect();
        if again == used {
            break;
        }
        equations = TermEquations::of(&rows, &again, count)?;
        used = again;
    }
    let fit = equations.solve();
    let terms = basis.terms().enumerate().map(|(k, term)| FittedTerm {
        term,
        pv_mm: fit.terms[k],
        uncertainty_mm: fit.uncertainties[k],
    });
    Some(FormFit { terms: terms.collect(), used, rest_mm: fit.rest })
}

/// What each point on the mirror is moved by along its normal: by six motions, by the terms, and how far it is off;
/// none of other points, and none at all where no point is on the mirror.
fn columns(basis: &LowFormTerms, found: &PointAlignment) -> Option<Vec<Option<Vec<f64>>>> {
    let near = found.residuals.iter().flatten();
    let points = near.clone().count();
    if points == 0 {
        return None;
    }
    let centre = near.clone().map(|r| r.at).sum::<DVec3>() / points as f64;
    let square = |r: &PointResidual| (r.at - centre).length_squared();
    let gyration = (near.map(square).sum::<f64>() / points as f64).sqrt();
    let row = |residual: &PointResidual| {
        let n = residual.normal;
        let lever = (residual.at - centre).cross(n) / gyration;
        let heights = basis.heights([residual.at.x, residual.at.y]).map(|height| height * n.z);
        let motions = [n.x, n.y, n.z, lever.x, lever.y, lever.z];
        motions.into_iter().chain(heights).chain([residual.distance]).collect()
    };
    Some(found.residuals.iter().map(|residual| residual.as_ref().map(row)).collect())
}

/// Normal equations of motions, `count` terms and the distances of so many points.
struct TermEquations {
    products: DMatrix<f64>,
    count: usize,
    points: usize,
}

/// Their solution.
struct SolvedTerms {
    terms: DVector<f64>,
    uncertainties: Vec<f64>,
    rest: f64,
}

impl TermEquations {
    /// The equations of the rows that are used; none of too few.
    fn of(rows: &[Option<Vec<f64>>], used: &[bool], count: usize) -> Option<Self> {
        let width = MOTIONS + count + 1;
        let mut products = DMatrix::<f64>::zeros(width, width);
        let mut points = 0;
        for row in
            rows.iter().zip(used).filter(|(_, used)| **used).filter_map(|(row, _)| row.as_ref())
        {
            points += 1;
            for (j, b) in row.iter().enumerate() {
                for (i, a) in row.iter().enumerate().take(j + 1) {
                    products[(i, j)] += a * b;
                }
            }
        }
        products.fill_lower_triangle_with_upper_triangle();
        (points > MOTIONS + count).then_some(Self { products, count, points })
    }

    /// What motions and terms together leave of each row, mm; infinite of none.
    fn left(&self, rows: &[Option<Vec<f64>>]) -> Vec<f64> {
        let size = MOTIONS + self.count;
        let (inverse, _) =
            pseudo_inverse(self.products.view((0, 0), (size, size)).into_owned(), ROUNDING);
        let found = inverse * self.products.view((0, size), (size, 1));
        let left = |row: &Vec<f64>| {
            row[size] - row[..size].iter().zip(found.iter()).map(|(a, b)| a * b).sum::<f64>()
        };
        rows.iter().map(|row| row.as_ref().map_or(f64::INFINITY, left)).collect()
    }

    /// Solves for the motions, and then for the terms of what these leave.
    fn solve(self) -> SolvedTerms {
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
        let freedom = self.points - (m - free) - (n - lost);
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
