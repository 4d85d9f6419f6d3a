//! Whole designs by the solver: the paper's panoramic and conquistador mirrors.

use super::basis::{Basis, LocalValues, NodeSet};
use super::minimax::{MinimaxFit, minimax};
use super::residual_sample::{PointwiseResidual, ResidualSample};
use super::solve::{LeastSquaresFit, SolverOptions, solve};
use crate::geom::{DVec2, Rect};
use crate::num::legendre::Series;
use crate::num::quadrature::gauss_legendre;
use crate::num::{Scalar, asin, asinh, cos, exp, sin, tan};
use std::f64::consts::PI;

/// The paper's field on the cylindrical strip, one unit per radian.
fn field(q: DVec2) -> DVec2 {
    exp(-asinh(q.y)) * DVec2::new(-sin(q.x), -cos(q.x))
}

/// grad F - s, times 2 / (1 + |s|^2) where the ray error is meant.
pub struct StripGradient {
    ray: bool,
}

impl PointwiseResidual<2> for StripGradient {
    fn at<S: Scalar>(&self, q: DVec2, _: S, [x, y]: [S; 2]) -> [S; 2] {
        let s = field(q);
        let weight = if self.ray { 2.0 / (1.0 + s.length_squared()) } else { 1.0 };
        [(x - s.x) * weight, (y - s.y) * weight]
    }
}

/// Sine of the angle between the mirror's normal and the wanted one.
pub struct StripNormal;

impl PointwiseResidual<3> for StripNormal {
    fn at<S: Scalar>(&self, q: DVec2, _: S, [x, y]: [S; 2]) -> [S; 3] {
        let s = field(q);
        let lengths = ((x.square() + y.square() + 1.0) * (1.0 + s.length_squared())).sqrt();
        [(x - s.x) / lengths, (y - s.y) / lengths, (x * s.y - y * s.x) / lengths]
    }
}

/// Displacement on the strip of the content that the slope shows.
pub struct StripImage;

impl PointwiseResidual<2> for StripImage {
    fn at<S: Scalar>(&self, q: DVec2, _: S, [x, y]: [S; 2]) -> [S; 2] {
        // The azimuth as turned back by the wanted one: no jump near.
        let (c, s) = (cos(q.x), sin(q.x));
        let azimuth = (y * s - x * c).atan2(-(y * c + x * s));
        let p = (x.square() + y.square()).sqrt();
        [azimuth, (S::constant(1.0) / p - p) * 0.5 - q.y]
    }
}

/// Half sizes of the paper's two strips: 360 x 60 degrees, and half a frame of 4 : 3.
fn strips() -> [(&'static str, DVec2); 2] {
    [
        ("panoramic", DVec2::new(PI, tan(PI / 6.0))),
        ("conquistador", DVec2::new(0.5 * PI, 3.0 * PI / 16.0)),
    ]
}

struct PaperMirror {
    half: DVec2,
    degree: usize,
    squares: Basis,
    rim: Basis,
}

impl PaperMirror {
    fn new(half: DVec2, degree: usize) -> Self {
        let area = Rect { min: -half, max: half };
        Self {
            half,
            degree,
            squares: Basis::rectangle(area, [true, false], degree, NodeSet::Quadrature),
            rim: Basis::rectangle(area, [true, false], degree, NodeSet::Extrema),
        }
    }

    fn least<const N: usize>(
        &self,
        r: &impl PointwiseResidual<N>,
        start: Option<&[f64]>,
    ) -> LeastSquaresFit {
        solve(&self.squares, r, &SolverOptions { start, ..SolverOptions::default() }).unwrap()
    }

    fn worst<const N: usize>(&self, r: &impl PointwiseResidual<N>, start: &[f64]) -> MinimaxFit {
        minimax(&self.rim, r, start).unwrap()
    }

    /// Place, weight and local values on a grid of its own, by a code of its own.
    fn grid(&self, c: &[f64]) -> Vec<(DVec2, f64, LocalValues)> {
        let n = self.degree + 1;
        let mut all = vec![0.0; n * n];
        for (&(i, j), c) in self.squares.terms().iter().zip(c) {
            all[i * n + j] = *c;
        }
        let series = Series::from_fn(n, n, |i, j| all[i * n + j]);
        let area = Rect { min: DVec2::new(0.0, -self.half.y), max: self.half };
        let mut grid = Vec::new();
        for (y, row) in area.grid_rows(240, 240) {
            let line = series.row(y / self.half.y);
            for (q, weight) in row {
                let jet = line.gradient(q.x / self.half.x);
                let slope = [jet.gradient[0] / self.half.x, jet.gradient[1] / self.half.y];
                grid.push((q, 2.0 * weight, [jet.f, slope[0], slope[1]]));
            }
        }
        grid
    }

    /// Integral of |r|^2 and largest |r|.
    fn measure<const N: usize>(&self, r: &impl PointwiseResidual<N>, c: &[f64]) -> [f64; 2] {
        self.grid(c).into_iter().fold([0.0f64; 2], |[sum, most], (q, weight, local)| {
            let square = ResidualSample::new(r, q, local).square();
            [sum + weight * square, most.max(f64::sqrt(square))]
        })
    }

    /// Largest angle between the direction shown and the direction wanted, mrad.
    fn ray_error(&self, c: &[f64]) -> f64 {
        let most = self.grid(c).into_iter().fold(0.0f64, |most, (q, _, [_, x, y])| {
            let (p, s) = (DVec2::new(x, y), field(q));
            let lengths = (1.0 + p.length_squared()) * (1.0 + s.length_squared());
            most.max((p - s).length() / f64::sqrt(lengths))
        });
        2e3 * asin(most)
    }
}

#[test]
fn the_content_of_the_wanted_slope_is_where_it_belongs() {
    for x in [-PI, -2.0, 0.0, 1.0, PI] {
        for y in [-0.5, 0.0, 0.7] {
            let q = DVec2::new(x, y);
            let s = field(q);
            assert!(StripImage.at(q, 0.0, [s.x, s.y]).iter().all(|r| r.abs() < 1e-15));
            // A slope error d moves the content by the slope of the projection: |d| / |s| across.
            let across = StripImage.at(q, 0.0, [s.x - 1e-7 * s.y, s.y + 1e-7 * s.x]);
            assert!((across[0].abs() - 1e-7).abs() < 1e-13 && across[1].abs() < 1e-13);
        }
    }
}

#[test]
fn each_method_is_the_best_of_the_three_by_its_own_measure() {
    for (name, half) in strips() {
        let case = PaperMirror::new(half, 12);
        let (plain, ray) = (StripGradient { ray: false }, StripGradient { ray: true });
        let vector = case.least(&plain, None).coefficients;
        let squares = [
            case.least(&StripNormal, Some(&vector)).coefficients,
            case.least(&StripImage, Some(&vector)).coefficients,
            vector,
        ];
        let start = &squares[2];
        let worsts = [
            case.worst(&StripNormal, start).coefficients,
            case.worst(&StripImage, start).coefficients,
            case.worst(&ray, start).coefficients,
        ];
        for (own, kind) in [(0, "squares"), (1, "worst")] {
            let designs = [&squares, &worsts][own];
            let by = [
                designs.each_ref().map(|c| case.measure(&StripNormal, c)[own]),
                designs.each_ref().map(|c| case.measure(&StripImage, c)[own]),
                designs.each_ref().map(|c| match own {
                    0 => case.measure(&plain, c)[0],
                    _ => case.measure(&ray, c)[1],
                }),
            ];
            for (k, measured) in by.iter().enumerate() {
                let least = measured.iter().copied().fold(f64::INFINITY, f64::min);
                assert!(measured[k] == least, "{name}, {kind}, method {k}: {measured:?}");
            }
        }
    }
}

#[test]
fn the_reported_integral_is_that_of_the_mirror() {
    for (_, half) in strips() {
        let case = PaperMirror::new(half, 12);
        let plain = StripGradient { ray: false };
        let fit = case.least(&plain, None);
        assert_eq!(fit.steps, 1);
        // The grid's trapezoidal rule is good to (step)^2.
        let measured = case.measure(&plain, &fit.coefficients)[0];
        assert!((measured / fit.integral - 1.0).abs() < 2e-3, "{measured} {}", fit.integral);
        // The quadrature resolves the field: the nodes of a larger basis find the same.
        let finer = PaperMirror::new(half, 16);
        let mut padded = vec![0.0; finer.squares.unknowns()];
        for (&term, c) in case.squares.terms().iter().zip(&fit.coefficients) {
            let at = finer.squares.terms().iter().position(|&t| t == term).unwrap();
            padded[at] = *c;
        }
        let again: f64 = finer
            .squares
            .locals(&padded)
            .into_iter()
            .enumerate()
            .map(|(k, local)| {
                let square = ResidualSample::new(&plain, finer.squares.at(k), local).square();
                finer.squares.weight(k) * square
            })
            .sum();
        assert!((again / fit.integral - 1.0).abs() < 1e-12, "{again} {}", fit.integral);
    }
}

/// A lower bound of the worst (linearised) ray error of any mirror whatsoever: around a loop a
/// gradient integrates to zero, so the loop's integral of s is that of the error, which is at
/// most the worst ray error times the integral of (1 + |s|^2) / 2.
fn loop_bound(corners: &[[f64; 2]]) -> f64 {
    let (nodes, weights) = gauss_legendre(12);
    let (mut around, mut length) = (0.0, 0.0);
    for (k, a) in corners.iter().enumerate() {
        let b = corners[(k + 1) % corners.len()];
        let (a, b) = (DVec2::from(*a), DVec2::from(b));
        for (t, w) in nodes.iter().zip(&weights) {
            let s = field(0.5 * (a + b) + 0.5 * t * (b - a));
            around += 0.5 * w * s.dot(b - a);
            length += 0.5 * w * 0.5 * (1.0 + s.length_squared()) * (b - a).length();
        }
    }
    around.abs() / length
}

#[test]
fn the_worst_ray_error_is_the_least_that_any_mirror_can_have() {
    // Loops found by a search for the largest bound.
    let h = tan(PI / 6.0);
    let panoramic = [
        [0.55, 0.0],
        [0.58, -0.28],
        [0.62, -0.42],
        [0.68, -0.5],
        [0.75, -0.555],
        [0.83, -h],
        [2.32, -h],
        [2.41, -0.545],
        [2.5, -0.46],
        [2.56, -0.29],
        [2.59, 0.0],
        [2.61, 0.24],
        [2.6, 0.385],
        [2.56, 0.485],
        [2.49, 0.55],
        [2.42, h],
        [0.73, h],
        [0.65, 0.55],
        [0.59, 0.49],
        [0.545, 0.39],
        [0.53, 0.23],
    ];
    let (e, h) = (0.5 * PI, 3.0 * PI / 16.0);
    let conquistador = [
        [0.377, 0.0],
        [0.4, -0.24],
        [0.44, -0.405],
        [0.49, -0.5],
        [0.55, -0.555],
        [0.645, -h],
        [1.475, -h],
        [1.53, -0.565],
        [e, -0.49],
        [e, 0.506],
        [1.545, 0.56],
        [1.494, h],
        [0.564, h],
        [0.5, 0.55],
        [0.44, 0.49],
        [0.397, 0.45],
        [0.37, 0.34],
        [0.366, 0.2],
    ];
    let cases = [(12, 15.0, &panoramic[..], 13.55), (14, 11.5, &conquistador[..], 10.71)];
    for ((name, half), (degree, goal, corners, known)) in strips().into_iter().zip(cases) {
        let case = PaperMirror::new(half, degree);
        let ray = StripGradient { ray: true };
        let squares = case.least(&StripGradient { ray: false }, None).coefficients;
        let best = case.worst(&ray, &squares);
        let (before, after) = (case.ray_error(&squares), case.ray_error(&best.coefficients));
        assert!(after < goal && before > 1.9 * goal, "{name}: {before} to {after}");
        let worst = case.measure(&ray, &best.coefficients)[1];
        assert!(worst <= 1.01 * best.bound, "{name}: {worst} {best:?}");
        let any = loop_bound(corners);
        assert!(1e3 * any > known, "{name}: {any}");
        assert!(any < worst && worst < 1.02 * any, "{name}: {worst} {any}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let half = strips()[0].1;
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let case = PaperMirror::new(half, 14);
            let fit = case.least(&StripNormal, None);
            let best = case.worst(&StripNormal, &fit.coefficients);
            (fit, best)
        })
    };
    assert_eq!(run(1), run(3));
}
