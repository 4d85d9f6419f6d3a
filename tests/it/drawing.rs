//! Drawings of parts: their figures, their files, and what goes with them.

use crate::support::builds::{SMALL, edited, folder, morion, save, told};
use crate::support::{share, shipped};
use morion::internals::design::design;
use morion::internals::pipeline::{Command, DrawingOptions, Silent};
use morion::internals::profile::{Profile, Shipped};
use morion::internals::tolerance::{Engine, ToleranceSpec};
use serde_json::Value;
use std::path::Path;

/// The text of a PDF: strings shown, in their order.
fn shown(pdf: &[u8]) -> Vec<String> {
    let text: String = pdf.iter().map(|&byte| char::from(byte)).collect();
    let string = |line: &str| {
        let shown = line.strip_suffix(" Tj")?;
        if let Some(plain) = shown.strip_prefix('(') {
            return Some(plain.strip_suffix(')')?.to_owned());
        }
        // What is not ASCII is in hexadecimal.
        let digits = shown.strip_prefix('<')?.strip_suffix('>')?;
        let byte = |k: usize| u8::from_str_radix(&digits[k..k + 2], 16).map(char::from).ok();
        (0..digits.len()).step_by(2).map(byte).collect()
    };
    text.lines().filter_map(string).collect()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// Millimetres as a drawing has them.
fn mm(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[test]
fn every_shipped_mirror_is_drawn_with_its_own_sizes_and_tolerances() {
    let out = folder();
    for Shipped { name, .. } in share(4, 1, morion::shipped()) {
        let profile = shipped(name);
        let report = DrawingOptions.publish(&profile, out.path(), &Silent).unwrap();
        let (facts, design) = (report.drawing, design(&profile).unwrap());
        assert_eq!(facts.size_mm, design.mounting.size_mm, "{name}");
        assert_eq!(facts.pmi.datums, design.datums().words(), "{name}");
        let pdf = std::fs::read(out.path().join(name).join("drawing.pdf")).unwrap();
        let shown = shown(&pdf);
        let said = |text: &str| shown.iter().any(|line| line == text);
        let [x, y, z] = facts.size_mm.map(mm);
        let wide = if facts.is_round { format!("\u{d8}{x}") } else { x };
        assert!(said(&wide) && said(&z) && (facts.is_round || said(&y)), "{name}: {shown:?}");
        assert!(said(&facts.scale) && said(&mm(facts.lowest_mm)), "{name}: {shown:?}");
        // What stands in the tolerance's frame is what a plan of an inspection goes by.
        assert_eq!(
            facts.pmi.surface_profile_mm.is_some_and(|zone| said(&mm(zone))),
            facts.pmi.surface_profile_mm.is_some()
        );
        let heights = facts.sag_mm.iter().filter(|place| said(&format!("{:.4}", place[2])));
        assert!(facts.sag_mm.len() >= 9 && heights.count() == facts.sag_mm.len(), "{name}");
        for place in &facts.sag_mm {
            let q = design.mirror.chart.coordinates((*place).into()).0;
            let off = design.mirror.position(q, &design.mirror.at(q)).z - place[2];
            // (On a step between panels either is right.)
            assert!(off.abs() < 1e-6 || design.mirror.has_steps(), "{name} {place:?}: {off}");
        }
        let Some(view) = &design.view else { continue };
        let spec = ToleranceSpec::of_form(&profile, facts.is_round);
        let engine = Engine::new(&design.mirror, &design.camera, view, spec).unwrap();
        let accepted = profile.acceptance_limits().pixel_error_rms_px.value;
        let exact = engine.slope_limit(accepted);
        assert_eq!(exact.is_some(), facts.slope_error_mrad.is_some(), "{name}");
        if let (Some(exact), Some(drawn)) = (exact, facts.slope_error_mrad) {
            assert!(drawn <= exact && drawn > 0.89 * exact, "{name}: {drawn} for {exact}");
        }
    }
}

#[test]
fn a_build_draws_what_the_command_draws_and_takes_away_what_is_not_asked_for() {
    let folder = folder();
    let drawn = "drawing = { title = \"A panorama\", date = 2026-11-27 }\n";
    let text =
        format!("{drawn}{}", edited(SMALL, &[("\"stl\", \"obj\"", "\"pdf\", \"step\", \"dxf\"")]));
    save(folder.path(), &text);
    let (code, _, err) = told(&morion(folder.path(), &["build", "small.toml"]));
    assert_eq!(code, 0, "{err}");
    let (code, _, err) = told(&morion(folder.path(), &["drawing", "small.toml", "--out", "alone"]));
    assert_eq!(code, 0, "{err}");
    let [built, alone] = ["out", "alone"].map(|out| folder.path().join(out).join("small"));
    for file in ["drawing.pdf", "drawing.dxf"] {
        let [a, b] = [&built, &alone].map(|path| std::fs::read(path.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
    let (report, alone) = (json(&built.join("report.json")), json(&alone.join("drawing.json")));
    for (key, value) in report["drawing"].as_object().unwrap() {
        assert_eq!(*value, alone[key], "{key}");
    }
    let formats: Vec<&Value> =
        report["files"].as_array().unwrap().iter().map(|file| &file["format"]).collect();
    assert_eq!(formats, ["pdf", "step", "dxf"]);
    let shown = shown(&std::fs::read(built.join("drawing.pdf")).unwrap());
    for text in ["A panorama", "2026-11-27", "A-A", "B-B"] {
        assert!(shown.iter().any(|line| line == text), "{text}: {shown:?}");
    }
    save(folder.path(), SMALL);
    let (code, _, err) = told(&morion(folder.path(), &["build", "small.toml"]));
    assert_eq!(code, 0, "{err}");
    assert!(!built.join("drawing.pdf").exists() && !built.join("drawing.dxf").exists());
    assert!(json(&built.join("report.json")).get("drawing").is_none());
}

/// A forecast knows the length of a drawing to the byte.
#[test]
fn a_dry_run_tells_the_length_of_a_drawing() {
    let folder = folder();
    save(folder.path(), &edited(SMALL, &[("\"stl\", \"obj\"", "\"step\", \"pdf\"")]));
    let told_json = |arguments: &[&str]| -> Value {
        let (code, out, err) = told(&morion(folder.path(), arguments));
        assert_eq!(code, 0, "{err}");
        serde_json::from_str(&out).unwrap()
    };
    let foreseen = told_json(&["build", "small.toml", "--dry-run", "--format", "json"]);
    let built = told_json(&["build", "small.toml", "--format", "json"]);
    assert_eq!(foreseen["files"][1]["bytes"], built["files"][1]["bytes"]);
    assert_eq!(built["files"][1]["name"], "drawing.pdf");
}

#[test]
fn holes_are_told_in_the_words_of_a_shop() {
    let out = folder();
    let text = include_str!("../fixtures/drilled.toml");
    let profile = Profile::parse("drilled", "drilled.toml", text.as_bytes()).unwrap();
    let report = DrawingOptions.publish(&profile, out.path(), &Silent).unwrap();
    let told: Vec<(&str, f64, &str)> =
        report.drawing.features.iter().map(|f| (&*f.name, f.diameter_mm, &*f.what)).collect();
    assert_eq!(
        told[0],
        ("H1", 2.5, "M3 x 0.5 - 6H, 5 deep, pilot 2.5, 7 deep, chamfer 0.3 x 45 deg")
    );
    assert!(told[3].2.starts_with("diameter 3 H7"), "{told:?}");
    assert_eq!(told[5], ("H6", 4.0, "6 deep, flat, counterbore 8, 2.2 deep"));
    let shown = shown(&std::fs::read(out.path().join("drilled/drawing.pdf")).unwrap());
    for (name, _, what) in told {
        assert!(shown.iter().any(|line| line == name) && shown.iter().any(|line| line == what));
    }
}

#[test]
fn chamfered_edges_are_drawn_and_told() {
    let out = folder();
    let text = include_str!("../fixtures/part.toml");
    for (leg, text) in
        [(Some(0.5), text.to_owned()), (None, text.replace("edge_chamfer_mm = 0.5\n", ""))]
    {
        let profile = Profile::parse("part", "part.toml", text.as_bytes()).unwrap();
        let report = DrawingOptions.publish(&profile, out.path(), &Silent).unwrap();
        assert_eq!(report.drawing.edge_chamfer_mm, leg);
        let shown = shown(&std::fs::read(out.path().join("part/drawing.pdf")).unwrap());
        assert_eq!(shown.iter().any(|line| line == "edges 0.5 x 45\u{b0}"), leg.is_some());
        let json = json(&out.path().join("part/drawing.json"));
        assert_eq!(json.get("edge_chamfer_mm").and_then(Value::as_f64), leg);
    }
}

/// Places along an axis of a PDF's lines across it, mm on paper.
fn lines_across(pdf: &[u8], axis: usize) -> Vec<f64> {
    let text: String = pdf.iter().map(|&byte| char::from(byte)).collect();
    let place = |line: &str, operator: &str| -> Option<[f64; 2]> {
        let mut numbers = line.strip_suffix(operator)?.split_whitespace().map(str::parse);
        Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
    };
    let lines: Vec<&str> = text.lines().collect();
    let across = |pair: &[&str]| {
        let (from, to) = (place(pair[0], " m")?[axis], place(pair[1], " l")?[axis]);
        (from == to).then_some(from * 25.4 / 72.0)
    };
    lines.windows(2).filter_map(across).collect()
}

/// Beside a rim that lies evenly about the axis, the mirror of a camera that is not above it does not.
#[test]
fn a_leaning_mirrors_own_size_is_drawn_where_the_mirror_is() {
    let out = folder();
    let text = std::fs::read_to_string("profiles/driver.toml").unwrap();
    let edits = [
        ("base_mm = 5", "base_mm = 12\nborder_mm = 20\nrim_mm = 3"),
        ("towards_deg = 90", "towards_deg = 50"),
    ];
    let profile =
        Profile::parse("driver", "driver.toml", edited(&text, &edits).as_bytes()).unwrap();
    let facts = DrawingOptions.publish(&profile, out.path(), &Silent).unwrap().drawing;
    let (_, enlarged) = facts.scale.split_once(':').unwrap();
    let scale = 1.0 / enlarged.parse::<f64>().unwrap();
    let pdf = std::fs::read(out.path().join("driver/drawing.pdf")).unwrap();
    for axis in [0, 1] {
        let aside = facts.mirror_least_mm[axis] + 0.5 * facts.mirror_mm[axis];
        assert!(aside.abs() > 0.5, "{aside}");
        assert!(shown(&pdf).contains(&mm(-facts.mirror_least_mm[axis])));
        let lines = lines_across(&pdf, axis);
        let has = |at: f64| lines.iter().any(|line| (line - at).abs() < 0.01);
        let ends = |least: f64, size: f64| {
            [least, least + size].map(|at| scale * (at - facts.least_mm[axis]))
        };
        let [part, mirror] = [
            ends(facts.least_mm[axis], facts.size_mm[axis]),
            ends(facts.mirror_least_mm[axis], facts.mirror_mm[axis]),
        ];
        let all = || part.into_iter().chain(mirror);
        assert!(lines.iter().any(|first| all().all(|at| has(first + at))), "{lines:?}");
        // The excerpt of the sag table goes to the last rows and columns that a corner of the mirror may hold.
        let mut places: Vec<f64> = facts.sag_mm.iter().map(|place| place[axis]).collect();
        places.sort_by(f64::total_cmp);
        places.dedup();
        let (first, size) = (facts.mirror_least_mm[axis], facts.mirror_mm[axis]);
        let most = places.len() - 1;
        let step = (places[most] - places[0]) / most as f64;
        let short = [places[0] - first, first + size - places[most]];
        assert!(short.iter().all(|far| (0.0..2.0 * step).contains(far)), "{short:?}");
    }
}
