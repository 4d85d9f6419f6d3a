//! JSON Schemas (draft 2020-12) of all JSON outputs: files made from the types that are serialised, and held to them by a test.

#[cfg(test)]
mod derived;

use super::failure::CommandFailure;
use crate::packed_text::{PackedText, packed_text};
use crate::results::NamedOutput;

/// An output, and the schema of its type as JSON of several lines.
struct Output {
    named: NamedOutput,
    text: PackedText,
}

/// Rows of name, what it is, and the commands that it is from.
macro_rules! outputs {
    ($($name:literal, $what:literal, $from:literal;)+) => {
        [$(Output {
            named: NamedOutput { name: $name, what: $what, from: $from },
            text: packed_text!(concat!($name, ".json")),
        }),+]
    };
}

/// All JSON outputs, those of `morion build` first.
static OUTPUTS: [Output; 25] = outputs![
    "bench", "bench.json", "morion bench";
    "build", "report.json of a build", "morion build";
    "dry-run", "forecast of a build", "morion build --dry-run";
    "timings", "timings.json", "morion build (the file alone)";
    "check", "valid profile", "morion check";
    "verify", "report.json of a verified file", "morion verify";
    "render", "picture that was rendered", "morion render";
    "frame", "frame.json", "morion frame";
    "unwrap", "photo that was unwrapped", "morion unwrap";
    "table", "table.json", "morion table";
    "blur", "blur.json", "morion blur";
    "tolerance", "tolerance.json", "morion tolerance";
    "part", "trials of a part of a run", "morion tolerance --part";
    "replay", "replay.json", "morion tolerance --replay";
    "pose", "pose.json", "morion tolerance --replay (the file alone)";
    "tolerance-timings", "tolerance-timings.json", "morion tolerance (the file alone)";
    "machining", "machining.json", "morion machining";
    "program", "program.json", "morion program";
    "inspect", "inspection.json", "morion inspect";
    "drawing", "drawing.json", "morion drawing";
    "sweep", "sweep.json", "morion sweep";
    "shard", "points of one job of a study", "morion sweep --shard";
    "profiles", "shipped profile, a line for each", "morion profiles";
    "schema", "JSON output, a line for each", "morion schema";
    "error", "error, a line for each", "every command that ends with exit code 2";
];

/// All JSON outputs.
pub(super) fn outputs() -> impl Iterator<Item = NamedOutput> {
    OUTPUTS.iter().map(|output| output.named.clone())
}

/// The JSON Schema of the output `name`.
///
/// # Errors
/// A sentence that lists the names, if this is none of them.
pub(super) fn named(name: &str) -> Result<&'static str, CommandFailure> {
    let known = OUTPUTS.iter().find(|output| output.named.name == name);
    known.map(|output| output.text.text()).ok_or_else(|| {
        let names: Vec<&str> = outputs().map(|output| output.name).collect();
        CommandFailure::unknown("JSON output", name, &names)
    })
}
