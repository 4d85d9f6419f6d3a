//! Changes of single values in a profile's text; comments, order and unknown keys stay.

use serde_json::Value as Json;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

/// A step from a table or list into what it holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum KeyStep {
    /// The value of a key.
    Key(String),
    /// An entry of a list, from 0.
    Entry(usize),
}

/// Sets the value at the end of a path to what `json` is in TOML; tables on the way to it are made where they are not
/// there.
///
/// # Errors
/// A sentence where the path leads through something that is no table, or to an entry that no list has.
pub(crate) fn set_value(
    document: &mut DocumentMut,
    path: &[KeyStep],
    json: &Json,
) -> Result<(), String> {
    let is_key = |step: &KeyStep| matches!(step, KeyStep::Key(_));
    let last = path.iter().rposition(is_key).ok_or("the path must name a key")?;
    let (mut table, mut is_inline) = (document.as_table_mut() as &mut dyn TableLike, false);
    let mut steps = path[..last].iter().peekable();
    while let Some(step) = steps.next() {
        let KeyStep::Key(key) = step else { return Err("a list must have a key".into()) };
        (table, is_inline) = match steps.next_if(|step| !is_key(step)) {
            Some(KeyStep::Entry(entry)) => listed(table, key, *entry)?,
            _ => below(table, key, [is_inline, steps.peek().is_none()])?,
        };
    }
    let KeyStep::Key(key) = &path[last] else { return Err("the path must name a key".into()) };
    if last + 1 == path.len() {
        let old = table.get(key).and_then(Item::as_value);
        let value = value_of(json, old).ok_or_else(|| format!("{key} cannot have this value"))?;
        put(table, key, value);
        return Ok(());
    }
    let mut old = table.get_mut(key).and_then(Item::as_value_mut);
    for step in &path[last + 1..] {
        let KeyStep::Entry(entry) = step else { return Err(format!("{key} is no list")) };
        old = old.and_then(Value::as_array_mut).and_then(|list| list.get_mut(*entry));
        if old.is_none() {
            return Err(format!("{key} has no entry {entry}"));
        }
    }
    let old = old.ok_or_else(|| format!("{key} has no such entry"))?;
    let new = value_of(json, Some(old)).ok_or_else(|| format!("{key} cannot have this value"))?;
    replace(old, new);
    Ok(())
}

/// The table under a key, made where it is not there, and whether it is an inline one. `is_inline`: the table that has
/// the key is; `is_last`: the value itself is put into it.
fn below<'d>(
    table: &'d mut dyn TableLike,
    key: &str,
    [is_inline, is_last]: [bool; 2],
) -> Result<(&'d mut dyn TableLike, bool), String> {
    if table.get(key).is_none_or(Item::is_none) {
        let mut made = Table::new();
        made.set_implicit(!is_last);
        let inline = || Item::Value(Value::InlineTable(InlineTable::new()));
        table.insert(key, if is_inline { inline() } else { Item::Table(made) });
    }
    let none = || format!("{key} is no table");
    let item = table.get_mut(key).ok_or_else(none)?;
    let is_inline = item.is_value();
    Ok((item.as_table_like_mut().ok_or_else(none)?, is_inline))
}

/// A table of a list of tables, and whether it is an inline one.
fn listed<'d>(
    table: &'d mut dyn TableLike,
    key: &str,
    entry: usize,
) -> Result<(&'d mut dyn TableLike, bool), String> {
    let found: Option<(&mut dyn TableLike, bool)> = match table.get_mut(key) {
        Some(Item::ArrayOfTables(tables)) => {
            tables.get_mut(entry).map(|table| (table as &mut dyn TableLike, false))
        }
        Some(Item::Value(Value::Array(list))) => list
            .get_mut(entry)
            .and_then(Value::as_inline_table_mut)
            .map(|table| (table as &mut dyn TableLike, true)),
        _ => None,
    };
    found.ok_or_else(|| format!("there is no {key}[{entry}]"))
}

/// Puts a value in the place of an old one, with the spaces and comments around that.
pub(crate) fn put(table: &mut dyn TableLike, key: &str, value: Value) {
    match table.get_mut(key) {
        Some(Item::Value(old)) => replace(old, value),
        Some(old) => *old = Item::Value(value),
        None => drop(table.insert(key, Item::Value(value))),
    }
}

fn replace(old: &mut Value, mut value: Value) {
    *value.decor_mut() = old.decor().clone();
    *old = value;
}

/// `json` in TOML: a whole number is an integer unless `old` has a decimal point.
pub(crate) fn value_of(json: &Json, old: Option<&Value>) -> Option<Value> {
    Some(match json {
        Json::Bool(flag) => Value::from(*flag),
        Json::String(text) => Value::from(text.as_str()),
        Json::Number(number) => match number.as_i64() {
            Some(whole) if !old.is_some_and(Value::is_float) => Value::from(whole),
            _ => Value::from(number.as_f64()?),
        },
        Json::Array(items) => {
            let old = old.and_then(Value::as_array);
            let entry = |(k, item): (usize, &Json)| value_of(item, old.and_then(|old| old.get(k)));
            Value::Array(items.iter().enumerate().map(entry).collect::<Option<Array>>()?)
        }
        Json::Null | Json::Object(_) => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn edited(text: &str, path: &[&str], json: Json) -> Result<String, String> {
        let step = |word: &&str| match word.parse() {
            Ok(entry) => KeyStep::Entry(entry),
            Err(_) => KeyStep::Key((*word).to_owned()),
        };
        let mut document = text.parse::<DocumentMut>().unwrap();
        let path: Vec<KeyStep> = path.iter().map(step).collect();
        set_value(&mut document, &path, &json).map(|()| document.to_string())
    }

    #[test]
    fn entries_of_lists_and_of_lists_of_tables_change_alone() {
        let text =
            "a.b = [1, 2.0] # kept\n[[hole]]\nat_mm = [1, 2]\n[[hole]] # second\nat_mm = [3, 4]\n";
        assert_eq!(edited(text, &["a", "b", "1"], json!(3)).unwrap(), text.replace("2.0", "3.0"));
        let second = edited(text, &["hole", "1", "at_mm", "0"], json!(7.5)).unwrap();
        assert_eq!(second, text.replace("[3, 4]", "[7.5, 4]"));
        let new = edited(text, &["hole", "0", "depth_mm"], json!(5)).unwrap();
        assert_eq!(new, text.replace("[1, 2]\n", "[1, 2]\ndepth_mm = 5\n"));
        let inline = "hole = [{ at_mm = [1, 2] }, { at_mm = [3, 4] }]\n";
        let second = edited(inline, &["hole", "1", "at_mm"], json!([5, 6])).unwrap();
        assert_eq!(second, inline.replace("[3, 4]", "[5, 6]"));
        let nested = "terms = [[1, 2, 0.5], [3, 0, 1e-3]]\n";
        let third = edited(nested, &["terms", "1", "2"], json!(2e-3)).unwrap();
        assert_eq!(third, nested.replace("1e-3", "0.002"));
    }

    #[test]
    fn tables_that_are_not_there_are_made_as_their_parents_are_written() {
        let text = "a = { b = 1 }\n";
        let inline = edited(text, &["a", "c", "d"], json!("x")).unwrap();
        assert_eq!(inline, "a = { b = 1 , c = { d = \"x\" } }\n");
        let table = edited(text, &["e", "f", "g"], json!(true)).unwrap();
        assert_eq!(table, "a = { b = 1 }\n\n[e.f]\ng = true\n");
    }

    #[test]
    fn what_a_path_does_not_lead_to_is_said() {
        let text = "a = 1\nb = [1]\n[[hole]]\n";
        for path in [
            &["a", "b"][..],
            &["b", "1"],
            &["a", "0"],
            &["c", "0"],
            &["hole", "1", "at_mm"],
            &["b", "0", "c"],
            &["0"],
            &[],
        ] {
            assert!(edited(text, path, json!(1)).is_err(), "{path:?}");
        }
        assert!(edited(text, &["a"], json!({ "b": 1 })).is_err());
    }
}
