//! Broken profiles: each is refused with exactly the complaints that are written down beside it.

use crate::support::builds::{folder, morion};
use morion::internals::profile::Profile;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A broken profile and the complaints it must draw.
struct Fixture {
    file: String,
    bytes: Vec<u8>,
    expected: String,
}

fn broken() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/broken")
}

/// Every `.expected` file with its profile; the one too large to keep is made here.
fn fixtures() -> Vec<Fixture> {
    let mut fixtures: Vec<Fixture> = fs::read_dir(broken())
        .expect("the fixtures are there")
        .map(|entry| entry.expect("a readable entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "expected"))
        .map(|path| {
            let stem = path.file_stem().expect("a name").to_string_lossy();
            let file = format!("{stem}.toml");
            let bytes = match stem.as_ref() {
                "megabyte-of-brackets" => vec![b'['; 1 << 20],
                _ => fs::read(broken().join(&file)).expect("a profile beside its expectation"),
            };
            let expected = fs::read_to_string(&path).expect("UTF-8");
            Fixture { file, bytes, expected: expected.trim_end().to_owned() }
        })
        .collect();
    fixtures.sort_by(|a, b| a.file.cmp(&b.file));
    fixtures
}

/// What is wrong with a refusal: it must exit with 2, say nothing on stdout, say `expected` on
/// stderr and leave nothing behind.
fn faults(output: &Output, out: &Path, expected: &[&str]) -> Vec<String> {
    let mut faults = Vec::new();
    if output.status.code() != Some(2) {
        faults.push(format!("ended with {}", output.status));
    }
    if !output.stdout.is_empty() {
        let stdout = String::from_utf8_lossy(&output.stdout);
        faults.push(format!("wrote to stdout: {stdout}"));
    }
    let stderr = String::from_utf8_lossy(&output.stderr);
    for expected in expected {
        if !stderr.contains(expected) {
            faults.push(format!("did not say: {expected}\nbut said: {stderr}"));
        }
    }
    if stderr.contains("panicked") {
        faults.push(format!("panicked: {stderr}"));
    }
    if out.exists() && fs::read_dir(out).map_or(true, |mut entries| entries.next().is_some()) {
        faults.push("left something behind".to_owned());
    }
    faults
}

#[test]
fn every_profile_here_has_an_expectation_and_there_are_many() {
    let profiles = fs::read_dir(broken())
        .expect("the fixtures are there")
        .map(|entry| entry.expect("a readable entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"));
    for profile in profiles {
        let expected = profile.with_extension("expected");
        assert!(expected.exists(), "{} is missing", expected.display());
    }
    assert!(fixtures().len() >= 28);
}

#[test]
fn the_library_complains_exactly_as_expected() {
    let mut wrong = Vec::new();
    for fixture in fixtures() {
        let found = match Profile::parse("broken", &fixture.file, &fixture.bytes) {
            Ok(_) => "it is valid".to_owned(),
            Err(complaints) => complaints.to_string(),
        };
        if found != fixture.expected {
            wrong.push(format!("{}: expected\n{}\nfound\n{found}", fixture.file, fixture.expected));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn the_program_complains_exactly_as_expected_and_writes_nothing() {
    let scratch = folder();
    let mut wrong = Vec::new();
    for fixture in fixtures() {
        fs::write(scratch.path().join(&fixture.file), &fixture.bytes).expect("a writable scratch");
        let out = scratch.path().join("out");
        let output = morion(scratch.path(), &["build", &fixture.file]);
        for fault in faults(&output, &out, &[&fixture.expected]) {
            wrong.push(format!("{}: {fault}", fixture.file));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn a_folder_is_no_profile() {
    let scratch = folder();
    fs::create_dir(scratch.path().join("folder.toml")).expect("a writable scratch");
    let out = scratch.path().join("out");
    let output = morion(scratch.path(), &["build", "folder.toml"]);
    let faults = faults(&output, &out, &["folder.toml"]);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let scratch = folder();
    let out = scratch.path().join("out");
    let output = morion(scratch.path(), &["build", "absent.toml"]);
    let faults = faults(&output, &out, &["absent.toml"]);
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
