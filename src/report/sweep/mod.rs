//! Studies, in words, as tables and as a page.

mod page;
mod parallel_axes;
mod pareto_plot;
mod rows;

use super::answer::{Answer, AnswerRows, Head, ToRows};
use super::plot::Axis;
use crate::profile::ColumnGoal;
use crate::results::{AxisFacts, ColumnFacts, PointFacts, PointFailures, SweepReport, digits};
use serde_json::Value as Json;

impl Answer for SweepReport {
    fn head(&self) -> Head<'_> {
        Head::of(&self.profile).with_warnings(&self.warnings)
    }

    fn rows(&self) -> AnswerRows {
        let mut rows = AnswerRows::default();
        let Self { points, made, invalid, refused, .. } = self;
        rows.add("study", format!("{}, whose points each run {}", self.study, self.command.name()));
        let failed = match points - made {
            0 => String::new(),
            _ => format!("; {invalid} with a profile that is not valid, {refused} refused"),
        };
        rows.add("points", format!("{made} of {points} have figures{failed}"));
        for (k, failure) in self.failures.iter().enumerate() {
            let add = |rows: &mut AnswerRows| rows.add("failed", reason(failure));
            if k == 0 { add(&mut rows) } else { rows.details(add) }
        }
        for column in &self.columns {
            rows.add(if column.goal.is_some() { "best" } else { "range" }, self.found(column));
        }
        if self.front_points > 0 {
            let points = self.front_points;
            let listed = match self.front.len() {
                listed if listed < points => {
                    format!("; {listed} of them, spread over all, are listed")
                }
                _ => String::new(),
            };
            rows.add("front", format!("{points} points that no other beats in every goal{listed}"));
        }
        self.files.add_to(&mut rows);
        if let Some(point) =
            self.columns.iter().find_map(|column| Some(column.best.as_ref()?.point))
        {
            rows.terminal(
                "next",
                format!("the same command with --show {point} prints the profile of that point, to be built"),
            );
        }
        rows
    }
}

impl SweepReport {
    /// What was found of a column, in a sentence.
    fn found(&self, column: &ColumnFacts) -> String {
        let ColumnFacts { label, goal, known, range, best, .. } = column;
        let Some([least, most]) = range.map(|ends| ends.map(digits)) else {
            return format!("{label}: {known} points have a value");
        };
        let (Some(goal), Some(best)) = (goal, best) else {
            return format!("{label}: {least} to {most}");
        };
        let [value, worst] = match goal {
            ColumnGoal::Least => [least, most],
            ColumnGoal::Most => [most, least],
        };
        let PointFacts { point, axes, .. } = best;
        let at = self.settings(axes).join(", ");
        format!("{label}: {value} at point {point} ({at}); the worst is {worst}")
    }

    /// Keys of the axes with these values, as they stand in a profile.
    fn settings(&self, values: &[Json]) -> Vec<String> {
        let setting =
            |(axis, value): (&AxisFacts, &Json)| format!("{} = {}", axis.key, shown(value));
        self.axes.iter().zip(values).map(setting).collect()
    }
}

/// A value as it stands in a profile.
fn shown(value: &Json) -> String {
    match value {
        Json::Array(entries) => {
            let entries: Vec<String> = entries.iter().map(shown).collect();
            format!("[{}]", entries.join(", "))
        }
        value => value.to_string(),
    }
}

/// The axis of a plot over numbers: logarithmic where that is asked for, or where they are positive and of very
/// different sizes.
fn scale_axis(numbers: &[f64], label: &str, is_logarithmic: bool) -> Axis {
    /// Largest number over the least from which on a linear axis would show the largest alone.
    const WIDE: f64 = 100.0;
    let ends = numbers.iter().map(|x| [*x, *x]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]);
    let [least, most] = ends.unwrap_or([0.0, 1.0]);
    match least > 0.0 && (is_logarithmic || most > WIDE * least) {
        true => Axis::logarithmic(numbers.iter().copied(), label),
        false => Axis::around([least, most], label),
    }
}

/// Why points have no figures.
fn reason(failure: &PointFailures) -> String {
    let PointFailures { points, first, status, error } = failure;
    format!("{points} {} like point {first}: {error}", status.word())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::profile::SweepCommand;
    use crate::results::{PointOutcome, PointStatus, ProfileId, SCHEMA, SweepRow, SweepTable};
    use serde_json::json;

    /// A study of two axes and two goals, one of whose points has failed.
    pub(in crate::report::sweep) fn study() -> (SweepReport, SweepTable) {
        let axis = |key: &str| AxisFacts {
            key: key.into(),
            label: key.into(),
            values: 2,
            range: None,
            is_logarithmic: false,
            paired_with: None,
            goal: None,
        };
        let row = |axes: [Json; 2], values: [f64; 2], is_on_front| SweepRow {
            axes: axes.into(),
            outcome: PointOutcome {
                status: PointStatus::Made,
                error: None,
                values: values.map(Json::from).into(),
            },
            is_on_front,
        };
        let mut rows = vec![
            row([json!(1), json!("a, \"b\"")], [0.5, 2.0], true),
            row([json!(1), json!("=1+1")], [1.0, 3.0], false),
            row([json!(2.5), json!([1, 2])], [1.5, 1.0], true),
            row([json!(2.5), json!(true)], [0.0, 0.0], false),
        ];
        rows[3].outcome = PointOutcome {
            status: PointStatus::Refused,
            error: Some("too wide, by 3".into()),
            values: vec![],
        };
        let point = |point: usize| PointFacts {
            point,
            axes: rows[point].axes.clone(),
            columns: rows[point].outcome.values.clone(),
        };
        let column = |key: &str, range, best: usize| ColumnFacts {
            key: key.into(),
            label: key.into(),
            goal: Some(ColumnGoal::Least),
            known: 3,
            range: Some(range),
            best: Some(point(best)),
        };
        let columns = vec![column("error_px", [0.5, 1.5], 0), column("depth_mm", [1.0, 3.0], 2)];
        let report = SweepReport {
            schema: SCHEMA,
            study: "trade".into(),
            profile: ProfileId {
                name: "base".into(),
                sha256: "0123456789".into(),
                files: Vec::new(),
            },
            command: SweepCommand::Design,
            points: 4,
            made: 3,
            invalid: 0,
            refused: 1,
            axes: vec![axis("part.width_mm"), axis("part.form")],
            columns,
            front_points: 2,
            front: vec![point(0), point(2)],
            failures: vec![PointFailures {
                points: 1,
                first: 3,
                status: PointStatus::Refused,
                error: "too wide, by 3".into(),
            }],
            files: vec![],
            warnings: vec![],
        };
        let [axes, columns] = [["part.width_mm", "part.form"], ["error_px", "depth_mm"]]
            .map(|keys| keys.map(String::from).into());
        (report, SweepTable { axes, columns, rows })
    }

    #[test]
    fn the_summary_has_the_best_points_and_why_others_failed() {
        let text = study().0.text();
        for row in [
            "  points   3 of 4 have figures; 0 with a profile that is not valid, 1 refused\n",
            "  failed   1 refused like point 3: too wide, by 3\n",
            "  best     error_px: 0.500 at point 0 (part.width_mm = 1, part.form = \"a, \\\"b\\\"\"); the worst is 1.500\n",
            "  best     depth_mm: 1.000 at point 2 (part.width_mm = 2.5, part.form = [1, 2]); the worst is 3.000\n",
            "  front    2 points that no other beats in every goal\n",
            "--show 0 prints the profile",
        ] {
            assert!(text.contains(row), "{row}: {text}");
        }
    }
}
