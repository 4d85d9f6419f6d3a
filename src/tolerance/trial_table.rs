//! Tables of trials as CSV: a line a trial, with its figures, adjustments and perturbations.

use super::compensate::DisplacementPx;
use super::trials::Trial;
use std::fmt::Write;

/// The figures of trials that every line of their table begins with.
const FIGURES: [&str; 5] = ["trial", "rms_px", "p95_px", "adjusted_rms_px", "adjusted_p95_px"];

/// What the columns of a table of trials are called: figures, adjustments and sources.
#[must_use]
pub fn trial_columns(adjustments: &[String], sources: &[String]) -> String {
    let all: Vec<&str> =
        FIGURES.into_iter().chain(adjustments.iter().chain(sources).map(String::as_str)).collect();
    all.join(",")
}

/// What stands in the place of each figure and adjustment of a trial that loses rays.
const LOST: &str = "lost";

/// A line of it, with so many adjustments; every number with the digits that give the same one back.
pub fn trial_line(
    out: &mut String,
    trial: &Trial,
    adjustments: usize,
    draws: impl Iterator<Item = f64>,
) {
    let Trial { index, before, after, steps } = trial;
    let _ = write!(out, "{index}");
    if !after.kept() {
        (0..4 + adjustments).for_each(|_| out.extend([",", LOST]));
    }
    let figures = [before.rms_px, before.p95_px, after.rms_px, after.p95_px];
    let figures = figures.into_iter().filter(|_| after.kept());
    for figure in figures.chain(steps.iter().copied()).chain(draws) {
        let _ = write!(out, ",{figure}");
    }
    out.push('\n');
}

/// The trial of a line, with so many adjustments; none where it is no such line.
#[must_use]
pub fn read_trial(line: &str, adjustments: usize) -> Option<Trial> {
    let mut words = line.split(',');
    let index = words.next()?.parse().ok()?;
    if words.clone().take(4 + adjustments).eq(std::iter::repeat_n(LOST, 4 + adjustments)) {
        let (before, after) = (DisplacementPx::LOST, DisplacementPx::LOST);
        return Some(Trial { index, before, after, steps: Vec::new() });
    }
    let figures: Option<Vec<f64>> =
        words.take(4 + adjustments).map(|word| word.parse().ok()).collect();
    let figures = figures.filter(|figures| figures.len() == 4 + adjustments)?;
    let pixels = |k: usize| DisplacementPx { rms_px: figures[k], p95_px: figures[k + 1] };
    Some(Trial { index, before: pixels(0), after: pixels(2), steps: figures[4..].to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_give_the_same_trial_back() {
        let pixels = |x: f64| DisplacementPx { rms_px: x, p95_px: 1.0 / x };
        let trial = Trial {
            index: 12,
            before: pixels(0.1 + 0.2),
            after: pixels(1e-17),
            steps: vec![-1.0 / 3.0, 7.0],
        };
        let (before, after) = (DisplacementPx::LOST, DisplacementPx::LOST);
        let lost = Trial { index: 3, before, after, steps: Vec::new() };
        for trial in [trial, lost] {
            let mut line = String::new();
            trial_line(&mut line, &trial, 2, [0.25].into_iter());
            assert_eq!(line.matches(',').count(), 7);
            assert_eq!(read_trial(line.trim_end(), 2), Some(trial));
        }
        assert_eq!(read_trial("12,lost,lost,lost", 0), None);
        assert_eq!(read_trial("12,1,2,3", 0), None);
        assert_eq!(read_trial("12,1,2,3,x", 0), None);
        let columns = trial_columns(&["shift x px".into()], &["tilt_x_mrad".into()]);
        assert!(
            columns.starts_with("trial,rms_px,") && columns.ends_with("shift x px,tilt_x_mrad")
        );
    }
}
