//! The page of a study.

use super::super::answer::Answer;
use super::super::page::Page;
use super::parallel_axes::parallel_axes_figure;
use super::pareto_plot::goal_figures;
use super::shown;
use crate::num::rounding::significant;
use crate::results::{SweepReport, SweepTable};
use serde_json::Value as Json;

/// Digits of figures in the table; the rows have all.
const DIGITS: usize = 5;

impl SweepReport {
    /// `sweep.html`.
    #[must_use]
    pub fn html(&self, table: &SweepTable) -> String {
        let mut page = Page::new(self, &format!("study {}", self.study));
        page.warnings(&self.warnings);
        page.plain_facts(&self.rows());
        let parallel = parallel_axes_figure(self, table);
        page.figures(goal_figures(self, table).into_iter().chain(parallel));
        if !self.front.is_empty() {
            self.add_front(&mut page);
        }
        page.files(&self.files);
        page.finish()
    }

    /// Adds the table of the front, and the values of the best points to be pasted into the profile.
    fn add_front(&self, page: &mut Page) {
        page.heading("Points that no other beats in every goal");
        let axes = self.axes.iter().map(|axis| &*axis.label);
        let labels = axes.chain(self.columns.iter().map(|column| &*column.label));
        let labels: Vec<String> =
            ["point"].into_iter().chain(labels).map(super::super::page::escaped).collect();
        let names: Vec<&str> = labels.iter().map(String::as_str).collect();
        let rows = self.front.iter().map(|found| {
            let axes = found.axes.iter().map(shown);
            let columns = found.columns.iter().map(figure);
            [found.point.to_string()].into_iter().chain(axes).chain(columns).collect()
        });
        page.numbers(&names, rows);
        page.heading("Values to paste");
        page.paragraph(
            "The keys as they stand in a profile. The command of this study with --show and a point's number prints the whole profile.",
        );
        for column in &self.columns {
            let Some(best) = &column.best else { continue };
            page.paragraph(&format!("Point {}, the best in {}:", best.point, column.label));
            page.code(&self.settings(&best.axes));
        }
    }
}

/// A figure in a few digits.
fn figure(value: &Json) -> String {
    match value {
        Json::Number(number) if number.is_f64() => {
            number.as_f64().map_or(String::new(), |x| significant(x, DIGITS).to_string())
        }
        Json::Null => String::new(),
        value => shown(value),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::study;

    #[test]
    fn the_page_has_the_front_and_the_values_to_paste() {
        let (report, table) = study();
        let page = report.html(&table);
        assert!(page.contains("part.width_mm = 2.5\npart.form = [1, 2]"), "{page}");
        assert!(page.contains("part.width_mm = 1\npart.form = &quot;a, \\&quot;b\\&quot;&quot;"));
        assert_eq!(page.matches("<figure>").count(), 2);
        assert!(page.contains("<h1>base: study trade</h1>"));
    }
}
