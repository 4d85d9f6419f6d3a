//! The tables of keys in the pages about reports, against the JSON Schemas: every key that an output can have.

use super::report_keys::{REPORT, STUDIES, TOLERANCE, documented};
use crate::support::builds::{folder, morion, told};
use serde_json::Value;
use std::collections::BTreeSet;

/// Keys of outputs that only other outputs of the same types fill: rims of a solid that is closed by construction,
/// normals of files that hold none, and files and as-cut part of a study, which makes none.
const NEVER: [(&str, &[&str]); 5] = [
    ("build", &["solid.open."]),
    ("machining", &["as_cut.trace.interpolated_normals.", "as_cut.trace.solid.open."]),
    (
        "program",
        &[
            "as_cut.trace.interpolated_normals.",
            "as_cut.trace.solid.open.",
            // A ball finishes.
            "program.radius_mm",
            "program.corner_mm",
        ],
    ),
    ("tolerance", &["machining.as_cut.", "machining.files[]."]),
    ("replay", &["files[].solid.open."]),
];

/// The outputs, and the headings of the tables that have their keys.
const TABLES: &[(&[&str], &str, &[&str])] = &[
    (
        &["build", "verify"],
        REPORT,
        &["## `report.json` of a build", "## `report.json` of a verified file"],
    ),
    (&["timings"], REPORT, &["## `timings.json`"]),
    (&["dry-run"], REPORT, &["### `morion build --dry-run`"]),
    (&["render"], REPORT, &["### `morion render`"]),
    (&["unwrap"], REPORT, &["### `morion unwrap`"]),
    (&["frame"], STUDIES, &["## `frame.json`"]),
    (&["blur"], STUDIES, &["## `blur.json`"]),
    (&["table"], STUDIES, &["## `table.json`"]),
    (&["machining"], STUDIES, &["## `machining.json`"]),
    (&["program"], STUDIES, &["## `program.json`"]),
    (&["drawing"], STUDIES, &["## `drawing.json`"]),
    (&["inspect"], STUDIES, &["## `inspection.json`"]),
    (&["sweep"], STUDIES, &["## `sweep.json`"]),
    (&["bench"], STUDIES, &["## `bench.json`"]),
    (&["tolerance"], TOLERANCE, &["## `tolerance.json`"]),
    (&["tolerance-timings"], TOLERANCE, &["## `tolerance-timings.json`"]),
    (&["replay"], TOLERANCE, &["## `replay.json`"]),
    (&["pose"], TOLERANCE, &["## `pose.json`"]),
];

/// The keys of a schema: of leaves, and of objects whose keys it leaves open.
#[derive(Default)]
struct Keys {
    leaves: BTreeSet<String>,
    open: BTreeSet<String>,
}

impl Keys {
    fn collect(&mut self, root: &Value, schema: &Value, path: &str) {
        if let Some(name) = schema["$ref"].as_str() {
            let pointer = name.strip_prefix('#').expect("of this schema");
            return self.collect(root, root.pointer(pointer).expect("a definition"), path);
        }
        let mut is_leaf = true;
        for alternative in schema["anyOf"].as_array().into_iter().flatten() {
            if alternative.get("$ref").or(alternative.get("properties")).is_some() {
                self.collect(root, alternative, path);
                is_leaf = false;
            }
        }
        for (key, below) in schema["properties"].as_object().into_iter().flatten() {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            self.collect(root, below, &path);
            is_leaf = false;
        }
        if let Some(items) = schema.get("items") {
            self.collect(root, items, &format!("{path}[]"));
            is_leaf = false;
        }
        if schema["additionalProperties"].is_object() {
            self.open.insert(format!("{path}."));
            is_leaf = false;
        }
        if is_leaf {
            self.leaves.insert(path.trim_end_matches("[]").to_owned());
        }
    }
}

fn printed(name: &str) -> Value {
    let (code, out, err) = told(&morion(folder().path(), &["schema", name]));
    assert_eq!(code, 0, "{name}: {err}");
    serde_json::from_str(&out).unwrap()
}

#[test]
fn the_pages_have_every_key_of_the_schemas_and_no_other() {
    for (names, page, headings) in TABLES {
        let mut keys = Keys::default();
        for name in *names {
            let schema = printed(name);
            let mut own = Keys::default();
            own.collect(&schema, &schema, "");
            let never =
                NEVER.iter().find(|(other, _)| other == name).map_or(&[][..], |never| never.1);
            own.leaves.retain(|key| !never.iter().any(|never| key.starts_with(never)));
            keys.leaves.extend(own.leaves);
            keys.open.extend(own.open);
        }
        let rows: BTreeSet<String> = headings.iter().flat_map(|h| documented(page, h)).collect();
        let missing: Vec<_> = keys.leaves.difference(&rows).collect();
        assert!(missing.is_empty(), "{headings:?} have no row for {missing:?}");
        // (A group that is always null or empty has a row of its own.)
        let groups: Vec<&str> = NEVER.iter().flat_map(|never| never.1).copied().collect();
        let is_group =
            |row: &str| groups.iter().any(|group| group.trim_end_matches(['[', ']', '.']) == row);
        let idle = |row: &&String| {
            !keys.leaves.contains(*row)
                && !keys.open.iter().any(|open| row.starts_with(open.as_str()))
                && !is_group(row)
        };
        let idle: Vec<_> = rows.iter().filter(idle).collect();
        assert!(idle.is_empty(), "{headings:?} have rows for {idle:?}, which the schemas have not");
    }
}

#[test]
fn every_schema_has_its_name_its_version_and_closed_objects() {
    let (code, out, err) = told(&morion(folder().path(), &["schema", "--format", "json"]));
    assert_eq!(code, 0, "{err}");
    let mut names = BTreeSet::new();
    for line in out.lines() {
        let name =
            serde_json::from_str::<Value>(line).unwrap()["name"].as_str().unwrap().to_owned();
        let schema = printed(&name);
        let version = if name == "bench" { 2 } else { 1 };
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
        assert_eq!(schema["$id"], format!("urn:morion:{name}:{version}"));
        assert_eq!(schema["additionalProperties"], false, "{name}");
        if let Some(key) = schema.pointer("/properties/schema") {
            assert_eq!(key["const"], version, "{name}");
        }
        names.insert(name);
    }
    for (tables, _, _) in TABLES {
        assert!(tables.iter().all(|name| names.contains(*name)), "{tables:?}");
    }
}

#[test]
fn an_unknown_output_is_refused_with_the_names_and_what_was_meant() {
    let out = folder();
    let (code, _, err) = told(&morion(out.path(), &["schema", "tolerence"]));
    assert_eq!(code, 2);
    assert!(err.contains("did you mean tolerance?") && err.contains("dry-run"), "{err}");
    let (code, _, err) = told(&morion(out.path(), &["schema", "xyz"]));
    assert!(code == 2 && !err.contains("mean") && err.contains("dry-run"), "{err}");
}
