//! A pixel's footprint on the part: the mean of a texture over it displaces the pixel's content, and the
//! deviation from the mean blurs it.

use super::line_of_sight::LineOfSight;
use crate::geom::{DVec2, DVec3};
use crate::num::{Scalar, sin};
use crate::optics::Camera;

/// A pixel's footprint on the part in X and Y, a parallelogram: its two sides, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Footprint([[f64; 2]; 2]);

/// Shortest side of a footprint that is told from a point, in periods: below it differences of polynomials
/// have no digits.
const LEAST_SIDE: f64 = 1e-3;
/// Positions in a period by which the mean square of a mean is found.
const PLACES: usize = 128;

impl Footprint {
    /// A point, which sees all of a texture.
    pub(super) const POINT: Self = Self([[0.0; 2]; 2]);

    /// The footprint of a pixel of `camera` whose ray meets the mirror at `hit` with the slope `p`. For a ray from
    /// the pinhole at height P along (t, -1), X = t (P - Z) + const and dZ = p . dX give
    /// dX = k (P - Z) (I - t p^T / (1 + p . t)) dq; k (P - Z) is 1 for parallel rays.
    pub(super) fn of(camera: &Camera, sight: &LineOfSight, hit: DVec3, p: [f64; 2]) -> Self {
        let chart = &camera.chart;
        let k = chart.vergence;
        let grown = camera.pixel_mm * (1.0 + k * (chart.plane_mm - hit.z));
        let (p, q) = (DVec2::from_array(p), sight.on_chart);
        if chart.lean == DVec2::ZERO && camera.picture.is_identity() {
            let lean = k / (1.0 + k * p.dot(q));
            let side = |side: DVec2| ((side - q * (lean * p.dot(side))) * grown).to_array();
            return Self([DVec2::X, DVec2::Y].map(side));
        }
        let tangent = chart.tangent_at(q);
        let fall = 1.0 + p.dot(tangent);
        let side = |side: DVec2| {
            let side = sight.along * side;
            ((side - tangent * (p.dot(side) / fall)) * grown).to_array()
        };
        Self([DVec2::X, DVec2::Y].map(side))
    }

    /// Its area, mm^2.
    pub(super) fn area(&self) -> f64 {
        let [[a, b], [c, d]] = self.0;
        (a * d - b * c).abs()
    }

    /// Lengths of both sides along a direction, mm.
    fn along(&self, way: [f64; 2]) -> [f64; 2] {
        self.0.map(|side| (side[0] * way[0] + side[1] * way[1]).abs())
    }

    /// Amplitude of the mean of a ripple of wave vector `k`, 1/mm, as a share of its own.
    pub(super) fn ripple(&self, k: [f64; 2]) -> f64 {
        self.along(k).map(|phase| sinc(0.5 * phase)).iter().product()
    }

    /// Mean of the distance to the nearest of lines `period` apart, that follow each other along
    /// `way`, over the footprint around a place at the distance `x` from one, less `x`.
    pub(super) fn sawtooth<S: Scalar>(&self, way: [f64; 2], period: f64, x: S) -> S {
        if *self == Self::POINT {
            return S::constant(0.0);
        }
        let [a, b] = self.along(way).map(|side| (side / period).max(LEAST_SIDE));
        // Distance in periods is the periodic Bernoulli polynomial of degree 1, half a period on;
        // that of degree 3 is six times its second integral.
        let at = |more: f64| bernoulli(x / period + (0.5 + more));
        let (far, near) = (0.5 * (a + b), 0.5 * (a - b));
        let sum = at(far) - at(near) - at(-near) + at(-far);
        sum * (period / (6.0 * a * b)) - x
    }

    /// Mean square of that mean over all places, as a share of the distance's own, period^2 / 12.
    pub(super) fn sawtooth_share(&self, way: [f64; 2], period: f64) -> f64 {
        let square = |k: usize| {
            let x = ((k as f64 + 0.5) / PLACES as f64 - 0.5) * period;
            let mean = x + self.sawtooth(way, period, x);
            mean * mean
        };
        let own = (PLACES * PLACES) as f64 - 1.0;
        let own = period * period * own / (12.0 * (PLACES * PLACES) as f64);
        (0..PLACES).map(square).sum::<f64>() / PLACES as f64 / own
    }
}

/// sin x / x.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { sin(x) / x }
}

/// The Bernoulli polynomial of degree 3 of the fractional part.
fn bernoulli<S: Scalar>(x: S) -> S {
    let x = x - x.mid().floor();
    x * (x - 0.5) * (x - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::cos;

    /// By sums over the parallelogram.
    #[test]
    fn means_are_those_of_many_points() {
        let shape = Footprint([[0.11, 0.02], [-0.03, 0.07]]);
        let mean = |f: &dyn Fn([f64; 2]) -> f64| {
            let n = 400;
            let at = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
            let [a, b] = shape.0;
            let point = |u: f64, v: f64| [0, 1].map(|k| a[k] * u + b[k] * v);
            let row = |i: usize| (0..n).map(|j| f(point(at(i), at(j)))).sum::<f64>();
            (0..n).map(row).sum::<f64>() / (n * n) as f64
        };
        let k = [31.0, -12.0];
        let exact = mean(&|[x, y]| cos(k[0] * x + k[1] * y));
        assert!((shape.ripple(k) - exact).abs() < 1e-4, "{exact}");
        let way = [0.6, 0.8];
        for period in [0.05, 0.1, 0.3, 2.0] {
            for at in [-0.45, -0.2, 0.0, 0.31] {
                let x = at * period;
                let nearest = |t: f64| t - (t / period).round() * period;
                let exact = mean(&|[p, q]| nearest(x + way[0] * p + way[1] * q));
                let found = x + shape.sawtooth(way, period, x);
                assert!((found - exact).abs() < 2e-3 * period, "{period} {at}: {found} {exact}");
            }
        }
        // Along X alone over half a period: the mean's square is that of Fourier's sum.
        let flat = Footprint([[0.5, 0.0], [0.0, 0.3]]);
        let term = |n: f64| sinc(0.5 * n * std::f64::consts::PI) / n;
        let sum: f64 = (1..100_000).map(|n| term(f64::from(n))).map(|t| t * t).sum();
        let exact = 6.0 * sum / (std::f64::consts::PI * std::f64::consts::PI);
        let found = flat.sawtooth_share([1.0, 0.0], 1.0);
        assert!((found - exact).abs() < 1e-3, "{found} {exact}");
        assert!((Footprint::POINT.sawtooth_share(way, 1.0) - 1.0).abs() < 1e-12);
    }
}
