//! A plot: two axes, and what is drawn between them.

use super::axis::Axis;
use super::diagram::{Anchor, Diagram, Ink, LETTER, Marker, Stroke, text_width};
use super::labels::{Labels, extent};
use crate::geom::DVec2;

/// Room between a tick and its text, units.
const TICK: f64 = 5.0;
/// From line to line of text, units.
const LINE: f64 = 15.0;

/// Room around the area between the axes, units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margins {
    /// Left: for ticks, and for a label that is read from below.
    pub left: f64,
    /// Right.
    pub right: f64,
    /// Above.
    pub top: f64,
    /// Below: for ticks and a label.
    pub bottom: f64,
}

impl Margins {
    /// Room for the texts of two axes.
    pub(crate) fn of(x: &Axis, y: &Axis) -> Self {
        let widest = y.ticks.iter().map(|tick| text_width(&tick.1)).fold(0.0, f64::max);
        let labels = [x, y].map(|axis| if axis.label.is_empty() { 0.0 } else { LINE + 3.0 });
        // Half of the last tick's text goes beyond the axis.
        let right = x.ticks.last().map_or(0.0, |tick| 0.5 * text_width(&tick.1));
        let [below, beside] = labels;
        Self {
            left: widest + 2.0 * TICK + beside,
            right: right.max(8.0),
            top: 8.0,
            bottom: LINE + TICK + below,
        }
    }
}

/// A plot that is being drawn into a diagram.
pub(crate) struct Plot<'a> {
    diagram: &'a mut Diagram,
    /// Upper left and lower right corner of the area between the axes.
    area: [DVec2; 2],
    x: &'a Axis,
    y: &'a Axis,
    labels: Labels,
    /// Where ticks of X may be, from left to right: other plots may lie beside this one.
    sides: [f64; 2],
}

impl<'a> Plot<'a> {
    /// A plot that fills a diagram: grid, ticks and the axes' labels.
    pub(crate) fn new(diagram: &'a mut Diagram, x: &'a Axis, y: &'a Axis) -> Self {
        let Margins { left, right, top, bottom } = Margins::of(x, y);
        let area = [DVec2::new(left, top), diagram.size - DVec2::new(right, bottom)];
        let mut plot = Self::within(diagram, area, x, y);
        plot.sides = [0.0, plot.diagram.size.x];
        plot.draw_x_ticks();
        plot.draw_y_ticks();
        let [low, high] = area;
        let middle = 0.5 * (low + high);
        let foot = plot.diagram.size.y - 4.0;
        let across = DVec2::new(middle.x, foot);
        let upwards = DVec2::new(LETTER[1], middle.y);
        let diagram = &mut *plot.diagram;
        if !x.label.is_empty() {
            diagram.text(
                Ink::Text,
                inside(across, &x.label, [0.0, diagram.size.x]),
                Anchor::Middle,
                &*x.label,
            );
        }
        if !y.label.is_empty() {
            diagram.turned_text(Ink::Text, upwards, &y.label);
        }
        plot
    }

    /// A plot between two corners of a diagram: its grid, without texts.
    pub(crate) fn within(
        diagram: &'a mut Diagram,
        area: [DVec2; 2],
        x: &'a Axis,
        y: &'a Axis,
    ) -> Self {
        let [low, high] = area;
        let sides = [low.x, high.x];
        let plot = Self { diagram, area, x, y, labels: Labels::default(), sides };
        let ticks = |axis: &Axis| if axis.has_grid { axis.ticks.clone() } else { Vec::new() };
        let upright = ticks(x).into_iter().map(|(at, _)| {
            let x = plot.across(at);
            vec![DVec2::new(x, low.y), DVec2::new(x, high.y)]
        });
        let level = ticks(y).into_iter().map(|(at, _)| {
            let y = plot.upwards(at);
            vec![DVec2::new(low.x, y), DVec2::new(high.x, y)]
        });
        let grid: Vec<Vec<DVec2>> = upright.chain(level).collect();
        plot.diagram.lines(Stroke::solid(Ink::Line, 1.0), grid);
        let axes = vec![low, DVec2::new(low.x, high.y), high];
        plot.diagram.lines(Stroke::solid(Ink::Faint, 1.0), [axes]);
        plot
    }

    fn across(&self, x: f64) -> f64 {
        let [low, high] = self.area;
        low.x + self.x.share(x) * (high.x - low.x)
    }

    fn upwards(&self, y: f64) -> f64 {
        let [low, high] = self.area;
        high.y - self.y.share(y) * (high.y - low.y)
    }

    fn place(&self, [x, y]: [f64; 2]) -> DVec2 {
        DVec2::new(self.across(x), self.upwards(y))
    }

    /// Writes the ticks of X below the area; those for which there is no room are left out.
    pub(crate) fn draw_x_ticks(&mut self) {
        let y = self.area[1].y + TICK + LETTER[1];
        let ticks: Vec<_> =
            self.x.ticks.iter().map(|(at, text)| (self.across(*at), text)).collect();
        for (x, text) in ticks {
            let at = inside(DVec2::new(x, y), text, self.sides);
            self.labels.write(self.diagram, (Ink::Text, text), [(at, Anchor::Middle)]);
        }
    }

    /// Writes the ticks of Y to the left of the area; those for which there is no room are left out.
    pub(crate) fn draw_y_ticks(&mut self) {
        let x = self.area[0].x - TICK;
        let ticks: Vec<_> =
            self.y.ticks.iter().map(|(at, text)| (self.upwards(*at), text)).collect();
        for (y, text) in ticks {
            let at = DVec2::new(x, y + 4.0);
            self.labels.write(self.diagram, (Ink::Text, text), [(at, Anchor::End)]);
        }
    }

    /// Draws a line through values.
    pub(crate) fn line(&mut self, stroke: Stroke, values: impl IntoIterator<Item = [f64; 2]>) {
        let line = values.into_iter().map(|at| self.place(at)).collect();
        self.diagram.lines(stroke, [line]);
    }

    /// Draws points of a radius in units.
    pub(crate) fn points(
        &mut self,
        (ink, marker, radius): (Ink, Marker, f64),
        values: impl IntoIterator<Item = [f64; 2]>,
    ) {
        for at in values {
            let at = self.place(at);
            self.diagram.point(ink, marker, at, radius);
        }
    }

    /// Draws the area within an outline.
    pub(crate) fn outline(
        &mut self,
        (ink, opacity): (Ink, f64),
        values: impl IntoIterator<Item = [f64; 2]>,
    ) {
        let corners = values.into_iter().map(|at| self.place(at)).collect();
        self.diagram.area(ink, opacity, corners);
    }

    /// Draws a rectangle between two corners.
    pub(crate) fn bar(&mut self, ink: Ink, [[left, low], [right, high]]: [[f64; 2]; 2]) {
        self.outline((ink, 1.0), [[left, low], [right, low], [right, high], [left, high]]);
    }

    /// Draws a line across the area at `y`, with its label at the left or, if there is no room, elsewhere along it.
    pub(crate) fn mark_y(&mut self, stroke: Stroke, y: f64, label: &str) {
        let [left, right] = [self.area[0].x, self.area[1].x];
        let y = self.upwards(y);
        let ends = [DVec2::new(left, y), DVec2::new(right, y)];
        self.diagram.lines(stroke, [ends.to_vec()]);
        self.labels.add_line(ends);
        let rows = [y + 12.0, y - 4.0];
        let places = rows.into_iter().flat_map(|y| {
            let at = |x: f64, anchor| (DVec2::new(x, y), anchor);
            [
                at(left + 4.0, Anchor::Start),
                at(right - 4.0, Anchor::End),
                at(0.5 * (left + right), Anchor::Middle),
            ]
        });
        self.labels.write(self.diagram, (label_ink(stroke.ink), label), places);
    }

    /// Draws upright lines, each with its label beside its upper end or, if there is no room, lower down.
    pub(crate) fn mark_x(&mut self, lines: &[(Stroke, f64, &str)]) {
        let [low, high] = self.area;
        let places: Vec<f64> = lines.iter().map(|line| self.across(line.1)).collect();
        for ((stroke, ..), &x) in lines.iter().zip(&places) {
            let ends = [DVec2::new(x, low.y), DVec2::new(x, high.y)];
            self.diagram.lines(*stroke, [ends.to_vec()]);
            self.labels.add_line(ends);
        }
        let rows = ((high.y - low.y) / LINE) as usize;
        for ((stroke, _, label), x) in lines.iter().zip(places) {
            let candidates = (0..rows).flat_map(|row| {
                let y = low.y + 12.0 + LINE * row as f64;
                [(DVec2::new(x + 4.0, y), Anchor::Start), (DVec2::new(x - 4.0, y), Anchor::End)]
            });
            let within = |(at, anchor): &(DVec2, Anchor)| {
                let [from, to] = extent(*at, *anchor, label);
                from.x >= low.x && to.x <= self.diagram.size.x
            };
            let candidates: Vec<_> = candidates.filter(within).collect();
            self.labels.write(self.diagram, (label_ink(stroke.ink), label), candidates);
        }
    }

    /// Writes a label beside a value, `offset` units to the right and down of it.
    pub(crate) fn label(
        &mut self,
        ink: Ink,
        at: [f64; 2],
        offset: [f64; 2],
        anchor: Anchor,
        text: &str,
    ) {
        let at = self.place(at) + DVec2::from_array(offset);
        let at = match anchor {
            Anchor::Middle => inside(at, text, [0.0, self.diagram.size.x]),
            _ => at,
        };
        self.labels.write(self.diagram, (ink, text), [(at, anchor)]);
    }

    /// Writes a label in an upper corner, or below what is there.
    pub(crate) fn corner_label(&mut self, anchor: Anchor, text: &str) {
        let [low, high] = self.area;
        let x = low.x + 4.0 + anchor.share() * (high.x - low.x - 8.0);
        let rows = ((high.y - low.y) / LINE) as usize;
        let places = (0..rows).map(|row| (DVec2::new(x, low.y + 12.0 + LINE * row as f64), anchor));
        self.labels.write(self.diagram, (Ink::Text, text), places);
    }
}

/// Texts of grid colour would hardly be read.
fn label_ink(ink: Ink) -> Ink {
    if ink == Ink::Line { Ink::Faint } else { ink }
}

/// The place of a text's middle at which it lies between two sides.
fn inside(at: DVec2, text: &str, [left, right]: [f64; 2]) -> DVec2 {
    let half = 0.5 * text_width(text);
    DVec2::new(at.x.min(right - half).max(left + half), at.y)
}

#[cfg(test)]
mod tests {
    use super::super::diagram::Mark;
    use super::*;

    /// Corners of every text.
    fn texts(diagram: &Diagram) -> Vec<([DVec2; 2], String)> {
        let text = |mark: &Mark| match mark {
            Mark::Text { at, anchor, is_turned, text, .. } => {
                let [low, high] = extent(*at, *anchor, text);
                let turned = |corner: DVec2| *at + DVec2::new(corner.y - at.y, at.x - corner.x);
                let corners = if *is_turned { [low, high].map(turned) } else { [low, high] };
                Some(([corners[0].min(corners[1]), corners[0].max(corners[1])], text.clone()))
            }
            _ => None,
        };
        diagram.marks.iter().filter_map(text).collect()
    }

    #[test]
    fn texts_of_extreme_values_stay_inside_and_clear_of_each_other() {
        let odd = [0.0, 1.0, -1.0, 1.0 + 1e-7, 1e-300, 1e300, -1e300, 123_456.789, f64::NAN];
        for low in odd {
            for high in odd {
                let (x, y) =
                    (Axis::linear([low, high], "length, mm"), Axis::around([high, low], "y, %"));
                let mut diagram = Diagram::new(440.0, 300.0);
                let mut plot = Plot::new(&mut diagram, &x, &y);
                for (k, at) in
                    [low, high, 0.5 * (low + high), f64::INFINITY].into_iter().enumerate()
                {
                    let (stroke, label) = (Stroke::dashed(Ink::Red, 1.5), format!("upright {k}"));
                    plot.mark_x(&[(stroke, at, &label), (stroke, high, "another")]);
                    plot.mark_y(Stroke::dashed(Ink::Blue, 1.5), at, &format!("level {k}"));
                    plot.label(Ink::Text, [at, at], [0.0, 0.0], Anchor::Middle, "a label");
                }
                plot.line(Stroke::solid(Ink::Blue, 1.5), [[low, high], [high, low]]);
                plot.points((Ink::Blue, Marker::Disc, 2.0), [[f64::NAN, 1.0], [high, high]]);
                let svg = diagram.svg("odd");
                assert!(!svg.contains("NaN") && !svg.contains("inf\""), "{svg}");
                let texts = texts(&diagram);
                assert!(texts.len() > 8);
                for (k, ([from, to], text)) in texts.iter().enumerate() {
                    let is_inside = from.cmpge(DVec2::ZERO).all() && to.cmple(diagram.size).all();
                    assert!(is_inside, "{low} {high}: {text} at {from} to {to}");
                    for ([a, b], other) in &texts[..k] {
                        let overlap = from.cmplt(*b).all() && a.cmplt(*to).all();
                        assert!(!overlap, "{low} {high}: {text} and {other}");
                    }
                }
            }
        }
    }

    #[test]
    fn values_are_drawn_where_the_axes_have_them() {
        let (x, y) = (Axis::linear([0.0, 10.0], ""), Axis::linear([0.0, 1.0], ""));
        let mut diagram = Diagram::new(120.0, 120.0);
        let area = [DVec2::splat(10.0), DVec2::splat(110.0)];
        let mut plot = Plot::within(&mut diagram, area, &x, &y);
        plot.line(Stroke::solid(Ink::Blue, 2.0), [[0.0, 0.0], [5.0, 1.0]]);
        let svg = diagram.svg("a line");
        assert!(svg.contains("d=\"M10.0 110.0L60.0 10.0\""), "{svg}");
    }

    #[test]
    fn rows_have_names_from_above() {
        let (x, y) =
            (Axis::linear([0.0, 1.0], "share"), Axis::of_rows(["a", "b"].map(String::from)));
        let mut diagram = Diagram::new(200.0, 100.0);
        Plot::new(&mut diagram, &x, &y);
        let texts = texts(&diagram);
        let height = |name: &str| texts.iter().find(|t| t.1 == name).unwrap().0[0].y;
        assert!(height("a") < height("b"));
    }
}
