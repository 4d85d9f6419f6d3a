//! `tolerance.html`: a study of tolerances as one page that needs nothing beside it.

use super::ToleranceReport;
use super::html::{STYLE, escaped, head};
use super::plot::Failure;
use super::text::digits;
use super::tolerance::{
    FORM_RMS, SYSTEMATIC, blur, criterion, distribution, gap_percent, or_dash, percent, px,
    reference, share, statistics, unmet_words,
};
use super::tolerance_plots::plots;
use crate::tolerance::{FormMeasure, PlotData, SourceFacts};
use std::fmt::Write;

/// Beside [`STYLE`]: numbers to the right, two plots side by side, pages of A4.
const MORE: &str = "body{max-width:64rem}h2{font-size:1.15rem;margin:1.4rem 0 .3rem}\
table.n td,table.n thead th{text-align:right;white-space:nowrap;font-variant-numeric:tabular-nums}\
table.n th{width:auto}table.n{font-size:.87em}table.n tr>:first-child{text-align:left}\
.plots{display:grid;grid-template-columns:1fr 1fr;gap:1rem}figure{margin:0;break-inside:avoid}\
figure svg{width:100%;height:auto}figcaption{font-size:.85em}tr{break-inside:avoid}\
@page{size:A4;margin:14mm}@media print{body{max-width:none;margin:0;padding:0;font-size:10pt}\
h2{break-after:avoid}h2.next{break-before:page}table.n{font-size:7.6pt}th,td{padding:.15rem .4rem}}";

impl ToleranceReport {
    /// The page.
    ///
    /// # Errors
    /// What the drawing library reports.
    pub fn html(&self, points: &PlotData) -> Result<String, Failure> {
        let mut out = String::new();
        self.page(&mut out, points)?;
        Ok(out)
    }

    fn page(&self, out: &mut String, points: &PlotData) -> Result<(), Failure> {
        let study = &self.study;
        head(out, &self.profile.name, &format!("{STYLE}{MORE}"), self.verdict)?;
        let [share, low, high] =
            [study.yields.share, study.yields.low, study.yields.high].map(|x| 100.0 * x);
        let figure = criterion(study.criterion);
        writeln!(
            out,
            "<p>{share:.2} % of {} made systems (95 % interval {low:.2} to {high:.2} %) keep a \
             displacement of {} px ({figure}) from {}; {} % are asked.</p>",
            study.trials,
            study.budget_px,
            reference(study.reference),
            percent(study.target_yield)
        )?;
        if study.lost_trials > 0 {
            writeln!(
                out,
                "<p>{} of them lose rays that do not meet the mirror, and do not keep it.</p>",
                study.lost_trials
            )?;
        }
        for reason in &self.reasons {
            writeln!(out, "<p class=\"fail\">{}</p>", escaped(reason))?;
        }
        writeln!(out, "<div class=\"plots\">")?;
        for plot in plots(study, points)? {
            let caption = escaped(&plot.caption);
            let svg = plot.svg.trim_end();
            writeln!(out, "<figure>{svg}\n<figcaption>{caption}</figcaption></figure>")?;
        }
        writeln!(out, "</div>")?;
        self.facts(out)?;
        self.sources(out)?;
        self.limits(out)?;
        self.trials(out)?;
        self.cutting(out)?;
        writeln!(out, "</html>")?;
        Ok(())
    }

    fn facts(&self, out: &mut String) -> std::fmt::Result {
        let study = &self.study;
        let rows = [
            ("profile sha256", self.profile.sha256.clone()),
            (
                "trials",
                format!(
                    "{} to {} of seed {}, traced in full at {} samples of {} % of the picture",
                    study.first,
                    study.first + study.trials - 1,
                    study.seed,
                    study.samples,
                    percent(study.picture_share)
                ),
            ),
            (
                "nominal",
                format!(
                    "{} rms, {} p95 px of the design from the projection",
                    digits(study.nominal.rms_px),
                    digits(study.nominal.p95_px)
                ),
            ),
            (
                "root sum of squares",
                format!(
                    "{} px by first derivatives, {} px of it in every part; {} px in the trials (all RMS)",
                    px(study.rss_px),
                    px(study.mean_px),
                    px(study.rms_px)
                ),
            ),
            (
                "linear model",
                format!(
                    "trial by trial {} px off the full trace, {} % of its mean, over {} trials",
                    px(study.gap.rms_px),
                    gap_percent(study),
                    study.gap.trials
                ),
            ),
            ("worst offenders", self.offenders()),
            ("blur", self.blur()),
        ];
        let facets = self.facets_from.map(|from| ("facets", from.words().to_owned()));
        writeln!(out, "<table>")?;
        for (name, value) in rows.into_iter().chain(facets) {
            writeln!(out, "<tr><th>{name}</th><td>{}</td></tr>", escaped(&value))?;
        }
        writeln!(out, "</table>")
    }

    fn sources(&self, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "<h2 class=\"next\">Sensitivities, each source alone at its limits, px</h2>"
        )?;
        let names = [
            "source",
            "limit",
            "",
            "made, &minus;",
            "made, +",
            "adjusted, &minus;",
            "adjusted, +",
            "blur",
            "share of variance, %",
        ];
        let row = |s: &SourceFacts| {
            let px = [s.minus_px, s.plus_px, s.minus_adjusted_px, s.plus_adjusted_px].map(px);
            let [a, b, c, d] = px;
            let kind = distribution(s.distribution).to_owned();
            vec![s.source.clone(), s.limit.to_string(), kind, a, b, c, d, blur(s), share(s)]
        };
        table(out, &names, self.study.sources.iter().map(row))?;
        if self.study.sources.iter().any(|source| source.systematic) {
            writeln!(out, "<p>{SYSTEMATIC}</p>")?;
        }
        Ok(())
    }

    fn limits(&self, out: &mut String) -> std::fmt::Result {
        let budget = self.study.budget_px;
        writeln!(out, "<h2>Limits for a budget of {budget} px</h2>")?;
        let names = ["source", "unit", "limit", "weight", "alone", "in concert"];
        let limit = |limit: Option<f64>| limit.map_or("none".into(), digits);
        let row = |s: &SourceFacts| {
            let mark = if s.limit_joint_widest { "*" } else { "" };
            let (alone, joint) = (limit(s.limit_alone), limit(s.limit_joint) + mark);
            let (given, weight) = (s.limit.to_string(), s.weight.to_string());
            vec![s.source.clone(), s.unit.into(), given, weight, alone, joint]
        };
        table(out, &names, self.study.sources.iter().map(row))?;
        if self.study.form == FormMeasure::Rms {
            writeln!(out, "<p>{FORM_RMS}</p>")?;
        }
        if let Some(unmet) = self.study.no_limit_joint {
            writeln!(out, "<p>No limits in concert meet the budget: {}.</p>", unmet_words(unmet))?;
        }
        writeln!(
            out,
            "<p>Alone: the limit at which the source uses up the budget by itself. In concert: all at \
             these limits reach the yield that is asked; * is four times the limit, and none is made \
             wider.</p>"
        )
    }

    fn cutting(&self, out: &mut String) -> std::fmt::Result {
        let Some(machining) = &self.machining else { return Ok(()) };
        writeln!(out, "<h2>Machining, unpolished</h2>\n<table>")?;
        for (name, value) in machining.facts() {
            writeln!(out, "<tr><th>{name}</th><td>{}</td></tr>", escaped(&value))?;
        }
        for reason in &machining.reasons {
            writeln!(out, "<tr><th></th><td>{}</td></tr>", escaped(reason))?;
        }
        writeln!(out, "</table>")
    }

    fn trials(&self, out: &mut String) -> std::fmt::Result {
        let study = &self.study;
        writeln!(out, "<h2>Monte Carlo: {} displacement, px</h2>", criterion(study.criterion))?;
        let named = statistics(&study.adjusted);
        let names: Vec<&str> = [""].into_iter().chain(named.iter().map(|n| n.0)).collect();
        let rows = [
            ("as made", &study.as_made),
            ("adjusted", &study.adjusted),
            ("adjusted, first derivatives", &study.linear),
        ];
        let row = |(name, s): (&str, _)| {
            let figures = statistics(s).map(|(_, x)| x);
            [name.to_owned()].into_iter().chain(figures).collect()
        };
        table(out, &names, rows.into_iter().map(row))?;
        if study.adjustments.is_empty() {
            return Ok(());
        }
        writeln!(out, "<h2>Adjustments</h2>")?;
        let names = ["adjustment", "unit", "sigma", "95 % within", "farthest"];
        let row = |a: &crate::tolerance::AdjustmentFacts| {
            let [p95, far] = [a.p95, a.farthest].map(px);
            vec![a.name.to_owned(), a.unit.to_owned(), or_dash(a.sigma), p95, far]
        };
        table(out, &names, study.adjustments.iter().map(row))
    }
}

/// A table of numbers; `names` may hold entities.
fn table(
    out: &mut String,
    names: &[&str],
    rows: impl Iterator<Item = Vec<String>>,
) -> std::fmt::Result {
    let names: Vec<String> = names.iter().map(|name| format!("<th>{name}</th>")).collect();
    writeln!(out, "<table class=\"n\">\n<thead><tr>{}</tr></thead>", names.concat())?;
    for row in rows {
        let cells: Vec<String> =
            row.iter().map(|cell| format!("<td>{}</td>", escaped(cell))).collect();
        writeln!(out, "<tr>{}</tr>", cells.concat())?;
    }
    writeln!(out, "</table>")
}
