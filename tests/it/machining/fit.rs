//! Where a ball does not fit: ridges' roots, hollows, and the map of both.

use super::{CUTTING, DISC, cut};
use crate::support::builds::{self, SMALL, files, folder, morion, save, told};
use crate::support::small_but;
use morion::internals::design::design;
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::machining::{Fillet, Gouge, bounding_corners, plan_outlines};
use morion::internals::pipeline::{MachiningOptions, load};
use morion::internals::results::Verdict;
use serde_json::Value;

#[test]
fn a_valley_keeps_a_fillet_that_two_ways_measure_alike() {
    let folder = folder();
    let profile = builds::parsed(&small_but("\"crest\"", "\"valley\""));
    let cutting = MachiningOptions {
        ball_mm: 0.5,
        stepover_mm: Some(0.1),
        as_cut: true,
        angle_deg: Some(0.0),
        ..CUTTING
    };
    let found = cut(&profile, cutting, folder.path());
    assert_eq!(found.verdict, Verdict::Fail);
    assert!(
        found.reasons.iter().any(|r| r.to_string().contains("fillet of")),
        "{:?}",
        found.reasons
    );
    let fillet = found.fillet.unwrap();
    // The root along each line against the closing of the mirror by the ball.
    let design = design(&profile).unwrap();
    let gouge = Gouge::new(
        &design.mirror,
        bounding_corners(&plan_outlines(&design.mirror)),
        cutting.ball_mm,
        None,
    );
    let cells = gouge.rest_mm.iter().flatten().filter(|left| **left > 0.0).count();
    let area = cells as f64 * gouge.step * gouge.step;
    let exact = fillet.pixels * design.camera.pixel_mm * design.camera.pixel_mm;
    // The map is coarse: a row of it on either side.
    let row = 2.0 * gouge.step * 15.0;
    assert!((area - exact).abs() < row, "{area} {exact}");
    let (left, at) = gouge.largest.unwrap();
    assert!((left / fillet.left_max_mm - 1.0).abs() < 1e-3 && at.y == 0.0, "{left} {fillet:?}");
    assert_eq!(gouge.largest_outside_fillet, None);
    // Ridges that stand out, and those that flatten towards their ends, are none.
    for crest in [builds::parsed(SMALL), load("conformal").unwrap()] {
        let design = morion::internals::design::design(&crest).unwrap();
        assert_eq!(Fillet::new(&design.mirror, &design.camera, 0.1 * crest.part.width_mm), None);
    }
    // The part is cut all the same, and is a solid.
    let trace = found.as_cut.unwrap().trace;
    assert!(trace.solid.reasons.is_empty(), "{:?}", trace.solid.reasons);
    assert!((trace.worst_vertex.unwrap().off_mm / fillet.left_max_mm - 1.0).abs() < 0.05);
}

#[test]
fn a_ball_too_large_for_a_hollow_is_a_negative_verdict_and_leaves_no_part() {
    let folder = folder();
    let home = folder.path();
    let text = format!(
        "camera.orthographic.pixels = [64, 48]\n{DISC}\nmirror.polynomial = {{ radius_mm = 10, conic = -1 }}\n\
         mesh.chord_um = 5\nexport.formats = [\"stl\"]\n"
    );
    save(home, &text);
    let run = |ball: &str| {
        let arguments =
            ["machining", "small.toml", "--stepover-mm", "0.5", "--ball-mm", ball, "-q"];
        told(&morion(home, &arguments))
    };
    let (code, out, err) = run("4");
    assert_eq!((code, &*err), (0, ""), "{out}");
    assert!(
        out.contains("the ball fits everywhere") && out.contains("least hollow radius 10.000 mm"),
        "{out}"
    );
    assert!(home.join("out/small/as-cut.stl").exists());
    let (code, out, err) = run("12");
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("the as-cut part was not made: the ball of 12 mm does not fit"), "{err}");
    let made = files(&home.join("out/small"));
    assert_eq!(made.keys().collect::<Vec<_>>(), ["gouge.png", "machining.html", "machining.json"]);
    let json: Value = serde_json::from_slice(&made["machining.json"]).unwrap();
    assert!((json["least_hollow_mm"]["value"].as_f64().unwrap() - 10.0).abs() < 1e-6);
    // A paraboloid z = r^2 / 2a keeps a ball of R > a off its bottom by (R - a)^2 / 2a.
    let left = json["gouge"]["left_max_um"].as_f64().unwrap();
    assert!((left / 200.0 - 1.0).abs() < 1e-6, "{left}");
    assert!(out.contains("does not fit: at X") && out.ends_with("verdict  fail\n"), "{out}");
    // One decision, however little is left: 0.005 um.
    let (code, out, err) = run("10.01");
    assert_eq!(code, 1, "{err}");
    assert!(out.contains("the ball leaves up to 0.005") && !out.contains("fits"), "{out}");
    assert!(out.contains("does not fit: at X"), "{out}");
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_ball_that_fits_nowhere_is_a_negative_verdict_with_its_map() {
    let folder = folder();
    let home = folder.path();
    let bowl = |radius: f64| {
        format!(
            "camera.orthographic.pixels = [64, 48]\n{DISC}\nmirror.polynomial = {{ radius_mm = {radius}, conic = 0 }}\n\
             mesh.chord_um = 5\nexport.formats = [\"stl\"]\n"
        )
    };
    save(home, &bowl(25.0));
    let run = |ball: &str| {
        let arguments = ["machining", "small.toml", "--stepover-mm", "0.5", "--ball-mm", ball];
        told(&morion(home, &arguments))
    };
    // It lies on the rim of radius 12 mm.
    for ball in [25.001f64, 25.1, 40.0] {
        let (code, out, err) = run(&ball.to_string());
        assert_eq!(code, 1, "{err}");
        for words in ["fits nowhere on the mirror: at X", "scallops none", "verdict  fail"] {
            assert!(out.contains(words), "no {words:?} in {out}");
        }
        let made = files(&home.join("out/small"));
        assert_eq!(
            made.keys().collect::<Vec<_>>(),
            ["gouge.png", "machining.html", "machining.json"]
        );
        let json: Value = serde_json::from_slice(&made["machining.json"]).unwrap();
        let nothing = json.get("scallop_um").is_some_and(Value::is_null);
        assert!(nothing && json["gouge"]["fits"] == false, "{json}");
        let sag = |radius: f64| radius - (radius * radius - 144.0).sqrt();
        let exact = 1e3 * (sag(25.0) - sag(ball));
        let left = json["gouge"]["left_max_um"].as_f64().unwrap();
        assert!((left / exact - 1.0).abs() < 1e-3, "{ball}: {left} {exact}");
    }
    let (code, out, err) = run("24.999");
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("the ball fits everywhere"), "{out}");
}

/// A map against no search but brute force: all centres of a grid against all nodes of a fine one.
#[test]
#[ignore = "long: .ci/nightly"]
fn the_map_of_the_panoramic_mirror_is_that_of_brute_force() {
    let mirror = design(&load("panoramic").unwrap()).unwrap().mirror;
    let rim = bounding_corners(&plan_outlines(&mirror));
    let (ball, fine) = (15.0f64, 0.1);
    let gouge = Gouge::new(&mirror, rim, ball, None);
    let [lo, hi] = rim;
    let count = ((hi - lo) / fine).ceil();
    let node = |k: usize| {
        let share =
            DVec2::new((k % (count.x as usize + 1)) as f64, (k / (count.x as usize + 1)) as f64);
        mirror.extended_surface_over(lo + (hi - lo) * share / count).unwrap().at
    };
    let nodes: Vec<DVec3> =
        (0..(count.x as usize + 1) * (count.y as usize + 1)).map(node).collect();
    let over = |c: DVec2, stride: usize| {
        let height = |at: &DVec3| {
            let square = ball * ball - (at.truncate() - c).length_squared();
            at.z + square.sqrt()
        };
        nodes.iter().step_by(stride).map(height).fold(f64::NEG_INFINITY, f64::max)
    };
    let closed = |p: DVec2| {
        let lower = |c: DVec2, stride: usize| {
            let square = ball * ball - (p - c).length_squared();
            if square > 0.0 { over(c, stride) - square.sqrt() } else { f64::INFINITY }
        };
        let (mut best, mut pitch) = (p, 1.0);
        let mut least = f64::INFINITY;
        for round in 0..12 {
            let (reach, stride) = if round == 0 { (14, 7) } else { (4, 1) };
            let about = best;
            if round == 1 {
                least = f64::INFINITY;
            }
            for k in 0..(2 * reach + 1) * (2 * reach + 1) {
                let (x, y) = (k % (2 * reach + 1) - reach, k / (2 * reach + 1) - reach);
                let c = about + DVec2::new(f64::from(x), f64::from(y)) * pitch;
                let height = lower(c, stride);
                if height < least {
                    (least, best) = (height, c);
                }
            }
            pitch *= 0.5;
        }
        least
    };
    let face: Vec<usize> =
        (0..gouge.rest_mm.len()).filter(|&k| gouge.rest_mm[k].is_some()).collect();
    let (mut bad, mut good) = (0, 0);
    for n in 0..16 {
        let k = face[(n * 7919 + 131) * 31 % face.len()];
        let p = gouge.place(k);
        let exact = closed(p) - mirror.extended_surface_over(p).unwrap().at.z;
        let found = gouge.rest_mm[k].unwrap();
        // The nodes lie a tenth of a millimetre apart, under which a ball sinks by a micrometre; from above there are
        // the last steps of the centres.
        assert!(found < exact + 2e-3 && found > exact - 5e-3, "{p}: {found} {exact}");
        if found > 0.0 { bad += 1 } else { good += 1 }
    }
    assert!(bad > 2 && good > 2, "{bad} {good}");
}
