//! What a dry run foresees, held against what a build makes.

use crate::support::builds::{self, SMALL, edited, folder, morion, save, told};
use crate::support::{self, share, small_but, times};
use morion::internals::pipeline::{Silent, build, dry_run};
use morion::internals::profile::{FileFormat, MeshFormat, MeshGoal, Profile, shipped};
use rayon::prelude::*;
use serde_json::Value;

/// Share by which a forecast may be off.
const OFF: f64 = 0.2;

#[track_caller]
fn foresaw(what: &str, foreseen: f64, found: f64) {
    println!("{what}: foreseen {foreseen}, found {found}");
    assert!((foreseen / found - 1.0).abs() < OFF, "{what}: foreseen {foreseen}, found {found}");
}

/// Holds the forecast for `profile` against its build.
fn compare(profile: &Profile) {
    let source = profile.clone();
    let foreseen = dry_run(&source, &Silent).unwrap();
    let folder = folder();
    let report = build(&source, folder.path(), &Silent).unwrap();
    let (name, mesh) = (&profile.name, report.mesh.unwrap());
    let expected = foreseen.mesh.unwrap();
    let what = |what: &str| format!("{name}, {:?}: {what}", profile.mesh);
    let [optical, all] = [mesh.optical_triangles, mesh.triangles].map(|n| n as f64);
    foresaw(&what("optical"), expected.optical_triangles as f64, optical);
    foresaw(&what("in all"), expected.triangles as f64, all);
    assert_eq!(foreseen.files.len(), report.files.len());
    for (foreseen, found) in foreseen.files.iter().zip(&report.files) {
        assert_eq!((&*foreseen.name, foreseen.format), (&*found.name, &*found.format));
        foresaw(&what(&found.name), foreseen.bytes as f64, found.bytes as f64);
    }
    if profile.mesh.max_triangles().is_some() {
        let Some(facet) = expected.facet_px.foreseen else { panic!("no facet error") };
        let found = mesh.facet_px.bound;
        println!("{}: foreseen {facet}, found {found}", what("facet"));
        assert!((0.5..2.0).contains(&(facet / found)), "{facet} for {found}");
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn forecasts_of_the_shipped_mirrors_are_near() {
    let all: Vec<FileFormat> = FileFormat::all().collect();
    let stl = [FileFormat::Mesh(MeshFormat::Stl)];
    let asked = [
        (MeshGoal::limits(None, Some(3.0)), &all[..]),
        (MeshGoal::limits(Some(8.0), None), &stl[..]),
        (MeshGoal::Budget(20_000), &stl[..]),
    ];
    // Each by one of them, in turns, but for a long run.
    let profiles: Vec<_> = share(8, 0, shipped()).collect();
    profiles.par_iter().enumerate().for_each(|(k, profile)| {
        let profile = support::shipped(profile.name);
        for (mesh, formats) in asked.iter().cycle().skip(k).take(times(1, asked.len())) {
            compare(&Profile { mesh: *mesh, formats: formats.to_vec(), ..profile.clone() });
        }
    });
}

#[test]
fn the_length_of_an_stl_is_foreseen_to_the_byte() {
    let foreseen = dry_run(&builds::parsed(SMALL), &Silent).unwrap();
    assert_eq!(foreseen.files[0].bytes, 84 + 50 * foreseen.mesh.unwrap().triangles as u64);
}

#[test]
fn a_dry_run_writes_nothing() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let (code, out, err) = told(&morion(home, &["build", "small.toml", "--dry-run"]));
    assert_eq!(code, 0, "{err}");
    let stages: Vec<&str> = err.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(stages, ["design", "forecast"], "{err}");
    for words in [
        "small  (",
        " optical triangles (",
        "; chord within 20 um, facet within 3 px",
        "mirror.stl  about 0.",
        "mirror.obj  about 0.",
        "nothing was written",
    ] {
        assert!(out.contains(words), "no {words:?} in {out}");
    }
    assert!(!home.join("out").exists());
    // Not even where nothing could be written.
    std::fs::write(home.join("file"), "mine").unwrap();
    let arguments = ["build", "small.toml", "--dry-run", "--quiet", "--out", "file"];
    let (code, _, err) = told(&morion(home, &arguments));
    assert_eq!((code, &*err), (0, ""));
    assert_eq!(std::fs::read_dir(home).unwrap().count(), 2);
}

#[test]
fn a_dry_run_answers_in_json_profile_by_profile() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let budget = small_but("chord_um = 20\nfacet_px = 3\n", "max_triangles = 9000\n");
    std::fs::write(home.join("budget.toml"), budget).unwrap();
    let arguments = ["build", "small.toml", "budget.toml", "--dry-run", "--format", "json"];
    let (code, out, _) = told(&morion(home, &arguments));
    assert_eq!(code, 0);
    let values: Result<Vec<Value>, _> =
        serde_json::Deserializer::from_str(&out).into_iter().collect();
    let [small, budget] = <[Value; 2]>::try_from(values.unwrap()).unwrap();
    assert_eq!((&small["profile"]["name"], &small["dry_run"]), (&"small".into(), &true.into()));
    assert_eq!(small["mesh"]["chord_um"]["limit"], 20.0);
    assert!(small["mesh"]["chord_um"]["foreseen"].is_null());
    assert_eq!(small["files"][1]["name"], "mirror.obj");
    assert_eq!(budget["mesh"]["max_triangles"], 9000);
    for key in ["chord_um", "facet_px"] {
        assert!(budget["mesh"][key]["limit"].is_null());
        assert!(budget["mesh"][key]["foreseen"].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(budget["mesh"]["triangles"].as_u64().unwrap() <= 9100);
    assert_eq!(budget["warnings"], serde_json::json!([]));
}

#[test]
fn what_cannot_be_built_cannot_be_foreseen() {
    let folder = folder();
    let home = folder.path();
    for (text, words) in [
        (small_but("facet_px = 3", "facet_px = 0.001"), "fit in memory"),
        (small_but("degree = 8", "degree = 80"), "small.toml:16:10: "),
    ] {
        save(home, &text);
        let (code, out, err) = told(&morion(home, &["build", "small.toml", "--dry-run", "-q"]));
        assert_eq!((code, &*out), (2, ""), "{err}");
        assert!(err.starts_with("error: ") && err.contains(words), "{err}");
    }
    assert!(!home.join("out").exists());
}

/// The value that `warning` suggests for `key`.
fn suggested(warning: &str, key: &str) -> String {
    let key = format!("{key} = ");
    let at = warning.find(&key).unwrap_or_else(|| panic!("no {key} in {warning}")) + key.len();
    let value: String =
        warning[at..].chars().take_while(|&c| c.is_ascii_digit() || c == '.').collect();
    value.trim_end_matches('.').to_owned()
}

/// 1 100 972 of the 1 286 795 pixels of the disc that a square frame would show.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_disc_beyond_a_wide_frame_draws_a_warning_that_helps() {
    let warnings = |name: &str, edits: &[(&str, &str)]| {
        let foreseen = dry_run(&support::shipped_but(name, edits), &Silent).unwrap();
        foreseen.warnings.into_iter().filter(|w| w.contains("cuts off")).collect::<Vec<_>>()
    };
    let frame = |pixels| ("pixels = [480, 480]", pixels);
    let wide = warnings("plane", &[frame("pixels = [1280, 960]")]);
    let [warning] = &wide[..] else { panic!("{wide:?}") };
    for words in ["1280 x 960 pixels cuts off 14.4 % of the mirror", "1280 pixels across"] {
        assert!(warning.contains(words), "{warning}");
    }
    let (_, instead) = warning.split_once("write ").unwrap();
    let square = instead.split(", the").next().unwrap();
    assert!(warnings("plane", &[frame(square)]).is_empty(), "{warning}");

    // A pinhole goes farther away.
    let low = frame("pixels = [480, 360]");
    let near = warnings("equiangular", &[low]);
    let [warning] = &near[..] else { panic!("{near:?}") };
    let (_, farther) = warning.split_once("write ").unwrap();
    assert!(
        warnings("equiangular", &[low, ("distance_mm = 100", farther)]).is_empty(),
        "{warning}"
    );
}

#[test]
fn large_parts_and_files_draw_warnings_that_help() {
    let folder = folder();
    let home = folder.path();
    let dry = |text: &str| {
        save(home, text);
        let arguments = ["build", "small.toml", "--dry-run", "--quiet", "--format", "json"];
        let (code, out, err) = told(&morion(home, &arguments));
        assert_eq!(code, 0, "{err}");
        let prospect: Value = serde_json::from_str(&out).unwrap();
        let warnings: Vec<String> = serde_json::from_value(prospect["warnings"].clone()).unwrap();
        // The same on stderr, whoever wants to be told of progress.
        let said: Vec<&str> = err.lines().collect();
        let expected: Vec<String> = warnings.iter().map(|w| format!("warning: {w}")).collect();
        assert_eq!(said, expected);
        (prospect, warnings)
    };
    let many = small_but("facet_px = 3", "facet_px = 0.16");
    let (_, warnings) = dry(&many);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains(" triangles in all") && warnings[0].contains("STEP"));
    assert!(warnings[1].contains("mirror.obj takes ") && warnings[1].contains("100 MB"));
    let facet = suggested(&warnings[1], "facet_px");
    let (prospect, calm) = dry(&edited(&many, &[("0.16", &facet)]));
    assert_eq!(calm, [""; 0]);
    let triangles = prospect["mesh"]["triangles"].as_f64().unwrap();
    assert!((600_000.0..1_000_000.0).contains(&triangles), "{triangles}");
    let budget = format!("max_triangles = {}", suggested(&warnings[1], "max_triangles"));
    let (_, calm) = dry(&edited(&many, &[("chord_um = 20\nfacet_px = 0.16", &budget)]));
    assert_eq!(calm, [""; 0]);
}

#[test]
fn a_build_warns_as_its_dry_run_does_and_the_report_too() {
    let folder = folder();
    let home = folder.path();
    let many =
        edited(SMALL, &[("facet_px = 3", "facet_px = 0.16"), ("\"stl\", \"obj\"", "\"stl\"")]);
    save(home, &many);
    let (code, out, err) = told(&morion(home, &["build", "small.toml", "--quiet"]));
    assert_eq!(code, 0, "{out}");
    assert!(err.starts_with("warning: small: 1") && err.lines().count() == 1, "{err}");
    let report = std::fs::read(home.join("out/small/report.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(format!("warning: {}\n", report["warnings"][0].as_str().unwrap()), err);
    let page = std::fs::read_to_string(home.join("out/small/report.html")).unwrap();
    assert!(page.contains("a burden for many CAM programs"));
}
