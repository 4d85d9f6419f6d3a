//! Diagrams of lines, areas, points and texts, whose unit is a thirteenth of a letter's height.

use crate::geom::DVec2;
use crate::raster::Srgb;

/// Width and height of a letter's cell, units: those of the bitmap letters; a page's letters are hardly wider.
pub(crate) const LETTER: [f64; 2] = [7.0, 13.0];

/// Width of a text, units.
pub(crate) fn text_width(text: &str) -> f64 {
    LETTER[0] * text.chars().count() as f64
}

/// What a colour stands for; the page's style sheet has each in a light and a dark shade.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ink {
    /// Of texts and of edges.
    Text,
    /// Of what is less important.
    Faint,
    /// Of grid lines.
    Line,
    /// Of the ground.
    Paper,
    /// First of the colours that the colour-blind tell apart (M. Okabe and K. Ito, *Color universal design*, 2008).
    Blue,
    /// Vermilion, the second.
    Red,
    /// Bluish green, the third.
    Green,
}

impl Ink {
    /// Its name in the style sheet.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Text => "ink",
            Self::Faint => "faint",
            Self::Line => "line",
            Self::Paper => "paper",
            Self::Blue => "blue",
            Self::Red => "red",
            Self::Green => "green",
        }
    }

    /// Its light shade.
    pub(super) fn srgb(self) -> Srgb {
        match self {
            Self::Text => [0x1c, 0x1f, 0x23],
            Self::Faint => [0x5b, 0x63, 0x70],
            Self::Line => [0xd5, 0xd9, 0xdf],
            Self::Paper => [0xff; 3],
            Self::Blue => [0x00, 0x72, 0xb2],
            Self::Red => [0xd5, 0x5e, 0x00],
            Self::Green => [0x00, 0x9e, 0x73],
        }
    }
}

/// How a line is interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dash {
    /// Not at all.
    Solid,
    /// Long strokes.
    Dashed,
    /// Short strokes.
    Dotted,
}

impl Dash {
    /// Lengths of strokes and of gaps, units; none of a whole line.
    pub(super) fn lengths(self) -> Option<[f64; 2]> {
        match self {
            Self::Solid => None,
            Self::Dashed => Some([6.0, 4.0]),
            Self::Dotted => Some([2.0, 3.0]),
        }
    }
}

/// The look of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    /// Its colour.
    pub ink: Ink,
    /// Its width, units.
    pub width: f64,
    /// Its interruptions.
    pub dash: Dash,
}

impl Stroke {
    /// A whole line.
    pub(crate) fn solid(ink: Ink, width: f64) -> Self {
        Self { ink, width, dash: Dash::Solid }
    }

    /// A dashed line.
    pub(crate) fn dashed(ink: Ink, width: f64) -> Self {
        Self { ink, width, dash: Dash::Dashed }
    }
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    /// A disc.
    Disc,
    /// A square on its side.
    Square,
    /// A triangle on its side.
    Triangle,
    /// A circle around another point.
    Ring,
}

impl Marker {
    /// Corners around `at`, for a disc of this radius of about the same area; none of round ones.
    pub(super) fn corners(self, at: DVec2, radius: f64) -> Option<Vec<DVec2>> {
        let corners: &[[f64; 2]] = match self {
            Self::Disc | Self::Ring => return None,
            Self::Square => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
            Self::Triangle => &[[0.0, -1.4], [1.25, 0.8], [-1.25, 0.8]],
        };
        Some(corners.iter().map(|corner| at + DVec2::from_array(*corner) * radius).collect())
    }
}

/// Where a text is beside its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

impl Anchor {
    /// The share of a text's width that is left of its place.
    pub(super) fn share(self) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => 0.5,
            Self::End => 1.0,
        }
    }
}

/// What is drawn; places are in units, y downwards.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Mark {
    /// Lines of one look.
    Lines { stroke: Stroke, lines: Vec<Vec<DVec2>> },
    /// The inside of an outline, from 0 (unseen) to 1 opaque.
    Area { ink: Ink, opacity: f64, corners: Vec<DVec2> },
    /// A point.
    Point { ink: Ink, marker: Marker, at: DVec2, radius: f64 },
    /// A line of text on a base line, which is read from below if it is turned.
    Text { ink: Ink, at: DVec2, anchor: Anchor, is_turned: bool, text: String },
}

/// A diagram that is being drawn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Diagram {
    /// Width and height, units.
    pub size: DVec2,
    pub(super) marks: Vec<Mark>,
}

impl Diagram {
    /// An empty diagram of a width and height, units.
    pub(crate) fn new(width: f64, height: f64) -> Self {
        Self { size: DVec2::new(width, height), marks: Vec::new() }
    }

    /// Adds lines, each through its places; those that are not finite are left out.
    pub(crate) fn lines(&mut self, stroke: Stroke, lines: impl IntoIterator<Item = Vec<DVec2>>) {
        let finite = |line: Vec<DVec2>| line.into_iter().filter(|at| at.is_finite()).collect();
        let lines: Vec<Vec<DVec2>> = lines.into_iter().map(finite).collect();
        self.marks.push(Mark::Lines { stroke, lines });
    }

    /// Adds the inside of an outline, from 0 (unseen) to 1 opaque.
    pub(crate) fn area(&mut self, ink: Ink, opacity: f64, corners: Vec<DVec2>) {
        if corners.iter().all(|at| at.is_finite()) {
            self.marks.push(Mark::Area { ink, opacity, corners });
        }
    }

    /// Adds a point of a radius in units.
    pub(crate) fn point(&mut self, ink: Ink, marker: Marker, at: DVec2, radius: f64) {
        if at.is_finite() {
            self.marks.push(Mark::Point { ink, marker, at, radius });
        }
    }

    /// Adds a line of text whose base line goes through `at`.
    pub(crate) fn text(&mut self, ink: Ink, at: DVec2, anchor: Anchor, text: impl Into<String>) {
        self.marks.push(Mark::Text { ink, at, anchor, is_turned: false, text: text.into() });
    }

    /// Adds a line of text that is read from below, its middle at `at`.
    pub(crate) fn turned_text(&mut self, ink: Ink, at: DVec2, text: &str) {
        let (anchor, text) = (Anchor::Middle, text.into());
        self.marks.push(Mark::Text { ink, at, anchor, is_turned: true, text });
    }
}
