//! Axes: the range that is shown, and round numbers along it.

use crate::num::log;

/// An axis with its ticks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    /// What it is of, in words with its unit.
    pub label: String,
    /// Values at its lower (left) and upper (right) end; the first may be the larger one.
    pub ends: [f64; 2],
    /// Values with their texts.
    pub ticks: Vec<(f64, String)>,
    /// Whether ticks have grid lines.
    pub has_grid: bool,
    is_log: bool,
}

/// Most steps between ticks: with steps of 1, 2 and 5 there are at least three ticks then.
const MOST_STEPS: usize = 8;
/// Most steps of a logarithmic axis, whose texts are long.
const MOST_LOG_STEPS: usize = 6;
/// Largest magnitude of a value: differences stay finite.
const LARGEST: f64 = 1e300;
/// Least length of a range over its magnitude: ticks have texts that differ.
const LEAST_LENGTH: f64 = 1e-9;

impl Axis {
    /// A linear axis over a range, which is widened where both ends are equal.
    pub(crate) fn linear([low, high]: [f64; 2], label: impl Into<String>) -> Self {
        let [low, high] = widened([low, high]);
        let step = tick_step((high - low) / MOST_STEPS as f64);
        let first = (low / step.value()).ceil();
        let ticks = (0..=2 * MOST_STEPS).map(|k| step.multiple(first + k as f64));
        let ticks = ticks.take_while(|tick| tick.0 <= high + 1e-9 * (high - low));
        let ticks = ticks.filter(|tick| tick.0 >= low).collect();
        Self { label: label.into(), ends: [low, high], ticks, has_grid: true, is_log: false }
    }

    /// A linear axis over the range and a twentieth of it beyond both ends.
    pub(crate) fn around([low, high]: [f64; 2], label: impl Into<String>) -> Self {
        let [low, high] = widened([low, high]);
        let room = 0.05 * (high - low);
        Self::linear([low - room, high + room], label)
    }

    /// A logarithmic axis between the powers of ten around all positive `values`.
    pub(crate) fn logarithmic(
        values: impl IntoIterator<Item = f64>,
        label: impl Into<String>,
    ) -> Self {
        let positive = values.into_iter().filter(|x| *x > 0.0 && x.is_finite());
        let ends = positive.map(|x| [x, x]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
        let [low, high] = ends.map_or([0, 0], |ends| ends.map(exponent));
        // A value at the upper power of ten lies on the edge.
        let high = match ends {
            Some([_, most]) if power(high) >= most && high > low => high,
            _ => high + 1,
        };
        let step = ((high - low) as usize).div_ceil(MOST_LOG_STEPS).max(1);
        let ticks = (low..=high).step_by(step).map(|n| (power(n), text(1, n))).collect();
        let ends = [power(low), power(high)];
        Self { label: label.into(), ends, ticks, has_grid: true, is_log: true }
    }

    /// An axis of rows with names, from above.
    pub(crate) fn of_rows(names: impl IntoIterator<Item = String>) -> Self {
        let ticks: Vec<(f64, String)> =
            names.into_iter().enumerate().map(|(k, name)| (k as f64 + 0.5, name)).collect();
        let ends = [ticks.len().max(1) as f64, 0.0];
        Self { label: String::new(), ends, ticks, has_grid: false, is_log: false }
    }

    /// Where `x` is from the lower (0) to the upper end (1); what lies beyond is at the end.
    pub(crate) fn share(&self, x: f64) -> f64 {
        let [low, high] = self.ends;
        let share = match self.is_log {
            true => log(x / low) / log(high / low),
            false => (x - low) / (high - low),
        };
        share.clamp(0.0, 1.0)
    }
}

/// A range of finite ends that differ.
fn widened(ends: [f64; 2]) -> [f64; 2] {
    let [low, high] = ends.map(|x| if x.is_finite() { x.clamp(-LARGEST, LARGEST) } else { 0.0 });
    let [low, high] = [low.min(high), low.max(high)];
    let size = low.abs().max(high.abs());
    if high - low > LEAST_LENGTH * size {
        return [low, high];
    }
    let room = if size > 1.0 / LARGEST { 0.05 * size } else { 1.0 };
    [low - room, high + room]
}

/// 1, 2 or 5 times a power of ten.
#[derive(Debug, Clone, Copy)]
struct Step {
    digit: i64,
    exponent: i32,
}

/// The least step that is not less than the positive `x`.
fn tick_step(x: f64) -> Step {
    let exponent = exponent(x);
    let steps = [1, 2, 5].map(|digit| Step { digit, exponent });
    let up = Step { digit: 1, exponent: exponent + 1 };
    steps.into_iter().find(|step| step.value() >= x).unwrap_or(up)
}

impl Step {
    fn value(self) -> f64 {
        parsed(self.digit, self.exponent)
    }

    /// The value and text of a whole multiple.
    fn multiple(self, times: f64) -> (f64, String) {
        let digits = times as i64 * self.digit;
        (parsed(digits, self.exponent), text(digits, self.exponent))
    }
}

/// `digits` times a power of ten, correctly rounded.
fn parsed(digits: i64, exponent: i32) -> f64 {
    format!("{digits}e{exponent}").parse().unwrap_or(0.0)
}

fn power(exponent: i32) -> f64 {
    parsed(1, exponent)
}

/// The exponent of the largest power of ten that is not over the positive `x`.
fn exponent(x: f64) -> i32 {
    let digits = format!("{:e}", x.clamp(1.0 / LARGEST, LARGEST));
    digits.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// `digits` times a power of ten, as it is read best.
fn text(digits: i64, exponent: i32) -> String {
    let value = parsed(digits, exponent);
    match value.abs() {
        0.0 => "0".into(),
        1e-3..1e5 => value.to_string(),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|tick| &*tick.1).collect()
    }

    #[test]
    fn ticks_are_round_numbers_in_their_range_over_a_sweep() {
        let mut size = 1e-280;
        while size < 1e280 {
            for (low, high) in [(0.0, 1.0), (-0.3, 0.7), (1.0, 1.013), (17.3, 99.9), (-5.0, -4.2)] {
                let axis = Axis::linear([low * size, high * size], "x");
                let ticks = &axis.ticks;
                assert!((3..=9).contains(&ticks.len()), "{low} {high} {size}: {ticks:?}");
                assert!(ticks.is_sorted_by(|a, b| a.0 < b.0 && a.1 != b.1), "{ticks:?}");
                for (value, text) in ticks {
                    assert!((low * size..=high * size).contains(value), "{size}: {ticks:?}");
                    assert_eq!(text.parse::<f64>().unwrap(), *value, "{text}");
                    let digits = text.split('e').next().unwrap().trim_matches(['-', '0', '.']);
                    assert!(digits.len() <= 6, "{text}");
                }
                let gaps: Vec<f64> = ticks.windows(2).map(|t| (t[1].0 - t[0].0) / size).collect();
                assert!(gaps.iter().all(|gap| (gap / gaps[0] - 1.0).abs() < 1e-6), "{gaps:?}");
                assert_eq!(axis.share(low * size), 0.0);
                assert_eq!(axis.share(high * size), 1.0);
            }
            size *= 7.3;
        }
    }

    #[test]
    fn plain_ranges_have_plain_texts() {
        assert_eq!(texts(&Axis::linear([0.0, 1.0], "")), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(
            texts(&Axis::linear([-0.1, 0.4], "")),
            ["-0.1", "0", "0.1", "0.2", "0.3", "0.4"]
        );
        assert_eq!(texts(&Axis::linear([0.0, 3e-4], ""))[1..3], ["5e-5", "1e-4"]);
    }

    #[test]
    fn extreme_ranges_have_ticks_that_differ() {
        let odd = [0.0, -0.0, 1.0, -3.7, 1e-320, 1e300, -1e308, f64::MAX, f64::NAN, f64::INFINITY];
        for low in odd {
            for high in odd {
                for axis in [Axis::linear([low, high], ""), Axis::around([low, high], "")] {
                    let [from, to] = axis.ends;
                    assert!(from.is_finite() && to.is_finite() && from < to, "{low} {high}");
                    let ticks = &axis.ticks;
                    assert!((1..=10).contains(&ticks.len()), "{low} {high}: {ticks:?}");
                    assert!(ticks.is_sorted_by(|a, b| a.0 < b.0 && a.1 != b.1), "{ticks:?}");
                    assert!(ticks.iter().all(|t| (0.0..=1.0).contains(&axis.share(t.0))));
                }
            }
        }
    }

    #[test]
    fn logarithmic_axes_run_from_power_to_power() {
        let of = |values: &[f64]| Axis::logarithmic(values.iter().copied(), "");
        assert_eq!(of(&[0.0123, 9.99]).ends, [0.01, 10.0]);
        assert_eq!(of(&[3.0, 2.0, 7.5]).ends, [1.0, 10.0]);
        assert_eq!(of(&[1.0, 100.0]).ends, [1.0, 100.0]);
        assert_eq!(of(&[10.0]).ends, [10.0, 100.0]);
        assert_eq!(of(&[0.0, -1.0, f64::NAN, f64::INFINITY]).ends, [1.0, 10.0]);
        assert_eq!(texts(&of(&[2e-3, 2e4])), ["0.001", "0.1", "10", "1000", "1e5"]);
        let wide = of(&[1e-300, 1e300]);
        assert!((2..=9).contains(&wide.ticks.len()), "{:?}", wide.ticks);
        for k in 0..=20 {
            let axis = of(&[power(k - 10), 0.99 * power(k - 9)]);
            assert!((axis.share(power(k - 10)) - 0.0).abs() < 1e-12);
            assert!((axis.share(3.0 * power(k - 10)) - 0.477_121).abs() < 1e-6);
        }
    }
}
