//! An axis of a study: a key and its values.

use super::super::reader::Need::{Optional, Required};
use super::super::reader::{ProfileReader, Section, TomlValue};
use super::super::values;
use super::super::values::{Located, within};
use super::super::words::shown;
use super::fields::{goal, kind, label, text};
use super::{AxisSpec, MOST_POINTS, key_path, number};
use crate::num::rounding::significant;
use crate::num::{exp, log};
use serde_json::Value as Json;
use toml::de::DeValue;

/// Digits of values between `from` and `to`: enough for any step, and 0.3 stays 0.3.
const DIGITS: usize = 12;
/// Most values of all axes together: they are kept in memory.
const MOST_VALUES: usize = 2 * MOST_POINTS;
/// Hint at the two forms of an axis.
const FORMS: &str = "write values = [40, 60], or from = 40, to = 60 and count = 5";

/// An axis, and where its key stands.
pub(super) struct AxisEntry {
    pub spec: AxisSpec,
    pub at: usize,
}

/// The axis of a table, after these.
pub(super) fn axis(
    reader: &mut ProfileReader,
    section: &Section,
    earlier: &[AxisEntry],
) -> Option<AxisEntry> {
    let must = "a key of a profile, as part.width_mm";
    let hint = "write key = \"part.width_mm\"";
    let key = text(reader, section, "key", (Required, must, hint));
    let label = label(reader, section);
    let goal = goal(reader, section);
    let range = ["from", "to", "count"].iter().any(|key| section.has(key));
    let logarithms = [("linear", false), ("log", true)];
    let scale = values::word(reader, section, "scale", &logarithms, "without it, linear");
    let is_logarithmic = scale.unwrap_or(false);
    let values = match (section.has("values"), range) {
        (true, false) => listed(reader, section),
        (false, true) => spaced(reader, section, is_logarithmic, earlier),
        (is_both, _) => {
            let found = if is_both { "both" } else { "nothing" };
            let message = format!("axis must have values, or from, to and count, found {found}");
            reader.missing(section, message, FORMS);
            None
        }
    };
    let first = values.as_ref().and_then(|values| values.first());
    if goal.is_some() && first.is_some_and(|first| !first.is_number()) {
        let found = first.map_or("", kind);
        let message = format!("an axis with a goal must have numbers, found {found}");
        reader.complain(section.at, message, "leave the goal out, or sweep an entry: key[1]");
    }
    let count = values.as_ref().map(Vec::len);
    let paired_with = pair(reader, section, count, earlier);
    let key = key?;
    let Located { value: key, at } = key;
    let steps = key_path::steps(&key).ok_or_else(|| {
        "write the table and the key, as part.width_mm; docs/profile.md lists all".to_owned()
    });
    match steps.and_then(|steps| key_path::check(&steps).map(|()| steps)) {
        Ok(path) => {
            let spec =
                AxisSpec { key, path, label, values: values?, is_logarithmic, paired_with, goal };
            Some(AxisEntry { spec, at })
        }
        Err(hint) => {
            let message = format!("axis.key must be {must}, found {}", shown(&key));
            reader.complain(at, message, &hint);
            None
        }
    }
}

/// The values of a list, all of one kind.
fn listed(reader: &mut ProfileReader, section: &Section) -> Option<Vec<Json>> {
    let must = "a list of values of one kind, at least one";
    let value = reader.value(section, "values", Required, must, FORMS)?;
    let items = match value.get_ref() {
        DeValue::Array(items) if !items.is_empty() => items,
        _ => {
            let message = format!("axis.values must be {must}, found {}", reader.quote_type(value));
            reader.complain(value.span().start, message, FORMS);
            return None;
        }
    };
    let mut values: Vec<Json> = Vec::with_capacity(items.len());
    for item in items {
        let value = json(reader, item)?;
        if let Some(first) = values.first().filter(|first| kind(first) != kind(&value)) {
            let message = format!(
                "axis.values must be of one kind, found {} and {}",
                kind(first),
                kind(&value)
            );
            reader.complain(item.span().start, message, "sweep each kind by a study of its own");
            return None;
        }
        values.push(value);
    }
    Some(values)
}

/// A value of the profile; a complaint where it is none that an axis can have.
fn json(reader: &mut ProfileReader, value: &TomlValue) -> Option<Json> {
    match value.get_ref() {
        DeValue::Boolean(flag) => Some(Json::Bool(*flag)),
        DeValue::String(text) => Some(Json::String(text.to_string())),
        DeValue::Array(items) => items.iter().map(|item| json(reader, item)).collect(),
        _ => {
            let must = "numbers, texts, true and false, or lists of them";
            within(reader, "axis.values", value, must, FORMS, |_| true).map(number)
        }
    }
}

/// Equally spaced values.
fn spaced(
    reader: &mut ProfileReader,
    section: &Section,
    is_logarithmic: bool,
    earlier: &[AxisEntry],
) -> Option<Vec<Json>> {
    let (must, hint) = match is_logarithmic {
        true => ("a number over 0", "a logarithmic axis has no 0"),
        false => ("a number", FORMS),
    };
    let allowed = |x: f64| !is_logarithmic || x > 0.0;
    let mut end = |key| values::number(reader, section, key, Required, must, hint, allowed);
    let [from, to] = ["from", "to"].map(&mut end);
    let must = format!("a whole number from 2 to {MOST_POINTS}");
    let hint = "how many values there are, both ends included";
    let is_count = |x: f64| (2.0..=MOST_POINTS as f64).contains(&x) && x.fract() == 0.0;
    let count = values::number(reader, section, "count", Required, &must, hint, is_count)?;
    let together = earlier.iter().map(|axis| axis.spec.values.len()).sum::<usize>();
    if together + count.value as usize > MOST_VALUES {
        let message =
            format!("the axes of a study must have at most {MOST_VALUES} values together");
        reader.complain(count.at, message, "take fewer values");
        return None;
    }
    let (from, to, count) = (from?.value, to?.value, count.value as usize);
    let value = |k: usize| {
        let share = k as f64 / (count - 1) as f64;
        let between = match is_logarithmic {
            true => exp((1.0 - share) * log(from) + share * log(to)),
            false => (1.0 - share) * from + share * to,
        };
        match k {
            0 => from,
            _ if k + 1 == count => to,
            _ => significant(between, DIGITS),
        }
    };
    Some((0..count).map(|k| number(value(k))).collect())
}

/// The axis that this one goes with; `count` values of its own.
fn pair(
    reader: &mut ProfileReader,
    section: &Section,
    count: Option<usize>,
    earlier: &[AxisEntry],
) -> Option<usize> {
    let must = "the key of an earlier axis";
    let hint = "an axis with paired_with takes its first value with the first one there, and so on";
    let named = text(reader, section, "paired_with", (Optional, must, hint))?;
    let Some(found) = earlier.iter().position(|axis| axis.spec.key == named.value) else {
        let message = format!("axis.paired_with must be {must}, found {}", shown(&named.value));
        reader.complain(named.at, message, hint);
        return None;
    };
    let wanted = earlier[found].spec.values.len();
    if let Some(count) = count.filter(|count| *count != wanted) {
        let message =
            format!("axis must have the {wanted} values of {}, found {count}", named.value);
        reader.complain(named.at, message, "give both as many values");
    }
    Some(earlier[found].spec.paired_with.unwrap_or(found))
}
