//! Whole builds: a small profile, folders, and the program itself. The tests of the process compile this
//! file too.

use morion::internals::profile::Profile;
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A conquistador of some twelve thousand facets, which builds in a moment and passes.
pub const SMALL: &str = r#"summary = "A small conquistador"

[camera.orthographic]
pixels = [160, 120]

[projection.cylindrical]
azimuth_deg = [-180, 180]
elevation_deg = [-30, 30]

[layout.conquistador]
panel = "refit"
ridge = "crest"
fill_frame = true

[method.vector-field]
degree = 8

[part]
width_mm = 15
base_mm = 2

[mesh]
chord_um = 20
facet_px = 3

[export]
formats = ["stl", "obj"]

[accept]
pixel_error_rms_px = 2
pixel_error_max_px = 5
frame_filled = 0.99
"#;

/// `text` with each `from` that it holds replaced by its `to`.
pub fn edited(text: &str, edits: &[(&str, &str)]) -> String {
    edits.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "no {from} in the profile");
        text.replace(from, to)
    })
}

/// Reads a profile called `small`.
pub fn parsed(text: &str) -> Profile {
    Profile::parse("small", "small.toml", text.as_bytes())
        .unwrap_or_else(|complaints| panic!("{complaints}\n{text}"))
}

/// A folder that goes when it is dropped.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder can be made")
}

/// Writes `text` as `small.toml` into `folder`, which is made if need be.
pub fn save(folder: &Path, text: &str) -> PathBuf {
    std::fs::create_dir_all(folder).unwrap();
    let path = folder.join("small.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// The program, to be run in `folder`, deaf to the caller's taste in colours.
pub fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_morion"));
    command.current_dir(folder);
    for variable in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
        command.env_remove(variable);
    }
    command
}

/// Runs the program in `folder`.
pub fn morion<S: AsRef<OsStr>>(folder: &Path, arguments: &[S]) -> Output {
    command(folder).args(arguments).output().expect("the program starts")
}

/// Exit code, stdout and stderr.
pub fn told(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("output is UTF-8");
    let code = output.status.code().expect("the program ends by itself");
    (code, text(&output.stdout), text(&output.stderr))
}

/// Every file in `folder` by its name; none where there is no folder.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    if !folder.exists() {
        return BTreeMap::new();
    }
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    std::fs::read_dir(folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .map(|path| (name(&path), std::fs::read(&path).unwrap()))
        .collect()
}

/// Asserts that two sets of files are the same, without printing megabytes.
#[track_caller]
pub fn assert_same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>, what: &str) {
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(a), names(b), "{what}");
    for (name, bytes) in a {
        let other = &b[name];
        if let Some(at) = bytes.iter().zip(other).position(|(a, b)| a != b) {
            panic!("{what}: {name} differs from byte {at}");
        }
        assert_eq!(bytes.len(), other.len(), "{what}: length of {name}");
    }
}

/// The files but for the timings, which differ from run to run.
pub fn lasting(mut files: BTreeMap<String, Vec<u8>>) -> BTreeMap<String, Vec<u8>> {
    assert!(files.remove("timings.json").is_some(), "no timings.json");
    files
}
