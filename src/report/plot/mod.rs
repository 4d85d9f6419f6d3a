//! Plots: axes with units, lines, bars, points and labels of one look, as SVG in the colours of the page and as PNG.

mod axis;
mod diagram;
mod labels;
mod panel;
mod png;
mod svg;

pub(crate) use axis::Axis;
pub(crate) use diagram::{Anchor, Dash, Diagram, Ink, LETTER, Marker, Stroke, text_width};
pub(crate) use panel::{Margins, Plot};
