//! Monte Carlo trials against the width of the yield's interval.

use super::{BenchError, BenchSweep, BenchTime, Subject, convergence_order, run, timed};
use crate::pipeline::{PreparedStudy, Run, Silent, prepared};
use crate::tolerance::{Yield, quantile};
use std::convert::Infallible;

const TRIALS: [u64; 5] = [100, 300, 1000, 3000, 10_000];
const SEED: u64 = 1;

/// More and more trials, traced in full. The error is the width of the 95 % interval of the yield, at the
/// budget that half of the parts keep: it falls as the root of their number.
pub(super) fn sweep(subjects: &[Subject], quick: bool) -> Result<BenchSweep, BenchError> {
    let numbers = if quick { &TRIALS[..3] } else { &TRIALS };
    let mut runs = Vec::new();
    for subject in subjects.iter().filter(|subject| subject.design.view.is_some()) {
        let in_memory = Run::in_memory(&subject.profile, &Silent);
        let PreparedStudy { engine, .. } = prepared(&in_memory)?;
        let sources = &engine.spec.sources;
        let most = numbers.last().copied().unwrap_or_default();
        let all = engine.trials(sources, SEED, 0..most, None);
        let figures = engine.figures(&all);
        let mut sorted = figures.clone();
        sorted.sort_by(f64::total_cmp);
        let median_px = quantile(&sorted, 0.5);
        for &number in numbers {
            let make = || Ok::<_, Infallible>(engine.trials(sources, SEED, 0..number, None));
            let Ok((time_ms, _)) = timed(true, make);
            // The first trials are the same in every run.
            let good = figures.iter().take(number as usize).filter(|px| **px <= median_px).count();
            let found = Yield::of(good as u64, number);
            let number = number as f64;
            let pixels = engine.samples() as f64;
            let more = [
                ("yield", found.share),
                ("sources", sources.len() as f64),
                ("pixels", pixels),
                ("us_per_pixel", 1e3 * time_ms / (pixels * number)),
            ];
            let at = (subject.name(), "");
            runs.push(run(at, number, time_ms, found.width(), more.into()));
        }
    }
    let orders = [
        convergence_order(&runs, "error ~ trials", -0.5, |run| (run.setting, run.error)),
        convergence_order(&runs, "time ~ trials", 1.0, |run| (run.setting, run.time_ms)),
        convergence_order(&runs, "error ~ time", -0.5, |run| (run.time_ms, run.error)),
    ];
    Ok(BenchSweep {
        name: "trials",
        about: "Trials of the Monte Carlo",
        time: BenchTime::Run,
        setting: "trials",
        error: "interval_width",
        error_axis: "width of the yield's 95 % interval",
        runs,
        orders: orders.into_iter().flatten().collect(),
    })
}
