//! Drawings to scale.

use crate::geom::DVec2;
use crate::report::plot::{Anchor, Dash, Diagram, Ink, Stroke};

/// A drawing to scale: places are in mm, y upwards.
pub(super) struct Drawing {
    low: DVec2,
    high: DVec2,
    diagram: Diagram,
}

/// The look of edges of the part.
pub(super) const PART: Stroke = Stroke { ink: Ink::Blue, width: 1.4, dash: Dash::Solid };
/// The look of a camera and of a bar of a length.
pub(super) const EDGE: Stroke = Stroke { ink: Ink::Text, width: 1.4, dash: Dash::Solid };

/// Room around what is drawn for letters, units of the drawing.
const MARGIN: f64 = 38.0;

impl Drawing {
    /// An empty drawing of what lies between two corners (mm), `width` units wide.
    pub(super) fn new([low, high]: [DVec2; 2], width: f64) -> Self {
        let scale = (width - 2.0 * MARGIN) / (high.x - low.x);
        let height = (high.y - low.y) * scale + 2.0 * MARGIN;
        Self { low, high, diagram: Diagram::new(width, height) }
    }

    /// Units a millimetre.
    fn scale(&self) -> f64 {
        (self.diagram.size.x - 2.0 * MARGIN) / (self.high.x - self.low.x)
    }

    /// Millimetres that a length of the drawing is on the part.
    pub(super) fn mm(&self, units: f64) -> f64 {
        units / self.scale()
    }

    fn place(&self, at: DVec2) -> DVec2 {
        let from = DVec2::new(at.x - self.low.x, self.high.y - at.y);
        from * self.scale() + DVec2::splat(MARGIN)
    }

    /// Adds lines, each through its places.
    pub(super) fn lines<'a>(
        &mut self,
        stroke: Stroke,
        lines: impl IntoIterator<Item = &'a [DVec2]>,
    ) {
        let lines = lines.into_iter().map(|line| line.iter().map(|at| self.place(*at)).collect());
        let lines: Vec<Vec<DVec2>> = lines.collect();
        self.diagram.lines(stroke, lines);
    }

    /// Adds a text, `offset` units to the right and down from its place.
    pub(super) fn text(&mut self, at: DVec2, offset: [f64; 2], anchor: Anchor, text: &str) {
        let at = self.place(at) + DVec2::from_array(offset);
        self.diagram.text(Ink::Text, at, anchor, text);
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
        self.lines(Stroke::solid(Ink::Faint, 1.0), arrows.iter().map(Vec::as_slice));
        let upright = along.y.abs() > along.x.abs();
        let (offset, anchor) =
            if upright { ([6.0, 4.0], Anchor::Start) } else { ([0.0, 15.0], Anchor::Middle) };
        self.text(0.5 * (from + to), offset, anchor, text);
    }

    /// The drawing as SVG, with what it shows for those who do not see it.
    pub(super) fn svg(&self, label: &str) -> String {
        self.diagram.svg(label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_axes_have_one_scale_and_y_goes_up() {
        let mut drawing = Drawing::new([DVec2::ZERO, DVec2::new(100.0, 50.0)], 176.0);
        assert_eq!(drawing.mm(1.0), 1.0);
        drawing.lines(EDGE, [&[DVec2::ZERO, DVec2::new(10.0, 20.0)][..]]);
        let svg = drawing.svg("a line");
        assert!(svg.contains("viewBox=\"0 0 176 126\""), "{svg}");
        assert!(svg.contains("M38.0 88.0L48.0 68.0"), "{svg}");
    }
}
