//! Drawings to scale, as SVG whose colours follow the page's.

use super::escaped;
use crate::geom::DVec2;
use std::fmt::Write;

/// A drawing to scale: places are in mm, y upwards.
pub(super) struct Drawing {
    low: DVec2,
    high: DVec2,
    /// Width of the drawing, units of its letters.
    width: f64,
    marks: String,
}

/// Where a text is beside its place.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// Room around what is drawn for letters, units of the drawing.
const MARGIN: f64 = 38.0;

impl Drawing {
    /// An empty drawing of what lies between two corners (mm), `width` units wide.
    pub(super) fn new([low, high]: [DVec2; 2], width: f64) -> Self {
        Self { low, high, width, marks: String::new() }
    }

    /// Units a millimetre.
    fn scale(&self) -> f64 {
        (self.width - 2.0 * MARGIN) / (self.high.x - self.low.x)
    }

    /// Millimetres that a length of the drawing is on the part.
    pub(super) fn mm(&self, units: f64) -> f64 {
        units / self.scale()
    }

    fn place(&self, at: DVec2) -> DVec2 {
        let from = DVec2::new(at.x - self.low.x, self.high.y - at.y);
        from * self.scale() + DVec2::splat(MARGIN)
    }

    fn mark(&mut self, arguments: std::fmt::Arguments) {
        // Writing to a string cannot fail.
        let _ = self.marks.write_fmt(arguments);
    }

    /// Adds lines, each through its places, in the look of `class`.
    pub(super) fn lines<'a>(&mut self, class: &str, lines: impl IntoIterator<Item = &'a [DVec2]>) {
        let mut path = String::new();
        for line in lines {
            for (k, at) in line.iter().enumerate() {
                let DVec2 { x, y } = self.place(*at);
                let _ = write!(path, "{}{x:.1} {y:.1}", if k == 0 { "M" } else { "L" });
            }
        }
        self.mark(format_args!("<path class=\"{class}\" d=\"{path}\"/>\n"));
    }

    /// Adds a text, `offset` units to the right and down from its place.
    pub(super) fn text(&mut self, at: DVec2, offset: [f64; 2], anchor: Anchor, text: &str) {
        let DVec2 { x, y } = self.place(at) + DVec2::from_array(offset);
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escaped(text);
        self.mark(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{text}</text>\n"
        ));
    }

    /// Adds a length between two places with arrows at both ends, and its text.
    pub(super) fn length(&mut self, [from, to]: [DVec2; 2], text: &str) {
        let along = (to - from).normalize_or_zero();
        let [back, side] = [along, along.perp()].map(|unit| unit * self.mm(6.0));
        let arrows = [
            vec![from, to],
            vec![from + back + side * 0.5, from, from + back - side * 0.5],
            vec![to - back + side * 0.5, to, to - back - side * 0.5],
        ];
        self.lines("faint", arrows.iter().map(Vec::as_slice));
        let upright = along.y.abs() > along.x.abs();
        let (offset, anchor) =
            if upright { ([6.0, 4.0], Anchor::Start) } else { ([0.0, 15.0], Anchor::Middle) };
        self.text(0.5 * (from + to), offset, anchor, text);
    }

    /// The drawing as SVG, with what it shows for those who do not see it.
    pub(super) fn svg(&self, label: &str) -> String {
        let height = (self.high.y - self.low.y) * self.scale() + 2.0 * MARGIN;
        let (width, label) = (self.width, escaped(label));
        format!(
            "<svg class=\"drawing\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{label}\">\n{}</svg>",
            self.marks
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_axes_have_one_scale_and_y_goes_up() {
        let mut drawing = Drawing::new([DVec2::ZERO, DVec2::new(100.0, 50.0)], 176.0);
        assert_eq!(drawing.mm(1.0), 1.0);
        drawing.lines("ink", [&[DVec2::ZERO, DVec2::new(10.0, 20.0)][..]]);
        let svg = drawing.svg("a line");
        assert!(svg.contains("viewBox=\"0 0 176 126\""), "{svg}");
        assert!(svg.contains("M38.0 88.0L48.0 68.0"), "{svg}");
    }
}
