//! Why a request could not be answered.

use crate::pipeline::all_errors;
use crate::results::ToldError;
use serde_json::{Value as Json, json};
use std::error::Error;

/// Status of an answer that says what is wrong with the text.
const UNPROCESSABLE: u16 = 422;

/// Status of an answer in whose place a newer one comes.
const CONFLICT: u16 = 409;

/// A request that could not be answered.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RequestFailure {
    /// Status of HTTP.
    pub status: u16,
    /// The errors, at least one.
    pub errors: Vec<ToldError>,
}

impl RequestFailure {
    /// A failure that is a sentence.
    pub(super) fn said(status: u16, sentence: impl Into<String>) -> Self {
        Self { status, errors: vec![ToldError::said(sentence)] }
    }

    /// A failure because of what is in the text, or in the request.
    pub(super) fn of_text(sentence: impl Into<String>) -> Self {
        Self::said(UNPROCESSABLE, sentence)
    }

    /// A failure because a newer request takes the place of this one.
    pub(super) fn superseded() -> Self {
        Self::said(CONFLICT, "a newer request took the place of this one")
    }

    /// Whether a newer request takes the place of this one.
    pub(super) fn is_superseded(&self) -> bool {
        self.status == CONFLICT
    }

    /// `{"error": ...}` with the first error, and all of them.
    pub(super) fn json(&self) -> Json {
        json!({ "error": self.errors.first(), "errors": self.errors })
    }
}

impl<E: Error + 'static> From<E> for RequestFailure {
    fn from(error: E) -> Self {
        Self { status: UNPROCESSABLE, errors: all_errors(&error) }
    }
}
