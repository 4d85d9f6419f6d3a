//! Distributions of errors about zero.

use crate::num::exp;
use crate::num::random::{normal_cdf, normal_quantile};
use std::f64::consts::PI;

super::words_enum! {
    /// Distribution of an error. A limit of a normal distribution is two standard deviations.
    pub enum Distribution {
        /// Anything between both limits alike.
        Uniform = "uniform",
        /// Normal: one in 22 lies beyond the limits.
        Normal = "normal",
        /// Normal, without what lies beyond the limits.
        Truncated = "truncated",
        /// Always at the limit, with its sign: a known error. Of a texture this is its strength, and the
        /// pattern is random.
        Fixed = "fixed",
    }
}

impl Distribution {
    /// Standard deviations in a limit.
    const SIGMAS: f64 = 2.0;

    /// The error that `u`, uniform in (0, 1), stands for, in units of the limit.
    #[must_use]
    pub fn quantile(self, u: f64) -> f64 {
        match self {
            Self::Uniform => 2.0 * u - 1.0,
            Self::Normal => normal_quantile(u) / Self::SIGMAS,
            Self::Truncated => {
                let tail = normal_cdf(-Self::SIGMAS);
                (normal_quantile(tail + (1.0 - 2.0 * tail) * u) / Self::SIGMAS).clamp(-1.0, 1.0)
            }
            Self::Fixed => 1.0,
        }
    }

    /// Mean square, in units of the limit squared.
    #[must_use]
    pub fn mean_square(self) -> f64 {
        match self {
            Self::Uniform => 1.0 / 3.0,
            Self::Normal => 1.0 / (Self::SIGMAS * Self::SIGMAS),
            Self::Truncated => {
                let a = Self::SIGMAS;
                let density = exp(-0.5 * a * a) / (2.0 * PI).sqrt();
                let inside = 1.0 - 2.0 * normal_cdf(-a);
                (1.0 - 2.0 * a * density / inside) / (a * a)
            }
            Self::Fixed => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distributions_have_their_mean_square_and_keep_their_limits() {
        for kind in [Distribution::Uniform, Distribution::Normal, Distribution::Truncated] {
            let n = 200_000;
            let at = |k: i32| kind.quantile((f64::from(k) + 0.5) / f64::from(n));
            let square = (0..n).map(|k| at(k) * at(k)).sum::<f64>() / f64::from(n);
            assert!((square / kind.mean_square() - 1.0).abs() < 2e-4, "{kind:?} {square}");
            assert!((at(0) + at(n - 1)).abs() < 1e-9);
            let beyond = (0..n).filter(|&k| at(k).abs() > 1.0).count() as f64 / f64::from(n);
            let exact = if kind == Distribution::Normal { 0.045_500_26 } else { 0.0 };
            assert!((beyond - exact).abs() < 2e-5, "{kind:?} {beyond}");
        }
        assert_eq!(Distribution::Fixed.quantile(0.3), 1.0);
    }
}
