//! A diagram as SVG.

use super::diagram::{Anchor, Dash, Diagram, Ink, Mark, Marker, Stroke};
use crate::geom::DVec2;
use crate::report::page::{COLOURS, DRAWING, escaped};
use std::fmt::Write;

impl Diagram {
    /// The diagram in a page, whose style sheet has its colours; `label` says what it shows to those who do not see it.
    pub(crate) fn svg(&self, label: &str) -> String {
        let DVec2 { x: width, y: height } = self.size;
        let label = escaped(label);
        format!(
            "<svg class=\"drawing\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{label}\">\n{}</svg>",
            self.elements()
        )
    }

    /// The diagram as a file of its own, with its colours for light and dark.
    pub(crate) fn svg_file(&self, label: &str) -> String {
        let DVec2 { x: width, y: height } = self.size;
        let label = escaped(label);
        let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
        let corners = corners.map(DVec2::from_array).to_vec();
        let mut ground = String::new();
        // Writing to a string cannot fail.
        let _ = element(&mut ground, &Mark::Area { ink: Ink::Paper, opacity: 1.0, corners });
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"drawing\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             role=\"img\" aria-label=\"{label}\">\n<style>\n{COLOURS}{DRAWING}</style>\n{ground}{}</svg>\n",
            self.elements()
        )
    }

    fn elements(&self) -> String {
        let mut svg = String::new();
        for mark in &self.marks {
            // Writing to a string cannot fail.
            let _ = element(&mut svg, mark);
        }
        svg
    }
}

fn element(svg: &mut String, mark: &Mark) -> std::fmt::Result {
    match mark {
        Mark::Lines { stroke: Stroke { ink, width, dash }, lines } => {
            let dash = match dash {
                Dash::Solid => "",
                Dash::Dashed => " dashed",
                Dash::Dotted => " dotted",
            };
            let class = ink.class();
            let paths = lines.iter().map(|line| path(line));
            writeln!(
                svg,
                "<path class=\"{class}{dash}\" stroke-width=\"{width}\" d=\"{}\"/>",
                paths.collect::<String>()
            )
        }
        Mark::Area { ink, opacity, corners } => {
            let (class, path) = (ink.class(), path(corners));
            let opacity = match opacity {
                1.0 => String::new(),
                opacity => format!(" fill-opacity=\"{opacity}\""),
            };
            writeln!(svg, "<path class=\"area {class}\"{opacity} d=\"{path}Z\"/>")
        }
        Mark::Point { ink, marker, at, radius } => {
            let (class, DVec2 { x, y }) = (ink.class(), *at);
            let look = if *marker == Marker::Ring { "ring" } else { "point area" };
            match marker.corners(*at, *radius) {
                Some(corners) => {
                    writeln!(svg, "<path class=\"{look} {class}\" d=\"{}Z\"/>", path(&corners))
                }
                None => writeln!(
                    svg,
                    "<circle class=\"{look} {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>"
                ),
            }
        }
        Mark::Text { ink, at: DVec2 { x, y }, anchor, is_turned, text } => {
            let (class, text) = (ink.class(), escaped(text));
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let turn = match is_turned {
                true => format!(" transform=\"rotate(-90 {x:.1} {y:.1})\""),
                false => String::new(),
            };
            writeln!(
                svg,
                "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{turn}>{text}</text>"
            )
        }
    }
}

/// A line through places.
fn path(line: &[DVec2]) -> String {
    let mut path = String::new();
    for (k, DVec2 { x, y }) in line.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(path, "{}{x:.1} {y:.1}", if k == 0 { "M" } else { "L" });
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::palette::hexadecimal;

    const INKS: [Ink; 7] =
        [Ink::Text, Ink::Faint, Ink::Line, Ink::Paper, Ink::Blue, Ink::Red, Ink::Green];

    #[test]
    fn the_style_sheets_have_every_colour_with_the_shade_of_the_raster() {
        let (light, dark) = COLOURS.split_once("@media (prefers-color-scheme: dark)").unwrap();
        for ink in INKS {
            let class = ink.class();
            let shade = format!("--{class}: {};", hexadecimal(ink.srgb()));
            assert!(light.contains(&shade), "{shade}");
            assert!(dark.contains(&format!("--{class}: #")), "{class}");
            assert!(DRAWING.contains(&format!(".{class} {{")), "{class}");
        }
    }

    #[test]
    fn texts_are_escaped_and_files_are_well_formed() {
        let mut diagram = Diagram::new(100.0, 50.0);
        diagram.text(Ink::Text, DVec2::new(1.0, 20.0), Anchor::Start, "a<b> & \"c\"");
        diagram.turned_text(Ink::Faint, DVec2::new(9.0, 20.0), "x < y");
        diagram.point(Ink::Red, Marker::Triangle, DVec2::splat(f64::NAN), 3.0);
        diagram.area(Ink::Red, 0.5, vec![DVec2::ZERO, DVec2::splat(f64::INFINITY)]);
        let line = vec![DVec2::ZERO, DVec2::splat(f64::NAN), DVec2::ONE];
        diagram.lines(Stroke::dashed(Ink::Blue, 1.5), [line]);
        for svg in [diagram.svg("<label>"), diagram.svg_file("<label>")] {
            assert!(svg.contains("a&lt;b&gt; &amp; &quot;c&quot;</text>"), "{svg}");
            assert!(svg.contains("d=\"M0.0 0.0L1.0 1.0\"") && !svg.contains("NaN"), "{svg}");
            let mut reader = quick_xml::Reader::from_str(&svg);
            while !matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {}
        }
    }
}
