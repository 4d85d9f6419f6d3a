//! Summaries of error samples, summed in a fixed order.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// RMS, 95th percentile and maximum of an error, in the error's own unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Root of the (weighted) mean square.
    pub rms: f64,
    /// The value that 95 % of the weight does not exceed.
    pub p95: f64,
    /// The largest sample.
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

#[cfg(test)]
mod tests {
    use super::*;

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
