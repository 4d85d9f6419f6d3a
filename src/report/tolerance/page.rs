//! `tolerance.html`: a study of tolerances as one page that needs nothing beside it.

use super::plots::figures;
use super::words::{
    FORM_RMS, SYSTEMATIC, SourceCells, criterion, or_dash, reference, statistics, unmet,
};
use crate::profile::Profile;
use crate::report::answer::{Answer, AnswerRows};
use crate::report::page::{Page, escaped};
use crate::results::{ToleranceReport, displacement, percent};
use crate::tolerance::{AdjustmentFacts, FormMeasure, PlotData, SourceFacts, Statistics};

impl ToleranceReport {
    /// `tolerance.html`.
    #[must_use]
    pub fn html(&self, profile: &Profile, data: &PlotData) -> String {
        let mut page = Page::new(self, "tolerances");
        self.add_yield(&mut page);
        for reason in self.head().reasons {
            page.raw(&format!("<p class=\"fail\">{}</p>", escaped(&reason)));
        }
        page.figures(figures(&self.study, data));
        page.facts(&self.page_rows());
        self.add_sensitivities(&mut page);
        self.add_limits(&mut page);
        self.add_statistics(&mut page);
        self.add_adjustments(&mut page);
        self.add_machining(&mut page);
        page.links("tolerance.html", profile);
        page.finish()
    }

    fn add_yield(&self, page: &mut Page) {
        let study = &self.study;
        let [share, low, high] =
            [study.yields.share, study.yields.low, study.yields.high].map(|x| 100.0 * x);
        page.paragraph(&format!(
            "{share:.2} % of {} made systems (95 % interval {low:.2} to {high:.2} %) keep a displacement of {} \
             px ({}) from {}; {} % are asked.",
            study.trials,
            study.budget_px,
            criterion(study.criterion),
            reference(study.reference),
            percent(study.target_yield)
        ));
        if study.lost_trials > 0 {
            page.paragraph(&format!(
                "{} of them lose rays that do not meet the mirror, and do not keep it.",
                study.lost_trials
            ));
        }
    }

    fn add_sensitivities(&self, page: &mut Page) {
        page.raw("<h2 class=\"next\">Sensitivities, each source alone at its limits, px</h2>");
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
            let cells = SourceCells::new(s);
            let [a, b, c, d] = cells.displacements;
            let kind = cells.distribution.to_owned();
            vec![s.source.clone(), cells.limit, kind, a, b, c, d, cells.blur, cells.share]
        };
        page.numbers(&names, self.study.sources.iter().map(row));
        if self.study.sources.iter().any(|source| source.systematic) {
            page.paragraph(SYSTEMATIC);
        }
    }

    fn add_limits(&self, page: &mut Page) {
        page.raw(&format!("<h2>Limits for a budget of {} px</h2>", self.study.budget_px));
        let names = ["source", "unit", "limit", "weight", "alone", "in concert"];
        let row = |s: &SourceFacts| {
            let SourceCells { limit, alone, joint, .. } = SourceCells::new(s);
            vec![s.source.clone(), s.unit.into(), limit, s.weight.to_string(), alone, joint]
        };
        page.numbers(&names, self.study.sources.iter().map(row));
        if self.study.form == FormMeasure::Rms {
            page.paragraph(FORM_RMS);
        }
        if let Some(why) = self.study.no_limit_joint {
            page.paragraph(&format!("No limits in concert meet the budget: {}.", unmet(why)));
        }
        page.paragraph(
            "Alone: the limit at which the source uses up the budget by itself. In concert: all at these \
             limits reach the yield that is asked; * is four times the limit, and none is made wider.",
        );
    }

    fn add_statistics(&self, page: &mut Page) {
        let study = &self.study;
        let figure = criterion(study.criterion);
        page.raw(&format!("<h2>Monte Carlo: {figure} displacement, px</h2>"));
        let named = statistics(&study.adjusted);
        let names: Vec<&str> = [""].into_iter().chain(named.iter().map(|n| n.0)).collect();
        let rows = [
            ("as made", &study.as_made),
            ("adjusted", &study.adjusted),
            ("adjusted, first derivatives", &study.linear),
        ];
        let row = |(name, s): (&str, &Statistics)| {
            let figures = statistics(s).map(|(_, x)| x);
            [name.to_owned()].into_iter().chain(figures).collect()
        };
        page.numbers(&names, rows.map(row));
    }

    fn add_adjustments(&self, page: &mut Page) {
        if self.study.adjustments.is_empty() {
            return;
        }
        page.heading("Adjustments");
        let names = ["adjustment", "unit", "sigma", "95 % within", "farthest"];
        let row = |a: &AdjustmentFacts| {
            let [p95, far] = [a.p95, a.farthest].map(displacement);
            vec![a.name.to_owned(), a.unit.to_owned(), or_dash(a.sigma), p95, far]
        };
        page.numbers(&names, self.study.adjustments.iter().map(row));
    }

    fn add_machining(&self, page: &mut Page) {
        let Some(machining) = &self.machining else { return };
        page.heading("Machining, unpolished");
        let mut rows: AnswerRows = machining.rows();
        machining.reasons.iter().for_each(|reason| rows.page("", reason.to_string()));
        page.facts(&rows);
    }
}
