//! The command: arguments, streams and files.

use crate::support::builds::{self, SMALL, files, folder, morion, save, told};
use crate::support::refused;
use morion::internals::geom::DVec3;
use serde_json::Value;

#[test]
fn numbers_without_sense_are_refused_before_anything_is_written() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    for (arguments, words) in [
        (&["--ball-mm", "-3", "--stepover-mm", "0.1"][..], &["--ball-mm", "positive", "-3"][..]),
        (&["--ball-mm", "0", "--stepover-mm", "0.1"], &["--ball-mm", "positive"]),
        (&["--ball-mm", "nan", "--stepover-mm", "0.1"], &["--ball-mm", "NaN"]),
        (&["--ball-mm", "1e9", "--stepover-mm", "0.1"], &["--ball-mm", "at most 150"]),
        (&["--ball-mm", "1", "--stepover-mm", "0"], &["--stepover-mm", "positive"]),
        (&["--ball-mm", "1", "--stepover-mm", "inf"], &["--stepover-mm", "finite"]),
        (&["--ball-mm", "1", "--stepover-mm", "2"], &["--stepover-mm", "diameter"]),
        (&["--ball-mm", "1", "--stepover-mm", "1.9"], &["too far for a ball of 1 mm"]),
        (&["--ball-mm", "1", "--stepover-mm", "1e-9"], &["--stepover-mm", "at least"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--budget-px", "0"], &["--budget-px"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--scallop-um", "-1"], &["--scallop-um"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--allowance-mm", "-1"], &["--allowance-mm"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--angle-deg", "1e4"], &["--angle-deg"]),
        (&["--ball-mm", "one", "--stepover-mm", "0.1"], &["invalid value"]),
    ] {
        let all = [&["machining", "small.toml", "-q"][..], arguments].concat();
        refused(home, &all, words);
        let made = home.join("out/small");
        assert!(!made.exists() || files(&made).is_empty(), "{arguments:?}");
    }
}

#[test]
fn the_json_is_the_file_and_no_thread_shows_in_it() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let run = |threads: &str| {
        let arguments = [
            "machining",
            "small.toml",
            "--ball-mm",
            "1",
            "--stepover-mm",
            "0.4",
            "--budget-px",
            "99",
            "--format",
            "json",
            "--quiet",
            "--threads",
            threads,
            "--out",
            threads,
        ];
        let (code, out, err) = told(&morion(home, &arguments));
        assert_eq!((code, &*err), (0, ""));
        (out, files(&home.join(threads).join("small")))
    };
    let (one, three) = (run("1"), run("3"));
    assert!(one.0 == three.0 && one.0.as_bytes() == one.1["machining.json"]);
    builds::assert_same(&one.1, &three.1, "threads");
    let names: Vec<&str> = one.1.keys().map(String::as_str).collect();
    assert_eq!(names, ["as-cut.stl", "gouge.png", "machining.html", "machining.json"]);
    let json: Value = serde_json::from_str(&one.0).unwrap();
    assert_eq!((&json["schema"], &json["verdict"]), (&1.into(), &"pass".into()));
    for path in [
        "profile.sha256",
        "ball_mm",
        "stepover_mm",
        "angle_deg",
        "steepest_deg.value",
        "steepest_deg.at_mm",
        "least_hollow_mm",
        "gouge.left_max_um",
        "gouge.share",
        "gouge.step_mm",
        "scallop_um.value",
        "slope_rms",
        "slope_max",
        "pixel_error_px.rms",
        "pixel_error_px.p95",
        "pixel_error_px.max",
        "design_pixel_error_px.rms",
        "best.pixels.angle_deg",
        "best.height.of_worst",
        "budget.p95_px",
        "budget.stepover_for_px_mm",
        "reach.face_mm",
        "reach.wall_mm",
        "stock.size_mm",
        "stock.removed_mm3",
        "as_cut.optical_triangles",
        "as_cut.trace.facet_error_px.rms",
        "files",
        "reasons",
        "warnings",
    ] {
        let found = path.split('.').try_fold(&json, |value, key| value.get(key));
        assert!(found.is_some(), "no {path}");
    }
    for file in json["files"].as_array().unwrap() {
        let name = file["name"].as_str().unwrap();
        assert_eq!(file["bytes"].as_u64().unwrap() as usize, one.1[name].len(), "{name}");
    }
    // The STL is what the report speaks of.
    let mesh = morion::internals::export::read_stl(&one.1["as-cut.stl"]).unwrap().mesh;
    let optical = json["as_cut"]["optical_triangles"].as_u64().unwrap() as usize;
    assert!(mesh.triangles.len() > optical);
    assert!((0..optical).all(|t| mesh.area_vector(t).dot(DVec3::Z) > 0.0));
}
