//! The shipped profiles, built once in a run of the tests, by the program itself.

use super::builds::{command, told};
use morion::internals::profile::shipped;
use morion::internals::results::BuildReport;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("shipped");
    std::fs::create_dir_all(&folder).unwrap();
    let names = shipped().iter().map(|profile| profile.name);
    let mut command = command(&folder);
    // Whatever an earlier run left, these are the files of this program.
    command.args(["build", "--force", "--quiet", "--out", "."]).args(names);
    let (code, out, err) = told(&command.output().expect("the program starts"));
    assert!(code < 2, "{out}{err}");
    folder
});

/// The folder with a folder of results for each shipped profile.
pub fn folder() -> &'static Path {
    &FOLDER
}

/// The report of a shipped profile's build.
pub fn report(name: &str) -> BuildReport {
    let path = folder().join(name).join("report.json");
    let text = std::fs::read_to_string(&path);
    let text = text.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
