//! Results -> bytes: JSON, CSV, HTML, pictures and the terminal's summary. It computes nothing.
//!
//! A command's result is a struct whose fields are its JSON, and an [`Answer`]: rows of facts in words, from
//! which one renderer makes the terminal's text and one the page.

mod answer;
mod blur;
mod build;
mod build_figures;
mod build_forecast;
mod cavity;
mod drawing;
mod fact_rows;
mod frame;
mod inspection;
mod inspection_sheet;
mod least_error;
mod machining;
mod maps;
mod meanings;
mod measured;
mod milling;
mod milling_plots;
mod page;
mod plot;
mod program;
mod render;
mod replay;
mod sharpness;
mod sweep;
mod table;
mod text_layout;
mod tolerance;
mod tool;
mod unwanted_views;
mod unwrap;
mod visible;

pub(crate) use answer::json_text;
pub use answer::{Answer, AnswerRows, Head, ToRows};
pub use build_figures::{BuildFigures, PartFigures};
pub use inspection::inspection_csv;
pub use inspection_sheet::{InspectionMap, inspection_sheet};
pub use maps::{curl_map, design_error_map, form_map, gouge_map, pixel_error_map, spot_map};
pub use milling::LeftPicture;
#[cfg(feature = "studio")]
pub(crate) use page::{MapLetter, STYLE, THREE, VIEWER, map_letters};
pub(crate) use plot::{
    Anchor, Axis, Dash, Diagram, Ink, LETTER, Margins, Marker, Plot, Stroke, text_width,
};
#[cfg(feature = "studio")]
pub(crate) use sharpness::PlainSharpness;
pub use text_layout::TextLayout;
pub use visible::visible;
