//! A study of tolerances as JSON, as text and, trial by trial, as CSV.

use super::text::{digits, head_line, pretty, verdict_lines, written};
use super::{Machining, ProfileId, SCHEMA, Verdict};
use crate::tolerance::{
    Criterion, Distribution, Measure, Offender, Reference, SourceFacts, Statistics, Study, Trial,
};
use serde::Serialize;
use std::fmt::Write;

/// `tolerance.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToleranceReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Which profile.
    pub profile: ProfileId,
    /// The answers.
    #[serde(flatten)]
    pub study: Study,
    /// The errors that do most alone after adjustment.
    pub worst_offenders: Vec<Offender>,
    /// What the ball cutter makes of the mirror as designed, where tool tracks are a source. Its own
    /// reasons do not count here: the tracks do, in the trials.
    pub machining: Option<Machining>,
    /// Pass or fail.
    pub verdict: Verdict,
    /// Why it fails; empty for a pass.
    pub reasons: Vec<String>,
}

impl ToleranceReport {
    /// The report of `study`; it fails when the yield is below the target.
    #[must_use]
    pub fn new(
        profile: ProfileId,
        study: Study,
        worst_offenders: Vec<Offender>,
        machining: Option<Machining>,
    ) -> Self {
        let (verdict, reasons) = if study.passes {
            (Verdict::Pass, Vec::new())
        } else {
            let reason = format!(
                "{:.2} % of the parts stay within {} px, below the {} % of tolerance.target_yield",
                100.0 * study.yields.share,
                study.budget_px,
                100.0 * study.target_yield
            );
            (Verdict::Fail, vec![reason])
        };
        Self { schema: SCHEMA, profile, study, worst_offenders, machining, verdict, reasons }
    }

    /// As JSON.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// A readable summary, styled for terminals.
    #[must_use]
    pub fn text(&self) -> String {
        written(|out| self.write_text(out))
    }

    fn write_text(&self, out: &mut String) -> std::fmt::Result {
        let Self { profile, study, .. } = self;
        head_line(out, profile)?;
        let (criterion, reference) = (criterion(study.criterion), reference(study.reference));
        writeln!(
            out,
            "  asked    {criterion} displacement from {reference} within {} px for {} % of the parts",
            study.budget_px,
            100.0 * study.target_yield,
        )?;
        writeln!(
            out,
            "  made     {} pixels; trials {} to {} of seed {}",
            study.samples,
            study.first,
            study.first + study.trials - 1,
            study.seed
        )?;
        writeln!(
            out,
            "  nominal  {} rms, {} p95 px from the projection",
            digits(study.nominal.rms_px),
            digits(study.nominal.p95_px)
        )?;
        self.write_sources(out)?;
        writeln!(out, "  worst    {}", self.offenders())?;
        writeln!(
            out,
            "  linear   RSS {} px, the trials' {} px; predicted {} +- {} px, {} px at P95; trial by \
             trial {} px off ({:.1} %)",
            digits(study.rss_px),
            digits(study.rms_px),
            digits(study.linear.mean_px),
            digits(study.linear.sigma_px),
            digits(study.linear.p95_px),
            digits(study.gap.rms_px),
            100.0 * study.gap.relative
        )?;
        writeln!(out, "  as made  {} px", statistics_line(&study.as_made))?;
        writeln!(out, "  adjusted {} px", statistics_line(&study.adjusted))?;
        for adjustment in &study.adjustments {
            let (unit, figures) = (adjustment.unit, [adjustment.sigma, adjustment.p95]);
            let [sigma, p95] = figures.map(digits);
            writeln!(
                out,
                "           by {:13} sigma {sigma} {unit}, 95 % within {p95}, farthest {} {unit}",
                adjustment.name,
                digits(adjustment.farthest)
            )?;
        }
        writeln!(
            out,
            "  yield    {:.2} % within {} px (95 % interval {:.2} to {:.2} %)",
            100.0 * study.yields.share,
            study.budget_px,
            100.0 * study.yields.low,
            100.0 * study.yields.high
        )?;
        if let Some(machining) = &self.machining {
            writeln!(out, "  machining, unpolished:")?;
            machining.write_facts(out)?;
            machining.reasons.iter().try_for_each(|reason| writeln!(out, "  - {reason}"))?;
        }
        verdict_lines(out, &self.reasons, self.verdict)
    }

    /// The worst offenders, on one line.
    pub(super) fn offenders(&self) -> String {
        const MOST: usize = 5;
        let one =
            |o: &Offender| format!("{} at {}: {} px", o.source, o.value, digits(o.adjusted_px));
        let all: Vec<String> = self.worst_offenders.iter().take(MOST).map(one).collect();
        all.join(", ")
    }

    fn write_sources(&self, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "  {:19} {:>10}  {:9} {:>9} {:>9}   {:>9} {:>9}  {:>7} {:>11} {:>11}",
            "source",
            "limit",
            "",
            "made - px",
            "+ px",
            "adjust. -",
            "+ px",
            "share %",
            "limit alone",
            "in concert"
        )?;
        let limit = |limit: Option<f64>| limit.map_or("none".into(), digits);
        let mut widest = false;
        for source in &self.study.sources {
            widest |= source.limit_joint_widest;
            let mark = if source.limit_joint_widest { "*" } else { "" };
            let SourceFacts { minus_px, plus_px, minus_adjusted_px, plus_adjusted_px, .. } = source;
            let distribution = distribution(source.distribution);
            writeln!(
                out,
                "  {:19} {:>10}  {distribution:9} {:>9} {:>9}   {:>9} {:>9}  {:7.2} {:>11} {:>11}",
                source.source,
                source.limit,
                digits(*minus_px),
                digits(*plus_px),
                digits(*minus_adjusted_px),
                digits(*plus_adjusted_px),
                100.0 * source.share_of_variance,
                limit(source.limit_alone),
                limit(source.limit_joint) + mark,
            )?;
        }
        if self.study.form == Measure::Rms {
            writeln!(out, "  {FORM_RMS}")?;
        }
        if widest {
            writeln!(out, "  * four times the limit, and wider than that it is not made")?;
        }
        Ok(())
    }
}

/// Said where form errors are not from peak to valley.
pub(super) const FORM_RMS: &str = "form errors (legendre, zernike) are root mean squares";

/// Which figure counts.
pub(super) fn criterion(criterion: Criterion) -> &'static str {
    match criterion {
        Criterion::Rms => "RMS",
        Criterion::P95 => "P95",
    }
}

/// What displacements are measured from.
pub(super) fn reference(reference: Reference) -> &'static str {
    match reference {
        Reference::Design => "the picture as designed",
        Reference::Projection => "the projection",
    }
}

/// How likely errors are.
pub(super) fn distribution(distribution: Distribution) -> &'static str {
    match distribution {
        Distribution::Uniform => "uniform",
        Distribution::Normal => "normal",
        Distribution::Truncated => "truncated",
        Distribution::Fixed => "fixed",
    }
}

/// All figures with their names.
pub(super) fn statistics(s: &Statistics) -> [(&'static str, f64); 9] {
    [
        ("mean", s.mean_px),
        ("sigma", s.sigma_px),
        ("P50", s.p50_px),
        ("P80", s.p80_px),
        ("P90", s.p90_px),
        ("P95", s.p95_px),
        ("P98", s.p98_px),
        ("P99", s.p99_px),
        ("worst", s.worst_px),
    ]
}

fn statistics_line(s: &Statistics) -> String {
    statistics(s).map(|(name, x)| format!("{name} {}", digits(x))).join(", ")
}

/// The figures of trials that every line of their table begins with.
const FIGURES: [&str; 5] = ["trial", "rms_px", "p95_px", "adjusted_rms_px", "adjusted_p95_px"];

/// What the columns of a table of trials are called: figures, adjustments and sources.
#[must_use]
pub fn trial_columns(adjustments: &[String], sources: &[String]) -> String {
    let all: Vec<&str> =
        FIGURES.into_iter().chain(adjustments.iter().chain(sources).map(String::as_str)).collect();
    all.join(",")
}

/// A line of it; every number with the digits that give the same one back.
pub fn trial_line(out: &mut String, trial: &Trial, draws: impl Iterator<Item = f64>) {
    let Trial { index, before, after, steps } = trial;
    let _ = write!(out, "{index}");
    let figures = [before.rms_px, before.p95_px, after.rms_px, after.p95_px];
    for figure in figures.into_iter().chain(steps.iter().copied()).chain(draws) {
        let _ = write!(out, ",{figure}");
    }
    out.push('\n');
}

/// The trial of a line, with so many adjustments; none where it is no such line.
#[must_use]
pub fn read_trial(line: &str, adjustments: usize) -> Option<Trial> {
    use crate::tolerance::Pixels;
    let mut words = line.split(',');
    let index = words.next()?.parse().ok()?;
    let figures: Option<Vec<f64>> =
        words.take(4 + adjustments).map(|word| word.parse().ok()).collect();
    let figures = figures.filter(|figures| figures.len() == 4 + adjustments)?;
    let pixels = |k: usize| Pixels { rms_px: figures[k], p95_px: figures[k + 1] };
    Some(Trial { index, before: pixels(0), after: pixels(2), steps: figures[4..].to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerance::Pixels;

    #[test]
    fn lines_give_the_same_trial_back() {
        let pixels = |x: f64| Pixels { rms_px: x, p95_px: 1.0 / x };
        let trial = Trial {
            index: 12,
            before: pixels(0.1 + 0.2),
            after: pixels(1e-17),
            steps: vec![-1.0 / 3.0, f64::INFINITY],
        };
        let mut line = String::new();
        trial_line(&mut line, &trial, [0.25].into_iter());
        assert_eq!(read_trial(line.trim_end(), 2), Some(trial));
        assert_eq!(read_trial("12,1,2,3", 0), None);
        assert_eq!(read_trial("12,1,2,3,x", 0), None);
        let columns = trial_columns(&["shift x px".into()], &["tilt_x_mrad".into()]);
        assert!(
            columns.starts_with("trial,rms_px,") && columns.ends_with("shift x px,tilt_x_mrad")
        );
    }
}
