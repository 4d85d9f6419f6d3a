//! Texts of a study.

use super::super::reader::Need::{self, Optional};
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, word};
use super::super::words::shown;
use super::ColumnGoal;
use serde_json::Value as Json;

/// Most letters of a label, which has a line of a plot.
const MOST_LETTERS: usize = 60;

/// What an axis or column is called in plots.
pub(super) fn label(reader: &mut ProfileReader, section: &Section) -> Option<String> {
    let must = format!("a text of 1 to {MOST_LETTERS} letters");
    let hint = "write label = \"width, mm\"";
    let label = text(reader, section, "label", (Optional, &must, hint))?;
    let is_plain = !label.value.chars().any(char::is_control);
    if is_plain && label.value.chars().count() <= MOST_LETTERS {
        return Some(label.value);
    }
    let path = section.path_of("label");
    reader.complain(
        label.at,
        format!("{path} must be {must}, found {}", shown(&label.value)),
        hint,
    );
    None
}

/// A text that is not empty.
pub(super) fn text(
    reader: &mut ProfileReader,
    section: &Section,
    key: &str,
    (need, must, hint): (Need, &str, &str),
) -> Option<Located<String>> {
    let value = reader.value(section, key, need, must, hint)?;
    let at = value.span().start;
    match value.get_ref().as_str() {
        Some(text) if !text.trim().is_empty() => Some(Located { value: text.to_owned(), at }),
        _ => {
            let path = section.path_of(key);
            let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
            reader.complain(at, message, hint);
            None
        }
    }
}

/// What is sought of an axis or column.
pub(super) fn goal(reader: &mut ProfileReader, section: &Section) -> Option<ColumnGoal> {
    let goals = [("least", ColumnGoal::Least), ("most", ColumnGoal::Most)];
    word(reader, section, "goal", &goals, "without it nothing is sought")
}

/// What kind of value it is, in words.
pub(super) fn kind(value: &Json) -> &'static str {
    match value {
        Json::Number(_) => "numbers",
        Json::Bool(_) => "true and false",
        Json::String(_) => "texts",
        _ => "lists",
    }
}
