//! Plots of the time that programs take on the machine.

use super::page::Figure;
use super::plot::{Anchor, Axis, Diagram, Ink, Plot, Stroke};
use crate::results::{OperationFacts, three_digits};

/// Width of a plot, and height of one of speeds, units.
const WIDTH: f64 = 440.0;
const HEIGHT: f64 = 220.0;
/// Height of a row of bars, and of the axis below them, units.
const ROW: f64 = 54.0;
const FOOT: f64 = 50.0;
/// Room over the largest speed.
const HEADROOM: f64 = 1.15;

/// Minutes of each operation at the feed, changing speed and in rapid moves, as bars one after the other; none without operations.
pub(super) fn times_figure(operations: &[OperationFacts]) -> Option<Figure> {
    let longest = operations.iter().map(|done| done.machine_min).reduce(f64::max)?;
    let whole: f64 = operations.iter().map(|done| done.machine_min).sum();
    let changing: f64 = operations.iter().map(|done| done.changing_min).sum();
    let x = Axis::linear([0.0, longest], "time on the machine, min");
    let y = Axis::of_rows(operations.iter().map(|done| done.operation.name().to_owned()));
    let mut diagram = Diagram::new(WIDTH, FOOT + ROW * operations.len() as f64);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    for (row, done) in (0..).map(f64::from).zip(operations) {
        let parts = [
            (Ink::Blue, done.at_feed_min),
            (Ink::Red, done.changing_min),
            (Ink::Green, done.rapid_min),
        ];
        let mut from = 0.0;
        for (ink, minutes) in parts {
            plot.bar(ink, [[from, row + 0.45], [from + minutes, row + 0.9]]);
            from += minutes;
        }
        let [feed, changing, rapid] = parts.map(|(_, minutes)| three_digits(minutes));
        let text = format!("{feed} + {changing} + {rapid} min");
        plot.label(Ink::Text, [0.0, row + 0.35], [4.0, 0.0], Anchor::Start, &text);
    }
    let share = three_digits(1e2 * changing / whole.max(f64::MIN_POSITIVE));
    let title = "Time of the programs";
    Some(Figure {
        title: title.into(),
        body: diagram.svg(title),
        caption: format!(
            "Each bar and its figures from the left: at the feed, then speeding up, slowing down and in corners, then rapid moves. \
             {share} % of all the time is speed that changes: that is what a machine with more acceleration saves."
        ),
    })
}

/// Mean speed in equal parts of the time of an operation, with the feed that it asks for.
pub(super) fn speeds_figure(operation: &OperationFacts, speeds_mm_min: &[f64]) -> Figure {
    let feed = operation.speeds.feed_mm_min;
    let fastest = speeds_mm_min.iter().copied().fold(feed, f64::max);
    let x = Axis::linear([0.0, operation.machine_min], "time, min");
    let y = Axis::linear([0.0, HEADROOM * fastest], "mean speed, mm/min");
    let mut diagram = Diagram::new(WIDTH, HEIGHT);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    let part = operation.machine_min / speeds_mm_min.len().max(1) as f64;
    let steps = speeds_mm_min
        .iter()
        .enumerate()
        .flat_map(|(k, &speed)| [k, k + 1].map(|end| [part * end as f64, speed]));
    plot.line(Stroke::solid(Ink::Blue, 1.2), steps);
    plot.mark_y(Stroke::dashed(Ink::Text, 1.2), feed, &format!("feed {feed} mm/min"));
    let share =
        three_digits(1e2 * operation.at_feed_min / operation.machine_min.max(f64::MIN_POSITIVE));
    let title = format!("Speed of {}", operation.operation.name());
    Figure {
        body: diagram.svg(&title),
        title,
        caption: format!(
            "Over the time of the program. {share} % of it runs at the feed; above it are rapid moves, below it corners and the ends \
             of moves, where the machine's acceleration holds it back."
        ),
    }
}
