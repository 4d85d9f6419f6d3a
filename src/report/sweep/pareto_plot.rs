//! Goals of a study against each other: the points, and those that no other beats.

use super::super::page::Figure;
use super::super::plot::{Anchor, Diagram, Ink, Marker, Plot, Stroke};
use super::scale_axis;
use crate::num::sort_by_number;
use crate::profile::ColumnGoal;
use crate::results::{SweepReport, SweepTable};

/// Width and height of a plot, units.
const SIZE: [f64; 2] = [440.0, 330.0];
/// Most points of a plot: each is an element of the page.
const MOST_POINTS: usize = 1500;
/// Most plots.
const MOST_PLOTS: usize = 3;

/// A figure of which something is sought.
struct Goal<'a> {
    label: &'a str,
    goal: ColumnGoal,
    /// Its place among axes and then columns.
    place: usize,
    is_logarithmic: bool,
}

fn goals(report: &SweepReport) -> Vec<Goal<'_>> {
    let axes = report.axes.iter().map(|axis| (&*axis.label, axis.goal, axis.is_logarithmic));
    let columns = report.columns.iter().map(|column| (&*column.label, column.goal, false));
    let goals = axes.chain(columns).enumerate().filter_map(|(place, (label, goal, log))| {
        Some(Goal { label, goal: goal?, place, is_logarithmic: log })
    });
    goals.collect()
}

/// A goal against another one, pair by pair; a single goal against the first axis of numbers.
pub(super) fn goal_figures(report: &SweepReport, table: &SweepTable) -> Vec<Figure> {
    let goals = goals(report);
    if let [goal] = &goals[..] {
        let axis = report.axes.iter().position(|axis| axis.range.is_some());
        let against = axis.filter(|axis| *axis != goal.place).map(|axis| {
            let labels = [&*report.axes[axis].label, goal.label];
            let is_logarithmic = [report.axes[axis].is_logarithmic, goal.is_logarithmic];
            plot((labels, is_logarithmic), &places(table, [axis, goal.place]), None)
        });
        return Vec::from_iter(against);
    }
    let pairs = (0..goals.len()).flat_map(|b| (0..b).map(move |a| [a, b]));
    let figure = |pair: [usize; 2]| {
        let pair = pair.map(|k| &goals[k]);
        let axes = (pair.map(|goal| goal.label), pair.map(|goal| goal.is_logarithmic));
        let sought = (pair.map(|goal| goal.goal), goals.len() == 2);
        plot(axes, &places(table, pair.map(|goal| goal.place)), Some(sought))
    };
    pairs.take(MOST_PLOTS).map(figure).collect()
}

/// A point in a plot: its number, its place, and whether it is on the front.
type Place = (usize, [f64; 2], bool);

fn places(table: &SweepTable, [x, y]: [usize; 2]) -> Vec<Place> {
    let rows = table.rows.iter().enumerate();
    rows.filter_map(|(k, row)| Some((k, [row.number(x)?, row.number(y)?], row.is_on_front)))
        .collect()
}

/// A plot; `goals`: what is sought of both, and whether the front is that of these two alone.
fn plot(
    (labels, is_logarithmic): ([&str; 2], [bool; 2]),
    places: &[Place],
    goals: Option<([ColumnGoal; 2], bool)>,
) -> Figure {
    let along = |k: usize| places.iter().map(|place| place.1[k]).collect::<Vec<f64>>();
    let x = scale_axis(&along(0), labels[0], is_logarithmic[0]);
    let y = scale_axis(&along(1), labels[1], is_logarithmic[1]);
    let mut diagram = Diagram::new(SIZE[0], SIZE[1]);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    let step = places.len().div_ceil(MOST_POINTS).max(1);
    let others: Vec<[f64; 2]> =
        places.iter().filter(|place| !place.2).step_by(step).map(|place| place.1).collect();
    let mut front: Vec<&Place> = places.iter().filter(|place| place.2).collect();
    sort_by_number(&mut front, |place| place.1[0]);
    let count = front.len();
    plot.points((Ink::Faint, Marker::Disc, 1.4), others.iter().copied());
    if goals.is_some_and(|(_, is_whole_front)| is_whole_front) {
        plot.line(Stroke::solid(Ink::Blue, 1.2), front.iter().map(|place| place.1));
    }
    let shown = front.iter().step_by(count.div_ceil(MOST_POINTS).max(1));
    plot.points((Ink::Blue, Marker::Square, 2.6), shown.map(|place| place.1));
    for place in front.first().into_iter().chain(front.last().filter(|_| count > 1)) {
        let anchor = if x.share(place.1[0]) > 0.5 { Anchor::End } else { Anchor::Start };
        let beside = if anchor == Anchor::End { -6.0 } else { 6.0 };
        let text = format!("point {}", place.0);
        plot.label(Ink::Text, place.1, [beside, -5.0], anchor, &text);
    }
    let word = |goal: ColumnGoal| match goal {
        ColumnGoal::Most => "the most",
        ColumnGoal::Least => "the least",
    };
    let sought = match goals {
        Some(([a, b], _)) => format!(" Sought: {} along X and {} along Y.", word(a), word(b)),
        None => String::new(),
    };
    let some =
        if step > 1 { format!(" Of the others every {step}th is drawn.") } else { String::new() };
    let title = format!("{} against {}", labels[1], labels[0]);
    Figure {
        body: diagram.svg(&title),
        title,
        caption: format!(
            "Squares: the {count} points that no other beats in every goal. Discs: others.{some}{sought}"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::study;
    use super::*;

    #[test]
    fn points_are_discs_and_those_of_the_front_squares() {
        let (report, table) = study();
        let [figure] = &goal_figures(&report, &table)[..] else { panic!("two goals are one pair") };
        assert_eq!(figure.body.matches("<circle").count(), 1, "{}", figure.body);
        assert_eq!(figure.body.matches("class=\"point area blue").count(), 2, "{}", figure.body);
        assert!(figure.body.contains("point 0") && figure.body.contains("point 2"));
        assert!(figure.caption.contains("the 2 points"), "{}", figure.caption);
    }

    #[test]
    fn one_goal_is_drawn_against_an_axis_of_numbers_and_none_not_at_all() {
        let (mut report, table) = study();
        report.columns[1].goal = None;
        assert!(goal_figures(&report, &table).is_empty(), "an axis of words");
        report.axes[0].range = Some([1.0, 2.5]);
        let [figure] = &goal_figures(&report, &table)[..] else { panic!("one plot") };
        assert_eq!(figure.title, "error_px against part.width_mm");
        report.columns[0].goal = None;
        assert!(goal_figures(&report, &table).is_empty());
    }
}
