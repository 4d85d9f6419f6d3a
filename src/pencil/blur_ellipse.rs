//! Blur ellipses, and the focus that makes most of them small.

use super::Pencil;
use crate::parallel;
use serde::Serialize;

/// Pixels that the first search for the best focus looks at, its steps, and those of the second.
const FEW: usize = 4096;
const STEPS: usize = 128;
const FINE_STEPS: usize = 64;
/// Steps of golden section: the last interval is 1e-6 of the first.
const GOLDEN: usize = 30;

/// Blur ellipse of a pixel as a function of aperture and focus, in the unit of K (mm on the reference
/// plane for each unit of the pupil) or, [`scaled`](Self::scaled), in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlurEllipse {
    /// phi of the pixel's own best focus: half the trace of K.
    own_focus: f64,
    /// Half the difference of K's two off-diagonal elements.
    twist: f64,
    /// Norm of the deviator of K, which no focus removes.
    astigmatism: f64,
    /// Factor of the results.
    unit: f64,
}

impl BlurEllipse {
    /// The blur of `pencil`.
    #[must_use]
    pub fn new(pencil: &Pencil) -> Self {
        let [a, c, b, d] = pencil.focus.to_cols_array();
        let [half, cross] = [0.5 * (a - d), 0.5 * (b + c)];
        Self {
            own_focus: 0.5 * (a + d),
            twist: 0.5 * (c - b),
            astigmatism: (half * half + cross * cross).sqrt(),
            unit: 1.0,
        }
    }

    /// The same with results times `unit`.
    #[must_use]
    pub fn scaled(self, unit: f64) -> Self {
        Self { unit: self.unit * unit, ..self }
    }

    /// phi of the focus that minimises this ellipse.
    #[must_use]
    pub fn own_focus(&self) -> f64 {
        self.own_focus
    }

    /// Semi-axes of the blur ellipse, the larger first, for an aperture radius of 1.
    #[must_use]
    pub fn semi_axes(&self, phi: f64) -> [f64; 2] {
        let off = self.own_focus - phi;
        let even = (off * off + self.twist * self.twist).sqrt();
        [even + self.astigmatism, (even - self.astigmatism).abs()].map(|axis| axis * self.unit)
    }

    /// Full length of the ellipse for an aperture radius of 1.
    #[must_use]
    pub fn length(&self, phi: f64) -> f64 {
        2.0 * self.semi_axes(phi)[0]
    }

    /// Twice the root mean square distance from the chief ray's place of rays that fill the aperture
    /// evenly, for an aperture radius of 1: the root of the sum of both semi-axes' squares.
    #[must_use]
    pub fn rms_diameter(&self, phi: f64) -> f64 {
        let [a, b] = self.semi_axes(phi);
        (a * a + b * b).sqrt()
    }

    /// phi of the two line images, the smaller first.
    #[must_use]
    pub fn foci(&self) -> [f64; 2] {
        let square = self.astigmatism * self.astigmatism - self.twist * self.twist;
        let half = square.max(0.0).sqrt();
        [self.own_focus - half, self.own_focus + half]
    }
}

/// Median, 95th percentile and maximum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Quantiles {
    /// The value that half of the samples do not exceed.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub p50: f64,
    /// The value that 95 % of them do not exceed.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub p95: f64,
    /// The largest.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub max: f64,
}

impl Quantiles {
    /// The same in another unit.
    #[must_use]
    pub fn scaled(self, unit: f64) -> Self {
        Self { p50: self.p50 * unit, p95: self.p95 * unit, max: self.max * unit }
    }
}

/// Quantiles of `samples`; none without any.
#[must_use]
pub fn quantiles(mut samples: Vec<f64>) -> Option<Quantiles> {
    let max = samples.iter().copied().max_by(f64::total_cmp)?;
    let mut at = |share: f64| {
        let rank = (share * samples.len() as f64).ceil() as usize;
        let rank = rank.saturating_sub(1).min(samples.len() - 1);
        *samples.select_nth_unstable_by(rank, f64::total_cmp).1
    };
    Some(Quantiles { p50: at(0.5), p95: at(0.95), max })
}

/// phi of the focus, at least `least`, that makes the 95th percentile of the spots' lengths smallest;
/// none without spots.
///
/// Every spot shrinks towards its own best focus and grows beyond, so the answer lies between the
/// least and the greatest of these. A scan over some of the spots finds the valley, a finer one over
/// all of them and golden section its bottom.
#[must_use]
pub fn best_focus(spots: &[BlurEllipse], least: f64) -> Option<f64> {
    let p95 = |spots: &[&BlurEllipse], phi: f64| {
        let lengths = parallel::map_slice(spots, 4096, |spot| spot.length(phi));
        quantiles(lengths).map_or(f64::NAN, |quantiles| quantiles.p95)
    };
    let range =
        spots.iter().map(BlurEllipse::own_focus).fold(None, |range: Option<[f64; 2]>, phi| {
            let [lo, hi] = range.unwrap_or([phi; 2]);
            Some([lo.min(phi), hi.max(phi)])
        });
    let [lo, hi] = range?.map(|phi| phi.max(least));
    let few: Vec<&BlurEllipse> = spots.iter().step_by(spots.len().div_ceil(FEW)).collect();
    let all: Vec<&BlurEllipse> = spots.iter().collect();
    let scanned = |spots: &[&BlurEllipse], [from, to]: [f64; 2], steps: usize| {
        let step = (to - from) / steps as f64;
        let at = |k: usize| (from + step * k as f64, p95(spots, from + step * k as f64));
        let (valley, _) = (0..=steps).map(at).min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some([(valley - step).max(lo), (valley + step).min(hi)])
    };
    let [from, to] = scanned(&few, [lo, hi], STEPS)?;
    let more = to - from;
    let valley = [(from - more).max(lo), (to + more).min(hi)];
    Some(golden(scanned(&all, valley, FINE_STEPS)?, |phi| p95(&all, phi)))
}

/// Where `f`, which has one valley in the range, is least.
fn golden([mut lo, mut hi]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    let share = 0.5 * (f64::sqrt(5.0) - 1.0);
    let place = |lo: f64, hi: f64| [hi - share * (hi - lo), lo + share * (hi - lo)];
    let [mut a, mut b] = place(lo, hi);
    let [mut fa, mut fb] = [f(a), f(b)];
    for _ in 0..GOLDEN {
        if fa <= fb {
            (hi, b, fb) = (b, a, fa);
            a = place(lo, hi)[0];
            fa = f(a);
        } else {
            (lo, a, fa) = (a, b, fb);
            b = place(lo, hi)[1];
            fb = f(b);
        }
    }
    if fa <= fb { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::sample::Draws;
    use crate::num::{cos, sin};
    use glam::{DMat2, DVec2};

    fn spot(k: DMat2) -> BlurEllipse {
        BlurEllipse::new(&Pencil { seen: DVec2::ZERO, turn: DMat2::IDENTITY, focus: k })
    }

    #[test]
    fn the_ellipse_is_the_image_of_the_aperture() {
        for mut r in (0..50).map(Draws::new) {
            let mut draw = || r.inside([-2.0, 2.0]);
            let k = DMat2::from_cols(DVec2::new(draw(), draw()), DVec2::new(draw(), draw()));
            let phi = draw();
            let matrix = k - DMat2::from_diagonal(DVec2::splat(phi));
            let rim = (0..20_000).map(|step| {
                let angle = 1e-4 * std::f64::consts::PI * f64::from(step);
                (matrix * DVec2::new(cos(angle), sin(angle))).length()
            });
            let (lo, hi) = rim.fold((f64::INFINITY, 0.0f64), |(a, b), d| (a.min(d), b.max(d)));
            let [major, minor] = spot(k).semi_axes(phi);
            assert!((major - hi).abs() < 1e-6 && (minor - lo).abs() < 1e-3, "{major} {minor}");
            // The mean square over a disc of radius 1 of |M a|^2 is the trace of M^T M over 4.
            let trace: f64 = (matrix.transpose() * matrix).to_cols_array().iter().step_by(3).sum();
            let rms = 2.0 * (0.25 * trace).sqrt();
            assert!((spot(k).rms_diameter(phi) - rms).abs() < 1e-12);
            assert!((spot(k).scaled(3.0).length(phi) - 6.0 * major).abs() < 1e-12);
        }
    }

    #[test]
    fn at_a_focus_the_ellipse_is_a_line() {
        let k = DMat2::from_cols(DVec2::new(3.0, 0.4), DVec2::new(0.4, 2.0));
        let foci = spot(k).foci();
        for phi in foci {
            assert!(spot(k).semi_axes(phi)[1] < 1e-12);
        }
        assert!((foci[0] * foci[1] - k.determinant()).abs() < 1e-12);
    }

    #[test]
    fn the_best_focus_is_the_best_of_a_dense_scan() {
        for seed in 0..6 {
            let mut r = Draws::new(seed);
            let spots: Vec<BlurEllipse> = (0..3000)
                .map(|_| {
                    let middle = 4.0 + r.inside([-1.0, 1.0]) * r.inside([0.0, 2.0]);
                    let off = r.inside([0.0, 0.5]);
                    spot(DMat2::from_diagonal(DVec2::new(middle - off, middle + off)))
                })
                .collect();
            let p95 =
                |phi: f64| quantiles(spots.iter().map(|s| s.length(phi)).collect()).unwrap().p95;
            let best = p95(best_focus(&spots, 0.0).unwrap());
            let scan = (0..4000).map(|k| p95(2.0 + 1e-3 * f64::from(k))).fold(f64::MAX, f64::min);
            assert!(best <= scan * (1.0 + 1e-3), "{seed}: {best} {scan}");
            assert_eq!(best_focus(&spots, 9.0), Some(9.0));
        }
        assert_eq!(best_focus(&[], 0.0), None);
    }

    #[test]
    fn quantiles_are_ranks() {
        let hundred = (1..=100).rev().map(f64::from).collect();
        assert_eq!(quantiles(hundred), Some(Quantiles { p50: 50.0, p95: 95.0, max: 100.0 }));
        assert_eq!(quantiles(vec![]), None);
    }
}
