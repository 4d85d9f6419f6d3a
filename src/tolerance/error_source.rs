//! Error sources: what can be off, in which unit, by how much and how likely.

use crate::num::random::{RandomStream, normal_cdf, normal_quantile};
use crate::num::{exp, radians};
use serde::Serialize;
use std::f64::consts::PI;

/// What is off. Rotations and the scale are about the part frame's origin, the middle of the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Perturbation {
    /// The mirror is shifted along X.
    DecentreX,
    /// The mirror is shifted along Y.
    DecentreY,
    /// The mirror is shifted towards the camera.
    Despace,
    /// The mirror is turned about X.
    TiltX,
    /// The mirror is turned about Y.
    TiltY,
    /// The mirror is turned about the axis.
    Clocking,
    /// The part is larger.
    Scale,
    /// The part is warmer, and larger by its thermal expansion.
    Temperature,
    /// The camera's picture is magnified.
    Magnification,
    /// The chief rays of a telecentric camera lean outwards, by the angle at half the frame's
    /// width.
    Telecentricity,
    /// The sensor is shifted along X.
    PrincipalX,
    /// The sensor is shifted along Y.
    PrincipalY,
    /// Third-order radial distortion, at half the frame's width.
    Distortion,
    /// Form error along Z, peak to valley or RMS: the Legendre term of these degrees in X and Y over the
    /// rectangle around a rectangular mirror.
    Legendre(u8, u8),
    /// Form error along Z, peak to valley or RMS: the Zernike term of this index (Noll's) over the disc
    /// of a round mirror.
    Zernike(u8),
    /// A measured form error, in its own heights.
    Map,
    /// A ripple, peak to valley, of a known period and direction and any phase.
    Waviness,
    /// A random slope error with a Gaussian autocorrelation: RMS of the gradient of its height along
    /// Z. On ground of slope g the normal turns by 1 / (1 + g^2) of that up and down the slope, and by
    /// 1 / sqrt(1 + g^2) across it.
    Slope,
    /// Cusps that a ball cutter leaves between tracks so far apart, of any phase.
    Stepover,
    /// Flat terraces that a printer's layers of this height leave: what reflects is level.
    Layers,
    /// Flat facets of the mesh that the part is made from: the bound of the picture's displacement.
    Facets,
}

/// The form errors of rectangles, by their degrees in X and Y.
const LEGENDRE: [(u8, u8); 9] =
    [(2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (4, 0), (2, 2)];
/// The form errors of discs: defocus, astigmatism, coma, trefoil, spherical.
const ZERNIKE: std::ops::RangeInclusive<u8> = 4..=11;

impl Perturbation {
    /// Every kind, in the order of reports.
    pub fn all() -> impl Iterator<Item = Self> {
        let placed = [
            Self::DecentreX,
            Self::DecentreY,
            Self::Despace,
            Self::TiltX,
            Self::TiltY,
            Self::Clocking,
            Self::Scale,
            Self::Temperature,
            Self::Magnification,
            Self::Telecentricity,
            Self::PrincipalX,
            Self::PrincipalY,
            Self::Distortion,
        ];
        let legendre = LEGENDRE.into_iter().map(|(i, j)| Self::Legendre(i, j));
        let textures = [Self::Waviness, Self::Slope, Self::Stepover, Self::Layers, Self::Facets];
        let rest = [Self::Map].into_iter().chain(textures);
        placed.into_iter().chain(legendre).chain(ZERNIKE.map(Self::Zernike)).chain(rest)
    }

    /// Its key in a profile, which ends in its unit.
    #[must_use]
    pub fn key(self) -> String {
        match self {
            Self::DecentreX => "decentre_x_um".into(),
            Self::DecentreY => "decentre_y_um".into(),
            Self::Despace => "despace_um".into(),
            Self::TiltX => "tilt_x_mrad".into(),
            Self::TiltY => "tilt_y_mrad".into(),
            Self::Clocking => "clocking_mrad".into(),
            Self::Scale => "scale_ppm".into(),
            Self::Temperature => "temperature_k".into(),
            Self::Magnification => "magnification_ppm".into(),
            Self::Telecentricity => "telecentricity_mrad".into(),
            Self::PrincipalX => "principal_x_px".into(),
            Self::PrincipalY => "principal_y_px".into(),
            Self::Distortion => "distortion_ppm".into(),
            Self::Legendre(i, j) => format!("legendre_{i}{j}_um"),
            Self::Zernike(j) => format!("zernike_{j}_um"),
            Self::Map => "map_share".into(),
            Self::Waviness => "waviness_um".into(),
            Self::Slope => "slope_mrad".into(),
            Self::Stepover => "stepover_mm".into(),
            Self::Layers => "layer_um".into(),
            Self::Facets => "facets_px".into(),
        }
    }

    /// The kind with this key.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        Self::all().find(|kind| kind.key() == key)
    }

    /// The unit its limit is in.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::TiltX | Self::TiltY | Self::Clocking | Self::Telecentricity | Self::Slope => {
                "mrad"
            }
            Self::Scale | Self::Magnification | Self::Distortion => "ppm",
            Self::Temperature => "K",
            Self::PrincipalX | Self::PrincipalY | Self::Facets => "px",
            Self::Map => "of the map",
            Self::Stepover => "mm",
            _ => "um",
        }
    }

    /// Whether every part has all of it, in a pattern that differs from part to part.
    #[must_use]
    pub fn is_texture(self) -> bool {
        matches!(self, Self::Waviness | Self::Slope | Self::Stepover | Self::Facets)
    }

    /// Whether it is usually finer than pixels, which see the mean of it: its displacement grows faster
    /// than its limit.
    #[must_use]
    pub fn is_fine(self) -> bool {
        matches!(self, Self::Stepover | Self::Facets)
    }

    /// The number of its random stream: the same whatever other sources there are.
    pub(super) fn stream(self) -> u32 {
        match self {
            Self::DecentreX => 0,
            Self::DecentreY => 1,
            Self::Despace => 2,
            Self::TiltX => 3,
            Self::TiltY => 4,
            Self::Clocking => 5,
            Self::Scale => 6,
            Self::Temperature => 7,
            Self::Magnification => 8,
            Self::Telecentricity => 9,
            Self::PrincipalX => 10,
            Self::PrincipalY => 11,
            Self::Distortion => 12,
            Self::Map => 13,
            Self::Waviness => 14,
            Self::Slope => 15,
            Self::Stepover => 16,
            Self::Facets => 17,
            Self::Layers => 18,
            Self::Legendre(i, j) => 100 + 10 * u32::from(i) + u32::from(j),
            Self::Zernike(j) => 200 + u32::from(j),
        }
    }
}

/// How likely an error is. A limit of a normal distribution is two standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// Anything between both limits alike.
    Uniform,
    /// Normal: one in 22 lies beyond the limits.
    Normal,
    /// Normal, without what lies beyond the limits.
    Truncated,
    /// Always at the limit, with its sign: a known error. Of a texture this is its strength, and the
    /// pattern is random.
    Fixed,
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

/// An error source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorSource {
    /// What is off.
    pub kind: Perturbation,
    /// By how much, in the unit of its kind; negative only of a systematic error.
    pub limit: f64,
    /// How likely.
    pub distribution: Distribution,
    /// Its share of the variance when a budget is allotted, against the others': what is expensive
    /// to hold gets more.
    pub weight: f64,
}

impl ErrorSource {
    /// Whether it is the same in every part: fixed, and no texture. Such errors add as they are,
    /// with their signs; they have no variance.
    #[must_use]
    pub fn is_systematic(&self) -> bool {
        self.distribution == Distribution::Fixed && !self.kind.is_texture()
    }

    /// The same always at another limit.
    #[must_use]
    pub(super) fn fixed(&self, limit: f64) -> Self {
        Self { limit, distribution: Distribution::Fixed, ..*self }
    }

    /// Its error in a trial, in its own unit; of a texture its strength.
    #[must_use]
    pub fn draw(&self, stream: &RandomStream) -> f64 {
        let [u, _] = stream.pair(self.kind.stream(), 0);
        self.limit * self.distribution.quantile(u)
    }
}

/// What shapes the textures and the thermal expansion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TextureShape {
    /// Thermal expansion of the part, 1e-6 / K.
    pub cte_ppm_per_k: f64,
    /// Period of the waviness, mm.
    pub waviness_period_mm: f64,
    /// Direction in which the waves follow each other, from X towards Y, degrees.
    pub waviness_direction_deg: f64,
    /// Distance over which the autocorrelation of the random slope falls to 1/e, mm.
    pub slope_correlation_mm: f64,
    /// Radius of the ball cutter, mm.
    pub ball_radius_mm: f64,
    /// Direction in which its tracks follow each other, from X towards Y, degrees.
    pub stepover_direction_deg: f64,
    /// Wavelength of the light, nm.
    pub wavelength_nm: f64,
}

impl TextureShape {
    /// Unit vector of a direction.
    pub(super) fn way(degrees: f64) -> [f64; 2] {
        let angle = radians(degrees);
        [crate::num::cos(angle), crate::num::sin(angle)]
    }
}

/// RMS slope of a ripple of height `pv` and period `period`, of the same unit.
#[must_use]
pub fn ripple_slope(pv: f64, period: f64) -> f64 {
    PI * pv / (std::f64::consts::SQRT_2 * period)
}

/// Height of the cusps that a ball of radius `ball` leaves between tracks `stepover` apart.
#[must_use]
pub fn scallop_height(ball: f64, stepover: f64) -> f64 {
    let half = 0.5 * stepover;
    // Without cancellation.
    half * half / (ball + (ball * ball - half * half).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_name_their_kind_and_streams_differ() {
        let all: Vec<Perturbation> = Perturbation::all().collect();
        for (k, kind) in all.iter().enumerate() {
            assert_eq!(Perturbation::of_key(&kind.key()), Some(*kind));
            assert!(all[..k].iter().all(|other| other.stream() != kind.stream()));
        }
        assert_eq!(Perturbation::of_key("colour"), None);
    }

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

    #[test]
    fn cusps_are_as_high_as_the_shop_says() {
        let (ball, stepover): (f64, f64) = (3.0, 0.4);
        let exact = ball - (ball * ball - 0.25 * stepover * stepover).sqrt();
        assert!((scallop_height(ball, stepover) - exact).abs() < 1e-15);
        assert!((ripple_slope(1e-3, 2.0) / 1.110_720_734_539_591_6e-3 - 1.0).abs() < 1e-15);
    }
}
