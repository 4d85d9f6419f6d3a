//! Rounding to figures that people read: few significant digits, and the 1-2-5 series of scales.

/// `x` rounded to so many significant decimal digits.
#[must_use]
pub fn significant(x: f64, digits: usize) -> f64 {
    let decimals = digits.saturating_sub(1);
    format!("{x:.decimals$e}").parse().unwrap_or(x)
}

/// A number of two digits that is not less than the positive `x`, and hardly more than 10 % more.
#[must_use]
pub fn two_digits_above(x: f64) -> f64 {
    let nearest = significant(x, 2);
    if nearest >= x { nearest } else { significant(1.05 * x, 2) }
}

/// A number of two digits that is not greater than the positive `x`, and hardly more than 10 % less.
#[must_use]
pub fn two_digits_below(x: f64) -> f64 {
    let nearest = significant(x, 2);
    if nearest <= x { nearest } else { significant(0.95 * x, 2) }
}

/// The least number of two digits that is not less than the positive `x`.
#[must_use]
pub fn ceil_two_digits(x: f64) -> f64 {
    let mut unit = 1.0;
    while x / unit >= 100.0 {
        unit *= 10.0;
    }
    while x / unit < 10.0 && unit > 1e-12 {
        unit /= 10.0;
    }
    // Tenths are shown as decimals.
    let digits = (x / unit).ceil();
    if unit < 1.0 { digits / (1.0 / unit).round() } else { digits * unit }
}

/// `x` rounded down to at least four digits, three of them decimals: a limit that must not be passed.
#[must_use]
pub fn floor_four_digits(x: f64) -> f64 {
    let mut decimals = 3;
    while decimals < 9 && x * f64::from(10u32.saturating_pow(decimals)) < 1e3 {
        decimals += 1;
    }
    let unit = f64::from(10u32.saturating_pow(decimals));
    (x * unit).floor() / unit
}

/// The least of 1, 2 and 5 times a power of ten that is not less than `x`; beyond 1e-6 to 5e5 `x` itself.
#[must_use]
pub fn ceil_125(x: f64) -> f64 {
    series_125().find(|round| *round >= x).unwrap_or(x)
}

/// The largest of 1, 2 and 5 times a power of ten that is not more than `x`; beyond 1e-6 to 5e5 `x` itself.
#[must_use]
pub fn floor_125(x: f64) -> f64 {
    series_125().rev().find(|round| *round <= x).unwrap_or(x)
}

fn series_125() -> impl DoubleEndedIterator<Item = f64> {
    let round = |k: i32| format!("{}e{}", [1, 2, 5][k.rem_euclid(3) as usize], k.div_euclid(3));
    (-18..18).filter_map(move |k| round(k).parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_digits_are_kept() {
        let found =
            [(0.123_456, 2), (-99.96, 3), (1e-9, 1), (0.0, 4)].map(|(x, n)| significant(x, n));
        assert_eq!(found, [0.12, -100.0, 1e-9, 0.0]);
    }

    #[test]
    fn two_digits_are_kept_upwards() {
        for k in 1..2000 {
            let x = 0.0123 * f64::from(k);
            let up = two_digits_above(x);
            assert!((1.0..=1.1).contains(&(up / x)) && up.to_string().len() <= 5, "{x}: {up}");
        }
        assert_eq!([1.0, 1.01].map(two_digits_above), [1.0, 1.1]);
    }

    #[test]
    fn two_digits_are_kept_downwards() {
        for (x, exact) in [(1.0, 1.0), (0.996, 0.95), (0.1049, 0.1), (0.1051, 0.1), (37.4, 37.0)] {
            assert_eq!(two_digits_below(x), exact, "{x}");
        }
        let mut x = 1e-5;
        while x < 1e5 {
            x *= 1.037;
            assert!(two_digits_below(x) <= x && two_digits_below(x) >= 0.89 * x, "{x}");
        }
        for k in 1..2000 {
            let many = 1e5 + 1234.0 * f64::from(k);
            let down = two_digits_below(many);
            assert!((0.9..=1.0).contains(&(down / many)), "{many}: {down}");
        }
        assert_eq!(two_digits_below(930_000.0), 930_000.0);
    }

    #[test]
    fn two_digits_are_never_less() {
        for (x, up) in [(0.0123, 0.013), (0.05, 0.05), (1.01, 1.1), (123.0, 130.0), (99.5, 100.0)] {
            assert_eq!(ceil_two_digits(x), up);
        }
    }

    #[test]
    fn limits_are_rounded_down() {
        for (limit, text) in [(0.123_59, "0.1235"), (12.3459, "12.345"), (0.001_239_9, "0.001239")]
        {
            assert_eq!(floor_four_digits(limit).to_string(), text);
        }
    }

    #[test]
    fn scales_end_at_round_numbers() {
        for (x, exact) in
            [(0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (4.0, 5.0), (60.0, 100.0), (3e-4, 5e-4)]
        {
            assert_eq!(ceil_125(x), exact, "{x}");
        }
        for (x, exact) in [(12.0, 10.0), (3.1, 2.0), (0.099, 0.05), (5.0, 5.0)] {
            assert_eq!(floor_125(x), exact, "{x}");
        }
    }
}
