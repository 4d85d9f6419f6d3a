//! The last build in a folder: whether the next one would only repeat it.

use super::observer::{StageTimer, Timings, Work};
use crate::profile::FileFormat;
use crate::profile::Profile;
use crate::publish::HashingWriter;
use crate::results::BuildReport;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::time::UNIX_EPOCH;

/// Why a stage had nothing to do.
const UNCHANGED: &str = "nothing has changed since the last build in this folder";

/// What a build was made of and what it left, for the next one: part of `timings.json`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct BuildRecord {
    /// SHA-256 of all that its files depend on.
    pub inputs: String,
    /// Its files but for `timings.json` itself.
    pub outputs: Vec<Output>,
    /// Work of its stages.
    pub work: Vec<Work>,
}

impl BuildRecord {
    /// `timings.json`: with the times of the build that this is of.
    pub(super) fn json(self, clock: &StageTimer) -> String {
        let Self { inputs, outputs, work } = self;
        let all = BuildTimings { inputs, outputs, times: clock.timings(work) };
        format!("{:#}\n", serde_json::json!(all))
    }
}

/// `timings.json`: run times and work of a build, and what the next one compares.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BuildTimings {
    /// SHA-256 of all that the files of the build depend on, hexadecimal.
    pub inputs: String,
    /// The files but for `timings.json` itself.
    pub outputs: Vec<Output>,
    /// Run times and work.
    #[serde(flatten)]
    pub times: Timings,
}

/// A file as it was published. One of the same length and time of change is taken for the same, as
/// `make` does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Output {
    /// Name in its folder.
    pub name: String,
    /// Length, bytes.
    pub bytes: u64,
    /// When it was written, ns since 1970.
    pub written_ns: u64,
}

impl Output {
    /// The file at `path`, which has or will have the name `name`.
    pub(super) fn of(path: &Path, name: &str) -> Option<Self> {
        let about = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
        let written = about.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        let written_ns = u64::try_from(written.as_nanos()).ok()?;
        Some(Self { name: name.to_owned(), bytes: about.len(), written_ns })
    }
}

/// SHA-256 of all that the files of a build depend on: the program's sources and `profile` as it is
/// understood.
pub(crate) fn inputs(profile: &Profile) -> String {
    let mut out = HashingWriter::new(io::sink());
    // Every field is in it, every number to the last digit. Hashing cannot fail.
    let _ = write!(out, "{} {profile:?}", env!("MORION_SOURCES"));
    out.sha256()
}

/// The report of the last build in `folder` if it was made of `inputs`, its files are as it left
/// them, and there is none of another format; and its record as that of a build which had nothing to
/// do.
pub(super) fn unchanged(folder: &Path, inputs: &str) -> Option<(BuildReport, BuildRecord)> {
    let read = |name: &str| fs::read(folder.join(name)).ok();
    let mut record: BuildRecord = serde_json::from_slice(&read("timings.json")?).ok()?;
    let is_same = |output: &Output| {
        Output::of(&folder.join(&output.name), &output.name).as_ref() == Some(output)
    };
    let is_foreign = |format: FileFormat| {
        let name = format.file_name();
        !record.outputs.iter().any(|output| output.name == name) && folder.join(name).exists()
    };
    let same = record.inputs == inputs
        && record.outputs.iter().all(is_same)
        && !FileFormat::all().any(is_foreign);
    let report = serde_json::from_slice(&read("report.json")?).ok().filter(|_| same)?;
    for work in &mut record.work {
        work.avoided += std::mem::take(&mut work.done);
        UNCHANGED.clone_into(&mut work.why);
    }
    Some((report, record))
}
