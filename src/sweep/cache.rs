//! Outcomes of points that earlier runs have left in journals, by what the points are known by.

use super::point::ValidPoint;
use crate::profile::ColumnSpec;
use crate::publish::{FileError, files_of, journal_lines};
use crate::results::{PointOutcome, PointStatus};
use serde::{Deserialize, Serialize};
use serde_json::Value as Json;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;

/// A line of a journal.
#[derive(Debug, Serialize, Deserialize)]
struct JournalLine {
    /// What the point is known by.
    key: String,
    status: PointStatus,
    error: Option<String>,
    /// Its figures by their keys.
    values: BTreeMap<String, Json>,
}

/// Outcomes by the keys of their points.
#[derive(Debug, Default)]
pub(super) struct Cache(HashMap<String, JournalLine>);

/// Name of the journal of a whole study, or of the shard `[number, of]`.
pub(super) fn journal_name(shard: Option<[usize; 2]>) -> String {
    match shard {
        Some([number, of]) => format!("{PREFIX}-{number}-of-{of}{SUFFIX}"),
        None => format!("{PREFIX}{SUFFIX}"),
    }
}

const PREFIX: &str = "journal";
const SUFFIX: &str = ".ndjson";

impl Cache {
    /// What all journals in `folder` hold of `columns`.
    ///
    /// # Errors
    /// [`FileError`] when one cannot be read.
    pub(super) fn read(folder: &Path, columns: &[ColumnSpec]) -> Result<Self, FileError> {
        let mut cache = Self::default();
        let mut paths = files_of(folder)?;
        paths.retain(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.starts_with(PREFIX) && name.ends_with(SUFFIX)
        });
        paths.sort();
        for path in paths {
            for line in journal_lines(&path)? {
                // What is no line of ours is not known.
                let Ok(mut line) = serde_json::from_str::<JournalLine>(&line) else { continue };
                line.values.retain(|key, _| columns.iter().any(|column| column.key == *key));
                match cache.0.get_mut(&line.key) {
                    Some(known) => known.values.append(&mut line.values),
                    None => drop(cache.0.insert(line.key.clone(), line)),
                }
            }
        }
        Ok(cache)
    }

    /// The outcome of a point, if all of its columns are known.
    pub(super) fn outcome(
        &self,
        point: &ValidPoint,
        columns: &[ColumnSpec],
    ) -> Option<PointOutcome> {
        let line = self.0.get(&point.key)?;
        let value = |column: &ColumnSpec| line.values.get(&column.key).cloned();
        let values = match line.status {
            PointStatus::Made => columns.iter().map(value).collect::<Option<Vec<Json>>>()?,
            _ => Vec::new(),
        };
        Some(PointOutcome { status: line.status, error: line.error.clone(), values })
    }
}

/// The line of a journal for the outcome of a point.
pub(super) fn line(point: &ValidPoint, outcome: &PointOutcome, columns: &[ColumnSpec]) -> String {
    let keys = columns.iter().map(|column| column.key.clone());
    let line = JournalLine {
        key: point.key.clone(),
        status: outcome.status,
        error: outcome.error.clone(),
        values: keys.zip(outcome.values.iter().cloned()).collect(),
    };
    serde_json::to_string(&line).unwrap_or_default()
}
