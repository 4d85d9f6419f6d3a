//! Conics of revolution as Legendre series.

use super::DesignError;
use crate::geom::{DVec2, Rect};
use crate::num::cos;
use crate::num::legendre::{Series, values};
use crate::num::quadrature::gauss_legendre;
use crate::profile::Conic;
use std::f64::consts::PI;

/// Degrees that are tried.
const DEGREES: [usize; 9] = [4, 8, 12, 16, 24, 40, 64, 88, 120];
/// Largest error of a series, as a share of the conic's height.
const CLOSE: f64 = 1e-12;

/// Height of a conic at the square of a distance from the axis; not a number where it has ended.
pub(super) fn sag(conic: &Conic, r2: f64) -> f64 {
    let curvature = 1.0 / conic.radius_mm;
    let root = f64::sqrt(1.0 - (1.0 + conic.conic) * r2 * curvature * curvature);
    r2 * curvature / (1.0 + root)
}

/// The conic as a series of u = 2 r^2 / outer^2 - 1.
pub(super) fn along_radius(conic: &Conic, outer: f64) -> Result<Series, DesignError> {
    close(
        outer,
        sag(conic, outer * outer),
        &LegendreProjection {
            line: true,
            even: false,
            f: |u, _| sag(conic, 0.5 * outer * outer * (1.0 + u)),
        },
    )
}

/// The conic as a series over a rectangle about the axis.
pub(super) fn over_area(conic: &Conic, area: Rect) -> Result<Series, DesignError> {
    let (centre, half) = (area.centre(), 0.5 * area.size());
    let reach = area.max.abs().max(area.min.abs()).length();
    close(
        reach,
        sag(conic, reach * reach),
        &LegendreProjection {
            line: false,
            // About the axis the conic is even, and so must its series be to the last bit.
            even: centre == DVec2::ZERO,
            f: |u, v| sag(conic, (centre + half * DVec2::new(u, v)).length_squared()),
        },
    )
}

/// The first series of a fit that is close to what it is of, `whole` high at `reach_mm`.
fn close(
    reach_mm: f64,
    whole: f64,
    fit: &LegendreProjection<impl Fn(f64, f64) -> f64>,
) -> Result<Series, DesignError> {
    let mut error = f64::NAN;
    for degree in DEGREES {
        let series = fit.series(degree);
        error = fit.off(&series, degree) / whole.abs();
        if error <= CLOSE {
            return Ok(series);
        }
    }
    Err(DesignError::Steep { reach_mm, degree: DEGREES[DEGREES.len() - 1], error })
}

/// A node, its weight, and the Legendre polynomials there.
type WeightedNode = (f64, f64, Vec<f64>);

/// The projection of a function onto Legendre series.
struct LegendreProjection<F> {
    /// Whether the function is one of u alone.
    line: bool,
    /// Whether it is even in u and in v.
    even: bool,
    f: F,
}

impl<F: Fn(f64, f64) -> f64> LegendreProjection<F> {
    fn series(&self, degree: usize) -> Series {
        let nodes = |degree: usize| -> Vec<WeightedNode> {
            let (nodes, weights) = gauss_legendre(degree + 16);
            nodes.iter().zip(weights).map(|(&t, w)| (t, w, values(degree, t))).collect()
        };
        let along = nodes(degree);
        let across = if self.line { vec![(0.0, 2.0, vec![1.0])] } else { nodes(degree) };
        let f = |v: f64| along.iter().map(|(u, ..)| (self.f)(*u, v)).collect::<Vec<_>>();
        let first = self.project(&along, &across, f);
        // Weights near the ends are less than exact; what they spoil is projected once more.
        let rest = self.project(&along, &across, |v| {
            let row = first.row(v);
            along.iter().map(|(u, ..)| (self.f)(*u, v) - row.gradient(*u).f).collect()
        });
        plus(&first, &rest)
    }

    /// The series of what has the values `f(v)` at the nodes along a line.
    fn project(
        &self,
        along: &[WeightedNode],
        across: &[WeightedNode],
        f: impl Fn(f64) -> Vec<f64>,
    ) -> Series {
        let (rows, columns) = (along[0].2.len(), across[0].2.len());
        // half[i][j]: along u done, across v summed up.
        let mut half = vec![0.0; rows * columns];
        for (v, w, q) in across {
            let values = f(*v);
            for (i, line) in half.chunks_exact_mut(columns).enumerate() {
                let sum: f64 = along.iter().zip(&values).map(|((_, w, p), f)| w * p[i] * f).sum();
                line.iter_mut().zip(q).for_each(|(c, q)| *c += w * sum * q);
            }
        }
        let norm = |k: usize| 0.5 * (2 * k + 1) as f64;
        Series::from_fn(rows, columns, |i, j| {
            let odd = self.even && (i % 2 == 1 || j % 2 == 1);
            if odd { 0.0 } else { norm(i) * norm(j) * half[i * columns + j] }
        })
    }

    /// The largest distance of `series` from the function: places are denser towards the ends,
    /// both included.
    fn off(&self, series: &Series, degree: usize) -> f64 {
        let count = 2 * degree + 9;
        let place = |k: usize| -cos(PI * k as f64 / count as f64);
        let places: Vec<f64> = (0..=count).map(place).collect();
        let lines = if self.line { &[0.0][..] } else { &places[..] };
        largest(lines.iter().map(|&v| {
            let row = series.row(v);
            largest(places.iter().map(|&u| (row.gradient(u).f - (self.f)(u, v)).abs()))
        }))
    }
}

/// The largest, not a number if one is not.
fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |most: f64, x| if most.is_nan() || x <= most { most } else { x })
}

/// The sum of two series.
pub(super) fn plus(a: &Series, b: &Series) -> Series {
    let ((m, n), (p, q)) = (a.shape(), b.shape());
    let of = |s: &Series, i: usize, j: usize| {
        if i < s.shape().0 && j < s.shape().1 { s.coefficient(i, j) } else { 0.0 }
    };
    Series::from_fn(m.max(p), n.max(q), |i, j| of(a, i, j) + of(b, i, j))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_degree_follows_the_steepness() {
        let degree = |radius_mm: f64, conic: f64| {
            let series = along_radius(&Conic { radius_mm, conic }, 30.0).unwrap();
            series.shape().0 - 1
        };
        assert_eq!(degree(-20.0, -1.0), 4);
        assert!(degree(-300.0, 0.0) <= 8);
        assert!(degree(-31.0, 0.0) > 40);
    }

    #[test]
    fn sums_keep_every_coefficient() {
        let a = Series::from_fn(3, 1, |i, _| i as f64);
        let b = Series::from_fn(1, 2, |_, j| 10.0 + j as f64);
        let found = plus(&a, &b);
        assert_eq!(found.shape(), (3, 2));
        assert_eq!((found.coefficient(0, 0), found.coefficient(0, 1)), (10.0, 11.0));
        assert_eq!((found.coefficient(2, 0), found.coefficient(2, 1)), (2.0, 0.0));
    }
}
