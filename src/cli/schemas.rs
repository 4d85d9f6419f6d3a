//! JSON Schemas of all JSON outputs, derived from the types that are serialised.

use super::failure::CommandFailure;
use crate::bench::{self, BenchReport};
use crate::pipeline::{BuildTimings, Timings};
use crate::results::{
    BlurReport, BuildForecast, BuildReport, DrawingReport, ErrorLine, FrameReport,
    InspectionReport, MachiningReport, NamedOutput, PartTrials, PoseFile, ProfileCheck,
    ProgramReport, RenderReport, ReplayReport, SCHEMA, ShippedProfile, TableReport,
    ToleranceReport, UnwrapReport, VerifyReport,
};
use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Map, Value, json};

/// An output with the schema of its type.
struct Output {
    named: NamedOutput,
    /// Version of its keys.
    version: u32,
    make: fn(SchemaGenerator) -> Schema,
}

/// The output `name`, which is `what`, `from` these commands, and has the keys of `T`.
fn output<T: JsonSchema>(name: &'static str, what: &'static str, from: &'static str) -> Output {
    let make = |generator: SchemaGenerator| generator.into_root_schema_for::<T>();
    Output { named: NamedOutput { name, what, from }, version: SCHEMA, make }
}

fn all() -> Vec<Output> {
    let bench = output::<BenchReport>("bench", "bench.json", "morion bench");
    vec![
        output::<BuildReport>("build", "report.json of a build", "morion build"),
        output::<BuildForecast>("dry-run", "forecast of a build", "morion build --dry-run"),
        output::<BuildTimings>("timings", "timings.json", "morion build (the file alone)"),
        output::<ProfileCheck>("check", "valid profile", "morion check"),
        output::<VerifyReport>("verify", "report.json of a verified file", "morion verify"),
        output::<RenderReport>("render", "picture that was rendered", "morion render"),
        output::<FrameReport>("frame", "frame.json", "morion frame"),
        output::<UnwrapReport>("unwrap", "photo that was unwrapped", "morion unwrap"),
        output::<TableReport>("table", "table.json", "morion table"),
        output::<BlurReport>("blur", "blur.json", "morion blur"),
        output::<ToleranceReport>("tolerance", "tolerance.json", "morion tolerance"),
        output::<PartTrials>("part", "trials of a part of a run", "morion tolerance --part"),
        output::<ReplayReport>("replay", "replay.json", "morion tolerance --replay"),
        output::<PoseFile>("pose", "pose.json", "morion tolerance --replay (the file alone)"),
        output::<Timings>(
            "tolerance-timings",
            "tolerance-timings.json",
            "morion tolerance (the file alone)",
        ),
        output::<MachiningReport>("machining", "machining.json", "morion machining"),
        output::<ProgramReport>("program", "program.json", "morion program"),
        output::<InspectionReport>("inspect", "inspection.json", "morion inspect"),
        output::<DrawingReport>("drawing", "drawing.json", "morion drawing"),
        Output { version: bench::SCHEMA, ..bench },
        output::<ShippedProfile>("profiles", "shipped profile, a line for each", "morion profiles"),
        output::<NamedOutput>("schema", "JSON output, a line for each", "morion schema"),
        output::<ErrorLine>(
            "error",
            "error, a line for each",
            "every command that ends with exit code 2",
        ),
    ]
}

/// All JSON outputs, those of `morion build` first.
pub(super) fn outputs() -> impl Iterator<Item = NamedOutput> {
    all().into_iter().map(|output| output.named)
}

/// The JSON Schema (draft 2020-12) of the output `name`, as JSON of several lines.
///
/// # Errors
/// A sentence that lists the names, if this is none of them.
pub(super) fn named(name: &str) -> Result<String, CommandFailure> {
    let known = all().into_iter().find(|output| output.named.name == name);
    let output = known.ok_or_else(|| {
        let names: Vec<&str> = outputs().map(|output| output.name).collect();
        CommandFailure::unknown("JSON output", name, &names)
    })?;
    Ok(format!("{:#}\n", output.schema().as_value()))
}

impl Output {
    fn schema(&self) -> Schema {
        let settings = SchemaSettings::draft2020_12().for_serialize();
        let settings = settings.with_transform(Plain).with_transform(Closed);
        let mut schema = (self.make)(settings.into_generator());
        let NamedOutput { name, what, .. } = &self.named;
        schema.insert("$id".into(), format!("urn:morion:{name}:{}", self.version).into());
        let title = format!("{what}, schema {}", self.version);
        schema.insert("title".into(), title.into());
        if let Some(version) = schema.pointer_mut("/properties/schema") {
            version["const"] = self.version.into();
        }
        schema
    }
}

/// Leaves out formats (the draft knows none for numbers, and strict validators refuse unknown ones) and the ends
/// of lines in descriptions.
#[derive(Debug, Clone)]
struct Plain;

impl Transform for Plain {
    fn transform(&mut self, schema: &mut Schema) {
        schema.remove("format");
        if let Some(Value::String(text)) = schema.get_mut("description") {
            *text = text.replace('\n', " ");
        }
        transform_subschemas(self, schema);
    }
}

/// Closes objects to keys that are not named, and takes null from keys that are left out instead.
#[derive(Debug, Clone)]
struct Closed;

impl Transform for Closed {
    fn transform(&mut self, schema: &mut Schema) {
        let Some(object) = schema.as_object_mut() else { return };
        if !object.contains_key("properties") || object.contains_key("additionalProperties") {
            return transform_subschemas(self, schema);
        }
        forbid_null(object);
        let alternatives = object.remove("anyOf");
        let rest =
            if alternatives.is_some() { "unevaluatedProperties" } else { "additionalProperties" };
        object.insert(rest.into(), false.into());
        transform_subschemas(self, schema);
        // The keys of the alternatives are keys of this object, which is closed as a whole.
        if let Some(alternatives) = alternatives {
            schema.insert("anyOf".into(), alternatives);
        }
    }
}

/// Takes null from the keys of `object` that are not required: what has no value is left out there. (A number
/// that may be infinite has another form and keeps it.)
fn forbid_null(object: &mut Map<String, Value>) {
    let required = object.get("required").cloned().unwrap_or(json!([]));
    let is_required = |key: &str| required.as_array().is_some_and(|all| all.contains(&key.into()));
    let Some(Value::Object(properties)) = object.get_mut("properties") else { return };
    for (_, property) in properties.iter_mut().filter(|(key, _)| !is_required(key)) {
        let Some(property) = property.as_object_mut() else { continue };
        if let Some([kind, Value::String(null)]) = property.get("type").and_then(pair)
            && null == "null"
        {
            property.insert("type".into(), kind.clone());
        }
        if let Some([choice, _]) = property.get("anyOf").and_then(pair)
            && let Some(named) = choice.get("$ref").cloned()
        {
            property.remove("anyOf");
            property.insert("$ref".into(), named);
        }
    }
}

/// The elements of an array of two.
fn pair(value: &Value) -> Option<&[Value; 2]> {
    value.as_array()?.as_slice().try_into().ok()
}
