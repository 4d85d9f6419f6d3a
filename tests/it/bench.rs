//! The benchmark of run time against error: its files, what it fits, and what it suggests.

use crate::support::builds::{SMALL, files, folder, morion, save, told};
use serde_json::Value;
use std::collections::BTreeSet;

const SWEEPS: [&str; 7] =
    ["design", "mesh-facet", "mesh-chord", "witness", "trials", "frames", "program"];

#[test]
#[ignore = "long: .ci/nightly"]
fn sweeps_are_tables_and_plots_and_lead_to_settings_that_hold() {
    let folder = folder();
    save(folder.path(), SMALL);
    let arguments = ["bench", "small.toml", "--quick", "--suggest", "1.5px", "--format", "json"];
    let (code, out, err) = told(&morion(folder.path(), &arguments));
    assert_eq!(code, 0, "{err}");
    let made = files(&folder.path().join("out/bench"));
    assert_eq!(made["bench.json"], out.as_bytes());
    let bench: Value = serde_json::from_str(&out).unwrap();
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value}"));
    for (sweep, name) in bench["sweeps"].as_array().unwrap().iter().zip(SWEEPS) {
        assert_eq!(sweep["name"], name);
        let runs = sweep["runs"].as_array().unwrap();
        let csv = String::from_utf8(made[&format!("{name}.csv")].clone()).unwrap();
        assert_eq!(csv.lines().count(), runs.len() + 1, "{csv}");
        let titles: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
        let different: BTreeSet<&&str> = titles.iter().collect();
        assert_eq!(different.len(), titles.len(), "{titles:?}");
        assert!(made[&format!("{name}.png")].starts_with(b"\x89PNG"));
        let svg = String::from_utf8(made[&format!("{name}.svg")].clone()).unwrap();
        let best = |run: &&Value| run["pareto"] == true;
        let drawn = |run: &&Value| number(&run["error"]) > 0.0;
        let [points, rings] =
            [runs.iter().filter(drawn).count(), runs.iter().filter(drawn).filter(best).count()];
        // The key has a ring, and a point for each series that has a name.
        let named: BTreeSet<&str> =
            runs.iter().filter(drawn).filter_map(|run| run["series"].as_str()).collect();
        let named = named.iter().filter(|name| !name.is_empty()).count();
        assert_eq!(svg.matches("class=\"point ").count(), points + named, "{name}");
        assert!(rings > 0 && svg.matches("class=\"ring ").count() == rings + 1, "{name}");
        assert!(
            runs.iter().all(|run| number(&run["time_ms"]) > 0.0 && number(&run["error"]) >= 0.0)
        );
    }
    let order = |name: &str, of: &str| {
        let sweep = bench["sweeps"].as_array().unwrap().iter().find(|s| s["name"] == name).unwrap();
        let found = sweep["orders"].as_array().unwrap().iter().find(|order| order["of"] == of);
        found.map(|order| (number(&order["order"]), number(&order["theory"])))
    };
    let (found, theory) = order("trials", "error ~ trials").unwrap();
    assert!((found - theory).abs() < 0.02, "{found}");

    // The suggested profile does what was said of it.
    let found = &bench["suggestions"][0]["settings"];
    let said = number(&found["pixel_rms_px"]);
    assert!(said <= 1.5 && found["file"] == "small.toml", "{found}");
    let (code, out, err) =
        told(&morion(folder.path(), &["build", "out/bench/small.toml", "--format", "json"]));
    let report: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{code} {err}"));
    assert_eq!(number(&report["trace"][0]["pixel_error_px"]["rms"]), said);
    assert_eq!(report["mesh"]["optical_triangles"], found["triangles"]);

    // So does the suggested program.
    let (found, theory) = order("program", "scallops ~ stepover").unwrap();
    assert!((found - theory).abs() < 0.02, "{found}");
    let found = &bench["suggestions"][0]["program"];
    let file = format!("out/bench/{}", found["file"].as_str().unwrap());
    let (code, out, err) = told(&morion(folder.path(), &["program", &file, "--format", "json"]));
    let report: Value = serde_json::from_str(&out).unwrap_or_else(|_| panic!("{code} {err}"));
    let traced = number(&report["as_cut"]["trace"]["pixel_error_px"]["rms"]);
    assert!(traced <= 1.5 && number(&found["pixel_rms_px"]) <= 1.5, "{traced} {found}");
    let minutes = number(&report["machine_min"]);
    assert!((minutes / number(&found["machine_min"]) - 1.0).abs() < 1e-3, "{minutes} {found}");
}

#[test]
fn an_error_below_every_design_is_a_negative_verdict() {
    let folder = folder();
    save(folder.path(), SMALL);
    let arguments = ["bench", "small.toml", "--quick", "--suggest", "0.001"];
    let (code, out, err) = told(&morion(folder.path(), &arguments));
    assert_eq!(code, 1, "{err}");
    assert!(out.contains("small: no design comes nearer than "), "{out}");
    assert!(!folder.path().join("out/bench/small.toml").exists());
    let (code, _, err) = told(&morion(folder.path(), &["bench", "--suggest", "half"]));
    assert!(code == 2 && err.contains("0.5px"), "{err}");
}
