//! Requests that were let in, and what is sent back.

use serde_json::Value as Json;
use std::fs::File;

/// What is sent back.
#[derive(Debug)]
pub(super) enum Content {
    /// The first page, whose scripts and styles have this nonce.
    Page {
        /// HTML.
        html: String,
        /// The nonce.
        nonce: String,
    },
    /// JSON.
    Json(Json),
    /// PNG.
    Png(Vec<u8>),
    /// A file of the last build.
    File(String, File),
}

/// A request that has been let in.
#[derive(Debug)]
pub(super) struct Asked<'a> {
    /// Verb.
    pub method: &'a str,
    /// Address without its query.
    pub path: &'a str,
    /// Body.
    pub body: &'a [u8],
}
