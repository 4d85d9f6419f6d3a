//! Charts: axes with units, lines, bars, points and labels of one look, as SVG in the colours of the page and as PNG.

mod axis;
mod labels;
mod picture;
mod plot;
mod png;
mod svg;

pub(crate) use axis::Axis;
pub(crate) use picture::{Anchor, Dash, Ink, LETTER, Marker, Picture, Stroke, text_width};
pub(crate) use plot::{Margins, Plot};
