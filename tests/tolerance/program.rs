//! The command: files, streams, exit codes, and runs in parts.

use crate::common::{SMALL, edited, files, folder, morion, save, told};
use std::collections::BTreeMap;
use std::path::Path;

/// The small profile under a camera of few pixels.
fn small() -> String {
    edited(SMALL, &[("[160, 120]", "[16, 12]")])
}

const FILES: [&str; 2] = ["tolerance.json", "trials.csv"];

/// The files of a run.
fn run(home: &Path, arguments: &[&str], expected: i32) -> BTreeMap<String, Vec<u8>> {
    let mut all = vec!["tolerance"];
    all.extend(arguments);
    let (code, out, err) = told(&morion(home, &all));
    assert_eq!(code, expected, "{out}{err}");
    let read = |name: &&str| std::fs::read(home.join("out/small").join(name)).unwrap();
    FILES.iter().map(|name| ((*name).to_owned(), read(name))).collect()
}

#[track_caller]
fn refused(home: &Path, arguments: &[&str], words: &[&str]) {
    let mut all = vec!["tolerance"];
    all.extend(arguments);
    let (code, out, err) = told(&morion(home, &all));
    assert_eq!((code, &*out), (2, ""), "{arguments:?}: {err}");
    assert!(words.iter().all(|word| err.contains(word)), "{words:?}: {err}");
}

#[test]
fn parts_of_any_size_make_the_bytes_of_one_run_on_any_threads() {
    let folder = folder();
    let home = folder.path();
    save(home, &small());
    let whole = run(home, &["small.toml", "--trials", "90", "--seed", "7", "--threads", "1"], 1);
    for range in ["60..90", "0..33", "33..60"] {
        let arguments = ["tolerance", "small.toml", "--trials", range, "--seed", "7", "--part"];
        let (code, out, _) = told(&morion(home, &arguments));
        assert_eq!(code, 0, "{out}");
    }
    let part = |range: &str| format!("out/small/trials-{range}.csv");
    let parts = ["60-90", "0-33", "33-60"].map(part);
    let [a, b, c] = parts.each_ref().map(String::as_str);
    assert!(run(home, &["--threads", "3", "--merge", a, b, c], 1) == whole);

    let kept = files(&home.join("out/small"));
    refused(home, &["--merge", a, b], &["trials-60-90.csv: it begins with trial 60, where 33"]);
    refused(home, &["--merge", a, "small.toml"], &["small.toml: it is no part of a run"]);
    refused(home, &["--merge", a, a], &["begins with trial 60, where 90"]);
    let torn = std::fs::read_to_string(home.join(b)).unwrap();
    std::fs::write(home.join("torn.csv"), &torn[..torn.rfind(',').unwrap() - 400]).unwrap();
    refused(home, &["--merge", "torn.csv", c], &["torn.csv: its trials are not whole"]);
    std::fs::write(home.join("other.csv"), torn.replace("# seed 7", "# seed 8")).unwrap();
    refused(home, &["--merge", b, "other.csv"], &["other.csv: its profile, seed or version"]);
    assert!(files(&home.join("out/small")) == kept);
}

#[test]
fn the_verdict_is_the_exit_code_and_json_is_the_file() {
    let folder = folder();
    let home = folder.path();
    let table = "[tolerance]\nbudget_px = 50\ncriterion = \"p95\"\nmap_file = \"map.csv\"\n\
                 [tolerance.limits]\nmap_share = 0.5\n[export]";
    save(home, &edited(&small(), &[("[export]", table)]));
    refused(home, &["small.toml"], &["cannot read", "map.csv"]);
    let node = |k: i32| format!("{},{},{}e-4", 4 * (k % 5) - 8, 3 * (k / 5) - 6, k % 3);
    let map: Vec<String> = (0..25).map(node).collect();
    std::fs::write(home.join("map.csv"), map.join("\n")).unwrap();
    let arguments = ["tolerance", "small.toml", "--trials", "40", "--format", "json", "-q"];
    let (code, out, err) = told(&morion(home, &arguments));
    assert_eq!((code, &*err), (0, ""), "{out}");
    assert_eq!(out, std::fs::read_to_string(home.join("out/small/tolerance.json")).unwrap());
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["verdict"], "pass");
    assert_eq!((&report["trials"], &report["first"]), (&40.into(), &0.into()));
    assert_eq!((&report["criterion"], &report["yield"]["share"]), (&"p95".into(), &1.0.into()));
    let sources = report["sources"].as_array().unwrap();
    assert_eq!(sources.len(), 27);
    let map = sources.iter().find(|source| source["source"] == "map_share").unwrap();
    assert!(map["plus_px"].as_f64().unwrap() > 0.0);

    let (code, out, _) = told(&morion(home, &["tolerance", "small.toml", "--trials", "40"]));
    assert_eq!(code, 0);
    let lines: Vec<&str> = out.lines().collect();
    assert!(lines[0].starts_with("small  (") && lines.last() == Some(&"  verdict  pass"), "{out}");
    assert!(out.contains("  yield    100.00 % within 50 px (95 % interval "), "{out}");

    let table = std::fs::read_to_string(home.join("out/small/trials.csv")).unwrap();
    let rows: Vec<&str> = table.lines().filter(|line| !line.starts_with('#')).collect();
    let width = rows[0].split(',').count();
    assert!(rows.len() == 41 && rows.iter().all(|row| row.split(',').count() == width));
    let mean: f64 = rows[1..]
        .iter()
        .map(|row| row.split(',').nth(4).unwrap().parse::<f64>().unwrap() / 40.0)
        .sum();
    let told = report["adjusted"]["mean_px"].as_f64().unwrap();
    assert!((mean - told).abs() < 1e-12 * told);
}

#[test]
fn wrong_usage_and_mirrors_that_aim_at_nothing_are_refused() {
    let folder = folder();
    let home = folder.path();
    save(home, &small());
    refused(home, &[], &["PROFILE", "Usage: "]);
    refused(home, &["small.toml", "--trials", "5..5"], &["at least one"]);
    refused(home, &["small.toml", "--until", "0"], &["percentage"]);
    refused(home, &["small.toml", "--part", "--until", "1%"], &["--until"]);
    refused(home, &["small.toml", "--merge", "a.csv"], &["--merge"]);
    refused(home, &["zebra"], &["zebra: no such file"]);
    assert!(!home.join("out").exists());
    let bare = "camera.orthographic.pixels = [64, 48]\nmirror.polynomial.terms = [[2, 0, 0.01]]\n\
                part = { width_mm = 6, height_mm = 4, base_mm = 2 }\nmesh.chord_um = 9\n\
                export.formats = [\"stl\"]\n";
    std::fs::write(home.join("bare.toml"), bare).unwrap();
    refused(home, &["bare.toml"], &["cannot tolerance bare: it has no projection"]);
}
