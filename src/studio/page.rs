//! The one page, whole: its scripts and styles are in it, so that the token is all that a browser has to send.

use super::failure::RequestFailure;
use super::message::Content;
use crate::packed_text::{PackedText, packed_text};
use crate::report::{STYLE, THREE, VIEWER};
use std::fmt::Write;

static HTML: PackedText = packed_text!("studio.html");
static CSS: PackedText = packed_text!("studio.css");
static FORM: PackedText = packed_text!("form.js");
static STUDIO: PackedText = packed_text!("studio.js");

/// The page; its scripts and styles have a nonce of their own each time.
///
/// # Errors
/// [`RequestFailure`] where the system has no random numbers.
pub(super) fn page() -> Result<Content, RequestFailure> {
    let mut bytes = [0; 16];
    let none = |_| RequestFailure::said(500, "the system has no random numbers");
    getrandom::fill(&mut bytes).map_err(none)?;
    let mut nonce = String::new();
    for byte in bytes {
        // (A string takes whatever is written.)
        let _ = write!(nonce, "{byte:02x}");
    }
    let script = |text: &str| format!("<script nonce=\"{nonce}\">\n{text}\n</script>\n");
    let scripts = [
        script(&format!("/*! three.js, (c) three.js authors, MIT licence */\n{}", THREE.text())),
        // The viewer draws the part that the page holds when it is called.
        script(&format!("function drawPart() {{\n{VIEWER}\n}}")),
        script(FORM.text()),
        script(STUDIO.text()),
    ];
    let style = format!("<style nonce=\"{nonce}\">\n{STYLE}{}</style>", CSS.text());
    let html = HTML
        .text()
        .replace("<!-- style -->", &style)
        .replace("<!-- scripts -->", &scripts.concat());
    Ok(Content::Page { html, nonce })
}
