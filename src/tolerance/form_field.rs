//! Departures of the made surface from the designed one, along Z over (X, Y) of the part frame.

use super::footprint::Footprint;
use crate::num::{Scalar, cos, log, sin};
use crate::tolerance_terms::{FormMeasure, FormTerm};
use std::f64::consts::{PI, TAU};

/// A departure of unit size: of a term one millimetre by its measure, of a wave an amplitude of one
/// millimetre.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum FormField {
    /// Sum of c u^i v^j over (i, j, c), with (u, v) = ((x, y) - centre) / half.
    Polynomial {
        /// Place of (u, v) = (0, 0), mm.
        centre: [f64; 2],
        /// mm per unit of u and v.
        half: [f64; 2],
        /// Terms.
        terms: Vec<(usize, usize, f64)>,
    },
    /// The cosine of k . (x, y).
    Cosine([f64; 2]),
    /// The sine of k . (x, y).
    Sine([f64; 2]),
}

/// Factor that makes P_i P_j, of degrees up to 4, one by its measure.
fn legendre_per(i: u8, j: u8, measure: FormMeasure) -> f64 {
    match measure {
        FormMeasure::Pv => {
            const LEAST: [f64; 5] = [1.0, -1.0, -0.5, -1.0, -3.0 / 7.0];
            let [a, b] = [i, j].map(|n| LEAST[usize::from(n)]);
            1.0 / (1.0 - (a * b).min(a).min(b))
        }
        // The mean square of P_n is 1 / (2 n + 1).
        FormMeasure::Rms => (f64::from(2 * i + 1) * f64::from(2 * j + 1)).sqrt(),
    }
}

/// Factor that makes a Zernike term of one peak to valley one by its measure.
fn zernike_per(j: u8, measure: FormMeasure) -> f64 {
    match (measure, j) {
        (FormMeasure::Pv, _) => 1.0,
        // Noll's own polynomials have a mean square of 1.
        (FormMeasure::Rms, 4) => 2.0 * 3f64.sqrt(),
        (FormMeasure::Rms, 5 | 6) => 2.0 * 6f64.sqrt(),
        (FormMeasure::Rms, 7..=10) => 4.0 * 2f64.sqrt(),
        (FormMeasure::Rms, _) => 1.5 * 5f64.sqrt(),
    }
}

/// Size, by a measure, of a form error that is one peak to valley.
#[must_use]
pub fn form_of_pv(term: FormTerm, measure: FormMeasure) -> f64 {
    let per = |measure| match term {
        FormTerm::Legendre(i, j) => legendre_per(i, j, measure),
        FormTerm::Zernike(j) => zernike_per(j, measure),
    };
    per(FormMeasure::Pv) / per(measure)
}

impl FormField {
    /// A term over the rectangle about `centre` with these half sides, or over the disc of half its width about the axis.
    pub(super) fn of_term(
        term: FormTerm,
        (centre, half): ([f64; 2], [f64; 2]),
        measure: FormMeasure,
    ) -> Self {
        match term {
            FormTerm::Legendre(i, j) => Self::legendre(i, j, centre, half, measure),
            FormTerm::Zernike(j) => Self::zernike(j, half[0], measure),
        }
    }

    /// The Legendre term of degrees `i` and `j` up to 4 over a rectangle.
    #[must_use]
    pub(super) fn legendre(
        i: u8,
        j: u8,
        centre: [f64; 2],
        half: [f64; 2],
        measure: FormMeasure,
    ) -> Self {
        const P: [&[f64]; 5] = [
            &[1.0],
            &[0.0, 1.0],
            &[-0.5, 0.0, 1.5],
            &[0.0, -1.5, 0.0, 2.5],
            &[0.375, 0.0, -3.75, 0.0, 4.375],
        ];
        let (i, j, per) = (usize::from(i), usize::from(j), legendre_per(i, j, measure));
        let along = P[i].iter().enumerate();
        let terms =
            along.flat_map(|(a, p)| P[j].iter().enumerate().map(move |(b, q)| (a, b, per * p * q)));
        Self::Polynomial { centre, half, terms: terms.filter(|t| t.2 != 0.0).collect() }
    }

    /// The Zernike term of Noll's index `j`, 4 to 11, over a disc about the axis (R. Noll, *Zernike
    /// polynomials and atmospheric turbulence*, 1976).
    #[must_use]
    pub(super) fn zernike(j: u8, radius: f64, measure: FormMeasure) -> Self {
        let terms: &[(usize, usize, f64)] = match j {
            4 => &[(2, 0, 1.0), (0, 2, 1.0), (0, 0, -0.5)],
            5 => &[(1, 1, 1.0)],
            6 => &[(2, 0, 0.5), (0, 2, -0.5)],
            7 => &[(2, 1, 1.5), (0, 3, 1.5), (0, 1, -1.0)],
            8 => &[(3, 0, 1.5), (1, 2, 1.5), (1, 0, -1.0)],
            9 => &[(2, 1, 1.5), (0, 3, -0.5)],
            10 => &[(3, 0, 0.5), (1, 2, -1.5)],
            _ => &[
                (4, 0, 4.0),
                (2, 2, 8.0),
                (0, 4, 4.0),
                (2, 0, -4.0),
                (0, 2, -4.0),
                (0, 0, 2.0 / 3.0),
            ],
        };
        let per = zernike_per(j, measure);
        let terms = terms.iter().map(|&(i, j, c)| (i, j, per * c)).collect();
        Self::Polynomial { centre: [0.0; 2], half: [radius; 2], terms }
    }

    /// Height and slope at a place.
    #[inline]
    pub(super) fn at<S: Scalar>(&self, at: [S; 2]) -> [S; 3] {
        match self {
            Self::Polynomial { centre, half, terms } => {
                let u = [0, 1].map(|k| (at[k] - centre[k]) / half[k]);
                let power = |x: S, n: usize| (0..n).fold(S::constant(1.0), |p, _| p * x);
                let slope = |x: S, n: usize| match n {
                    0 => S::constant(0.0),
                    _ => power(x, n - 1) * n as f64,
                };
                let mut sum = [S::constant(0.0); 3];
                for &(i, j, c) in terms {
                    sum[0] = sum[0] + power(u[0], i) * power(u[1], j) * c;
                    sum[1] = sum[1] + slope(u[0], i) * power(u[1], j) * (c / half[0]);
                    sum[2] = sum[2] + power(u[0], i) * slope(u[1], j) * (c / half[1]);
                }
                sum
            }
            Self::Cosine(k) => {
                let phase = at[0] * k[0] + at[1] * k[1];
                let down = -phase.sin();
                [phase.cos(), down * k[0], down * k[1]]
            }
            Self::Sine(k) => {
                let phase = at[0] * k[0] + at[1] * k[1];
                let up = phase.cos();
                [phase.sin(), up * k[0], up * k[1]]
            }
        }
    }

    /// The share of it that a pixel of this footprint sees.
    pub(super) fn footprint_share(&self, footprint: &Footprint) -> f64 {
        match self {
            Self::Polynomial { .. } => 1.0,
            Self::Cosine(k) | Self::Sine(k) => footprint.ripple(*k),
        }
    }

    /// A period, or half the mirror.
    pub(super) fn swing_mm(&self) -> f64 {
        match self {
            Self::Polynomial { half: [a, b], .. } => a.min(*b),
            Self::Cosine(k) | Self::Sine(k) => period_mm(*k),
        }
    }
}

/// The wavelength of a wave vector, mm.
pub(super) fn period_mm([x, y]: [f64; 2]) -> f64 {
    TAU / (x * x + y * y).sqrt()
}

/// `sum` and `a` times a height and slopes.
#[inline]
pub(super) fn add_scaled<S: Scalar>(sum: [S; 3], a: f64, [f, x, y]: [S; 3]) -> [S; 3] {
    [sum[0] + f * a, sum[1] + x * a, sum[2] + y * a]
}

/// Height and slope of a cos(phase) + b sin(phase), of phase k . (x, y).
#[inline]
pub(super) fn ripple<S: Scalar>(k: [f64; 2], [a, b]: [f64; 2], at: [S; 2]) -> [S; 3] {
    let phase = at[0] * k[0] + at[1] * k[1];
    let (s, c) = (phase.sin(), phase.cos());
    let rise = c * b - s * a;
    [c * a + s * b, rise * k[0], rise * k[1]]
}

/// Number of waves of the random slope error.
const MODES: usize = 24;

/// The waves whose sum, with independent normal amplitudes of the standard deviations given with
/// them, has a gradient of RMS 1 and the autocorrelation exp(-(d / `length`)^2): their wave vectors
/// sample the spectrum k^0 exp(-k^2 length^2 / 4) of the slope evenly, all directions alike. Each
/// comes as cosine and sine; none is longer than four times `size`.
#[must_use]
pub(super) fn slope_modes(length: f64, size: f64) -> Vec<(FormField, f64)> {
    // Turned on by the golden angle, no two waves have one direction.
    let golden = PI * (3.0 - 5.0f64.sqrt());
    let mode = |m: usize| {
        let below = (m as f64 + 0.5) / MODES as f64;
        let k = (2.0 / length * (-log(1.0 - below)).sqrt()).max(TAU / (4.0 * size));
        let angle = golden * m as f64;
        let k = [k * cos(angle), k * sin(angle)];
        let deviation = 1.0 / ((MODES as f64).sqrt() * (k[0] * k[0] + k[1] * k[1]).sqrt());
        [(FormField::Cosine(k), deviation), (FormField::Sine(k), deviation)]
    };
    (0..MODES).flat_map(mode).collect()
}

/// Tracks of a ball cutter, circles of some curvature, 1/mm: height over their grooves and slope along
/// the way they follow each other, at the signed distance `from_track`. Flanks steeper than 60 degrees
/// are not followed.
#[inline]
pub(super) fn cusp<S: Scalar>(curvature: f64, from_track: S) -> [S; 2] {
    let left = -(from_track * curvature).square() + 1.0;
    let root = if left.mid() > 0.25 { left.sqrt() } else { S::constant(0.5) };
    [from_track.square() * curvature / (root + 1.0), from_track * curvature / root]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::random::RandomStream;
    use crate::tolerance::texture::scallop_height;

    fn terms(measure: FormMeasure) -> Vec<(FormField, [f64; 2])> {
        let (centre, half) = ([1.0, -2.0], [30.0, 20.0]);
        let degrees = [(2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (4, 0), (2, 2)];
        let rect = degrees.map(|(i, j)| (FormField::legendre(i, j, centre, half, measure), half));
        let disc = (4..=11).map(|j| (FormField::zernike(j, 25.0, measure), [25.0; 2]));
        rect.into_iter().chain(disc).collect()
    }

    #[test]
    fn terms_have_a_peak_to_valley_of_one_and_their_slope() {
        for (k, (field, half)) in terms(FormMeasure::Pv).into_iter().enumerate() {
            let round = k >= 9;
            let centre = if round { [0.0; 2] } else { [1.0, -2.0] };
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in -200..=200 {
                for j in -200..=200 {
                    let (mut u, mut v) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
                    if round {
                        // Polar, so that the rim is met.
                        let (r, angle) = (0.5 * (u + 1.0), PI * v);
                        (u, v) = (r * cos(angle), r * sin(angle));
                    }
                    let f = field.at([centre[0] + u * half[0], centre[1] + v * half[1]])[0];
                    (lo, hi) = (lo.min(f), hi.max(f));
                }
            }
            assert!((hi - lo - 1.0).abs() < 3e-3, "{k}: {lo} {hi}");
        }
        let k = [0.3, -0.8];
        let waves = [FormField::Cosine(k), FormField::Sine(k)];
        let (at, [a, b]) = ([7.0, -4.5], [2.0, -3.0]);
        let [cosine, sine] = waves.each_ref().map(|wave| wave.at(at));
        for (both, (c, s)) in ripple(k, [a, b], at).into_iter().zip(cosine.into_iter().zip(sine)) {
            assert!((both - a * c - b * s).abs() < 1e-14);
        }
        for field in terms(FormMeasure::Pv).into_iter().map(|t| t.0).chain(waves) {
            let (x, y, h) = (7.0, -4.5, 1e-5);
            let f = |x: f64, y: f64| field.at([x, y])[0];
            let [_, f_x, f_y] = field.at([x, y]);
            assert!((f_x - (f(x + h, y) - f(x - h, y)) / (2.0 * h)).abs() < 1e-9);
            assert!((f_y - (f(x, y + h) - f(x, y - h)) / (2.0 * h)).abs() < 1e-9);
        }
    }

    #[test]
    fn terms_measured_by_rms_have_one_of_one() {
        for (k, (field, half)) in terms(FormMeasure::Rms).into_iter().enumerate() {
            let round = k >= 9;
            let centre = if round { [0.0; 2] } else { [1.0, -2.0] };
            let (mut squares, mut area) = (0.0, 0.0);
            for (i, j) in (0..200).flat_map(|i| (0..200).map(move |j| (i, j))) {
                let middle = |k: i32| (f64::from(k) + 0.5) / 100.0 - 1.0;
                let (mut u, mut v) = (middle(i), middle(j));
                let mut weight = 1.0;
                if round {
                    let (r, angle) = (0.5 * (u + 1.0), PI * v);
                    (u, v, weight) = (r * cos(angle), r * sin(angle), r);
                }
                let f = field.at([centre[0] + u * half[0], centre[1] + v * half[1]])[0];
                squares += weight * f * f;
                area += weight;
            }
            assert!((squares / area - 1.0).abs() < 2e-3, "{k}: {}", squares / area);
        }
    }

    #[test]
    fn random_slopes_have_their_rms_and_correlation() {
        let (length, trials) = (4.0, 4000);
        let modes = slope_modes(length, 60.0);
        let (mut square, mut at_length) = (0.0, 0.0);
        for trial in 0..trials {
            let stream = RandomStream { seed: 3, trial };
            let slope = |at: [f64; 2]| {
                let mut sum = [0.0; 2];
                for (m, (field, deviation)) in modes.iter().enumerate() {
                    let a = deviation * stream.normals(0, m as u32)[0];
                    let [_, x, y] = field.at(at);
                    sum = [sum[0] + a * x, sum[1] + a * y];
                }
                sum
            };
            let a = slope([2.0, 5.0]);
            square += (a[0] * a[0] + a[1] * a[1]) / trials as f64;
            for way in [[length, 0.0], [0.0, length], [0.6 * length, -0.8 * length]] {
                let b = slope([2.0 + way[0], 5.0 + way[1]]);
                at_length += (a[0] * b[0] + a[1] * b[1]) / (3 * trials) as f64;
            }
        }
        assert!((square - 1.0).abs() < 0.06, "{square}");
        assert!((at_length - crate::num::exp(-1.0)).abs() < 0.1, "{at_length}");
    }

    #[test]
    fn cusps_meet_at_the_scallop_height() {
        let (ball, stepover) = (3.0, 0.4);
        let [height, slope] = cusp(1.0 / ball, 0.5 * stepover);
        assert!((height - scallop_height(ball, stepover)).abs() < 1e-16);
        let h = 1e-6;
        let up = (cusp(1.0 / ball, 0.2 + h)[0] - cusp(1.0 / ball, 0.2 - h)[0]) / (2.0 * h);
        assert!((slope - up).abs() < 1e-9);
        // RMS slope about w / (2 sqrt 3 R).
        let n = 10_000;
        let at = |k: usize| cusp(1.0 / ball, stepover * ((k as f64 + 0.5) / n as f64 - 0.5))[1];
        let rms = ((0..n).map(|k| at(k) * at(k)).sum::<f64>() / n as f64).sqrt();
        assert!((rms / (stepover / (12.0f64.sqrt() * ball)) - 1.0).abs() < 2e-3);
    }
}
