//! Figures as people read them.

use crate::num::stats::Summary;

/// Three or four digits that matter.
#[must_use]
pub(crate) fn digits(x: f64) -> String {
    if x != 0.0 && x.abs() < 1e-3 { format!("{x:.2e}") } else { format!("{x:.3}") }
}

/// Three digits of a number that is not negative, without an exponent.
#[must_use]
pub(crate) fn three_digits(x: f64) -> String {
    let (mut decimals, mut first) = (2_usize, x);
    while first >= 10.0 && decimals > 0 {
        (decimals, first) = (decimals - 1, first / 10.0);
    }
    while first > 0.0 && first < 1.0 && decimals < 12 {
        (decimals, first) = (decimals + 1, first * 10.0);
    }
    format!("{x:.decimals$}")
}

/// A pixel error that is not negative, px. Below a thousandth of a pixel it is told as that much: less than that changes no
/// grey value of a camera of eight bits by more than a quarter of a step.
#[must_use]
pub(crate) fn error_px(px: f64) -> String {
    if px < 1e-3 { "less than 0.001".into() } else { three_digits(px) }
}

/// RMS, P95 and maximum, px, mm or mrad: what is below a billionth of these is rounding.
#[must_use]
pub(crate) fn figures(summary: Option<Summary>) -> String {
    let told = |x: f64| if x < 1e-9 { "0.000".to_owned() } else { digits(x) };
    summary.map_or("none".into(), |s| {
        format!("{} rms, {} p95, {} max", told(s.rms), told(s.p95), told(s.max))
    })
}

/// A displacement, px, to a thousandth; infinite where rays are lost.
#[must_use]
pub(crate) fn displacement(px: f64) -> String {
    match px {
        px if !px.is_finite() => "lost".into(),
        px if px.abs() >= 1e7 => format!("{px:.2e}"),
        px => coordinate(px, 3),
    }
}

/// A share as a percentage, without the noise of its last digits.
#[must_use]
pub(crate) fn percent(share: f64) -> f64 {
    (1e8 * share).round() / 1e6
}

/// A coordinate in mm to so many decimals, without the sign of a zero.
#[must_use]
pub(crate) fn coordinate(mm: f64, decimals: u32) -> String {
    let unit = f64::from(10u32.pow(decimals));
    format!("{:.width$}", (mm * unit).round() / unit + 0.0, width = decimals as usize)
}

/// The length of a file.
#[must_use]
pub(crate) fn file_size(bytes: u64) -> String {
    match bytes {
        ..100_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

/// The number of triangles allowed, if there is one.
#[must_use]
pub(crate) fn of_at_most(most: Option<usize>) -> String {
    most.map_or(String::new(), |most| format!(", of at most {most}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits() {
        let found =
            [0.83214, 15.06, 3.3, 120.4, 0.002_987, 0.5, 0.0129, 1.2851e-3].map(three_digits);
        assert_eq!(
            found,
            ["0.832", "15.1", "3.30", "120", "0.00299", "0.500", "0.0129", "0.00129"]
        );
    }

    #[test]
    fn pixel_errors_that_nobody_sees_are_told_as_such() {
        let found = [9.48e-9, 0.0, 9.99e-4, 1e-3, 1.627].map(error_px);
        let none = "less than 0.001";
        assert_eq!(found, [none, none, none, "0.00100", "1.63"]);
    }

    #[test]
    fn what_is_printed_is_short_and_finite() {
        assert_eq!([0.57, 0.999, 0.95].map(percent), [57.0, 99.9, 95.0]);
        assert_eq!([f64::INFINITY, f64::NAN].map(displacement), ["lost"; 2]);
        assert_eq!([2.5e57, 1.83e-11, 0.0994].map(displacement), ["2.50e57", "0.000", "0.099"]);
        assert_eq!([-1e-9, 1.23456].map(|mm| coordinate(mm, 3)), ["0.000", "1.235"]);
    }
}
