//! Cross-sections of the part, to scale.

use super::Figure;
use super::drawing::{Drawing, EDGE, PART};
use crate::geom::DVec2;
use crate::num::rounding::floor_125;
use crate::render::PartSection;
use crate::report::plot::Anchor;

/// Width of the drawing, units of its letters.
const WIDTH: f64 = 440.0;

/// Both cross-sections of the part, one above the other and to one scale; none where nothing is cut.
pub(in crate::report) fn sections_figure(sections: &[PartSection]) -> Option<Figure> {
    let bounds = |section: &PartSection| {
        let points = section.edges.iter().flatten().copied();
        points.map(|at| [at, at]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    };
    let all: Vec<_> =
        sections.iter().filter_map(|section| Some((section, bounds(section)?))).collect();
    let half = all.iter().flat_map(|(_, [a, b])| [-a.x, b.x]).reduce(f64::max)?;
    let gap = 0.16 * half;
    let height: f64 = all.iter().map(|(_, [_, b])| b.y + 2.0 * gap).sum();
    let corners = [DVec2::new(-half, 0.0), DVec2::new(half, height)];
    let mut drawing = Drawing::new(corners, WIDTH);
    let mut foot = height;
    for (section, [a, b]) in &all {
        foot -= b.y + 2.0 * gap;
        let up = DVec2::new(0.0, foot + gap);
        let edges: Vec<[DVec2; 2]> =
            section.edges.iter().map(|edge| edge.map(|at| at + up)).collect();
        drawing.lines(PART, edges.iter().map(<[DVec2; 2]>::as_slice));
        let name = format!("section at {}", section.plane.equation());
        drawing.text(DVec2::new(0.0, b.y) + up, [0.0, -10.0], Anchor::Middle, &name);
        let below = DVec2::new(0.0, -0.5 * gap) + up;
        let length = format!("{:.2} mm along {}", b.x - a.x, section.plane.along());
        drawing.length([DVec2::new(a.x, 0.0) + below, DVec2::new(b.x, 0.0) + below], &length);
    }
    let bar = floor_125(0.4 * half);
    let foot = DVec2::new(half, 0.0);
    drawing.lines(EDGE, [&[foot, foot - DVec2::new(bar, 0.0)][..]]);
    drawing.text(foot, [0.0, 16.0], Anchor::End, &format!("{bar} mm"));
    let deepest = all.iter().map(|(_, [_, b])| b.y).fold(0.0, f64::max);
    Some(Figure {
        title: "Cross-sections".into(),
        body: drawing.svg("Cross-sections of the part through its axis"),
        caption: format!(
            "Cut through the axis, to scale; the base is below, and the part is {deepest:.2} mm high there."
        ),
    })
}
