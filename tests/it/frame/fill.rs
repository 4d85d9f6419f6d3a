//! What fills the frame, and what does not.

use crate::support::builds::{self, SMALL, edited, files, folder, morion, save, told};
use crate::support::{refused, small_strip};
use serde_json::Value;
use std::path::Path;

/// Runs `morion frame` on the profile `small.toml` of `text`; the exit code and `frame.json`.
fn framed(home: &Path, text: &str, more: &[&str]) -> (i32, Value) {
    save(home, text);
    let arguments = [&["frame", "small.toml", "--quiet", "--format", "json"], more].concat();
    let (code, out, err) = told(&morion(home, &arguments));
    assert_eq!(err, "");
    let bytes = std::fs::read(home.join("out/small/frame.json")).unwrap();
    assert!(out.as_bytes() == bytes, "what is printed is what is written");
    (code, serde_json::from_str(&out).unwrap())
}

fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("{pointer}: {value}"))
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_papers_folded_mirror_and_the_conformal_one_fill_the_frame() {
    let folder = folder();
    for name in ["conquistador", "conformal"] {
        let arguments = ["frame", name, "--min", "0.999", "--quiet"];
        let (code, out, err) = told(&morion(folder.path(), &arguments));
        assert_eq!((code, &*err), (0, ""), "{out}");
        assert!(out.contains("+69.8 % against a disc"), "{out}");
        let made = files(&folder.path().join("out").join(name));
        assert!(
            made.keys().eq(["frame.csv", "frame.html", "frame.json", "frame.png"].iter()),
            "{:?}",
            made.keys()
        );
        let json: Value = serde_json::from_slice(&made["frame.json"]).unwrap();
        assert!(number(&json, "/frame/filled") >= 0.999);
        assert_eq!(json["coverage"]["seams"].as_array().unwrap().len(), 2);
        assert_eq!(json["round_mirrors"].as_array().unwrap().len(), 9);
        let lines = String::from_utf8(made["frame.csv"].clone()).unwrap();
        assert_eq!(lines.lines().count(), 1 + 640);
    }
}

#[test]
fn the_figures_are_those_of_a_build() {
    let folder = folder();
    let home = folder.path();
    let (code, json) = framed(home, SMALL, &[]);
    assert_eq!(code, 0);
    assert_eq!(told(&morion(home, &["build", "small.toml", "--quiet"])).0, 0);
    let report = std::fs::read(home.join("out/small/report.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(json["frame"], report["frame"]);
    // Files of both stand beside each other.
    assert!(home.join("out/small/frame.png").is_file());
}

#[test]
fn the_share_that_is_asked_for_decides() {
    let folder = folder();
    // Coarser facets may shadow each other.
    let text = edited(&small_strip(), &[("facet_px = 3", "facet_px = 2")]);
    let (code, json) = framed(folder.path(), &text, &["--min", "0.2"]);
    assert_eq!((code, json["verdict"].as_str()), (0, Some("pass")));
    // As usual of a strip.
    let (code, json) = framed(folder.path(), &text, &[]);
    assert_eq!((code, json["verdict"].as_str()), (0, Some("pass")));
    let (code, json) = framed(folder.path(), &text, &["--min", "0.995"]);
    assert_eq!((code, json["verdict"].as_str()), (1, Some("fail")));
    let reason = json["reasons"][0].as_str().unwrap();
    assert!(reason.contains("99.500 % asked for; [layout.conquistador] folds"), "{reason}");
    // The rows that are beyond the strip, and no other pixel.
    let filled = number(&json, "/frame/filled") * 160.0 * 120.0;
    assert_eq!(filled.round() + number(&json, "/frame/lost/beyond"), 160.0 * 120.0);
    assert_eq!(number(&json, "/resolution/pixels"), filled.round());
}

#[test]
fn a_valley_loses_pixels_to_shadow() {
    let folder = folder();
    let text = edited(SMALL, &[("\"crest\"", "\"valley\""), ("frame_filled = 0.99\n", "")]);
    let (code, json) = framed(folder.path(), &text, &[]);
    let lost = json["frame"]["lost"].as_object().unwrap();
    let shadow = lost["shadow"].as_u64().unwrap();
    assert!(code == 1 && shadow > 100, "{lost:?}");
    let all: u64 = lost.values().map(|count| count.as_u64().unwrap()).sum();
    let filled = number(&json, "/frame/filled") * 160.0 * 120.0;
    assert_eq!(all as f64 + filled.round(), 160.0 * 120.0);
}

#[test]
fn a_full_turn_closes_at_its_seam_and_a_half_turn_has_none() {
    let fine = [("facet_px = 3", "facet_px = 0.5"), ("chord_um = 20\n", "")];
    let exact = [("cylindrical", "mercator"), ("degree = 8", "degree = 16")];
    let edits = [&fine[..], &exact].concat();
    let folder = folder();
    for text in [edited(SMALL, &edits), edited(&small_strip(), &edits)] {
        let (_, json) = framed(folder.path(), &text, &[]);
        let seams = json["coverage"]["seams"].as_array().unwrap();
        let folded = text.contains("[layout.conquistador]");
        assert_eq!(seams.len(), if folded { 2 } else { 1 });
        for seam in seams {
            let [min, mean, max] =
                ["min", "mean", "max"].map(|k| number(seam, &format!("/gap_px/{k}")));
            assert!(min > -1.0 && max < 1.0 && mean.abs() < 0.1, "{seam}");
        }
        assert!((number(&json, "/coverage/azimuth_deg") - 360.0).abs() < 0.1, "{json}");
    }
    let half = edited(&small_strip(), &[("[-180, 180]", "[-90, 90]")]);
    let half = edited(&half, &edits);
    let (_, json) = framed(folder.path(), &half, &[]);
    assert_eq!(json["coverage"]["seams"].as_array().unwrap().len(), 0);
    let pixel = 180.0 / 160.0;
    assert!((number(&json, "/coverage/azimuth_deg") - 180.0).abs() < pixel);
    let gap = &json["coverage"]["gaps_deg"][0];
    assert!((number(gap, "/0") - 90.0).abs() < pixel && (number(gap, "/1") - 270.0).abs() < pixel);
}

#[test]
fn columns_end_where_the_law_says() {
    // Exact mirrors: every column sees the strip's elevations, a ring's middle columns the widest.
    let folder = folder();
    let exact = [
        ("cylindrical", "mercator"),
        ("degree = 8", "degree = 16"),
        ("facet_px = 3", "facet_px = 1"),
    ];
    let (_, json) = framed(folder.path(), &edited(SMALL, &exact), &[]);
    // The frame is filled up to z = 3 pi / 16 on both sides.
    let z = 3.0 * std::f64::consts::PI / 16.0;
    let edge = morion::internals::num::degrees(morion::internals::num::asin(
        morion::internals::num::tanh(z),
    ));
    let pixel = 180.0 / 160.0;
    for (which, exact) in [("lowest_deg", -edge), ("highest_deg", edge)] {
        for end in ["min", "mean", "max"] {
            let found = number(&json, &format!("/coverage/{which}/{end}"));
            let near = if end == "mean" { 0.3 } else { 1.0 } * pixel;
            assert!((found - exact).abs() < near, "{which} {end}: {found} {exact}");
        }
    }
}

#[test]
fn round_mirrors_cover_the_whole_turn() {
    let folder = folder();
    let text = "
camera.pinhole = { pixels = [120, 90], focal_px = 150, distance_mm = 100 }
projection.equiangular.outer_polar_deg = 120
layout.disc = {}
method.vector-field.degree = 16
part = { width_mm = 60, base_mm = 5 }
mesh.facet_px = 1
export.formats = [\"stl\"]
";
    let (code, json) = framed(folder.path(), text, &["--min", "0.5"]);
    assert_eq!(code, 0, "{json}");
    assert_eq!(number(&json, "/coverage/azimuth_deg").round(), 360.0);
    assert_eq!(json["coverage"]["seams"].as_array().unwrap().len(), 0);
    // The zenith lies between the middle columns, the lowest directions at the rim.
    assert!(number(&json, "/coverage/highest_deg/max") > 86.0);
    assert!((number(&json, "/coverage/lowest_deg/min") + 30.0).abs() < 2.0);
    // Its own row and that of the shipped one of its kind have as many pixels.
    let rounds = json["round_mirrors"].as_array().unwrap();
    let same = rounds.iter().find(|row| row["profile"] == "equiangular").unwrap();
    assert_eq!(same["pixels"], json["resolution"]["pixels"]);
    let [own, other] = [&json["resolution"], same].map(|row| number(row, "/pixel_usr/mean"));
    assert!((own / other - 1.0).abs() < 1e-6, "{own} {other}");
}

#[test]
fn what_cannot_be_done_leaves_nothing_behind() {
    let folder = folder();
    let home = folder.path();
    let given = "
camera.orthographic.pixels = [160, 120]
mirror.polynomial = { radius_mm = -80, terms = [[2, 0, 1e-4]] }
part = { width_mm = 30, height_mm = 20, base_mm = 5 }
mesh.chord_um = 20
export.formats = [\"stl\"]
";
    save(home, given);
    for (arguments, word) in [
        (&["frame", "small.toml"][..], "has no projection"),
        (&["frame", "conformal", "--min", "1.5"], "it must be a number from 0 to 1"),
        (&["frame", "conformal", "--min", "nan"], "it must be a number from 0 to 1"),
        (&["blur", "conformal"], "give --na"),
        (&["blur", "conformal", "--pupil-mm", "1"], "give --na"),
        (&["blur", "conical", "--na", "0.1"], "give --pupil-mm"),
        (&["blur", "conical", "--pupil-mm", "1", "--na", "0.1"], "cannot be used with"),
        (
            &["blur", "conical", "--pupil-mm", "0"],
            "it must be a number of millimetres from 1e-6 to 1e9",
        ),
        (&["blur", "conical", "--pupil-mm", "1", "--focus-mm", "-5"], "--focus-mm must be over 0"),
        (&["blur", "conformal", "--na", "1"], "it must be a number from 1e-6 to 0.99"),
        (
            &["blur", "conformal", "--na", "0.1", "--focus-mm", "inf"],
            "it must be a number from -1e9 to 1e9",
        ),
    ] {
        refused(home, arguments, &[word]);
        assert!(!home.join("out").exists(), "{arguments:?}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    let run = |threads: &str| {
        for arguments in [&["frame", "small.toml"][..], &["blur", "small.toml", "--na", "0.01"]] {
            let all = [arguments, &["--quiet", "--threads", threads, "--out", threads]].concat();
            assert_eq!(told(&morion(home, &all)).0, 0);
        }
        files(&home.join(threads).join("small"))
    };
    let one = run("1");
    assert_eq!(one.len(), 7);
    builds::assert_same(&one, &run("3"), "threads");
}

#[test]
fn a_part_that_is_a_pixel_off_loses_pixels_at_rim_and_ridge() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    assert_eq!(told(&morion(home, &["build", "small.toml", "--quiet"])).0, 0);
    let mut bytes = std::fs::read(home.join("out/small/mirror.stl")).unwrap();
    // A pixel to the right and upwards: the first column and the last row miss, and the row over the
    // middle sees the lower panel.
    let pixel = 15.0 / 160.0;
    for facet in bytes[84..].chunks_exact_mut(50) {
        for vertex in facet[12..48].chunks_exact_mut(12) {
            for axis in vertex[..8].chunks_exact_mut(4) {
                let moved = f32::from_le_bytes([axis[0], axis[1], axis[2], axis[3]]) + pixel;
                axis.copy_from_slice(&moved.to_le_bytes());
            }
        }
    }
    std::fs::write(home.join("moved.stl"), bytes).unwrap();
    let arguments =
        ["verify", "moved.stl", "--profile", "small.toml", "--quiet", "--format", "json"];
    let (code, out, _) = told(&morion(home, &arguments));
    let report: Value = serde_json::from_str(&out).unwrap();
    let lost = |cause: &str| number(&report, &format!("/frame/lost/{cause}"));
    assert_eq!((code, lost("rim"), lost("missed")), (1, 160.0 + 119.0, 0.0), "{}", report["frame"]);
    // At both ends the panels show nearly the same.
    assert!((140.0..160.0).contains(&lost("ridge")), "{}", report["frame"]);
    assert!(lost("content") < 10.0, "{}", report["frame"]);
}
