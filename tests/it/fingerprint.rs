//! The fingerprint of what the program makes: the hash of every file of the shipped builds, of a
//! tolerance run, a drawing, an inspection's plan, a machining run, programs, look-up tables and a render.
//!
//! A refactoring leaves it as it is. A change of behaviour renews it knowingly:
//! `MORION_RENEW=1 cargo test --test it fingerprint`, and the commit says which figure changed and why.

use crate::support::builds::{SMALL, folder, morion, save, told};
use crate::support::shipped_builds;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

const HEAD: &str = "\
# SHA-256 of every file that the runs in tests/it/fingerprint.rs make, but for timings.
# Renewed by MORION_RENEW=1 cargo test --test it fingerprint
";

/// The runs beside the builds: the name of their folder, and their arguments.
const RUNS: [(&str, &[&str]); 7] = [
    ("drawing", &["conquistador"]),
    ("inspect", &["hyperbolic"]),
    ("machining", &["conquistador", "--ball-mm", "3", "--stepover-mm", "0.3"]),
    ("program", &["small.toml"]),
    ("render", &["panoramic", "--scene", "chessboard"]),
    ("table", &["small.toml", "--floor-mm", "-40"]),
    ("tolerance", &["conquistador", "--trials", "200", "--seed", "1"]),
];

type Hashes = BTreeMap<String, String>;

/// Adds the hashes of the files below `path`, whose names begin with `name`.
fn collect(path: &Path, name: &str, hashes: &mut Hashes) {
    for entry in std::fs::read_dir(path).unwrap() {
        let path = entry.unwrap().path();
        let file = path.file_name().unwrap().to_str().unwrap();
        let name = format!("{name}/{file}");
        if path.is_dir() {
            collect(&path, &name, hashes);
        } else if !file.ends_with("timings.json") {
            let mut hex = String::new();
            for byte in Sha256::digest(std::fs::read(&path).unwrap()) {
                write!(hex, "{byte:02x}").unwrap();
            }
            hashes.insert(name, hex);
        }
    }
}

fn made() -> Hashes {
    let mut hashes = Hashes::new();
    collect(shipped_builds::folder(), "build", &mut hashes);
    let out = folder();
    save(out.path(), SMALL);
    for (command, arguments) in RUNS {
        let arguments = [&[command], arguments, &["--out", command]].concat();
        let (code, _, err) = told(&morion(out.path(), &arguments));
        assert!(code < 2, "{arguments:?}: {err}");
    }
    for (command, _) in RUNS {
        collect(&out.path().join(command), command, &mut hashes);
    }
    hashes
}

/// The lines that differ: a file that is new, gone or changed.
fn differences(before: &Hashes, now: &Hashes) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, hash) in now {
        match before.get(name) {
            None => lines.push(format!("new      {name}")),
            Some(old) if old != hash => lines.push(format!("changed  {name}")),
            Some(_) => {}
        }
    }
    let gone = before.keys().filter(|name| !now.contains_key(*name));
    lines.extend(gone.map(|name| format!("gone     {name}")));
    lines
}

fn read(text: &str) -> Hashes {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let pair = |line: &str| {
        let (hash, name) = line.split_once("  ").unwrap_or_else(|| panic!("{line:?}"));
        (name.to_owned(), hash.to_owned())
    };
    lines.map(pair).collect()
}

#[test]
fn files_have_the_bytes_of_the_fingerprint() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fingerprint.txt");
    let now = made();
    assert!(now.len() > 12 * 4, "{} files", now.len());
    if std::env::var_os("MORION_RENEW").is_some() {
        let lines = now.iter().map(|(name, hash)| format!("{hash}  {name}\n"));
        std::fs::write(&path, HEAD.to_owned() + &lines.collect::<String>()).unwrap();
        return;
    }
    let lines = differences(&read(&std::fs::read_to_string(&path).unwrap()), &now);
    assert!(
        lines.is_empty(),
        "the program makes other files than the fingerprint says; if that is meant, renew it by \
         MORION_RENEW=1 cargo test --test it fingerprint\n{}",
        lines.join("\n")
    );
}

#[test]
fn differences_from_the_fingerprint_are_told_by_name() {
    let before = read("# head\naa  kept\nbb  other\ncc  lost\n");
    let now = read("aa  kept\nb0  other\ndd  more\n");
    assert_eq!(differences(&before, &now), ["new      more", "changed  other", "gone     lost"]);
    assert!(differences(&now, &now).is_empty());
}
