//! Summaries of error samples, summed in a fixed order.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// RMS, 95th percentile and maximum of an error, in the error's own unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Summary {
    /// Root of the (weighted) mean square.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub rms: f64,
    /// The value that 95 % of the weight does not exceed.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub p95: f64,
    /// The largest sample.
    #[cfg_attr(test, schemars(with = "Option<f64>"))]
    pub max: f64,
}

impl Summary {
    /// Summary of samples of equal weight; `None` when there are none.
    #[must_use]
    pub fn of(mut samples: Vec<f64>) -> Option<Self> {
        let last = samples.len().checked_sub(1)?;
        let rms = (samples.iter().map(|e| e * e).sum::<f64>() / samples.len() as f64).sqrt();
        // In the total order a NaN is above every number: it must show.
        let max = samples.iter().copied().max_by(f64::total_cmp)?;
        let rank = ((0.95 * samples.len() as f64).ceil() as usize).saturating_sub(1).min(last);
        let p95 = *samples.select_nth_unstable_by(rank, f64::total_cmp).1;
        Some(Self { rms, p95, max })
    }

    /// Summary of (value, weight) samples; `None` when the weights sum to nothing.
    #[must_use]
    pub fn weighted(mut samples: Vec<(f64, f64)>) -> Option<Self> {
        let total: f64 = samples.iter().map(|s| s.1).sum();
        if !(total > 0.0) {
            return None;
        }
        let rms = (samples.iter().map(|(e, w)| w * e * e).sum::<f64>() / total).sqrt();
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let max = samples.last()?.0;
        let mut reached = 0.0;
        let p95 = samples
            .iter()
            .find(|(_, w)| {
                reached += w;
                reached >= 0.95 * total
            })
            .map_or(max, |s| s.0);
        Some(Self { rms, p95, max })
    }

    /// The same summary in another unit: every figure times `factor`.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self { rms: self.rms * factor, p95: self.p95 * factor, max: self.max * factor }
    }
}

/// A summary with its keys, all null when there is none: readers find the keys either way.
///
/// # Errors
/// Whatever the serializer returns.
pub fn or_null<S: Serializer>(summary: &Option<Summary>, serializer: S) -> Result<S::Ok, S::Error> {
    let nothing = Summary { rms: f64::NAN, p95: f64::NAN, max: f64::NAN };
    summary.unwrap_or(nothing).serialize(serializer)
}

/// The JSON Schema of a figure that may be absent and, where it is there, may be infinite, which JSON writes as
/// null.
#[cfg(test)]
pub fn finite_or_null(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "anyOf": [{ "type": "number" }, { "type": "null" }] })
}

/// Reads what [`or_null`] and its like wrote: nothing where a key is null.
///
/// # Errors
/// Whatever the deserializer returns.
pub fn unless_null<'de, D: Deserializer<'de>, T: DeserializeOwned>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    let value = serde_json::Value::deserialize(deserializer)?;
    Ok(serde_json::from_value(value).ok())
}

/// Samples that a [`SummaryBuilder`] keeps one by one, at the most.
const KEPT: usize = 1 << 21;
/// Bits of a sample by which more of them are counted: all but these, of sign, exponent and mantissa, are
/// cut off.
const COUNTED_BITS: u32 = 24;
/// Counters of an exponent: one for each mantissa of 12 bits.
const MANTISSAS: usize = 1 << 12;

/// Summary of samples that come one after the other and are not all kept: they may be as many as there are
/// pixels in the largest frame.
///
/// Of up to two million samples (`2^21`) it is that of [`Summary::of`] to the last bit. Of more, RMS and maximum
/// still are; the percentile is the upper end of a counter of width 2^-12, so that it is too large by a share
/// of 2^-12 = 2.4e-4 at the most, and never too small.
#[derive(Debug, Clone, Default)]
pub struct SummaryBuilder {
    count: usize,
    squares: f64,
    max: Option<f64>,
    kept: Vec<f64>,
    /// Numbers of samples by their leading bits, exponent by exponent, where there are more than are kept.
    counted: Vec<Vec<u64>>,
}

impl SummaryBuilder {
    /// Adds samples, each of which is not negative or not a number.
    pub fn extend(&mut self, samples: &[f64]) {
        self.count += samples.len();
        // In the total order a NaN is above every number: it must show.
        let mut max = self.max.unwrap_or(0.0);
        for &sample in samples {
            self.squares += sample * sample;
            max = if sample <= max { max } else { larger(sample, max) };
        }
        self.max = (self.count > 0).then_some(max);
        if self.count <= KEPT {
            self.kept.extend_from_slice(samples);
            return;
        }
        let kept = std::mem::take(&mut self.kept);
        self.tally(&kept);
        self.tally(samples);
    }

    fn tally(&mut self, samples: &[f64]) {
        let leading = |sample: &f64| (sample.to_bits() >> (64 - COUNTED_BITS)) as usize;
        let exponent = |sample: &f64| leading(sample) / MANTISSAS;
        for alike in samples.chunk_by(|a, b| exponent(a) == exponent(b)) {
            let exponent = exponent(&alike[0]);
            if self.counted.len() <= exponent {
                self.counted.resize(exponent + 1, Vec::new());
            }
            let counters = &mut self.counted[exponent];
            counters.resize(MANTISSAS, 0);
            alike.iter().for_each(|sample| counters[leading(sample) % MANTISSAS] += 1);
        }
    }

    /// The summary of all samples; `None` when there are none.
    #[must_use]
    pub fn finish(self) -> Option<Summary> {
        if self.count <= KEPT {
            return Summary::of(self.kept);
        }
        let count = self.count as f64;
        let max = self.max?;
        let rank = (0.95 * count).ceil() as u64;
        let mut reached = 0;
        let counters = self.counted.iter().enumerate().flat_map(|(exponent, counters)| {
            let first = exponent * MANTISSAS;
            counters.iter().enumerate().map(move |(k, count)| (first + k, *count))
        });
        let mut p95 = max;
        for (leading, count) in counters {
            reached += count;
            if reached >= rank {
                let cut_off = 64 - COUNTED_BITS;
                let end = f64::from_bits((leading as u64) << cut_off | ((1 << cut_off) - 1));
                p95 = if end < max { end } else { max };
                break;
            }
        }
        Some(Summary { rms: (self.squares / count).sqrt(), p95, max })
    }
}

/// The larger of two numbers of which the first is no number or not below the second.
#[cold]
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() {
        f64::NAN
    } else if b.is_nan() {
        b
    } else {
        a
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built(samples: impl Iterator<Item = f64>) -> Option<Summary> {
        let mut builder = SummaryBuilder::default();
        samples.for_each(|sample| builder.extend(&[sample]));
        builder.finish()
    }

    #[test]
    fn few_samples_one_by_one_have_the_summary_of_all_at_once() {
        let samples: Vec<f64> = (0..999).map(|k| f64::from(k * 7919 % 1000) * 0.1).collect();
        assert_eq!(built(samples.iter().copied()), Summary::of(samples));
        assert_eq!(built(std::iter::empty()), None);
    }

    #[test]
    fn of_many_samples_only_the_percentile_is_off_and_by_its_counters_width() {
        // Some nines of magnitudes, as errors of pixels have.
        let sample =
            |k: usize| crate::num::exp(20.0 * (k as f64 * 0.618_033_988_75).fract() - 15.0);
        let samples: Vec<f64> = (0..KEPT + 70_000).map(sample).collect();
        let exact = Summary::of(samples.clone()).unwrap();
        let found = built(samples.iter().copied()).unwrap();
        assert_eq!((found.rms, found.max), (exact.rms, exact.max));
        assert!(found.p95 >= exact.p95 && found.p95 <= exact.p95 * (1.0 + 1.0 / 4096.0));
        let same = built(std::iter::repeat_n(0.3, KEPT + 5)).unwrap();
        assert_eq!((same.p95, same.max), (0.3, 0.3));
        assert!(built(std::iter::repeat_n(f64::NAN, KEPT + 5)).unwrap().max.is_nan());
    }

    #[test]
    fn percentile_is_the_smallest_value_that_covers_the_share() {
        let hundred: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        let summary = Summary::of(hundred.clone()).unwrap();
        assert_eq!((summary.p95, summary.max), (95.0, 100.0));
        assert!((summary.rms - (338_350.0f64 / 100.0).sqrt()).abs() < 1e-12);
        let weighted = Summary::weighted(hundred.iter().map(|&e| (e, 2.0)).collect()).unwrap();
        assert!((weighted.rms - summary.rms).abs() < 1e-12);
        assert_eq!((weighted.p95, weighted.max), (95.0, 100.0));
    }

    #[test]
    fn a_sample_that_is_no_number_shows_in_rms_and_max() {
        let summary = Summary::of(vec![1.0, f64::NAN, 2.0]).unwrap();
        assert!(summary.rms.is_nan() && summary.max.is_nan());
        let summary = Summary::weighted(vec![(1.0, 1.0), (f64::NAN, 1.0)]).unwrap();
        assert!(summary.rms.is_nan() && summary.max.is_nan());
    }

    #[test]
    fn nothing_has_no_summary() {
        assert_eq!(Summary::of(vec![]), None);
        assert_eq!(Summary::weighted(vec![(1.0, 0.0)]), None);
    }
}
