//! Studies: TOML texts that say which keys of a profile are swept, and which figures are kept of each design.

mod axis;
mod check;
mod fields;
mod key_path;

use super::complaint::Complaints;
use super::edit::{KeyStep, set_value};
use super::reader::ProfileReader;
use super::schema::Schema;
use super::source;
use serde::Serialize;
use serde_json::Value as Json;
use toml_edit::DocumentMut;

/// Most points of a study: a row of each is kept in memory.
pub const MOST_POINTS: usize = 1_000_000;

/// The tables of a study.
const STUDY: Schema = Schema {
    whole: "the study",
    tables: &[
        ("", &["profile", "command", "axis", "column"]),
        (
            "axis",
            &["key", "label", "values", "from", "to", "count", "scale", "paired_with", "goal"],
        ),
        ("column", &["key", "label", "goal"]),
    ],
    lists: &["axis", "column"],
};

/// A checked study.
#[derive(Clone, Debug)]
pub struct SweepSpec {
    /// The name that output goes under: the file's name without `.toml`.
    pub name: String,
    /// The profile, as the study names it.
    pub profile: String,
    /// What each point runs.
    pub command: SweepCommand,
    /// Keys that are swept; at least one.
    pub axes: Vec<AxisSpec>,
    /// Figures that are kept; at least one.
    pub columns: Vec<ColumnSpec>,
    /// The text of the profile.
    base: DocumentMut,
}

/// What a point of a study runs, on a profile with its values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SweepCommand {
    /// The design alone: those keys of `report.json` that need no mesh.
    Design,
    /// The forecast of a build.
    DryRun,
    /// A whole build.
    Build,
    /// The filling of the frame.
    Frame,
    /// The spots through an open lens.
    Blur,
    /// Tolerances and yield.
    Tolerance,
    /// Programs that mill the mirror.
    Program,
}

impl SweepCommand {
    /// All of them, with their names in a study.
    pub const ALL: [(&'static str, Self); 7] = [
        ("design", Self::Design),
        ("dry-run", Self::DryRun),
        ("build", Self::Build),
        ("frame", Self::Frame),
        ("blur", Self::Blur),
        ("tolerance", Self::Tolerance),
        ("program", Self::Program),
    ];

    /// Its name in a study.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, command)| *command == self).map_or("", |(name, _)| name)
    }
}

/// A key of the profile that takes several values.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSpec {
    /// The key, as the study names it: `part.width_mm`, `projection.cylindrical.elevation_deg[1]`.
    pub key: String,
    /// The way to it.
    pub path: Vec<KeyStep>,
    /// What it is called in plots; none: by its key.
    pub label: Option<String>,
    /// Its values, all of one kind; at least one.
    pub values: Vec<Json>,
    /// Whether they are equally spaced in their logarithms.
    pub is_logarithmic: bool,
    /// The earlier axis with which it goes step by step, as many values as this; none of an axis of its own.
    pub paired_with: Option<usize>,
    /// What is sought of it, a number then; none: nothing.
    pub goal: Option<ColumnGoal>,
}

/// A figure of the report that is kept of each point.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnSpec {
    /// Its key in the report: `design.pixel_error_px.rms`, `sharpness.best.resolved[0]`.
    pub key: String,
    /// What it is called in plots; none: by its key.
    pub label: Option<String>,
    /// What is sought of it; none: nothing.
    pub goal: Option<ColumnGoal>,
}

/// What is sought of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ColumnGoal {
    /// The least value.
    Least,
    /// The largest value.
    Most,
}

/// The text of a profile that a study names, or why there is none.
pub type FindText<'f> = dyn Fn(&str) -> Result<String, String> + 'f;

/// Whether a command's report has a figure under a key; if not, a hint, or nothing.
pub type CheckColumn<'f> = dyn Fn(SweepCommand, &str) -> Result<(), String> + 'f;

/// What a study is checked against.
#[derive(Clone, Copy)]
pub struct StudyContext<'f> {
    /// Texts of profiles.
    pub profile: &'f FindText<'f>,
    /// Keys of reports.
    pub column: &'f CheckColumn<'f>,
}

impl SweepSpec {
    /// Reads and checks a study. On failure every complaint that can be made is made, in the order of the file.
    ///
    /// # Errors
    /// [`Complaints`], each with its place and a hint.
    pub fn parse(
        name: &str,
        file: &str,
        bytes: &[u8],
        context: StudyContext,
    ) -> Result<Self, Complaints> {
        let text = source::text(file, bytes)?;
        let (tree, errors) = toml::de::DeTable::parse_recoverable(text);
        let mut reader = ProfileReader::of(STUDY, file, text);
        errors.iter().for_each(|error| reader.broken(error));
        let found = check::study(&mut reader, tree.get_ref(), name, context);
        found.filter(|_| reader.is_clean()).ok_or_else(|| reader.into_complaints())
    }

    /// The text of the profile with these values of the axes, in their order.
    ///
    /// # Errors
    /// A sentence where a value has no place in it.
    pub fn text_with<'v>(
        &self,
        values: impl IntoIterator<Item = &'v Json>,
    ) -> Result<String, String> {
        let mut text = self.base.clone();
        for (axis, value) in self.axes.iter().zip(values) {
            set_value(&mut text, &axis.path, value)?;
        }
        Ok(text.to_string())
    }
}

/// A number as JSON: a whole one without a decimal point.
pub(super) fn number(x: f64) -> Json {
    // Up to there every whole number is one of double precision.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    if x.fract() == 0.0 && x.abs() < EXACT { Json::from(x as i64) } else { Json::from(x) }
}
