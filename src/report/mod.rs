//! Results -> bytes: JSON, CSV, HTML, pictures and the terminal's summary. It computes nothing.
//!
//! A command's result is a struct whose fields are its JSON, and an [`Answer`]: rows of facts in words, from
//! which one renderer makes the terminal's text and one the page.

mod answer;
mod blur;
mod build;
mod build_forecast;
mod fact_rows;
mod frame;
mod machining;
mod maps;
mod measured;
mod page;
mod plot;
mod render;
mod replay;
mod sharpness;
mod text_layout;
mod tolerance;
mod unwrap;
mod visible;

pub use answer::{Answer, AnswerRows, Head, ToRows};
pub use maps::{form_picture, gouge_picture, pixel_error_picture};
pub(crate) use plot::{Failure, svg};
pub use text_layout::TextLayout;
pub use visible::visible;
