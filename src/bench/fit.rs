//! What can be read off many runs.

use super::{BenchRun, ConvergenceOrder};
use crate::num::log;

/// Marks the runs that no other of the same profile beats in time and error both.
pub(super) fn mark_pareto(runs: &mut [BenchRun]) {
    let beats = |a: &BenchRun, b: &BenchRun| {
        a.profile == b.profile
            && a.time_ms <= b.time_ms
            && a.error <= b.error
            && (a.time_ms < b.time_ms || a.error < b.error)
    };
    let best: Vec<bool> =
        runs.iter().map(|run| !runs.iter().any(|other| beats(other, run))).collect();
    runs.iter_mut().zip(best).for_each(|(run, best)| run.pareto = best);
}

/// The order p of y ~ x^p within each profile's curve, fitted by least squares to all of `runs` at once,
/// each curve with a constant of its own; none without two points on one curve.
pub(super) fn convergence_order(
    runs: &[BenchRun],
    of: &'static str,
    theory: f64,
    point: impl Fn(&BenchRun) -> (f64, f64),
) -> Option<ConvergenceOrder> {
    let mut profiles: Vec<&str> = runs.iter().map(|run| &*run.profile).collect();
    profiles.dedup();
    let (mut centred, mut freedom) = (Vec::new(), 0usize);
    for profile in profiles {
        let curve = runs.iter().filter(|run| run.profile == profile);
        let logs: Vec<(f64, f64)> = curve
            .map(&point)
            .filter(|&(x, y)| x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite())
            .map(|(x, y)| (log(x), log(y)))
            .collect();
        let n = logs.len() as f64;
        let mean = |pick: fn(&(f64, f64)) -> f64| logs.iter().map(pick).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        centred.extend(logs.iter().map(|p| (p.0 - x, p.1 - y)));
        freedom += logs.len().saturating_sub(1);
    }
    let xx: f64 = centred.iter().map(|(x, _)| x * x).sum();
    let order = centred.iter().map(|(x, y)| x * y).sum::<f64>() / xx;
    let left: f64 = centred.iter().map(|(x, y)| (y - order * x) * (y - order * x)).sum();
    // One of the degrees of freedom is the order's own.
    let sigma = (left / (freedom.max(2) - 1) as f64 / xx).sqrt();
    (xx > 0.0).then_some(ConvergenceOrder { of, order, sigma, theory })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::exp;

    fn runs(curves: &[(&str, f64)], order: f64) -> Vec<BenchRun> {
        let each = |&(profile, factor): &(&str, f64)| {
            [1.0, 3.0, 10.0, 30.0].map(|x| {
                super::super::run(
                    (profile, "s"),
                    x,
                    factor * exp(order * log(x)),
                    1.0 / x,
                    [].into(),
                )
            })
        };
        curves.iter().flat_map(each).collect()
    }

    #[test]
    fn orders_are_found_within_curves_of_any_height() {
        for exact in [-2.0, -0.5, 0.0, 1.0] {
            let runs = runs(&[("a", 1.0), ("b", 1e6), ("c", 1e-4)], exact);
            let found =
                convergence_order(&runs, "", exact, |run| (run.setting, run.time_ms)).unwrap();
            assert!((found.order - exact).abs() < 1e-9 && found.sigma < 1e-7, "{found:?}");
        }
        let single = &runs(&[("a", 1.0)], 1.0)[..1];
        assert!(convergence_order(single, "", 1.0, |run| (run.setting, run.time_ms)).is_none());
        assert!(convergence_order(&[], "", 1.0, |run| (run.setting, run.time_ms)).is_none());
    }

    #[test]
    fn the_front_is_what_nothing_beats_in_both() {
        let mut all = runs(&[("a", 1.0)], 1.0);
        all.extend(runs(&[("a", 2.0)], 1.0));
        all.extend(runs(&[("b", 9.0)], 1.0));
        mark_pareto(&mut all);
        let front: Vec<bool> = all.iter().map(|run| run.pareto).collect();
        assert_eq!(front, [[true; 4], [false; 4], [true; 4]].concat());
    }
}
