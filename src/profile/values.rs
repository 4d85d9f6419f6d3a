//! Reading one key: a number, a pair, a flag or one of a few words.

use toml::de::DeValue;

use super::reader::Need::{Optional, Required};
use super::reader::{Need, Reader, Section, Value};
use super::schema;
use super::words::{figure, list};

const FINITE: &str = "every figure of a profile must be finite";

/// A number that `allowed` lets pass.
pub(super) fn number(
    reader: &mut Reader,
    section: &Section,
    key: &str,
    need: Need,
    must: &str,
    hint: &str,
    allowed: impl Fn(f64) -> bool,
) -> Option<f64> {
    let value = reader.value(section, key, need, must, hint)?;
    let path = section.path_of(key);
    within(reader, &path, value, must, hint, allowed)
}

/// What a list of two numbers is for.
pub(super) struct Pair<'h> {
    pub(super) key: &'h str,
    pub(super) parts: &'h str,
    pub(super) each: &'h str,
    /// Hint if the list has the wrong form.
    pub(super) form: &'h str,
    /// Hint if a number is out of its limits.
    pub(super) limit: &'h str,
}

/// Two numbers in a list, each of which `allowed` lets pass, and where the list stands.
pub(super) fn pair(
    reader: &mut Reader,
    section: &Section,
    pair: &Pair,
    allowed: impl Fn(f64) -> bool,
) -> Option<([f64; 2], usize)> {
    let path = section.path_of(pair.key);
    let must = format!("{}, each {}", pair.parts, pair.each);
    let value = reader.value(section, pair.key, Required, &must, pair.form)?;
    let at = value.span().start;
    let DeValue::Array(items) = value.get_ref() else {
        let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
        reader.complain(at, message, pair.form);
        return None;
    };
    if items.len() != 2 {
        let count = match items.len() {
            0 => "an empty list".to_owned(),
            1 => "a list of one".to_owned(),
            n => format!("a list of {n}"),
        };
        let message = format!("{path} must be {must}, found {count}");
        reader.complain(at, message, pair.form);
        return None;
    }
    let mut figures = [None; 2];
    for (figure, item) in figures.iter_mut().zip(items) {
        *figure = within(reader, &path, item, pair.each, pair.limit, &allowed);
    }
    Some(([figures[0]?, figures[1]?], at))
}

/// The number that a value is, if it is one and `allowed` lets it pass; else a complaint.
fn within(
    reader: &mut Reader,
    path: &str,
    value: &Value,
    must: &str,
    hint: &str,
    allowed: impl Fn(f64) -> bool,
) -> Option<f64> {
    let figure = figure(value);
    let hint = match figure {
        Some(f) if !f.is_finite() => FINITE,
        Some(f) if allowed(f) => return Some(f),
        Some(_) => hint,
        None if value.get_ref().is_str() => "write numbers without quotes",
        None => hint,
    };
    let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
    reader.complain(value.span().start, message, hint);
    None
}

/// True or false; may be absent.
pub(super) fn flag(reader: &mut Reader, section: &Section, key: &str) -> Option<bool> {
    let must = "true or false";
    let hint = "without quotes, in lower case";
    let value = reader.value(section, key, Optional, must, hint)?;
    if let DeValue::Boolean(flag) = value.get_ref() {
        return Some(*flag);
    }
    let path = section.path_of(key);
    let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
    reader.complain(value.span().start, message, hint);
    None
}

/// What one of a few words stands for.
pub(super) fn word<T: Copy>(
    reader: &mut Reader,
    section: &Section,
    key: &str,
    words: &[(&str, T)],
    hint: &str,
) -> Option<T> {
    let names: Vec<&str> = words.iter().map(|(name, _)| *name).collect();
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    let quoted: Vec<&str> = quoted.iter().map(String::as_str).collect();
    let must = list(&quoted, "or");
    let value = reader.value(section, key, Optional, &must, hint)?;
    let found = value.get_ref().as_str();
    if let Some((_, meaning)) = words.iter().find(|(name, _)| Some(*name) == found) {
        return Some(*meaning);
    }
    let hint = match found.and_then(|found| schema::nearest(found, &names)) {
        Some(meant) => format!("did you mean \"{meant}\"?"),
        None => hint.to_owned(),
    };
    let path = section.path_of(key);
    let found = match found {
        Some(_) => reader.quote(value),
        None => reader.quote_type(value),
    };
    reader.complain(value.span().start, format!("{path} must be {must}, found {found}"), &hint);
    None
}
