//! Reading one key: a number, a few numbers, a flag or one of a few words.

use toml::de::DeValue;

use super::reader::Need::{Optional, Required};
use super::reader::{Need, ProfileReader, Section, TomlValue};
use super::schema;
use super::words::list;

const FINITE: &str = "every figure of a profile must be finite";

/// A value and the byte offset where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Located<T> {
    pub(super) value: T,
    pub(super) at: usize,
}

/// A number that `allowed` lets pass.
pub(super) fn number(
    reader: &mut ProfileReader,
    section: &Section,
    key: &str,
    need: Need,
    must: &str,
    hint: &str,
    allowed: impl Fn(f64) -> bool,
) -> Option<Located<f64>> {
    let value = reader.value(section, key, need, must, hint)?;
    let path = section.path_of(key);
    let figure = within(reader, &path, value, must, hint, allowed)?;
    Some(Located { value: figure, at: value.span().start })
}

/// The name of a file that must be given.
pub(super) fn file(
    reader: &mut ProfileReader,
    section: &Section,
    hint: &str,
) -> Option<Located<String>> {
    let must = "the name of a file";
    let value = reader.value(section, "file", Required, must, hint)?;
    let at = value.span().start;
    match value.get_ref() {
        DeValue::String(file) if !file.trim().is_empty() => {
            Some(Located { value: file.to_string(), at })
        }
        _ => {
            let path = section.path_of("file");
            let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
            reader.complain(at, message, hint);
            None
        }
    }
}

/// Form of a list of a few numbers.
pub(super) struct NumbersFormat<'h> {
    pub(super) key: &'h str,
    pub(super) parts: &'h str,
    pub(super) each: &'h str,
    /// Hint if the list has the wrong form.
    pub(super) form: &'h str,
    /// Hint if a number is out of its limits.
    pub(super) limit: &'h str,
}

/// `N` numbers in a list, each of which `allowed` lets pass.
pub(super) fn numbers<const N: usize>(
    reader: &mut ProfileReader,
    section: &Section,
    keys: &NumbersFormat,
    allowed: impl Fn(f64) -> bool,
) -> Option<Located<[f64; N]>> {
    let path = section.path_of(keys.key);
    let must = format!("{}, each {}", keys.parts, keys.each);
    let value = reader.value(section, keys.key, Required, &must, keys.form)?;
    let at = value.span().start;
    let DeValue::Array(items) = value.get_ref() else {
        let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
        reader.complain(at, message, keys.form);
        return None;
    };
    if items.len() != N {
        let message = format!("{path} must be {must}, found {}", counted(items.len()));
        reader.complain(at, message, keys.form);
        return None;
    }
    let mut figures = [None; N];
    for (figure, item) in figures.iter_mut().zip(items) {
        *figure = within(reader, &path, item, keys.each, keys.limit, &allowed);
    }
    let mut found = [0.0; N];
    for (found, figure) in found.iter_mut().zip(figures) {
        *found = figure?;
    }
    Some(Located { value: found, at })
}

/// Form of a list of lists.
pub(super) struct RowsFormat<'h> {
    pub(super) key: &'h str,
    pub(super) need: Need,
    /// Form of one entry, as in `[row, degrees]`.
    pub(super) entry: &'h str,
    /// Fewest and most entries.
    pub(super) count: [usize; 2],
    pub(super) hint: &'h str,
}

/// The entries of a list of lists of `N`, each with its place; what they hold is not checked.
pub(super) fn rows<'t, const N: usize>(
    reader: &mut ProfileReader,
    section: &Section<'t>,
    rows: &RowsFormat,
) -> Option<Located<Vec<Located<[&'t TomlValue<'t>; N]>>>> {
    let path = section.path_of(rows.key);
    let [least, most] = rows.count;
    let must = format!("a list of {least} to {most} entries {}", rows.entry);
    let value = reader.value(section, rows.key, rows.need, &must, rows.hint)?;
    let at = value.span().start;
    let found = match value.get_ref() {
        DeValue::Array(items) if (least..=most).contains(&items.len()) => {
            let mut entries = Vec::with_capacity(items.len());
            for item in items {
                let at = item.span().start;
                let entry = item.get_ref().as_array().map(|list| list.iter().collect::<Vec<_>>());
                match entry.map(<[&TomlValue; N]>::try_from) {
                    Some(Ok(value)) => entries.push(Located { value, at }),
                    wrong => {
                        // The others are hardly any better.
                        let entry = rows.entry;
                        let found = match wrong {
                            Some(Err(list)) => counted(list.len()),
                            _ => reader.quote_type(item),
                        };
                        let message = format!("{path} must hold entries {entry}, found {found}");
                        reader.complain(at, message, rows.hint);
                        return None;
                    }
                }
            }
            return Some(Located { value: entries, at });
        }
        DeValue::Array(items) => counted(items.len()),
        _ => reader.quote_type(value),
    };
    reader.complain(at, format!("{path} must be {must}, found {found}"), rows.hint);
    None
}

/// A list by its length, in words.
fn counted(length: usize) -> String {
    match length {
        0 => "an empty list".to_owned(),
        1 => "a list of one".to_owned(),
        n => format!("a list of {n}"),
    }
}

/// The number that a value is, if it is one and `allowed` lets it pass; else a complaint.
pub(super) fn within(
    reader: &mut ProfileReader,
    path: &str,
    value: &TomlValue,
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
pub(super) fn flag(
    reader: &mut ProfileReader,
    section: &Section,
    key: &str,
) -> Option<Located<bool>> {
    let must = "true or false";
    let hint = "without quotes, in lower case";
    let value = reader.value(section, key, Optional, must, hint)?;
    if let DeValue::Boolean(flag) = value.get_ref() {
        return Some(Located { value: *flag, at: value.span().start });
    }
    let path = section.path_of(key);
    let message = format!("{path} must be {must}, found {}", reader.quote_type(value));
    reader.complain(value.span().start, message, hint);
    None
}

/// Meaning of one of a few words.
pub(super) fn word<T: Copy>(
    reader: &mut ProfileReader,
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

/// The number that a value is, finite or not; `None` if it is of another type.
fn figure(value: &TomlValue) -> Option<f64> {
    match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(int) if int.radix() == 10 => int.as_str().parse().ok(),
        DeValue::Integer(int) => {
            Some(u64::from_str_radix(int.as_str(), int.radix()).map_or(f64::INFINITY, |n| n as f64))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml::de::DeTable;

    #[test]
    fn figures_in_every_radix() {
        for (text, number) in [
            ("a = 1_000", 1000.0),
            ("a = +7", 7.0),
            ("a = 0x1F", 31.0),
            ("a = 0b101", 5.0),
            ("a = -2.5e-1", -0.25),
            ("a = 99999999999999999999", 1e20),
            ("a = 0xFFFFFFFFFFFFFFFFFFFFF", f64::INFINITY),
        ] {
            let tree = DeTable::parse(text).expect("TOML");
            assert_eq!(tree.get_ref().get("a").and_then(figure), Some(number), "{text}");
        }
    }
}
