//! The one page, whole: its scripts and styles are in it, so that the token is all that a browser has to send.

use super::failure::RequestFailure;
use super::message::Content;
use crate::report::{STYLE, THREE, VIEWER};
use std::fmt::Write;

const HTML: &str = include_str!("assets/studio.html");
const CSS: &str = include_str!("assets/studio.css");
const FORM: &str = include_str!("assets/form.js");
const STUDIO: &str = include_str!("assets/studio.js");

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
        script(FORM),
        script(STUDIO),
    ];
    let style = format!("<style nonce=\"{nonce}\">\n{STYLE}{CSS}</style>");
    let html =
        HTML.replace("<!-- style -->", &style).replace("<!-- scripts -->", &scripts.concat());
    Ok(Content::Page { html, nonce })
}
