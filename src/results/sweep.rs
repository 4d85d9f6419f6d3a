//! What a study found: its points, the best of them, and those that none beats.

use super::{FileFacts, ProfileId};
use crate::profile::{ColumnGoal, SweepCommand};
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

/// Results of a study, in the shape of `sweep.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct SweepReport {
    /// Version of these keys.
    pub schema: u32,
    /// Name of the study.
    pub study: String,
    /// The profile whose keys were swept.
    pub profile: ProfileId,
    /// What each point ran.
    pub command: SweepCommand,
    /// Number of points.
    pub points: usize,
    /// Number of those that have figures.
    pub made: usize,
    /// Number of those whose profile is not valid.
    pub invalid: usize,
    /// Number of those whose profile is valid and has no answer, as a mirror that cannot be designed.
    pub refused: usize,
    /// The keys that were swept.
    pub axes: Vec<AxisFacts>,
    /// The figures that were kept.
    pub columns: Vec<ColumnFacts>,
    /// Number of points that no other beats in every goal; 0 without a goal.
    pub front_points: usize,
    /// Those points, or some of them spread over all, by the first goal, the best first.
    pub front: Vec<PointFacts>,
    /// Why points have no figures, the commonest first; at most ten.
    pub failures: Vec<PointFailures>,
    /// The tables of all points.
    pub files: Vec<FileFacts>,
    /// Nuisances, and what to do about them.
    pub warnings: Vec<String>,
}

/// A key that was swept.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct AxisFacts {
    /// The key.
    pub key: String,
    /// What it is called in plots.
    pub label: String,
    /// Number of its values.
    pub values: usize,
    /// The least and the largest of them; null where they are no numbers.
    pub range: Option<[f64; 2]>,
    /// Whether they are equally spaced in their logarithms.
    pub is_logarithmic: bool,
    /// The key of the axis with which it goes step by step; null of an axis of its own.
    pub paired_with: Option<String>,
    /// What is sought of it; null: nothing.
    pub goal: Option<ColumnGoal>,
}

/// A figure that was kept of each point.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ColumnFacts {
    /// Its key in the report.
    pub key: String,
    /// What it is called in plots.
    pub label: String,
    /// What is sought of it; null: nothing.
    pub goal: Option<ColumnGoal>,
    /// Number of points that have a value.
    pub known: usize,
    /// The least and the largest of its numbers; null where there are none.
    pub range: Option<[f64; 2]>,
    /// The point with the best value, of equal ones the first on the front, or else the first; null without a goal or
    /// numbers.
    pub best: Option<PointFacts>,
}

/// A point with all that is known of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PointFacts {
    /// Its number, from 0.
    pub point: usize,
    /// Its values of the axes, in their order.
    pub axes: Vec<Json>,
    /// Its figures, in the order of the columns.
    pub columns: Vec<Json>,
}

/// Points that have no figures for one reason.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PointFailures {
    /// Number of them.
    pub points: usize,
    /// The first of them, from 0.
    pub first: usize,
    /// What became of them.
    pub status: PointStatus,
    /// The error of the first; those of the others differ in numbers at most.
    pub error: String,
}

/// What became of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum PointStatus {
    /// It has figures.
    Made,
    /// Its profile is not valid.
    Invalid,
    /// Its profile is valid and has no answer.
    Refused,
}

impl PointStatus {
    /// In a word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Made => "made",
            Self::Invalid => "invalid",
            Self::Refused => "refused",
        }
    }
}

/// Points that one of several jobs made: the answer of `morion sweep --shard`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ShardReport {
    /// Path of the journal that holds them.
    pub journal: String,
    /// Number of its points, of which some may be those of earlier runs.
    pub points: usize,
}

/// Figures of a point, or why it has none.
#[derive(Debug, Clone, PartialEq)]
pub struct PointOutcome {
    /// What became of it.
    pub status: PointStatus,
    /// Why it has no figures, on one line.
    pub error: Option<String>,
    /// Its figures, in the order of the columns; null what its report has not.
    pub values: Vec<Json>,
}

/// A point of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepRow {
    /// Its values of the axes, in their order.
    pub axes: Vec<Json>,
    /// What came of it.
    pub outcome: PointOutcome,
    /// Whether no other point beats it in every goal.
    pub is_on_front: bool,
}

impl SweepRow {
    /// The number at a place among its values of the axes and then its figures; none of a point without figures.
    #[must_use]
    pub fn number(&self, place: usize) -> Option<f64> {
        let values = &self.outcome.values;
        let found = match place.checked_sub(self.axes.len()) {
            Some(column) => values.get(column),
            None => self.axes.get(place).filter(|_| self.outcome.status == PointStatus::Made),
        };
        found.and_then(Json::as_f64)
    }
}

/// All points of a study, in the order of their numbers, from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepTable {
    /// Keys of the axes.
    pub axes: Vec<String>,
    /// Keys of the columns.
    pub columns: Vec<String>,
    /// The points.
    pub rows: Vec<SweepRow>,
}

/// How a key is called in a plot: its words, then its unit.
#[must_use]
pub fn words_of_key(key: &str) -> String {
    /// Units by which keys end, and how they are written.
    const UNITS: [(&str, &str); 22] = [
        ("_mm_min", "mm/min"),
        ("_mm_s2", "mm/s^2"),
        ("_mm3", "mm^3"),
        ("_mm2", "mm^2"),
        ("_mm", "mm"),
        ("_um", "um"),
        ("_nm", "nm"),
        ("_px", "px"),
        ("_deg", "deg"),
        ("_mrad", "mrad"),
        ("_urad", "urad"),
        ("_rad", "rad"),
        ("_usr", "usr"),
        ("_sr", "sr"),
        ("_ppm", "ppm"),
        ("_rpm", "1/min"),
        ("_min", "min"),
        ("_s", "s"),
        ("_k", "K"),
        ("_mb", "MB"),
        ("_n", "N"),
        ("_ms", "ms"),
    ];
    let mut unit = None;
    let word = |part: &str| {
        let (name, entry) = part.split_at(part.find('[').unwrap_or(part.len()));
        let found = UNITS.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)));
        let name = found.map_or(name, |(name, _)| name).replace('_', " ");
        unit = found.map(|(_, unit)| unit).or(unit);
        format!("{name}{entry}")
    };
    let words: Vec<String> = key.split('.').map(word).collect();
    let unit = unit.map_or(String::new(), |unit| format!(", {unit}"));
    format!("{}{unit}", words.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_read_as_words_with_their_unit() {
        for (key, words) in [
            ("part.width_mm", "part width, mm"),
            ("design.pixel_error_px.rms", "design pixel error rms, px"),
            ("projection.cylindrical.elevation_deg[1]", "projection cylindrical elevation[1], deg"),
            ("method.vector-field.degree", "method vector-field degree"),
            ("program.feed_mm_min", "program feed, mm/min"),
            ("solid.volume_mm3", "solid volume, mm^3"),
        ] {
            assert_eq!(words_of_key(key), words);
        }
    }
}
