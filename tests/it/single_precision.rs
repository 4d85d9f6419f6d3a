//! Tolerances finer than single precision carries: no STL then, but every other file.

use crate::support::builds::{SMALL, edited, files, folder, morion, save, told};
use crate::support::small_but;
use morion::internals::raster::Raster;
use serde_json::Value;
use std::path::Path;

/// A tolerance that rounding eats, as the part is far from its base.
fn far() -> String {
    edited(SMALL, &[("base_mm = 2", "base_mm = 100000"), ("chord_um = 20", "chord_um = 2")])
}

fn report(home: &Path) -> Value {
    serde_json::from_slice(&files(&home.join("out/small"))["report.json"]).unwrap()
}

#[test]
fn an_stl_alone_cannot_be_had_and_nothing_is_written() {
    let folder = folder();
    let home = folder.path();
    save(home, &edited(&far(), &[("\"stl\", \"obj\"", "\"stl\"")]));
    for extra in ["--quiet", "--dry-run"] {
        let (code, out, err) = told(&morion(home, &["build", "small.toml", extra]));
        assert_eq!((code, &*out), (2, ""), "{err}");
        for words in [
            "error: cannot mesh small: mirror.stl was not written: single precision reaches chord_um ",
            " at X ",
            "; loosen chord_um or export obj alone",
        ] {
            assert!(err.contains(words), "no {words:?} in {err}");
        }
    }
    assert!(files(&home.join("out/small")).is_empty());
}

#[test]
fn beside_an_obj_it_is_left_out_with_a_reason() {
    let folder = folder();
    let home = folder.path();
    save(home, SMALL);
    assert_eq!(told(&morion(home, &["build", "small.toml", "--quiet"])).0, 0);
    assert!(home.join("out/small/mirror.stl").exists());

    save(home, &far());
    let (code, out, _) = told(&morion(home, &["build", "small.toml", "--quiet", "--dry-run"]));
    assert_eq!(code, 0);
    assert!(out.contains("  - mirror.stl would not be written: single precision reaches"), "{out}");
    assert!(home.join("out/small/mirror.stl").exists());

    let (code, out, err) = told(&morion(home, &["build", "small.toml", "--quiet"]));
    assert_eq!(code, 1, "{err}");
    assert!(out.contains("  - mirror.stl was not written: single precision reaches"), "{out}");
    assert!(!home.join("out/small/mirror.stl").exists(), "an earlier one stays");
    let report = report(home);
    assert_eq!(
        (&report["verdict"], report["reasons"].as_array().unwrap().len()),
        (&"fail".into(), 1)
    );
    assert_eq!(report["files"].as_array().unwrap().len(), 1);
    assert_eq!(report["files"][0]["name"], "mirror.obj");
    assert!(report["mesh"]["chord_um"]["bound"].as_f64().unwrap() <= 2.0);
}

#[test]
fn an_obj_alone_needs_no_single_precision() {
    let folder = folder();
    let home = folder.path();
    save(home, &edited(&far(), &[("\"stl\", \"obj\"", "\"obj\"")]));
    let (code, out, _) = told(&morion(home, &["build", "small.toml", "--quiet"]));
    assert_eq!(code, 0, "{out}");
    assert_eq!(report(home)["mesh"]["rounding_px"], 0.0);
}

#[test]
#[ignore = "long: .ci/nightly"]
fn half_a_nanometre_is_kept_by_an_obj() {
    let folder = folder();
    let home = folder.path();
    let shipped = |name: &str, width: &str| {
        let (code, text, _) = told(&morion(home, &["profiles", "--show", name]));
        assert_eq!(code, 0);
        let mut lines: Vec<&str> = text.lines().collect();
        for line in &mut lines {
            for (key, new) in [
                ("chord_um =", "chord_um = 0.0005"),
                ("facet_px =", ""),
                ("pixel_error_max_px =", ""),
                ("formats =", "formats = [\"obj\"]"),
                ("distance_mm =", "distance_mm = 0.25"),
                ("base_mm =", "base_mm = 50"),
                ("width_mm =", width),
            ] {
                *line = if line.starts_with(key) { new } else { line };
            }
        }
        lines.join("\n")
    };
    for (name, width) in [
        ("panoramic", "width_mm = 0.12"),
        ("parabolic", "width_mm = 0.1"),
        ("hyperbolic", "width_mm = 0.15"),
    ] {
        save(home, &shipped(name, width));
        let (code, out, err) = told(&morion(home, &["build", "small.toml", "--quiet"]));
        assert_eq!(code, 0, "{name}: {out}{err}");
        let report = report(home);
        let bound = report["mesh"]["chord_um"]["bound"].as_f64().unwrap();
        assert!(bound <= 0.0005 && bound > 0.0004, "{name}: {bound}");
        assert!(report["mesh"]["triangles"].as_u64().unwrap() < 1_000_000);
        let off = report["trace"][0]["worst_vertex"]["off_mm"].as_f64().unwrap();
        assert!(off <= 5e-7, "{name}: {off}");
    }
}

#[test]
fn an_stl_within_its_reach_is_as_ever() {
    let folder = folder();
    let home = folder.path();
    save(home, &small_but("chord_um = 20", "chord_um = 10"));
    let (code, _, err) = told(&morion(home, &["build", "small.toml", "--quiet"]));
    assert_eq!((code, &*err), (0, ""));
    assert_eq!(report(home)["files"].as_array().unwrap().len(), 2);
}

/// Where there is no mesh at all, or no file of it, drawings and tables are written all the same.
#[test]
fn drawings_and_tables_are_written_without_a_mesh() {
    let folder = folder();
    let home = folder.path();
    let formats = |text: &str| edited(text, &[("\"stl\", \"obj\"", "\"stl\", \"step\", \"csv\"")]);
    let many = edited(SMALL, &[("chord_um = 20", "chord_um = 1e-4")]);
    for (text, why, mesh) in [
        (formats(&far()), "mirror.stl was not written: single precision reaches", true),
        (formats(&many), "mirror.stl was not written: the limits ask for about", false),
    ] {
        save(home, &text);
        let (code, out, err) =
            told(&morion(home, &["build", "small.toml", "--quiet", "--dry-run"]));
        assert_eq!((code, &*err), (0, ""), "{out}");
        let foreseen = why.replace("was not", "would not be");
        assert!(out.contains(&format!("  - {foreseen}")), "{out}");
        let (code, out, err) = told(&morion(home, &["build", "small.toml", "--quiet"]));
        assert_eq!((code, &*err), (1, ""), "{out}");
        assert!(out.contains(&format!("  - {why}")), "{out}");
        let made = files(&home.join("out/small"));
        for (name, is_there) in [("mirror.stl", false), ("mirror.step", true), ("sag.csv", true)] {
            assert_eq!(made.contains_key(name), is_there, "{name}");
        }
        let report = report(home);
        assert_eq!((&report["verdict"], report["mesh"].is_null()), (&"fail".into(), !mesh));
    }
}

/// Where there is no mesh, the preview shows the design: what the previews of ever finer meshes tend
/// to.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_preview_without_a_mesh_shows_the_same_mirror() {
    let folder = folder();
    let home = folder.path();
    let preview = |text: &str| {
        save(home, text);
        let (_, out, err) = told(&morion(home, &["build", "small.toml", "--quiet"]));
        assert_eq!(err, "", "{out}");
        let made = files(&home.join("out/small"));
        Raster::decode(&made["preview.png"]).unwrap()
    };
    let small = edited(SMALL, &[("\"stl\", \"obj\"", "\"obj\", \"csv\"")]);
    let limit = |um: &str| edited(&small, &[("chord_um = 20", &format!("chord_um = {um}"))]);
    let by_design = preview(&limit("1e-4"));
    assert!(report(home)["mesh"].is_null());
    // The mean over the picture of what the three colours differ by.
    let apart = |by_mesh: &Raster| {
        let apart =
            |(a, b): (&[f32; 3], &[f32; 3])| -> f32 { (0..3).map(|k| (a[k] - b[k]).abs()).sum() };
        let sum: f32 = by_mesh.rgb.iter().zip(&by_design.rgb).map(apart).sum();
        sum / by_mesh.rgb.len() as f32
    };
    // The tilt of facets, and with it what they show, falls with the root of their height.
    let means = ["0.32", "0.08", "0.02"].map(|um| apart(&preview(&limit(um))));
    let [coarse, middle, fine] = means;
    assert!(middle < 0.6 * coarse && fine < 0.6 * middle && fine > 0.0, "{means:?}");
}
