//! A study of tolerances as JSON, as text and, trial by trial, as CSV.

use super::text::{digits, head_line, pretty, verdict_lines, written};
use super::{Machining, ProfileId, SCHEMA, Verdict};
use crate::tolerance::{
    AllocationError, Criterion, DisplacementPx, Distribution, FormMeasure, Offender, Reference,
    SourceFacts, Statistics, Study, Trial,
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
    /// Where the limit of `facets_px` comes from, if facets are a source.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub facets_from: Option<FacetsFrom>,
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

/// Where the limit of the facets' displacement comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FacetsFrom {
    /// The profile's `tolerance.limits`.
    Limits,
    /// The profile's `mesh.facet_px`.
    Mesh,
    /// What a mesh by the profile's other limits is foreseen to keep.
    Foreseen,
}

impl FacetsFrom {
    /// In words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Limits => "facets_px as in tolerance.limits",
            Self::Mesh => "facets_px is mesh.facet_px: the part is made from the mesh",
            Self::Foreseen => {
                "facets_px is what the mesh is foreseen to keep: the part is made from it"
            }
        }
    }
}

impl ToleranceReport {
    /// The report of `study`; it fails when the yield is below the target or the blur
    /// above its budget.
    #[must_use]
    pub fn new(
        profile: ProfileId,
        study: Study,
        facets_from: Option<FacetsFrom>,
        worst_offenders: Vec<Offender>,
        machining: Option<Machining>,
    ) -> Self {
        let mut reasons = Vec::new();
        if study.yields.share < study.target_yield {
            reasons.push(format!(
                "{:.2} % of the parts stay within {} px, below the {} % of tolerance.target_yield",
                100.0 * study.yields.share,
                study.budget_px,
                percent(study.target_yield)
            ));
        }
        if study.blur_px > study.budget_blur_px {
            let most =
                study.sources.iter().max_by(|a, b| a.spread.blur_px.total_cmp(&b.spread.blur_px));
            reasons.push(format!(
                "textures blur each pixel by {} px, over the {} px of tolerance.budget_blur_px; most of it by \
                 {}",
                digits(study.blur_px),
                study.budget_blur_px,
                most.map_or("none", |source| &source.source)
            ));
        }
        let verdict = if reasons.is_empty() { Verdict::Pass } else { Verdict::Fail };
        let schema = SCHEMA;
        Self { schema, profile, study, facets_from, worst_offenders, machining, verdict, reasons }
    }

    /// As JSON.
    #[must_use]
    pub fn json(&self) -> String {
        pretty(self)
    }

    /// A readable summary.
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
            percent(study.target_yield),
        )?;
        writeln!(
            out,
            "  made     {} samples of {} % of the picture; trials {} to {} of seed {}",
            study.samples,
            percent(study.picture_share),
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
        if let Some(from) = self.facets_from {
            writeln!(out, "  facets   {}", from.words())?;
        }
        self.write_sources(out)?;
        if let Some(unmet) = study.no_limit_joint {
            writeln!(
                out,
                "  limits   no limits in concert meet the budget: {}",
                unmet_words(unmet)
            )?;
        }
        writeln!(out, "  worst    {}", self.offenders())?;
        writeln!(
            out,
            "  linear   RSS {} px ({} px in every part), the trials' {} px; predicted {} +- {} px, {} px \
             at P95; trial by trial {} px off ({} %)",
            px(study.rss_px),
            px(study.mean_px),
            px(study.rms_px),
            px(study.linear.mean_px),
            or_dash(study.linear.sigma_px),
            px(study.linear.p95_px),
            px(study.gap.rms_px),
            gap_percent(study)
        )?;
        writeln!(out, "  as made  {} px", statistics_line(&study.as_made))?;
        writeln!(out, "  adjusted {} px", statistics_line(&study.adjusted))?;
        for adjustment in &study.adjustments {
            let (unit, sigma) = (adjustment.unit, or_dash(adjustment.sigma));
            let [p95, far] = [adjustment.p95, adjustment.farthest].map(px);
            writeln!(
                out,
                "           by {:13} sigma {sigma} {unit}, 95 % within {p95}, farthest {far} {unit}",
                adjustment.name,
            )?;
        }
        if study.lost_trials > 0 {
            writeln!(
                out,
                "  lost     {} of {} trials lose rays that do not meet the mirror; they do not keep the budget",
                study.lost_trials, study.trials
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
        writeln!(out, "  blur     {}", self.blur())?;
        if let Some(machining) = &self.machining {
            writeln!(out, "  machining, unpolished:")?;
            machining.write_facts(out)?;
            machining.reasons.iter().try_for_each(|reason| writeln!(out, "  - {reason}"))?;
        }
        verdict_lines(out, &self.reasons, self.verdict)
    }

    /// What textures do within a pixel, on one line.
    pub(super) fn blur(&self) -> String {
        let Study { blur_px, budget_blur_px, scattered, .. } = &self.study;
        let blur = digits(*blur_px);
        let haze = digits(100.0 * scattered);
        format!(
            "{blur} px rms within each pixel by textures, of {budget_blur_px} px allowed; they turn or \
             scatter {haze} % of the light"
        )
    }

    /// The worst offenders, on one line.
    pub(super) fn offenders(&self) -> String {
        const MOST: usize = 5;
        let one = |o: &Offender| format!("{} at {}: {} px", o.source, o.value, px(o.adjusted_px));
        let all: Vec<String> = self.worst_offenders.iter().take(MOST).map(one).collect();
        all.join(", ")
    }

    fn write_sources(&self, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "  {:19} {:>10}  {:9} {:>9} {:>9}   {:>9} {:>9}  {:>7}  {:>7} {:>11} {:>11}",
            "source",
            "limit",
            "",
            "made - px",
            "+ px",
            "adjust. -",
            "+ px",
            "blur px",
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
                "  {:19} {:>10}  {distribution:9} {:>9} {:>9}   {:>9} {:>9}  {:>7}  {:>7} {:>11} {:>11}",
                source.source,
                source.limit,
                px(*minus_px),
                px(*plus_px),
                px(*minus_adjusted_px),
                px(*plus_adjusted_px),
                blur(source),
                share(source),
                limit(source.limit_alone),
                limit(source.limit_joint) + mark,
            )?;
        }
        if self.study.form == FormMeasure::Rms {
            writeln!(out, "  {FORM_RMS}")?;
        }
        if self.study.sources.iter().any(|source| source.systematic) {
            writeln!(out, "  {SYSTEMATIC}")?;
        }
        if widest {
            writeln!(out, "  * four times the limit, and wider than that it is not made")?;
        }
        Ok(())
    }
}

/// Said where form errors are not from peak to valley.
pub(super) const FORM_RMS: &str = "form errors (legendre, zernike) are root mean squares";

/// Said where errors are fixed.
pub(super) const SYSTEMATIC: &str = "fixed errors that are no textures are the same in every part: they \
    add with their signs, have no variance, and keep their limits in concert";

/// A share as a percentage, without the noise of its last digits.
pub(super) fn percent(share: f64) -> f64 {
    (1e8 * share).round() / 1e6
}

/// A figure of displacement.
pub(super) fn px(x: f64) -> String {
    match x {
        x if !x.is_finite() => "lost".into(),
        x if x.abs() >= 1e7 => format!("{x:.2e}"),
        x => digits(x),
    }
}

/// A figure that a single trial does not have.
pub(super) fn or_dash(x: Option<f64>) -> String {
    x.map_or("-".into(), px)
}

/// Of a texture, px.
pub(super) fn blur(source: &SourceFacts) -> String {
    match source.spread.blur_px {
        0.0 => "-".into(),
        blur => px(blur),
    }
}

/// Of the variance, in percent.
pub(super) fn share(source: &SourceFacts) -> String {
    if source.systematic { "-".into() } else { format!("{:.2}", 100.0 * source.share_of_variance) }
}

/// How far off first derivatives are, in percent.
pub(super) fn gap_percent(study: &Study) -> String {
    match 100.0 * study.gap.relative {
        x if x.is_finite() => format!("{x:.1}"),
        _ => "lost".into(),
    }
}

/// Why there are no limits in concert.
pub(super) fn unmet_words(unmet: AllocationError) -> &'static str {
    match unmet {
        AllocationError::Design => "the design alone uses it up",
        AllocationError::Systematic => "the errors that keep their limits use it up",
        AllocationError::NothingToShare => "no error that is not fixed displaces the picture",
        AllocationError::RaysLost => "rays are lost at all that were tried",
    }
}

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
pub(super) fn statistics(s: &Statistics) -> [(&'static str, String); 9] {
    [
        ("mean", px(s.mean_px)),
        ("sigma", or_dash(s.sigma_px)),
        ("P50", px(s.p50_px)),
        ("P80", px(s.p80_px)),
        ("P90", px(s.p90_px)),
        ("P95", px(s.p95_px)),
        ("P98", px(s.p98_px)),
        ("P99", px(s.p99_px)),
        ("worst", px(s.worst_px)),
    ]
}

fn statistics_line(s: &Statistics) -> String {
    statistics(s).map(|(name, x)| format!("{name} {x}")).join(", ")
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

    #[test]
    fn what_is_printed_is_short_and_finite() {
        assert_eq!([0.57, 0.999, 0.95].map(percent), [57.0, 99.9, 95.0]);
        assert_eq!([f64::INFINITY, f64::NAN].map(px), ["lost"; 2]);
        assert_eq!(px(2.5e57), "2.50e57");
        assert_eq!((or_dash(None), or_dash(Some(0.5))), ("-".into(), "0.500".into()));
    }
}
