//! A point of a study: its profile, what it is known by, and its figures.

use super::report_keys::{DESIGN_GROUPS, value_at};
use crate::mirror::Form;
use crate::pipeline::{
    BlurOptions, BuildOptions, Command, Error, FrameOptions, ProfileText, ProgramOptions, Silent,
    SourceError, ToleranceOptions, designed, designed_alone, designed_unmeasured, dry_run, inputs,
};
use crate::profile::{Profile, SweepCommand, SweepSpec};
use crate::publish::sha256;
use crate::render::UnwantedViews;
use crate::report::json_text;
use crate::results::{CavityFacts, HoleFacts, PointOutcome, PointStatus, ToolFacts};
use crate::verdict::sharpness::sharpness;
use serde::Serialize;
use serde_json::{Map, Value as Json};

/// Keys of the least error of any mirror.
const LEAST_ERROR: &str = "design.least_error.";

/// A point whose profile is valid.
pub(super) struct ValidPoint {
    profile: Profile,
    /// SHA-256 of all that its figures depend on, hexadecimal.
    pub key: String,
}

/// The point with this text of its profile, whose files lie beside `base`.
///
/// # Errors
/// The outcome of a point whose profile is not valid.
pub(super) fn checked(
    spec: &SweepSpec,
    base: &ProfileText,
    text: Result<String, String>,
) -> Result<ValidPoint, PointOutcome> {
    let invalid = |error: &str| failed(PointStatus::Invalid, error);
    let text = text.map_err(|error| invalid(&error))?;
    let text = ProfileText { bytes: text.into_bytes().into(), ..base.clone() };
    let mut profile = text.checked().map_err(|error| invalid(&sentence(&error)))?;
    // What is read later than the profile counts too.
    if spec.command == SweepCommand::Tolerance {
        let map = profile.form_map().map(|map| map.map(|map| map.into_owned()));
        profile.form_map = map.map_err(|error| invalid(&sentence(&error)))?;
    }
    // Where the study lies changes nothing.
    let named = std::mem::take(&mut profile.named);
    let key = sha256(format!("{} {}", inputs(&profile), spec.command.name()).as_bytes());
    profile.named = named;
    Ok(ValidPoint { profile, key })
}

impl ValidPoint {
    /// Runs it.
    pub(super) fn outcome(&self, spec: &SweepSpec) -> PointOutcome {
        match report(&self.profile, spec) {
            Ok(report) => {
                let values = spec.columns.iter().map(|column| value_at(&report, &column.key));
                PointOutcome { status: PointStatus::Made, error: None, values: values.collect() }
            }
            Err(error) => failed(PointStatus::Refused, &error.to_string()),
        }
    }
}

/// The outcome of a point without figures.
fn failed(status: PointStatus, error: &str) -> PointOutcome {
    let words: Vec<&str> = error.split_whitespace().collect();
    PointOutcome { status, error: Some(words.join(" ")), values: Vec::new() }
}

/// Why a profile is not valid: its first fault, without the place in a text that nobody has.
fn sentence(error: &SourceError) -> String {
    let SourceError::Faulty(complaints) = error else { return error.to_string() };
    let Some(first) = complaints.0.first() else { return error.to_string() };
    let hint = first.hint.as_ref().map_or(String::new(), |hint| format!("; {hint}"));
    let more = match complaints.0.len() - 1 {
        0 => String::new(),
        more => format!(" (and {more} more)"),
    };
    format!("{}{hint}{more}", first.message)
}

/// The report that the columns are of.
fn report(profile: &Profile, spec: &SweepSpec) -> Result<Json, Error> {
    Ok(match spec.command {
        SweepCommand::Design => design(profile, spec)?,
        SweepCommand::DryRun => json(dry_run(profile, &Silent)?),
        SweepCommand::Build => json(BuildOptions::default().in_memory(profile, &Silent)?.0),
        SweepCommand::Frame => json(FrameOptions::default().in_memory(profile, &Silent)?.0),
        SweepCommand::Blur => json(BlurOptions::default().in_memory(profile, &Silent)?.0),
        SweepCommand::Tolerance => json(ToleranceOptions::default().in_memory(profile, &Silent)?.0),
        SweepCommand::Program => json(ProgramOptions.in_memory(profile, &Silent)?.0),
    })
}

/// The keys of a report, from its text.
fn json(report: impl Serialize) -> Json {
    serde_json::from_str(&json_text(&report)).unwrap_or_default()
}

/// Those groups of the report of a build that a column needs.
fn design(profile: &Profile, spec: &SweepSpec) -> Result<Json, Error> {
    let group = |key: &str| key.split(['.', '[']).next().unwrap_or("").to_owned();
    let groups: Vec<String> = spec.columns.iter().map(|column| group(&column.key)).collect();
    let is_needed = |group: &str| groups.iter().any(|needed| needed == group);
    // Most of the time of a design goes into its figures.
    let has_least = spec.columns.iter().any(|column| column.key.starts_with(LEAST_ERROR));
    let design = match (is_needed("design"), has_least) {
        (true, true) => designed(profile)?,
        (true, false) => designed_alone(profile)?,
        (false, _) => designed_unmeasured(profile)?,
    };
    let mut report = Map::new();
    for group in DESIGN_GROUPS.into_iter().filter(|group| is_needed(group)) {
        let value = match group {
            "layout" => json(design.mounting),
            "design" => json(&design.facts),
            "unwanted" => json(UnwantedViews::of(&design)),
            "form" => json(Form::of(&design.mirror)),
            "tool" => json(design.tool.as_ref().map(ToolFacts::of)),
            "cavity" => json(CavityFacts::of(&design)),
            "holes" => json(HoleFacts::of(design.made_body().0)),
            "sharpness" => json(sharpness(profile, &design)),
            _ => json(design.view.as_ref().map(|_| profile.acceptance_limits())),
        };
        report.insert(group.to_owned(), value);
    }
    Ok(Json::Object(report))
}
