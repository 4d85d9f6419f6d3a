//! A study of tolerances in words.

use super::words::{
    FORM_RMS, SYSTEMATIC, SourceCells, criterion, gap_percent, or_dash, reference, statistics,
    unmet,
};
use crate::report::answer::{Answer, AnswerRows, Head};
use crate::results::{ToleranceReport, digits, displacement, percent};
use crate::tolerance::{FormMeasure, Offender, Statistics, Study};

impl Answer for ToleranceReport {
    fn head(&self) -> Head<'_> {
        Head::judged(&self.profile, self.verdict, &self.reasons)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        self.add_question(&mut rows);
        self.add_yield_share(&mut rows);
        self.add_blur(&mut rows);
        self.add_offenders(&mut rows);
        self.add_sources(&mut rows);
        if let Some(why) = self.study.no_limit_joint {
            let why = unmet(why);
            rows.terminal("limits", format!("no limits in concert meet the budget: {why}"));
        }
        rows.details(|rows| {
            self.add_nominal(rows);
            self.add_facets(rows);
            self.add_actions(rows);
            self.add_linear(rows);
            self.add_trials(rows);
            if let Some(machining) = &self.machining {
                rows.remark("machining, unpolished:");
                rows.append(machining.rows());
                machining.reasons.iter().for_each(|reason| rows.remark(format!("- {reason}")));
            }
        });
        rows
    }
}

impl ToleranceReport {
    /// Its facts in the order of the page.
    pub fn page_rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        rows.page("profile sha256", &self.profile.sha256);
        self.add_question(&mut rows);
        self.add_nominal(&mut rows);
        self.add_linear(&mut rows);
        self.add_offenders(&mut rows);
        self.add_blur(&mut rows);
        self.add_facets(&mut rows);
        rows
    }

    /// What was asked, and the trials that answer it.
    fn add_question(&self, rows: &mut AnswerRows) {
        let Study { budget_px, samples, first, seed, .. } = self.study;
        let (criterion, reference) =
            (criterion(self.study.criterion), reference(self.study.reference));
        let [share, picture] = [self.study.target_yield, self.study.picture_share].map(percent);
        rows.terminal(
            "asked",
            format!(
                "{criterion} displacement from {reference} within {budget_px} px for {share} % of the parts"
            ),
        );
        let last = first + self.study.trials - 1;
        let seeded = format!("{first} to {last} of seed {seed}");
        rows.terminal(
            "made",
            format!("{samples} samples of {picture} % of the picture; trials {seeded}"),
        );
        rows.page(
            "trials",
            format!("{seeded}, traced in full at {samples} samples of {picture} % of the picture"),
        );
    }

    fn add_nominal(&self, rows: &mut AnswerRows) {
        let [rms, p95] = [self.study.nominal.rms_px, self.study.nominal.p95_px].map(digits);
        rows.terminal("nominal", format!("{rms} rms, {p95} p95 px from the projection"));
        rows.page("nominal", format!("{rms} rms, {p95} p95 px of the design from the projection"));
    }

    fn add_facets(&self, rows: &mut AnswerRows) {
        if let Some(from) = self.facets_from {
            rows.add("facets", from.words());
        }
    }

    /// The terminal's table of the limits, and its remarks.
    fn add_sources(&self, rows: &mut AnswerRows) {
        let line = |name: &str, [limit, minus, plus, share, joint]: [&str; 5]| {
            format!("  {name:20} {limit:>10} {minus:>9} {plus:>9} {share:>8} {joint:>13}")
        };
        let sources = &self.study.sources;
        rows.line(line("", ["", "adjusted", "px", "", "limit"]));
        rows.line(line("source", ["limit", "-", "+", "share %", "in concert"]));
        for source in sources {
            let SourceCells { limit, displacements: [.., minus, plus], share, joint, .. } =
                &SourceCells::new(source);
            rows.line(line(&source.source, [limit, minus, plus, share, joint]));
        }
        if self.study.form == FormMeasure::Rms {
            rows.remark(FORM_RMS);
        }
        if sources.iter().any(|source| source.systematic) {
            rows.remark(SYSTEMATIC);
        }
        if sources.iter().any(|source| source.limit_joint_widest) {
            rows.remark("* four times the limit, and wider than that it is not made");
        }
    }

    /// The terminal's table of what each source does at its limits.
    fn add_actions(&self, rows: &mut AnswerRows) {
        let line = |name: &str, [kind, minus, plus, blur, alone]: [&str; 5]| {
            format!("  {name:20} {kind:>10} {minus:>9} {plus:>9} {blur:>8} {alone:>13}")
        };
        rows.line(line("", ["", "made", "px", "blur", "limit"]));
        rows.line(line("source", ["", "-", "+", "px", "alone"]));
        for source in &self.study.sources {
            let SourceCells { distribution, displacements: [minus, plus, ..], blur, alone, .. } =
                &SourceCells::new(source);
            rows.line(line(&source.source, [distribution, minus, plus, blur, alone]));
        }
    }

    fn add_offenders(&self, rows: &mut AnswerRows) {
        const MOST: usize = 5;
        let one = |o: &Offender| {
            format!("{} at {}: {} px", o.source, o.value, displacement(o.adjusted_px))
        };
        let all: Vec<String> = self.worst_offenders.iter().take(MOST).map(one).collect();
        rows.named("worst", "worst offenders", all.join(", "));
    }

    /// First derivatives against the trials.
    fn add_linear(&self, rows: &mut AnswerRows) {
        let Study { rss_px, mean_px, rms_px, linear, gap, .. } = &self.study;
        let [rss, common, rms, off] = [*rss_px, *mean_px, *rms_px, gap.rms_px].map(displacement);
        let [mean, p95] = [linear.mean_px, linear.p95_px].map(displacement);
        let (sigma, share) = (or_dash(linear.sigma_px), gap_percent(&self.study));
        rows.terminal(
            "linear",
            format!(
                "RSS {rss} px ({common} px in every part), the trials' {rms} px; predicted {mean} +- {sigma} \
                 px, {p95} px at P95; trial by trial {off} px off ({share} %)"
            ),
        );
        rows.page(
            "root sum of squares",
            format!(
                "{rss} px by first derivatives, {common} px of it in every part; {rms} px in the trials (all \
                 RMS)"
            ),
        );
        let trials = gap.trials;
        rows.page(
            "linear model",
            format!(
                "trial by trial {off} px off the full trace, {share} % of its mean, over {trials} trials"
            ),
        );
    }

    fn add_trials(&self, rows: &mut AnswerRows) {
        let Study { as_made, adjusted, adjustments, .. } = &self.study;
        let figures =
            |s: &Statistics| statistics(s).map(|(name, x)| format!("{name} {x}")).join(", ");
        rows.terminal("as made", format!("{} px", figures(as_made)));
        rows.terminal("adjusted", format!("{} px", figures(adjusted)));
        for adjustment in adjustments {
            let (name, unit) = (adjustment.name, adjustment.unit);
            let sigma = or_dash(adjustment.sigma);
            let [p95, far] = [adjustment.p95, adjustment.farthest].map(displacement);
            rows.terminal(
                "",
                format!(
                    "by {name:13} sigma {sigma} {unit}, 95 % within {p95}, farthest {far} {unit}"
                ),
            );
        }
    }

    fn add_yield_share(&self, rows: &mut AnswerRows) {
        let Study { yields, lost_trials, trials, .. } = &self.study;
        if *lost_trials > 0 {
            rows.terminal(
                "lost",
                format!(
                    "{lost_trials} of {trials} trials lose rays that do not meet the mirror; they do not keep \
                     the budget"
                ),
            );
        }
        let [share, low, high] = [yields.share, yields.low, yields.high].map(|x| 100.0 * x);
        let budget = self.study.budget_px;
        rows.terminal(
            "yield",
            format!("{share:.2} % within {budget} px (95 % interval {low:.2} to {high:.2} %)"),
        );
    }

    /// What textures do within a pixel.
    fn add_blur(&self, rows: &mut AnswerRows) {
        let Study { blur_px, budget_blur_px, scattered, .. } = &self.study;
        let [blur, haze] = [*blur_px, 100.0 * scattered].map(digits);
        rows.add(
            "blur",
            format!(
                "{blur} px rms within each pixel by textures, of {budget_blur_px} px allowed; they turn or \
                 scatter {haze} % of the light"
            ),
        );
    }
}
