//! The form: every key of a profile with what it is, from the table of the schema and the page of keys.

use crate::packed_text::{PackedText, packed_text};
use crate::profile::{LISTS, TABLES};
use serde_json::{Map, Value as Json, json};
use toml_edit::{DocumentMut, Item, Value};

/// The page of all keys: a row for each, `| key | unit or type | range and default | meaning |`.
static PAGE: PackedText = packed_text!("profile.md");

/// The tables of a profile, each with its keys, and with the tables of which one is chosen; not those of which there
/// may be several, which are written in the text.
pub(super) fn form() -> Json {
    let is_several = |path: &str| LISTS.contains(&path.split('.').next().unwrap_or(path));
    let once = TABLES.iter().filter(|(path, _)| !is_several(path));
    once.map(|(path, keys)| table(path, keys)).collect()
}

fn is_table(path: &str) -> bool {
    TABLES.iter().any(|(table, _)| *table == path)
}

fn joined(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}

fn table(path: &str, keys: &[&str]) -> Json {
    let (tables, values): (Vec<&str>, Vec<&str>) =
        keys.iter().partition(|key| is_table(&joined(path, key)));
    // One camera, one projection, one layout, one method.
    let is_choice = !path.is_empty() && values.is_empty() && !tables.is_empty();
    let choices = if is_choice { tables } else { Vec::new() };
    let values: Vec<Json> = values.iter().map(|key| field(path, key)).collect();
    json!({ "path": path, "choices": choices, "keys": values })
}

fn field(table: &str, key: &str) -> Json {
    let path = joined(table, key);
    let [unit, range, meaning] = row(&path).unwrap_or([""; 3]);
    let kind = kind(unit);
    let mut words = if kind == "word" || kind == "words" { words(range) } else { Vec::new() };
    if words.len() == 1 {
        // The default of words that stand elsewhere.
        words.clear();
    }
    let bounds = bounds(range);
    json!({
        "path": path, "key": key, "kind": kind, "words": words, "limits": bounds,
        "unit": unit, "range": plain(range), "meaning": plain(meaning),
    })
}

/// The words of a cell: without marks of code, and of links their texts.
fn plain(cell: &str) -> String {
    let mut text = String::new();
    for (k, part) in cell.replace('`', "").split("](").enumerate() {
        let part = if k == 0 { part } else { part.split_once(')').map_or("", |(_, rest)| rest) };
        text += part;
    }
    // (What is a link's text stands in brackets; ranges of numbers have a comma.)
    match text.split_once("see [") {
        Some((before, after)) => format!("{before}see {after}"),
        None => text,
    }
}

/// The cells of a key's row but for the key.
fn row(path: &str) -> Option<[&'static str; 3]> {
    PAGE.text().lines().find_map(|line| {
        let cells = line.strip_prefix("| `")?.strip_prefix(path)?.strip_prefix("` | ")?;
        let mut cells = cells.trim_end_matches(" |").splitn(3, " | ");
        Some([cells.next()?, cells.next()?, cells.next()?])
    })
}

/// The kind of field for a unit or type.
fn kind(unit: &str) -> &'static str {
    match unit {
        "text" | "file name" => "text",
        "true or false" => "flag",
        "word" => "word",
        "list of words" => "words",
        "whole number" => "whole",
        "list of numbers" => "toml",
        _ if unit.starts_with("[[") => "toml",
        _ if unit.starts_with('[') => "pair",
        _ => "number",
    }
}

/// The words in quotes.
fn words(range: &str) -> Vec<&str> {
    range.split('`').filter_map(|part| part.strip_prefix('"')?.strip_suffix('"')).collect()
}

/// Both numbers of a range that begins with `A to B`, or the one of `A or more`.
fn bounds(range: &str) -> [Option<f64>; 2] {
    let range = range.strip_prefix("strictly inside ").unwrap_or(range);
    let number = |text: &str| text.trim_end_matches([',', ';']).parse::<f64>().ok();
    let mut parts = range.split(' ');
    match [parts.next(), parts.next(), parts.next()] {
        [Some(low), Some("to"), Some(high)] => {
            let is_million = parts.next().is_some_and(|word| word.starts_with("million"));
            [number(low), number(high).map(|x| if is_million { 1e6 * x } else { x })]
        }
        [Some(low), Some("or"), _] => [number(low), None],
        _ => [None, None],
    }
}

/// Every value of a text that is TOML, by its path: with the value, or its TOML where JSON has none, and its line.
pub(super) fn values(text: &str) -> Option<Json> {
    crate::profile::text_of_profile("the text", text.as_bytes()).ok()?;
    let document = text.parse::<DocumentMut>().ok()?;
    let mut found = Map::new();
    collect(document.as_item(), "", &mut found);
    Some(found.into())
}

fn collect(item: &Item, path: &str, found: &mut Map<String, Json>) {
    if let Some(table) = item.as_table_like() {
        if !path.is_empty() {
            found.insert(path.to_owned(), json!({ "table": true }));
        }
        for (key, item) in table.iter() {
            collect(item, &joined(path, key), found);
        }
    } else if let Some(value) = item.as_value() {
        // Without the comment beside it.
        let toml = value.clone().decorated("", "").to_string();
        found.insert(path.to_owned(), json!({ "value": json_of(value), "toml": toml }));
    }
}

/// A value as JSON; null where it is none there.
fn json_of(value: &Value) -> Json {
    match value {
        Value::String(text) => text.value().as_str().into(),
        Value::Integer(number) => (*number.value()).into(),
        Value::Float(number) => (*number.value()).into(),
        Value::Boolean(flag) => (*flag.value()).into(),
        Value::Array(items) => items.iter().map(json_of).collect(),
        Value::Datetime(_) | Value::InlineTable(_) => Json::Null,
    }
}

/// The key of a profile that a complaint is about: it begins with it.
pub(super) fn key_of(message: &str) -> Option<&str> {
    let word = message.split(' ').next()?.trim_end_matches(':');
    let (table, key) = word.rsplit_once('.').unwrap_or(("", word));
    let is_known = TABLES.iter().any(|(path, keys)| *path == table && keys.contains(&key));
    is_known.then_some(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_has_its_field_and_meaning() {
        let form = form();
        let fields = form.as_array().unwrap().iter().flat_map(|t| t["keys"].as_array().unwrap());
        let mut count = 0;
        for field in fields {
            assert_ne!(field["meaning"], "", "{field}");
            let is_word = field["kind"] == "word" && field["range"].to_string().contains('"');
            let words = field["words"].as_array().unwrap();
            let is_elsewhere = field["meaning"] == "as in tolerance.limits" || words.len() > 1;
            assert!(!is_word || is_elsewhere, "{field}");
            count += 1;
        }
        assert!(count > 100, "{count}");
    }

    #[test]
    fn ranges_words_and_choices_are_those_of_the_page() {
        assert_eq!(bounds("0.001 to 1e6; required"), [Some(0.001), Some(1e6)]);
        assert_eq!(bounds("100 to 40 million; excludes"), [Some(100.0), Some(4e7)]);
        assert_eq!(bounds("0 or more; default"), [Some(0.0), None]);
        assert_eq!(bounds("rising; required"), [None, None]);
        assert_eq!(words("`\"refit\"` (default) or `\"section\"`"), ["refit", "section"]);
        let camera = form().as_array().unwrap()[1].clone();
        assert_eq!(camera["choices"], json!(["orthographic", "pinhole", "calibrated"]));
        assert_eq!(key_of("part.width_mm must be positive"), Some("part.width_mm"));
        assert_eq!(key_of("the text must be TOML"), None);
    }

    #[test]
    fn values_are_found_in_every_way_to_write_them() {
        let text = "a.b = 1\n[c]\nd = { e = [1.5, 2] }\nf = \"x\" # y\ng = inf\n";
        let found = values(text).unwrap();
        assert_eq!(found["a.b"]["value"], json!(1));
        assert_eq!(found["c.d.e"]["value"], json!([1.5, 2]));
        assert_eq!(found["c.f"], json!({ "value": "x", "toml": "\"x\"" }).clone());
        assert_eq!(found["c.g"]["value"], Json::Null);
        assert!(values("a = [").is_none());
    }
}
