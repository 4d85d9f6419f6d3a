//! Sweeps of a benchmark as plots of error against time, a panel a profile.

use super::{BenchRun, BenchSweep};
use crate::geom::DVec2;
use crate::raster::EncodingError;
use crate::report::{
    Anchor, Axis, Dash, Diagram, Ink, LETTER, Margins, Marker, Plot, Stroke, text_width,
};

/// Width of a diagram, units of its letters: they can be read where it is shown 400 pixels wide.
const WIDTH: f64 = 600.0;
/// Least height of a panel, with the room below it, and of all panels: the label of Y is as long, units.
const PANEL: f64 = 156.0;
const PANELS: f64 = 330.0;
/// Between panels side by side, and one above the other, where ticks are a line high, units.
const GAP: f64 = 10.0;
const ROW_GAP: f64 = 16.0;
/// From line to line of text, units.
const LINE: f64 = 17.0;
/// From the diagram's edges, units.
const EDGE: f64 = 8.0;

/// Looks of the series, of which the first are the commonest: colour, point and line tell them apart, each alone.
const INKS: [Ink; 3] = [Ink::Blue, Ink::Red, Ink::Green];
const MARKERS: [Marker; 3] = [Marker::Disc, Marker::Square, Marker::Triangle];
const DASHES: [Dash; 3] = [Dash::Solid, Dash::Dashed, Dash::Dotted];

impl BenchSweep {
    /// Error against time, both logarithmic: a panel a profile, a line a series, with rings around the runs that
    /// no other of their profile beats in both.
    #[must_use]
    pub fn svg(&self) -> String {
        self.diagram().svg_file(&format!("{}: error against {}", self.about, self.time.name()))
    }

    /// The same as PNG.
    ///
    /// # Errors
    /// What the encoder reports.
    pub fn png(&self) -> Result<Vec<u8>, EncodingError> {
        self.diagram().png()
    }

    fn diagram(&self) -> Diagram {
        // What is no error has no place on a logarithmic axis.
        let shown = |run: &&BenchRun| run.error > 0.0 && run.error.is_finite();
        let runs: Vec<&BenchRun> = self.runs.iter().filter(shown).collect();
        let curves = curves(&runs);
        let profiles: Vec<&str> = distinct(runs.iter().map(|run| &*run.profile));
        let (unit, factor) = self.time.unit();
        let label = format!("{}, {unit}", self.time.name());
        let x = Axis::logarithmic(runs.iter().map(|run| factor * run.time_ms), label);
        let y = Axis::logarithmic(runs.iter().map(|run| run.error), self.error_axis);
        let columns = [1, 2, 3][(profiles.len().saturating_sub(1) / 2).min(2)];
        let rows = profiles.len().div_ceil(columns).max(1);
        let panel = PANEL.max(PANELS / rows as f64);
        let head = head(self, &curves);
        let margins = Margins::of(&x, &y);
        let top = EDGE + LINE * head.lines() as f64 + 6.0;
        let height = top + panel * rows as f64 - ROW_GAP + margins.bottom;
        let mut diagram = Diagram::new(WIDTH, height);
        head.draw(&mut diagram);
        let width = (WIDTH - margins.left - margins.right.max(EDGE) + GAP) / columns as f64;
        for (k, profile) in profiles.iter().enumerate() {
            let (column, row) = (k % columns, k / columns);
            let low = DVec2::new(margins.left + width * column as f64, top + panel * row as f64);
            let area = [low, low + DVec2::new(width - GAP, panel - ROW_GAP)];
            let mut plot = Plot::within(&mut diagram, area, &x, &y);
            if column == 0 {
                plot.draw_y_ticks();
            }
            if k + columns >= profiles.len() {
                plot.draw_x_ticks();
            }
            draw_panel(&mut plot, (&curves, profile), factor);
        }
        let middle = 0.5 * (margins.left + WIDTH);
        diagram.text(Ink::Text, DVec2::new(middle, height - 5.0), Anchor::Middle, &*x.label);
        let middle = top + 0.5 * (panel * rows as f64 - ROW_GAP);
        diagram.turned_text(Ink::Text, DVec2::new(LETTER[1], middle), &y.label);
        diagram
    }
}

/// Draws the curves of a profile, and those of all others faintly behind; a millisecond is `factor` of the axis.
fn draw_panel(plot: &mut Plot, (curves, profile): (&[Curve], &str), factor: f64) {
    let values = |curve: &Curve| -> Vec<[f64; 2]> {
        curve.runs.iter().map(|run| [factor * run.time_ms, run.error]).collect()
    };
    for curve in curves.iter().filter(|curve| curve.profile != profile) {
        plot.line(Stroke::solid(Ink::Line, 1.0), values(curve));
    }
    for curve in curves.iter().filter(|curve| curve.profile == profile) {
        let Look { ink, marker, dash } = curve.look;
        plot.line(Stroke { ink, width: 1.5, dash }, values(curve));
        plot.points((ink, marker, 2.2), values(curve));
        let best = curve.runs.iter().filter(|run| run.pareto);
        let best = best.map(|run| [factor * run.time_ms, run.error]);
        plot.points((Ink::Text, Marker::Ring, 4.5), best);
    }
    plot.corner_label(Anchor::End, &fitted(profile));
}

/// A name no longer than a panel is wide.
fn fitted(name: &str) -> String {
    let most = 22;
    match name.chars().count() > most {
        true => format!("{}...", name.chars().take(most - 3).collect::<String>()),
        false => name.into(),
    }
}

/// The look of a series.
#[derive(Clone, Copy)]
struct Look {
    ink: Ink,
    marker: Marker,
    dash: Dash,
}

/// The runs of a profile and series.
struct Curve<'a> {
    profile: &'a str,
    series: &'a str,
    look: Look,
    runs: Vec<&'a BenchRun>,
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut all = Vec::new();
    names.for_each(|name| {
        if !all.contains(&name) {
            all.push(name);
        }
    });
    all
}

/// The curves of a sweep; a series has the same look in every panel.
fn curves<'a>(runs: &[&'a BenchRun]) -> Vec<Curve<'a>> {
    let series = distinct(runs.iter().map(|run| &*run.series));
    let mut curves: Vec<Curve> = Vec::new();
    for run in runs {
        let own = |curve: &&mut Curve| curve.profile == run.profile && curve.series == run.series;
        if let Some(curve) = curves.iter_mut().find(own) {
            curve.runs.push(run);
            continue;
        }
        let k = series.iter().position(|name| *name == run.series).unwrap_or(0);
        let look =
            Look { ink: INKS[k % 3], marker: MARKERS[k % 3], dash: DASHES[k / 3 % DASHES.len()] };
        let (profile, series) = (&*run.profile, &*run.series);
        curves.push(Curve { profile, series, look, runs: vec![run] });
    }
    curves
}

/// What stands above the panels.
struct Head {
    texts: Vec<String>,
    /// Names of the looks, line by line.
    keys: Vec<Vec<(Option<Look>, String)>>,
}

/// Title, conclusion and key of a sweep.
fn head(sweep: &BenchSweep, curves: &[Curve]) -> Head {
    let letters = ((WIDTH - 2.0 * EDGE) / LETTER[0]) as usize;
    let mut texts = vec![sweep.about.to_owned()];
    let conclusion = sweep.conclusion();
    texts.extend(textwrap::wrap(&conclusion, letters).into_iter().map(Into::into));
    let named = distinct(curves.iter().map(|curve| curve.series).filter(|name| !name.is_empty()));
    let look = |name: &&str| curves.iter().find(|curve| curve.series == *name).map(|c| c.look);
    let entries = named.iter().map(|name| (look(name), (*name).to_owned()));
    let ring = (None, "no other run of the profile is both faster and nearer".to_owned());
    let (mut keys, mut x) = (vec![Vec::new()], 0.0);
    for entry in entries.chain([ring]) {
        let width = SAMPLE + text_width(&entry.1) + 2.0 * GAP;
        if x > 0.0 && x + width > WIDTH - 2.0 * EDGE {
            keys.push(Vec::new());
            x = 0.0;
        }
        x += width;
        if let Some(line) = keys.last_mut() {
            line.push(entry);
        }
    }
    Head { texts, keys }
}

/// Length of the piece of a line in the key, with the room behind it, units.
const SAMPLE: f64 = 32.0;

impl Head {
    fn lines(&self) -> usize {
        self.texts.len() + self.keys.len()
    }

    fn draw(&self, diagram: &mut Diagram) {
        let mut y = EDGE - 4.0;
        for text in &self.texts {
            y += LINE;
            diagram.text(Ink::Text, DVec2::new(EDGE, y), Anchor::Start, &**text);
        }
        for line in &self.keys {
            y += LINE;
            let mut x = EDGE;
            for (look, name) in line {
                let at = |along: f64| DVec2::new(x + along, y - 4.0);
                match look {
                    Some(Look { ink, marker, dash }) => {
                        let stroke = Stroke { ink: *ink, width: 1.5, dash: *dash };
                        diagram.lines(stroke, [vec![at(0.0), at(SAMPLE - 6.0)]]);
                        diagram.point(*ink, *marker, at(0.5 * (SAMPLE - 6.0)), 2.6);
                    }
                    None => diagram.point(Ink::Text, Marker::Ring, at(0.5 * (SAMPLE - 6.0)), 4.5),
                }
                diagram.text(Ink::Text, DVec2::new(x + SAMPLE, y), Anchor::Start, &**name);
                x += SAMPLE + text_width(name) + 2.0 * GAP;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::results::tests::sweep;
    use super::*;

    #[test]
    fn every_run_is_a_point_and_the_best_have_rings() {
        let sweep = sweep();
        let svg = sweep.svg();
        // Two series, each with a point in the key, which has a ring too.
        assert_eq!(svg.matches("class=\"point ").count(), 6 + 2);
        assert_eq!(svg.matches("class=\"ring ").count(), 3 + 1);
        for text in ["panoramic", "conical", "ray error", "run time, ms"] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(svg, sweep.svg());
        assert!(sweep.png().unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn nothing_to_draw_is_an_empty_plot() {
        let mut sweep = sweep();
        sweep.runs.iter_mut().for_each(|run| run.error = 0.0);
        assert!(!sweep.svg().contains("NaN"));
        sweep.runs.clear();
        assert!(!sweep.svg().contains("NaN") && sweep.png().is_ok());
    }

    #[test]
    fn texts_end_within_the_picture() {
        let mut sweep = sweep();
        let runs = sweep.runs.clone();
        for k in 0..40 {
            let name = format!("a-rather-long-name-of-a-profile-{k}");
            let more = runs.iter().cloned();
            sweep.runs.extend(more.map(|run| BenchRun {
                profile: name.clone(),
                series: format!("series-of-number-{}", k % 12),
                ..run
            }));
        }
        let svg = sweep.svg();
        for text in svg.split("<text ").skip(1) {
            let value = |name: &str| {
                let from = text.split(&format!("{name}=\"")).nth(1).unwrap();
                from.split('"').next().unwrap().to_owned()
            };
            let at: f64 = value(" x").parse().unwrap();
            let words = text.split('>').nth(1).unwrap().split("</text").next().unwrap();
            let end = match &*value("text-anchor") {
                _ if text.contains("rotate") => at,
                "start" => at + text_width(words),
                "middle" => at + 0.5 * text_width(words),
                _ => at,
            };
            assert!(end <= WIDTH, "{words}: {end}");
        }
    }
}
