//! One word has one meaning: what the sources call their types and functions.

use super::reading::{blank, definitions, tokens};
use super::sources;
use std::collections::BTreeMap;

/// Types whose name two files may share. Six at most.
const SHARED: &[&str] = &[];
const MOST_SHARED: usize = 6;

/// Words of everyday speech or of metaphors that stood for terms of the field; docs/glossary.md has
/// the terms. No type, function, constant, field or file is called so.
const BANNED: &[&str] = &[
    "crowd",
    "doubt",
    "doubtful",
    "ease",
    "fate",
    "glance",
    "glimpse",
    "hopeful",
    "hopeless",
    "settle",
    "settled",
    "undoubted",
    "uneasy",
    "yardstick",
];

/// The words of an identifier: `CoarseMesh` and `coarse_mesh` are both `coarse`, `mesh`.
fn words(identifier: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = '_';
    for c in identifier.chars() {
        if c == '_' || (c.is_uppercase() && before.is_lowercase()) {
            words.push(String::new());
        }
        if c != '_' {
            words.last_mut().unwrap().extend(c.to_lowercase());
        }
        before = c;
    }
    words
}

#[test]
fn a_public_type_has_a_name_of_its_own() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for source in sources().iter().filter(|source| !source.all_test) {
        for item in definitions(&tokens(&blank(&source.text))) {
            if item.is_public && item.is_type && !item.in_test {
                places.entry(item.name.to_owned()).or_default().push(source.file.clone());
            }
        }
    }
    assert!(places.len() > 200, "{} types: definitions are not read", places.len());
    places.retain(|name, files| files.len() > 1 && !SHARED.contains(&name.as_str()));
    assert!(SHARED.len() <= MOST_SHARED && places.is_empty(), "{places:#?}");
}

/// Names that the crate promises: what its root hands on, but for the modules of the hidden `internals`.
const MOST_PROMISED: usize = 80;

#[test]
fn the_root_promises_few_names() {
    let root = sources().into_iter().find(|source| source.file == "src/lib.rs").unwrap();
    let code = blank(&root.text);
    let handed_on = code.split("pub use ").skip(1).map(|rest| rest.split(';').next().unwrap());
    let names: Vec<&str> = handed_on
        .flat_map(|list| list.rsplit("::").next().unwrap().split(['{', '}', ',', '\n', ' ']))
        .filter(|name| !name.is_empty())
        .collect();
    assert!(names.contains(&"Profile") && names.contains(&"Verdict"), "{names:?}");
    assert!(names.len() <= MOST_PROMISED, "{} names: {names:?}", names.len());
}

#[test]
fn nothing_is_called_by_a_metaphor() {
    let mut found = Vec::new();
    let mut look = |file: &str, name: &str| {
        let banned = words(name).into_iter().find(|word| BANNED.contains(&word.as_str()));
        found.extend(banned.map(|word| format!("{file}: {name} ({word})")));
    };
    for source in sources() {
        for part in &source.path {
            look(&source.file, part);
        }
        for item in definitions(&tokens(&blank(&source.text))) {
            look(&source.file, item.name);
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn identifiers_are_parted_into_words() {
    assert_eq!(words("CoarseMesh"), ["coarse", "mesh"]);
    assert_eq!(words("coarse_mesh"), ["coarse", "mesh"]);
    assert_eq!(words("MOST_TEXT"), ["most", "text"]);
}
