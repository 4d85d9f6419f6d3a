//! Parallel coordinates: a scale for each axis and figure, one below the other, and a line for each point.

use super::super::page::Figure;
use super::super::plot::{Anchor, Axis, Diagram, Ink, LETTER, Plot, Stroke};
use super::{scale_axis, shown};
use crate::geom::DVec2;
use crate::results::{SweepReport, SweepRow, SweepTable};
use serde_json::Value as Json;

/// Width of the diagram, units of its letters.
const WIDTH: f64 = 440.0;
/// From scale to scale, and from the sides of the diagram to them, units.
const STEP: f64 = 74.0;
const SIDE: f64 = 24.0;
/// Height of the ticks' marks, and of the label above a scale, units.
const MARK: f64 = 6.0;
const LABEL: f64 = 20.0;
/// Most scales of axes and of columns, and most lines: more would be a grey area.
const MOST_SCALES: usize = 8;
const MOST_LINES: usize = 400;
/// Most lines of the front.
const MOST_FRONT: usize = 40;
/// Most letters of a word on a scale.
const MOST_LETTERS: usize = 14;

/// A scale, and where a row is on it.
struct Scale<'a> {
    label: String,
    axis: Axis,
    /// Words in the order of their places; none of numbers.
    words: Vec<String>,
    value: Box<dyn Fn(&'a SweepRow) -> Option<&'a Json> + 'a>,
}

impl<'a> Scale<'a> {
    fn new(
        label: &str,
        is_logarithmic: bool,
        rows: &[&'a SweepRow],
        value: impl Fn(&'a SweepRow) -> Option<&'a Json> + 'a,
    ) -> Self {
        let all: Vec<&Json> =
            rows.iter().filter_map(|row| value(row)).filter(|value| !value.is_null()).collect();
        let numbers: Vec<f64> = all.iter().filter_map(|value| value.as_f64()).collect();
        let (label, value) = (label.to_owned(), Box::new(value));
        if numbers.len() == all.len() {
            let axis = scale_axis(&numbers, "", is_logarithmic);
            return Self { label, axis, words: Vec::new(), value };
        }
        let mut words: Vec<String> = Vec::new();
        for word in all.into_iter().map(shown) {
            if !words.contains(&word) {
                words.push(word);
            }
        }
        // (An axis of rows counts from above, here from the right.)
        words.reverse();
        let short = |word: &String| word.trim_matches('"').chars().take(MOST_LETTERS).collect();
        Self { label, axis: Axis::of_rows(words.iter().map(short)), words, value }
    }

    /// Where a row is between the ends of the scale; none where it has no value.
    fn share(&self, row: &'a SweepRow) -> Option<f64> {
        let value = (self.value)(row)?;
        if self.words.is_empty() {
            return value.as_f64().map(|x| self.axis.share(x));
        }
        let word = shown(value);
        let place = self.words.iter().position(|other| *other == word)?;
        Some(self.axis.share(place as f64 + 0.5))
    }
}

/// The scales of all axes and columns with the points' lines; none where no point has figures.
pub(super) fn parallel_axes_figure(report: &SweepReport, table: &SweepTable) -> Option<Figure> {
    let rows: Vec<&SweepRow> =
        table.rows.iter().filter(|row| row.outcome.error.is_none()).collect();
    if rows.is_empty() {
        return None;
    }
    let axes = report.axes.iter().enumerate().take(MOST_SCALES).map(|(k, axis)| {
        Scale::new(&axis.label, axis.is_logarithmic, &rows, move |row: &SweepRow| row.axes.get(k))
    });
    let columns = report.columns.iter().enumerate().take(MOST_SCALES).map(|(k, column)| {
        Scale::new(&column.label, false, &rows, move |row: &SweepRow| row.outcome.values.get(k))
    });
    let scales: Vec<Scale> = axes.chain(columns).collect();
    let mut diagram = Diagram::new(WIDTH, STEP * scales.len() as f64);
    let front: Vec<&SweepRow> = rows.iter().copied().filter(|row| row.is_on_front).collect();
    let drawn = spread(&rows, MOST_LINES);
    let others = if front.is_empty() { Ink::Blue } else { Ink::Line };
    diagram.lines(Stroke::solid(others, 0.7), drawn.iter().map(|row| line(&scales, row)));
    let best = spread(&front, MOST_FRONT);
    diagram.lines(Stroke::solid(Ink::Blue, 1.4), best.iter().map(|row| line(&scales, row)));
    for (k, scale) in scales.iter().enumerate() {
        draw(&mut diagram, k, scale);
    }
    let mut caption = match front.len() {
        0 => String::new(),
        count if count == best.len() => {
            "Blue: the points that no other beats in every goal. ".into()
        }
        count => format!(
            "Blue: {} of the {count} points that no other beats in every goal. ",
            best.len()
        ),
    };
    caption += &match rows.len() {
        count if count == drawn.len() => {
            format!("A line for each of the {count} points with figures.")
        }
        count => {
            format!("Lines for {} of the {count} points with figures, evenly chosen.", drawn.len())
        }
    };
    let title = "Parallel coordinates";
    Some(Figure { title: title.into(), body: diagram.svg(title), caption })
}

/// At most so many of `rows`, evenly chosen.
fn spread<'a>(rows: &[&'a SweepRow], most: usize) -> Vec<&'a SweepRow> {
    let count = rows.len().min(most);
    (0..count).map(|k| rows[k * rows.len() / count]).collect()
}

/// Height of a scale's marks, from above.
fn height(k: usize) -> f64 {
    STEP * k as f64 + LABEL
}

fn across(share: f64) -> f64 {
    SIDE + share * (WIDTH - 2.0 * SIDE)
}

/// The line of a row through all scales on which it has a value.
fn line<'a>(scales: &[Scale<'a>], row: &'a SweepRow) -> Vec<DVec2> {
    let place = |(k, scale): (usize, &Scale<'a>)| {
        Some(DVec2::new(across(scale.share(row)?), height(k) + 0.5 * MARK))
    };
    scales.iter().enumerate().filter_map(place).collect()
}

/// Draws a scale with its label over the lines, which shine through.
fn draw(diagram: &mut Diagram, k: usize, scale: &Scale) {
    let ground = |diagram: &mut Diagram, [low, high]: [f64; 2]| {
        let corners = [[0.0, low], [WIDTH, low], [WIDTH, high], [0.0, high]];
        diagram.area(Ink::Paper, 0.75, corners.map(DVec2::from_array).to_vec());
    };
    let top = height(k);
    ground(diagram, [top - LETTER[1] - 4.0, top - 2.0]);
    ground(diagram, [top + MARK + 2.0, top + MARK + LETTER[1] + 6.0]);
    let area = [DVec2::new(across(0.0), top), DVec2::new(across(1.0), top + MARK)];
    let mut level = Axis::linear([0.0, 1.0], "");
    level.has_grid = false;
    let mut scale_axis = scale.axis.clone();
    scale_axis.has_grid = true;
    Plot::within(diagram, area, &scale_axis, &level).draw_x_ticks();
    let letters = ((WIDTH - 8.0) / LETTER[0]) as usize;
    let label: String = scale.label.chars().take(letters).collect();
    diagram.text(Ink::Text, DVec2::new(4.0, top - 6.0), Anchor::Start, label);
}

#[cfg(test)]
mod tests {
    use super::super::tests::study;
    use super::*;

    #[test]
    fn every_point_with_figures_has_a_line_and_every_scale_its_label() {
        let (report, table) = study();
        let figure = parallel_axes_figure(&report, &table).unwrap();
        for text in ["part.width_mm", "part.form", "error_px", "depth_mm"] {
            assert!(figure.body.contains(text), "{text}");
        }
        // Three lines of all, then two of the front.
        let paths: Vec<&str> = figure.body.split("<path").collect();
        let lines = |path: &str| path.matches('M').count();
        assert_eq!((lines(paths[1]), lines(paths[2])), (3, 2), "{}", figure.body);
        assert!(figure.caption.contains("each of the 3 points"), "{}", figure.caption);
        assert!(!figure.body.contains("NaN"));
    }

    #[test]
    fn nothing_made_is_no_figure() {
        let (report, mut table) = study();
        table.rows.retain(|row| row.outcome.error.is_some());
        assert!(parallel_axes_figure(&report, &table).is_none());
    }
}
