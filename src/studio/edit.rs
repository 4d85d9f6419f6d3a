//! Changes of single values in a profile's text; comments, order and unknown keys stay.

use crate::profile::{KeyStep, put, set_value};
use serde::Deserialize;
use serde_json::Value as Json;
use toml_edit::{DocumentMut, InlineTable, Item, Table, Value};

/// A change of a text.
#[derive(Debug, Deserialize)]
pub(super) struct TextEdit {
    /// Keys from the outermost table to the value, or to the table of which another one is taken.
    pub path: Vec<String>,
    /// Entry of a list.
    #[serde(default)]
    pub index: Option<usize>,
    /// What is changed.
    #[serde(flatten)]
    pub change: Change,
}

/// A change of what the path leads to.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Change {
    /// A value; null leaves the key out.
    Value(Json),
    /// A value as TOML.
    Toml(String),
    /// Another name of the one table in it, of those in `among`.
    Take {
        /// The name.
        name: String,
        /// All that there may be.
        among: Vec<String>,
    },
}

impl TextEdit {
    /// The changed `text`.
    ///
    /// # Errors
    /// A sentence where the text is no TOML, or the path leads through something that is no table.
    pub(super) fn made(&self, text: &str) -> Result<String, String> {
        crate::profile::text_of_profile("the text", text.as_bytes())
            .map_err(|complaints| complaints.to_string())?;
        let document = text.parse::<DocumentMut>();
        let mut document = document.map_err(|error| format!("the text must be TOML: {error}"))?;
        let Some((last, tables)) = self.path.split_last() else {
            return Err("the path must name a key".into());
        };
        match &self.change {
            Change::Value(Json::Null) => remove(document.as_item_mut(), tables, last),
            Change::Value(json) => {
                let keys = self.path.iter().cloned().map(KeyStep::Key);
                let steps: Vec<KeyStep> = keys.chain(self.index.map(KeyStep::Entry)).collect();
                set_value(&mut document, &steps, json)?;
            }
            Change::Toml(text) => {
                let value = text.trim().parse::<Value>();
                let value = value.map_err(|_| format!("{last} must be a TOML value"))?;
                let table = opened(document.as_item_mut(), tables)?.as_table_like_mut();
                put(table.ok_or_else(|| format!("{last} is in no table"))?, last, value);
            }
            Change::Take { name, among } => take(document.as_item_mut(), &self.path, name, among)?,
        }
        Ok(document.to_string())
    }
}

/// The table that `path` leads to, made where it is not there.
fn opened<'d>(mut item: &'d mut Item, path: &[String]) -> Result<&'d mut Item, String> {
    for (k, key) in path.iter().enumerate() {
        let is_last = k + 1 == path.len();
        let is_inline = item.is_value();
        let table = item.as_table_like_mut().ok_or_else(|| format!("{key} is in no table"))?;
        if table.get(key).is_none_or(Item::is_none) {
            let mut made = Table::new();
            made.set_implicit(!is_last);
            let inline = || Item::Value(Value::InlineTable(InlineTable::new()));
            table.insert(key, if is_inline { inline() } else { Item::Table(made) });
        }
        item = table.get_mut(key).ok_or_else(|| format!("{key} cannot be made"))?;
    }
    Ok(item)
}

/// Leaves out a key, if it is there.
fn remove(mut item: &mut Item, path: &[String], last: &str) {
    for key in path {
        let Some(next) = item.as_table_like_mut().and_then(|table| table.get_mut(key)) else {
            return;
        };
        item = next;
    }
    if let Some(table) = item.as_table_like_mut() {
        table.remove(last);
    }
}

/// Gives the table of `among` that is at `path` the name `name`, with all that it holds.
fn take(root: &mut Item, path: &[String], name: &str, among: &[String]) -> Result<(), String> {
    if !among.iter().any(|other| other == name) {
        return Err(format!("{name} is none of the names there are"));
    }
    let item = opened(root, path)?;
    let is_inline = item.is_value();
    let table = item.as_table_like_mut().ok_or("the path leads to no table")?;
    if table.contains_key(name) {
        return Ok(());
    }
    let old = among.iter().find(|other| table.contains_key(other));
    let held = old.and_then(|old| table.remove(old)).unwrap_or_else(|| match is_inline {
        true => Item::Value(Value::InlineTable(InlineTable::new())),
        false => Item::Table(Table::new()),
    });
    table.insert(name, held);
    if let Some(table) = item.as_table_mut() {
        table.set_implicit(true);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::{Profile, shipped};
    use serde_json::json;

    fn edited(text: &str, edit: Json) -> Result<String, String> {
        serde_json::from_value::<TextEdit>(edit).unwrap().made(text)
    }

    const TEXT: &str = "# kept\n[part] # beside\nwidth_mm = 60 # wide\nbase_mm = 5.5\nmine = 1\n\
                        [camera.orthographic]\npixels = [640, 480] # frame\n";

    #[test]
    fn one_value_changes_and_everything_else_stays() {
        let width = edited(TEXT, json!({ "path": ["part", "width_mm"], "value": 61.5 })).unwrap();
        assert_eq!(width, TEXT.replace("= 60 #", "= 61.5 #"));
        let base = edited(TEXT, json!({ "path": ["part", "base_mm"], "value": 6 })).unwrap();
        assert_eq!(base, TEXT.replace("5.5", "6.0"));
        let path = json!(["camera", "orthographic", "pixels"]);
        let rows = edited(TEXT, json!({ "path": path, "index": 1, "value": 481 })).unwrap();
        assert_eq!(rows, TEXT.replace("480", "481"));
        let all = edited(TEXT, json!({ "path": path, "value": [1, 2] })).unwrap();
        assert_eq!(all, TEXT.replace("[640, 480]", "[1, 2]"));
        let none = edited(TEXT, json!({ "path": ["part", "base_mm"], "value": null })).unwrap();
        assert_eq!(none, TEXT.replace("base_mm = 5.5\n", ""));
        let new = edited(TEXT, json!({ "path": ["mesh", "chord_um"], "value": 2 })).unwrap();
        assert_eq!(new, format!("{TEXT}\n[mesh]\nchord_um = 2\n"));
    }

    #[test]
    fn another_table_takes_the_place_of_one_with_all_it_holds() {
        let among = json!(["cylindrical", "mercator"]);
        let take =
            json!({ "path": ["projection"], "take": { "name": "mercator", "among": among } });
        for shipped in shipped().iter().filter(|shipped| shipped.name == "conquistador") {
            let text = edited(shipped.text, take.clone()).unwrap();
            let profile = Profile::parse("a", "a", text.as_bytes());
            assert!(profile.is_ok(), "{text}");
            let comments = |text: &str| text.matches('#').count();
            assert_eq!(comments(&text), comments(shipped.text), "{text}");
        }
        let inline = "projection = { cylindrical = { azimuth_deg = [1, 2] } } # x\n";
        let text = edited(inline, take).unwrap();
        assert!(text.contains("mercator") && text.contains("# x"), "{text}");
    }

    #[test]
    fn what_cannot_be_changed_is_said() {
        for (text, edit) in [
            ("a = [", json!({ "path": ["a"], "value": 1 })),
            ("part = 1", json!({ "path": ["part", "width_mm"], "value": 1 })),
            (TEXT, json!({ "path": [], "value": 1 })),
            (TEXT, json!({ "path": ["part", "width_mm"], "index": 3, "value": 1 })),
            (TEXT, json!({ "path": ["part", "width_mm"], "value": { "a": 1 } })),
            (TEXT, json!({ "path": ["part", "width_mm"], "toml": "1 2" })),
            (TEXT, json!({ "path": ["part"], "take": { "name": "x", "among": ["y"] } })),
        ] {
            assert!(edited(text, edit.clone()).is_err(), "{text} {edit}");
        }
    }
}
