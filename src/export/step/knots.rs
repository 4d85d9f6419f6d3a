//! Knots: how fine a spline has to be, and where.

use super::b_spline::KnotVector;
use super::parametric_surface::ParametricSurface;
use crate::geom::{DVec2, DVec3};
use crate::num::max_or_nan;

/// Spans along an axis at first and at most.
const FIRST_SPANS: usize = 8;
pub(super) const MOST_SPANS: usize = 400;
/// Lines along which an axis' knots are chosen.
const LINES: usize = 25;
/// Places in every span where the error is measured.
const PARTS: usize = 6;

/// Lines along which the knots of an axis are chosen.
pub(super) struct KnotLines {
    pub axis: usize,
    pub ends: [f64; 2],
    /// Whether the mirror is even along them.
    pub even: bool,
    /// Their places on the other axis.
    pub across: Vec<f64>,
}

impl KnotLines {
    /// Lines all over the mirror.
    pub(super) fn across(surface: &ParametricSurface, axis: usize) -> Self {
        let [ends, across] = [axis, 1 - axis]
            .map(|axis| [surface.domain.min, surface.domain.max].map(|end| end[axis]));
        let from = if surface.even[1 - axis] { 0.5 * (across[0] + across[1]) } else { across[0] };
        let place = |k: usize| from + (across[1] - from) * k as f64 / (LINES - 1) as f64;
        let across = (0..LINES).map(place).chain(surface.ring.into_iter().flatten()).collect();
        Self { axis, ends: ends.map(written_digits), even: surface.even[axis], across }
    }
}

/// Breaks along an axis with which splines meet the mirror within `limit` on lines along it.
pub(super) fn choose_breaks(
    surface: &ParametricSurface,
    lines: &KnotLines,
    limit: f64,
) -> Vec<f64> {
    let mut breaks = distribute(&lines.ends, &[1.0], FIRST_SPANS, lines.even);
    loop {
        let errors = errors(surface, lines, &breaks);
        let worst = errors.iter().copied().fold(0.0, max_or_nan);
        let spans = breaks.len() - 1;
        if worst <= limit || spans >= MOST_SPANS || worst.is_nan() {
            return breaks;
        }
        // The error of a span falls with the fourth power of its length.
        let lengths: Vec<f64> = errors.iter().map(|e| (e / (0.7 * limit)).sqrt().sqrt()).collect();
        let wanted = lengths.iter().sum::<f64>().ceil() as usize;
        let few = |given: &Vec<f64>| given.len() <= MOST_SPANS + 1 && wanted + 1 >= given.len();
        if let Some(given) = surface.breaks(lines.axis).filter(few) {
            return given.into_iter().map(written_digits).collect();
        }
        let mut density: Vec<f64> =
            breaks.windows(2).zip(&lengths).map(|(ends, n)| n / (ends[1] - ends[0])).collect();
        for k in 1..spans {
            density[k] = density[k].max(0.5 * density[k - 1]);
        }
        for k in (1..spans).rev() {
            density[k - 1] = density[k - 1].max(0.5 * density[k]);
        }
        let count = wanted.clamp(spans + 1, 4 * spans).min(MOST_SPANS);
        breaks = distribute(&breaks, &density, count, lines.even);
    }
}

/// Breaks of `count` spans, whose density in each of the old spans is proportional to `density`.
fn distribute(old: &[f64], density: &[f64], count: usize, even: bool) -> Vec<f64> {
    let mut at = vec![0.0];
    for (ends, density) in old.windows(2).zip(density) {
        at.push(at[at.len() - 1] + density * (ends[1] - ends[0]));
    }
    let total = at[at.len() - 1];
    let place = |k: usize| {
        let wanted = total * k as f64 / count as f64;
        let span = at[1..at.len() - 1].partition_point(|&a| a <= wanted);
        let share = (wanted - at[span]) / (at[span + 1] - at[span]);
        old[span] + (old[span + 1] - old[span]) * share
    };
    let mut breaks: Vec<f64> = (0..=count).map(place).collect();
    // Knots of few digits whose means of three have few digits too.
    let least = breaks.windows(2).map(|ends| ends[1] - ends[0]).fold(f64::INFINITY, f64::min);
    let mut per = 1e-3;
    while per * least < 100.0 && per < 1e9 {
        per *= 10.0;
    }
    for knot in &mut breaks[1..count] {
        *knot = (*knot * per / 3.0).round() * 3.0 / per + 0.0;
    }
    (breaks[0], breaks[count]) = (old[0], old[old.len() - 1]);
    if even {
        for k in 0..=count / 2 {
            breaks[count - k] = 0.0 - breaks[k];
        }
    }
    breaks
}

/// The largest distance (mm) of a spline with `breaks` from the mirror in each of its spans.
fn errors(surface: &ParametricSurface, lines: &KnotLines, breaks: &[f64]) -> Vec<f64> {
    let KnotLines { axis, across, .. } = lines;
    let count = across.len();
    // One place after the other, with the points on all lines.
    let points = |places: &[f64]| -> Vec<Vec<DVec3>> {
        if *axis == 1 {
            return surface.grid(across, places);
        }
        let rows = surface.grid(places, across);
        (0..places.len()).map(|k| rows.iter().map(|row| row[k]).collect()).collect()
    };
    let line = KnotVector::new(breaks);
    let samples: Vec<f64> =
        points(&line.sites()).concat().iter().flat_map(|p| p.to_array()).collect();
    let found = line.fit(3 * count, &samples);
    let places = line.interior_points(PARTS);
    let wanted = points(&places);
    let mut errors = vec![0.0f64; breaks.len() - 1];
    for (k, (&place, wanted)) in places.iter().zip(&wanted).enumerate() {
        let (first, b) = line.basis(place);
        let is_in = |&l: &usize| {
            let mut q = DVec2::splat(place);
            q[1 - axis] = across[l];
            surface.contains(q)
        };
        for l in (0..count).filter(is_in) {
            let at = |r: usize| DVec3::from_slice(&found[3 * ((first + r) * count + l)..]) * b[r];
            let off = ((0..4).map(at).sum::<DVec3>() - wanted[l]).length();
            errors[k / PARTS] = max_or_nan(errors[k / PARTS], off);
        }
    }
    errors
}

/// `x` rounded to the digits that are written, 1e-10.
pub(super) fn written_digits(x: f64) -> f64 {
    (x * 1e10).round() / 1e10 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_follow_the_density_in_few_digits() {
        let breaks = distribute(&[-3.0, 0.0, 3.0], &[2.0, 2.0], 7, true);
        assert_eq!(breaks.len(), 8);
        for (k, knot) in breaks.iter().enumerate() {
            assert_eq!(breaks[7 - k], -knot);
            assert!((knot - (6.0 * k as f64 / 7.0 - 3.0)).abs() < 1e-2);
        }
        for mean in breaks.windows(3).map(|k| (k[0] + k[1] + k[2]) / 3.0).skip(1).take(4) {
            assert!((mean * 1e3 - (mean * 1e3).round()).abs() < 1e-9, "{mean}");
        }
        // Three times as dense on the right.
        let breaks = distribute(&[0.0, 10.0, 20.0], &[0.1, 0.3], 40, false);
        assert_eq!(breaks.iter().filter(|&&knot| knot < 9.9).count(), 10);
    }

    #[test]
    fn what_is_not_a_number_is_the_worst() {
        assert!(max_or_nan(1.0, f64::NAN).is_nan() && max_or_nan(f64::NAN, 1.0).is_nan());
        assert_eq!((max_or_nan(1.0, 2.0), max_or_nan(2.0, 1.0)), (2.0, 2.0));
    }

    #[test]
    fn written_digits_have_no_minus_zero() {
        assert_eq!(written_digits(-1e-11).to_bits(), 0.0f64.to_bits());
        assert_eq!(written_digits(1.234_567_890_123), 1.234_567_890_1);
    }
}
