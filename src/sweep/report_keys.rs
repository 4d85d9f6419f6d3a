//! Keys of the reports that points make, by their JSON Schemas.

use crate::packed_text::{PackedText, packed_text};
use crate::profile::SweepCommand;
use serde_json::Value as Json;

/// Groups of the report of a build that need no mesh.
pub(super) const DESIGN_GROUPS: [&str; 9] =
    ["layout", "design", "unwanted", "form", "tool", "cavity", "holes", "sharpness", "accepted"];

/// Schemas of the reports.
static BUILD: PackedText = packed_text!("build.json");
static DRY_RUN: PackedText = packed_text!("dry-run.json");
static FRAME: PackedText = packed_text!("frame.json");
static BLUR: PackedText = packed_text!("blur.json");
static TOLERANCE: PackedText = packed_text!("tolerance.json");
static PROGRAM: PackedText = packed_text!("program.json");

/// Similarity (Jaro-Winkler) from which a key is taken for a misspelt one.
const LIKE: f64 = 0.9;
/// Most keys that a hint lists.
const MOST_LISTED: usize = 8;

/// Keys that the report of a command may have.
pub(super) struct ReportKeys {
    command: SweepCommand,
    schema: Json,
}

impl ReportKeys {
    /// Those of the report of `command`.
    pub(super) fn of(command: SweepCommand) -> Self {
        let packed = match command {
            SweepCommand::Design | SweepCommand::Build => &BUILD,
            SweepCommand::DryRun => &DRY_RUN,
            SweepCommand::Frame => &FRAME,
            SweepCommand::Blur => &BLUR,
            SweepCommand::Tolerance => &TOLERANCE,
            SweepCommand::Program => &PROGRAM,
        };
        let mut schema: Json = serde_json::from_str(packed.text()).unwrap_or_default();
        if command == SweepCommand::Design
            && let Some(groups) = schema["properties"].as_object_mut()
        {
            groups.retain(|group, _| DESIGN_GROUPS.contains(&group.as_str()));
        }
        Self { command, schema }
    }

    /// Whether there may be a figure, a word or a flag under `key`.
    ///
    /// # Errors
    /// A hint.
    pub(super) fn check(&self, key: &str) -> Result<(), String> {
        let mut leaves = Vec::new();
        self.collect(&self.schema, "", &mut leaves);
        // Entries of lists are alike.
        if leaves.contains(&first_entries(key)) {
            return Ok(());
        }
        let below: Vec<&str> = leaves
            .iter()
            .filter(|leaf| leaf.strip_prefix(key).is_some_and(|rest| rest.starts_with(['.', '['])))
            .map(String::as_str)
            .collect();
        if !below.is_empty() {
            let listed = below[..below.len().min(MOST_LISTED)].join(", ");
            return Err(format!("it is a group; name one of its keys, as {listed}"));
        }
        let last = key.rsplit('.').next().unwrap_or(key);
        let ends = |leaf: &&String| leaf.rsplit('.').next() == Some(last);
        let likeness = |leaf: &&String| strsim::jaro_winkler(leaf, key);
        let near = leaves.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let near = near.filter(|leaf| likeness(leaf) > LIKE);
        let meant = near.or_else(|| leaves.iter().find(ends));
        let is_of_build = self.command == SweepCommand::Design && {
            let build = Self::of(SweepCommand::Build);
            build.check(key).is_ok()
        };
        let schema = match self.command {
            SweepCommand::Design => "build",
            other => other.name(),
        };
        Err(match meant {
            _ if is_of_build => {
                "a design has no mesh and no file; it is there with command = \"build\"".into()
            }
            Some(meant) => format!("did you mean {meant}?"),
            None => format!("`morion schema {schema}` tells all keys"),
        })
    }

    /// Adds the keys of all leaves below a part of the schema.
    fn collect(&self, part: &Json, path: &str, leaves: &mut Vec<String>) {
        if let Some(named) = part["$ref"].as_str().and_then(|name| name.strip_prefix('#'))
            && let Some(named) = self.schema.pointer(named)
        {
            return self.collect(named, path, leaves);
        }
        let mut is_leaf = !path.is_empty();
        let alternatives = part["anyOf"].as_array().into_iter().flatten();
        for other in
            alternatives.filter(|other| other.get("$ref").or(other.get("properties")).is_some())
        {
            self.collect(other, path, leaves);
            is_leaf = false;
        }
        for (key, below) in part["properties"].as_object().into_iter().flatten() {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            self.collect(below, &path, leaves);
            is_leaf = false;
        }
        if let Some(items) = part.get("items") {
            self.collect(items, &format!("{path}[0]"), leaves);
            is_leaf = false;
        }
        if is_leaf {
            leaves.push(path.to_owned());
        }
    }
}

/// A key with the first entry in the place of any other.
fn first_entries(key: &str) -> String {
    let mut first = String::new();
    let mut rest = key;
    while let Some((before, after)) = rest.split_once('[') {
        first += before;
        first.push('[');
        let digits = after.bytes().take_while(u8::is_ascii_digit).count();
        first += if digits > 0 { "0" } else { "" };
        rest = &after[digits..];
    }
    first + rest
}

/// What a report has under a key: a number, a word or a flag; null where there is none.
pub(super) fn value_at(report: &Json, key: &str) -> Json {
    let mut found = Some(report);
    for part in key.split('.') {
        let (name, entries) = part.split_at(part.find('[').unwrap_or(part.len()));
        found = found.and_then(|found| found.get(name));
        for entry in entries.split(['[', ']']).filter(|entry| !entry.is_empty()) {
            let entry = entry.parse::<usize>().ok();
            found = entry.and_then(|entry| found.and_then(|found| found.get(entry)));
        }
    }
    found.filter(|found| !found.is_array() && !found.is_object()).cloned().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn keys_are_those_of_the_schemas() {
        for (command, known) in [
            (
                SweepCommand::Design,
                &[
                    "design.pixel_error_px.rms",
                    "form.sphere.radius_of_curvature_mm",
                    "sharpness.best.na",
                    "sharpness.best.resolved[1]",
                ][..],
            ),
            (
                SweepCommand::Build,
                &["mesh.triangles", "trace[3].pixel_error_px.max", "verdict", "frame.filled"],
            ),
            (SweepCommand::DryRun, &["mesh.triangles", "files[0].bytes"]),
            (SweepCommand::Frame, &["frame.filled", "verdict"]),
            (SweepCommand::Blur, &["spots.length_px.p95"]),
            (SweepCommand::Tolerance, &["yield.share"]),
            (SweepCommand::Program, &["machine_min"]),
        ] {
            let keys = ReportKeys::of(command);
            for key in known {
                assert_eq!(keys.check(key), Ok(()), "{key}");
            }
            for key in ["", "design[0]", "x", "verdict.x"] {
                assert!(keys.check(key).is_err(), "{key}");
            }
        }
    }

    #[test]
    fn hints_lead_to_keys() {
        let keys = ReportKeys::of(SweepCommand::Design);
        for (key, hint) in [
            ("design.pixel_eror_px.rms", "did you mean design.pixel_error_px.rms?"),
            ("design.pixel_error_px", "design.pixel_error_px.rms"),
            ("mesh.triangles", "command = \"build\""),
            ("nothing.of.the.kind", "morion schema build"),
            ("gradient_residual", "did you mean design.gradient_residual?"),
        ] {
            let told = keys.check(key).unwrap_err();
            assert!(told.contains(hint), "{key}: {told}");
        }
    }

    #[test]
    fn values_are_leaves() {
        let report = json!({ "a": { "b": [1, { "c": true }], "d": "x" }, "e": null });
        for (key, value) in [
            ("a.b[0]", json!(1)),
            ("a.b[1].c", json!(true)),
            ("a.d", json!("x")),
            ("a.b", Json::Null),
            ("a", Json::Null),
            ("e", Json::Null),
            ("a.b[2]", Json::Null),
            ("a.d.x", Json::Null),
        ] {
            assert_eq!(value_at(&report, key), value, "{key}");
        }
    }
}
