//! What follows a change of a profile, in one answer: the changed text, what is wrong with it, its values, and what is seen of it. One
//! answer, because between several a browser draws the page again, on the processors that make the next one.

use super::edit::TextEdit;
use super::failure::RequestFailure;
use super::form;
use super::message::Content;
use super::routes::Studio;
use super::source::Source;
use crate::results::ToldError;
use serde::Deserialize;
use serde_json::{Value as Json, json};

/// A request to follow a change: a text, and what is changed in it.
#[derive(Debug, Deserialize)]
pub(super) struct FollowRequest {
    /// Name of the profile.
    name: String,
    /// The text before.
    text: String,
    /// Changes, one after the other.
    #[serde(default)]
    edits: Vec<TextEdit>,
    /// Whether a sketch of the mirror will do.
    #[serde(default)]
    sketch: bool,
}

impl Studio {
    /// `{"text", "errors", "keys", "values", "seen", "error"}`: the changed text; every complaint about it, as `morion check --format
    /// json` tells them, and the key of each; all values; what is seen of its design, or why there is none. Both are null where a newer
    /// change is followed.
    ///
    /// # Errors
    /// [`RequestFailure`] where an edit cannot be made; nothing of the text is changed then.
    pub(super) fn follow(&self, request: FollowRequest) -> Result<Content, RequestFailure> {
        let FollowRequest { name, text, edits, sketch } = request;
        let text = edits.iter().try_fold(text, |text, edit| edit.made(&text));
        let source = Source { name, text: text.map_err(RequestFailure::of_text)? };
        let profile = source.profile();
        let errors = profile.as_ref().err().map_or(&[][..], |failure| &failure.errors);
        let keys: Vec<_> = errors.iter().map(|error| form::key_of(&error.message)).collect();
        let mut answer = json!({
            "text": source.text,
            "errors": errors,
            "keys": keys,
            "values": form::values(&source.text),
        });
        let see = |profile| self.previewed(profile, sketch);
        let (seen, error) = told(profile.and_then(see));
        answer["seen"] = seen;
        answer["error"] = json!(error);
        Ok(Content::Json(answer))
    }
}

/// What is seen, or why nothing is; neither where the request is an old one.
fn told(seen: Result<Json, RequestFailure>) -> (Json, Option<ToldError>) {
    match seen {
        Ok(seen) => (seen, None),
        Err(failure) if failure.is_superseded() => (Json::Null, None),
        Err(failure) => (Json::Null, failure.errors.into_iter().next()),
    }
}
