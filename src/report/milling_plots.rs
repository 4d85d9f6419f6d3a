//! Plots of the time that programs take on the machine.

use super::page::Figure;
use super::plot::{Anchor, Axis, Diagram, Ink, Plot, Stroke};
use crate::results::{OperationFacts, three_digits};

/// Places along a plot of what is left: as many as it has units of width.
const PLACES: usize = 440;

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
        caption: match operations.iter().all(|done| done.servo.is_some()) {
            true => {
                "Each bar is the time that the moves are told to take, lifts included.".to_owned()
            }
            false => format!(
                "Each bar and its figures from the left: at the feed, then speeding up, slowing down and in corners, then rapid moves. \
                 {share} % of all the time is speed that changes: that is what a machine with more acceleration saves."
            ),
        },
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
        caption: match operation.servo {
            Some(_) => "Over the time of the program: X and Z follow the mirror around the axis, while X alone goes inwards by the feed. \
                        Peaks are lifts."
                .to_owned(),
            None => format!(
                "Over the time of the program. {share} % of it runs at the feed; above it are rapid moves, below it corners and the \
                 ends of moves, where the machine's acceleration holds it back."
            ),
        },
    }
}

/// What a program of a lathe leaves along the radius: distance from the axis (mm), the least and the most of all azimuths (um).
pub(super) fn section_figure(operation: &str, section: &[[f64; 3]], is_round: bool) -> Figure {
    // Of places that are nearer to each other than the plot shows, the extremes.
    let part = section.len().div_ceil(PLACES).max(1);
    let parts: Vec<[f64; 3]> = section
        .chunks(part)
        .map(|places| {
            let low = places.iter().map(|place| place[1]).fold(f64::INFINITY, f64::min);
            let high = places.iter().map(|place| place[2]).fold(f64::NEG_INFINITY, f64::max);
            [places[0][0], low, high]
        })
        .collect();
    let ends = |k: usize| {
        let all = || parts.iter().map(|place| place[k]);
        [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
    };
    let [left, right] = ends(0);
    let [low, high] = [ends(1)[0].min(0.0), ends(2)[1].max(f64::MIN_POSITIVE)];
    let x = Axis::linear([left, right], "distance from the axis, mm");
    let y = Axis::linear([low, high + 0.1 * (high - low)], "left, um");
    let mut diagram = Diagram::new(WIDTH, HEIGHT);
    let mut plot = Plot::new(&mut diagram, &x, &y);
    for (ink, k) in [(Ink::Red, 2), (Ink::Blue, 1)] {
        plot.line(Stroke::solid(ink, 1.0), parts.iter().map(|place| [place[0], place[k]]));
    }
    let title = format!("Left after {operation}, um");
    let along = match is_round {
        true => "along the mirror's normal",
        false => "within the mirror's sections",
    };
    Figure {
        body: diagram.svg(&title),
        title,
        caption: format!(
            "Along the radius: the most (upper line) and the least (lower line) of all azimuths that the program of {operation}, read back, leaves \
             {along}. Cusps between turns lie between both."
        ),
    }
}
