//! The schemas as the types have them.

use super::OUTPUTS;
use crate::bench::{self, BenchReport};
use crate::pipeline::{BuildTimings, Timings};
use crate::results::{
    BlurReport, BuildForecast, BuildReport, DrawingReport, ErrorLine, FrameReport,
    InspectionReport, MachiningReport, NamedOutput, PartTrials, PoseFile, ProfileCheck,
    ProgramReport, RenderReport, ReplayReport, SCHEMA, ShardReport, ShippedProfile, SweepReport,
    TableReport, ToleranceReport, UnwrapReport, VerifyReport,
};
use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// The files are what the types say; with `MORION_RENEW=1` they are written anew.
#[test]
fn schemas_are_those_of_the_types() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src/cli/schemas");
    let is_renewed = std::env::var_os("MORION_RENEW").is_some_and(|value| value == "1");
    for output in &OUTPUTS {
        let text = format!("{:#}\n", schema(&output.named).as_value());
        if is_renewed {
            std::fs::write(folder.join(format!("{}.json", output.named.name)), text).unwrap();
        } else {
            let name = output.named.name;
            assert!(text == output.text.text(), "{name}.json is not of its type: MORION_RENEW=1");
        }
    }
}

/// The root schema of the type of an output, and the version of its keys.
fn root(name: &str) -> (fn(SchemaGenerator) -> Schema, u32) {
    fn of<T: JsonSchema>(generator: SchemaGenerator) -> Schema {
        generator.into_root_schema_for::<T>()
    }
    let make = match name {
        "build" => of::<BuildReport>,
        "dry-run" => of::<BuildForecast>,
        "timings" => of::<BuildTimings>,
        "check" => of::<ProfileCheck>,
        "verify" => of::<VerifyReport>,
        "render" => of::<RenderReport>,
        "frame" => of::<FrameReport>,
        "unwrap" => of::<UnwrapReport>,
        "table" => of::<TableReport>,
        "blur" => of::<BlurReport>,
        "tolerance" => of::<ToleranceReport>,
        "part" => of::<PartTrials>,
        "replay" => of::<ReplayReport>,
        "pose" => of::<PoseFile>,
        "tolerance-timings" => of::<Timings>,
        "machining" => of::<MachiningReport>,
        "program" => of::<ProgramReport>,
        "inspect" => of::<InspectionReport>,
        "drawing" => of::<DrawingReport>,
        "sweep" => of::<SweepReport>,
        "shard" => of::<ShardReport>,
        "profiles" => of::<ShippedProfile>,
        "schema" => of::<NamedOutput>,
        "error" => of::<ErrorLine>,
        "bench" => return (of::<BenchReport>, bench::SCHEMA),
        _ => panic!("no type has the schema {name}"),
    };
    (make, SCHEMA)
}

fn schema(NamedOutput { name, what, .. }: &NamedOutput) -> Schema {
    let (make, version) = root(name);
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with_transform(Plain).with_transform(Closed);
    let mut schema = make(settings.into_generator());
    schema.insert("$id".into(), format!("urn:morion:{name}:{version}").into());
    schema.insert("title".into(), format!("{what}, schema {version}").into());
    if let Some(known) = schema.pointer_mut("/properties/schema") {
        known["const"] = version.into();
    }
    schema
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
