//! Cubic splines on clamped knots: of one variable, and their tensor products.

use crate::geom::{DVec2, DVec3};
use crate::parallel;

/// Samples of one span, on [0, 1] without the right end, and their weights: Lobatto's rule, whose
/// ends meet the neighbours'.
const LOBATTO: [(f64, f64); 3] =
    [(0.0, 1.0), (0.276_393_202_250_021, 5.0), (0.723_606_797_749_979, 5.0)];

/// Clamped knot vector of cubic splines of one variable.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct KnotVector {
    /// The inner ones once, both ends four times.
    knots: Vec<f64>,
}

impl KnotVector {
    /// The knots with breaks at `breaks`, two of them or more in rising order, ends included.
    pub(super) fn new(breaks: &[f64]) -> Self {
        let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
        let knots = [&[first; 3], breaks, &[last; 3]].concat();
        Self { knots }
    }

    /// Where splines break, ends included.
    pub(super) fn breaks(&self) -> &[f64] {
        &self.knots[3..self.knots.len() - 3]
    }

    /// How many coefficients a spline has.
    pub(super) fn count(&self) -> usize {
        self.knots.len() - 4
    }

    /// The coefficients of the identity (Greville's abscissae).
    pub(super) fn greville(&self) -> Vec<f64> {
        self.knots
            .windows(3)
            .skip(1)
            .take(self.count())
            .map(|k| (k[0] + k[1] + k[2]) / 3.0)
            .collect()
    }

    /// The knots of the splines s(-u).
    pub(super) fn reversed(&self) -> Self {
        Self { knots: self.knots.iter().rev().map(|&k| 0.0 - k).collect() }
    }

    /// The four basis functions that are not 0 at `u`: the number of the first, and their values.
    pub(super) fn basis(&self, u: f64) -> (usize, [f64; 4]) {
        let k = &self.knots;
        let inner = &k[4..k.len() - 4];
        let span = 3 + inner.partition_point(|&knot| knot <= u);
        let mut b = [1.0, 0.0, 0.0, 0.0];
        for degree in 1..4 {
            let mut carried = 0.0;
            for r in 0..degree {
                let (left, right) = (k[span + 1 + r - degree], k[span + 1 + r]);
                let share = b[r] / (right - left);
                b[r] = carried + (right - u) * share;
                carried = (u - left) * share;
            }
            b[degree] = carried;
        }
        (span - 3, b)
    }

    /// Where [`KnotVector::fit`] wants samples.
    pub(super) fn sites(&self) -> Vec<f64> {
        let span = |ends: &[f64]| LOBATTO.map(|(t, _)| ends[0] + (ends[1] - ends[0]) * t);
        let last = *self.breaks().last().expect("two breaks or more");
        self.breaks().windows(2).flat_map(span).chain([last]).collect()
    }

    /// `parts` places in every span, between its ends.
    pub(super) fn interior_points(&self, parts: usize) -> Vec<f64> {
        let at = |ends: &[f64], k: usize| {
            ends[0] + (ends[1] - ends[0]) * ((k as f64 + 0.5) / parts as f64)
        };
        let span = |ends: &[f64]| (0..parts).map(|k| at(ends, k)).collect::<Vec<_>>();
        self.breaks().windows(2).flat_map(span).collect()
    }

    /// The coefficients of the splines nearest in least squares to `lanes` functions, of which
    /// `samples` has a row of values for each of the sites; row after row.
    pub(super) fn fit(&self, lanes: usize, samples: &[f64]) -> Vec<f64> {
        let (count, sites) = (self.count(), self.sites());
        let mut normal = vec![[0.0; 4]; count];
        let mut x = vec![0.0; count * lanes];
        for (s, (&site, row)) in sites.iter().zip(samples.chunks_exact(lanes)).enumerate() {
            let end = s == 0 || s == sites.len() - 1;
            let weight = LOBATTO[s % 3].1 * if s % 3 == 0 && !end { 2.0 } else { 1.0 };
            let (first, b) = self.basis(site);
            for i in 0..4 {
                for j in i..4 {
                    normal[first + i][j - i] += weight * b[i] * b[j];
                }
                let to = &mut x[(first + i) * lanes..][..lanes];
                to.iter_mut().zip(row).for_each(|(to, value)| *to += weight * b[i] * value);
            }
        }
        solve(&mut normal, lanes, &mut x);
        x
    }
}

/// Solves the symmetric system whose row k holds the diagonal and three entries to its right.
fn solve(a: &mut [[f64; 4]], lanes: usize, x: &mut [f64]) {
    let count = a.len();
    for k in 0..count {
        for below in 1..4.min(count - k) {
            let share = a[k][below] / a[k][0];
            for more in below..4 {
                a[k + below][more - below] -= share * a[k][more];
            }
            let (done, rest) = x.split_at_mut((k + below) * lanes);
            let from = &done[k * lanes..][..lanes];
            rest.iter_mut().zip(from).for_each(|(to, from)| *to -= share * from);
        }
    }
    for k in (0..count).rev() {
        let (left, solved) = x.split_at_mut((k + 1) * lanes);
        let to = &mut left[k * lanes..];
        for after in 1..4.min(count - k) {
            let from = &solved[(after - 1) * lanes..][..lanes];
            to.iter_mut().zip(from).for_each(|(to, from)| *to -= a[k][after] * from);
        }
        to.iter_mut().for_each(|to| *to /= a[k][0]);
    }
}

/// A bicubic B-spline surface: knots and net of control points.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BSplineSurface {
    /// The knots along u and along v.
    pub axes: [KnotVector; 2],
    /// The control points, all v for the first u, then for the next.
    pub points: Vec<DVec3>,
}

impl BSplineSurface {
    /// The coefficients of the spline nearest to a function of which `samples` has a row of values
    /// along u's sites for each of v's sites; in the order of [`BSplineSurface::points`].
    pub(super) fn fit([u, v]: [&KnotVector; 2], samples: &[f64]) -> Vec<f64> {
        let sites = samples.len() / v.sites().len();
        let along_v = v.fit(sites, samples);
        let turned: Vec<f64> =
            (0..sites).flat_map(|i| along_v.iter().skip(i).step_by(sites).copied()).collect();
        u.fit(v.count(), &turned)
    }

    /// How many control points there are along u and along v.
    pub(super) fn size(&self) -> [usize; 2] {
        self.axes.each_ref().map(KnotVector::count)
    }

    /// The control points for the k-th u.
    pub(super) fn control_row(&self, k: usize) -> &[DVec3] {
        let count = self.axes[1].count();
        &self.points[k * count..][..count]
    }

    /// The surface at one point of its domain.
    pub(super) fn at(&self, q: DVec2) -> DVec3 {
        let ((i, a), (j, b)) = (self.axes[0].basis(q.x), self.axes[1].basis(q.y));
        (0..4).map(|k| a[k] * sum(self.control_row(i + k), j, &b)).sum()
    }

    /// The surface at all of `us` for each of `vs`.
    pub(super) fn grid(&self, us: &[f64], vs: &[f64]) -> Vec<Vec<DVec3>> {
        let [u, v] = &self.axes;
        let along_u: Vec<_> = us.iter().map(|&x| u.basis(x)).collect();
        let row = |&y: &f64| {
            let (j, b) = v.basis(y);
            let line: Vec<DVec3> =
                (0..u.count()).map(|i| sum(self.control_row(i), j, &b)).collect();
            along_u.iter().map(|(i, a)| sum(&line, *i, a)).collect()
        };
        parallel::map_slice(vs, 1, row)
    }
}

#[inline]
fn sum(points: &[DVec3], first: usize, weights: &[f64; 4]) -> DVec3 {
    points[first..first + 4].iter().zip(weights).map(|(&p, &w)| p * w).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::{cos, exp};

    fn uneven(spans: usize) -> KnotVector {
        let breaks: Vec<f64> = (0..=spans)
            .map(|k| k as f64 / spans as f64)
            .map(|t| 3.0 * t + 0.4 * t * t - 1.0)
            .collect();
        KnotVector::new(&breaks)
    }

    #[test]
    fn weights_sum_to_one_and_give_the_identity() {
        for axis in [uneven(1), uneven(2), uneven(9)] {
            let greville = axis.greville();
            assert_eq!(greville.len(), axis.count());
            for u in axis.sites() {
                let (first, b) = axis.basis(u);
                assert!((b.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                let identity: f64 = (0..4).map(|k| b[k] * greville[first + k]).sum();
                assert!((identity - u).abs() < 2e-15, "{identity} {u}");
            }
        }
    }

    #[test]
    fn cubics_are_met_exactly() {
        let cubic = |u: f64| [1.0 + u * (2.0 - u * (3.0 - u)), u * u];
        let axis = uneven(7);
        let samples: Vec<f64> = axis.sites().into_iter().flat_map(cubic).collect();
        let found = axis.fit(2, &samples);
        for u in axis.interior_points(5) {
            let (first, b) = axis.basis(u);
            for (lane, exact) in cubic(u).into_iter().enumerate() {
                let value: f64 = (0..4).map(|k| b[k] * found[2 * (first + k) + lane]).sum();
                assert!((value - exact).abs() < 1e-13, "{value} {exact}");
            }
        }
    }

    #[test]
    fn the_error_falls_with_the_fourth_power_of_the_spans() {
        let f = |x: f64, y: f64| exp(0.5 * x) * cos(y);
        let error = |spans: usize| {
            let (u, v) = (uneven(spans), uneven(spans + 1));
            let sites = u.sites();
            let samples: Vec<f64> =
                v.sites().iter().flat_map(|&y| sites.iter().map(move |&x| f(x, y))).collect();
            let z = BSplineSurface::fit([&u, &v], &samples);
            let points = z.into_iter().map(|z| DVec3::new(0.0, 0.0, z)).collect();
            let (us, vs) = (u.interior_points(7), v.interior_points(7));
            let net = BSplineSurface { axes: [u, v], points };
            let mut worst = 0.0f64;
            for (row, &y) in net.grid(&us, &vs).iter().zip(&vs) {
                for (p, &x) in row.iter().zip(&us) {
                    worst = worst.max((p.z - f(x, y)).abs());
                    assert!((net.at(DVec2::new(x, y)).z - p.z).abs() < 1e-14);
                }
            }
            worst
        };
        let ratio = error(8) / error(16);
        assert!((13.0..21.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn reversed_splines_run_backwards() {
        let axis = uneven(4);
        let (first, b) = axis.basis(0.3);
        let (last, c) = axis.reversed().basis(-0.3);
        assert_eq!(first + 4 + last, axis.count());
        assert!((0..4).all(|k| (b[k] - c[3 - k]).abs() < 1e-15));
    }
}
