//! What a build may leave undone: all of it where nothing has changed, and shortcuts that change no
//! byte.

use crate::support::builds::{
    self, SMALL, assert_same, command, edited, files, folder, lasting, morion, save, told,
};
use crate::support::{shipped_text, small_but};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Formats of every kind.
const ALL: &str = "[\"stl\", \"obj\", \"3mf\", \"glb\", \"step\", \"csv\"]";
const LINE: &str = "unchanged  made/small: profile, program and files are as the last build left \
                    them; --force builds again\n";

/// Builds `text` in `at`: exit code, summary, what was said, and all files.
fn build(at: &Path, text: &str, more: &[&str]) -> (i32, String, String, BTreeMap<String, Vec<u8>>) {
    save(at, text);
    let arguments = [&["build", "small.toml", "--out", "made"], more].concat();
    let (code, out, err) = told(&morion(at, &arguments));
    assert!(code < 2, "{err}");
    (code, out, err, files(&at.join("made/small")))
}

/// The work in `timings.json`: stage and what, done, avoided, why.
fn work(files: &BTreeMap<String, Vec<u8>>) -> Vec<(String, u64, u64, String)> {
    let timings: Value = serde_json::from_slice(&files["timings.json"]).unwrap();
    let word = |work: &Value, key: &str| work[key].as_str().unwrap().to_owned();
    let number = |work: &Value, key: &str| work[key].as_u64().unwrap();
    let each = |work: &Value| {
        let what = format!("{} {}", word(work, "stage"), word(work, "what"));
        (what, number(work, "done"), number(work, "avoided"), word(work, "why"))
    };
    timings["work"].as_array().unwrap().iter().map(each).collect()
}

#[test]
fn an_unchanged_build_is_not_repeated_and_says_the_same() {
    let valley = small_but("\"crest\"", "\"valley\"");
    for (text, verdict) in [(SMALL, 0), (&valley, 1)] {
        let text = edited(text, &[("[\"stl\", \"obj\"]", ALL)]);
        let folder = folder();
        let first = build(folder.path(), &text, &[]);
        assert_eq!(first.0, verdict);
        let second = build(folder.path(), &text, &[]);
        assert_eq!((second.0, &second.1, &*second.2), (verdict, &first.1, LINE));
        let (before, after) = (work(&first.3), work(&second.3));
        assert!(before.iter().any(|(_, done, ..)| *done > 0));
        for ((what, done, avoided, _), (again, none, all, why)) in before.into_iter().zip(after) {
            assert_eq!((none, all, &*again), (0, done + avoided, &*what));
            assert!(why.starts_with("nothing has changed"), "{what}: {why}");
        }
        assert_same(&lasting(first.3), &lasting(second.3), "the second build");
        // As JSON too, and once more.
        let json =
            |more: &[&str]| build(folder.path(), &text, &[&["--format", "json"], more].concat());
        let (again, afresh) = (json(&[]), json(&["--force"]));
        assert_eq!((again.0, &again.1, &*again.2), (verdict, &afresh.1, LINE));
        assert!(afresh.2.contains("mesh ") && !afresh.2.contains("unchanged"), "{}", afresh.2);
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn whatever_has_changed_is_built_again() {
    let folder = folder();
    let small = folder.path().join("made/small");
    let first = lasting(build(folder.path(), SMALL, &[]).3);
    let rebuilt = |what: &str, text: &str| {
        let made = build(folder.path(), text, &[]);
        assert!(made.2.contains("mesh ") && !made.2.contains("unchanged"), "{what}: {}", made.2);
        lasting(made.3)
    };
    let alter = |name: &str, change: &dyn Fn(&File)| {
        change(&File::options().write(true).open(small.join(name)).unwrap());
    };
    fs::remove_file(small.join("mirror.stl")).unwrap();
    assert_same(&first, &rebuilt("a file removed", SMALL), "a file removed");
    alter("mirror.obj", &|file| file.set_len(1000).unwrap());
    assert_same(&first, &rebuilt("a file cut short", SMALL), "a file cut short");
    let past = SystemTime::now() - Duration::from_secs(100);
    alter("preview.png", &|file| file.set_modified(past).unwrap());
    assert_same(&first, &rebuilt("a file of another time", SMALL), "a file of another time");
    fs::write(small.join("mirror.3mf"), "another profile's").unwrap();
    assert_same(&first, &rebuilt("a foreign file", SMALL), "a foreign file");
    fs::write(small.join("timings.json"), "{}").unwrap();
    assert_same(&first, &rebuilt("no record", SMALL), "no record");
    alter("report.json", &|file| {
        let about = file.metadata().unwrap();
        file.set_len(10).unwrap();
        file.set_len(about.len()).unwrap();
        file.set_modified(about.modified().unwrap()).unwrap();
    });
    assert_same(&first, &rebuilt("a report that is none", SMALL), "a report that is none");
    // A comment is in the report's hash.
    let commented = format!("# A comment.\n{SMALL}");
    assert_ne!(first, rebuilt("a comment", &commented));
    assert!(build(folder.path(), &commented, &[]).2 == LINE);
}

#[test]
fn a_profile_changed_in_memory_is_another_one() {
    let folder = folder();
    let build = |chord_um| {
        let mut profile = builds::parsed(SMALL);
        profile.mesh =
            morion::internals::profile::MeshGoal::limits(Some(chord_um), profile.mesh.facet_px());
        let source = profile;
        let report = morion::internals::pipeline::build(
            &source,
            folder.path(),
            &morion::internals::pipeline::Silent,
        );
        report.unwrap().mesh.unwrap().chord_um.limit
    };
    assert_eq!([20.0, 10.0, 10.0, 20.0].map(build), [20.0, 10.0, 10.0, 20.0].map(Some));
}

#[test]
#[ignore = "long: .ci/nightly"]
fn no_shortcut_changes_a_byte() {
    let valley = small_but("\"crest\"", "\"valley\"");
    let round =
        edited(shipped_text("hyperbolic"), &[("\"stl\", \"obj\"", "\"stl\", \"obj\", \"csv\"")]);
    for (text, copies) in [(SMALL, 2), (&valley, 2), (&round, 4)] {
        let (short, long) = (folder(), folder());
        let short = build(short.path(), text, &[]);
        let long = build(long.path(), text, &["--no-skip"]);
        assert_eq!((short.0, &short.1), (long.0, &long.1));
        let of = |files: &BTreeMap<String, Vec<u8>>, what: &str| {
            let found = work(files).into_iter().find(|(name, ..)| name == what);
            found.map_or_else(|| panic!("{what}"), |(_, done, avoided, _)| [done, avoided])
        };
        for what in ["trace camera rays searched for", "trace reflected rays followed"] {
            let ([done, avoided], [all, none]) = (of(&short.3, what), of(&long.3, what));
            assert_eq!((all, none), (done + avoided, 0), "{what}");
            assert!(avoided > done, "{what}");
        }
        let what = "mesh facets meshed and proven";
        let ([done, avoided], [all, rest]) = (of(&short.3, what), of(&long.3, what));
        assert_eq!((done * copies, done + avoided), (all, all + rest));
        assert_same(&lasting(short.3), &lasting(long.3), "no shortcuts");
    }
}

#[test]
fn the_ways_are_told_apart() {
    let folder = folder();
    let path = save(folder.path(), SMALL);
    let mut command = command(folder.path());
    let asked = command.args(["build", "--dry-run", "--force"]).arg(path).output().unwrap();
    assert_eq!(told(&asked).0, 2);
}
