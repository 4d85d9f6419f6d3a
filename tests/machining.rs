//! Cutters: closed forms, the as-cut part against what was foreseen of it, valleys, hollows, refusals.

mod common;
mod support;

use common::{SMALL, edited, files, folder, morion, save, small_but, told};
use morion::design::design;
use morion::geom::{DVec2, DVec3};
use morion::machining::{Fillet, Gouge, Passes, Place, Raster, Survey, corners, outlines};
use morion::num::{cos, hypot, radians};
use morion::pipeline::{Cutting, Silent, Source, load, machining};
use morion::profile::Profile;
use morion::report::{Machining, Verdict};
use serde_json::Value;
use std::path::Path;
use support::parts::{case, parsed};

const CUTTING: Cutting = Cutting {
    ball_mm: 1.0,
    stepover_mm: 0.137,
    angle_deg: None,
    budget_px: None,
    scallop_um: None,
    allowance_mm: 0.0,
    as_cut: false,
};

/// A mirror of a formula, without a projection.
fn given(outline: &str, formula: &str) -> Profile {
    let text = format!(
        "camera.orthographic.pixels = [64, 48]\n{outline}\nmirror.polynomial = {{ {formula} }}\n\
         mesh.chord_um = 5\nexport.formats = [\"stl\"]\n"
    );
    common::profile(&text)
}

/// A ring that lies between the centres of pixels.
fn unseen_profile() -> Profile {
    common::profile(
        "camera.orthographic.pixels = [8, 6]\nlayout.annulus.inner_width_mm = 23.2\n\
         part = { width_mm = 24, base_mm = 3 }\nmirror.polynomial = { radius_mm = -40, conic = 0 }\n\
         mesh.chord_um = 5\nexport.formats = [\"stl\"]\n",
    )
}

const DISC: &str = "layout.disc = {}\npart = { width_mm = 24, base_mm = 3 }";
const RECTANGLE: &str = "part = { width_mm = 12, height_mm = 9, base_mm = 3 }";

fn cut(profile: &Profile, cutting: Cutting, out: &Path) -> Machining {
    let found = machining(&Source::from(profile.clone()), &cutting, out, &Silent);
    found.unwrap_or_else(|error| panic!("{error}"))
}

/// A ball that touches a sphere of radius rho at height u has its centre at u (1 + R / rho), on the ray from the
/// sphere's centre: where a raster crosses the sphere's meridian plane the cut is a row of circles.
#[test]
fn the_cut_of_a_sphere_meets_its_closed_form_along_a_meridian() {
    let (ball, w) = (3.0, 0.5);
    for rho in [25.0f64, -25.0] {
        // A positive radius opens upwards in a profile.
        let profile = given(DISC, &format!("radius_mm = {}, conic = 0", -rho));
        let mirror = design(&profile, None).unwrap().mirror;
        for angle in [0.0, 90.0] {
            let raster = Raster { ball_mm: ball, stepover_mm: w, angle: radians(angle) };
            let passes = Passes::new(&mirror, corners(&outlines(&mirror)), raster).unwrap();
            let apex = Place::of(&mirror, DVec2::ZERO).at.z;
            for k in -100..=100 {
                let y = 0.1 * f64::from(k);
                let circle = |line: f64| {
                    let u = (line + 0.5) * w;
                    let (grown, up) = (1.0 + ball / rho, (rho * rho - u * u).sqrt() * rho.signum());
                    let centre = DVec2::new(u * grown, apex - rho + up * grown);
                    let off = y - centre.x;
                    centre.y - (ball * ball - off * off).sqrt()
                };
                let line = (y / w - 0.5).round();
                let exact =
                    [line - 1.0, line, line + 1.0].map(circle).into_iter().fold(1e9, f64::min);
                let xy = raster.along().perp() * y;
                let found = passes.height(xy).unwrap();
                assert!((found - exact).abs() < 1e-9, "{rho} {angle} {y}: {found} {exact}");
            }
        }
    }
}

#[test]
fn a_flat_mirror_has_the_shop_formulas_and_the_volume_of_its_scallops() {
    let folder = folder();
    let profile = given(RECTANGLE, "terms = [[0, 0, 1]]");
    let cutting = Cutting {
        stepover_mm: 0.3,
        as_cut: true,
        allowance_mm: 2.0,
        scallop_um: Some(12.0),
        ..CUTTING
    };
    let found = cut(&profile, cutting, folder.path());
    assert_eq!((found.verdict, &found.reasons[..]), (Verdict::Pass, &[][..]));
    let w = cutting.stepover_mm;
    let height = 1.0 - (1.0 - w * w / 4.0).sqrt();
    let scallops = found.scallops.unwrap();
    assert!((scallops.scallop_um.value - 1e3 * height).abs() < 1e-9);
    assert!((scallops.slope_rms - w / 12f64.sqrt()).abs() < 1e-12);
    assert!((scallops.slope_max - w / 2.0).abs() < 1e-12);
    // h = 12 um at w = sqrt(8 R h - 4 h^2).
    let step = found.budget.stepover_for_scallop_mm.unwrap();
    assert!((step - (8.0 * 0.012f64 - 4.0 * 0.012 * 0.012).sqrt()).abs() < 1e-9);
    assert_eq!((found.steepest_deg.value, found.least_hollow_mm), (0.0, None));
    assert!(found.best.height.any && found.best.pixels.is_none());
    assert_eq!(found.reach.face_mm, 0.0);
    assert!((found.reach.wall_mm - 3.0).abs() < 1e-12);
    let stock = found.stock;
    assert!((stock.volume_mm3 - 16.0 * 13.0 * 5.0).abs() < 1e-9);
    assert!((stock.removed_mm3 - (16.0 * 13.0 * 5.0 - 12.0 * 9.0 * 3.0)).abs() < 1e-6);
    // The mean of u^2 / 2R over a scallop, and of its chords over eighths of it.
    let trace = found.as_cut.unwrap().trace;
    let mean = w * w / 24.0 * (1.0 + 2.0 / 64.0);
    let more = trace.solid.check.volume_mm3 - trace.solid.volume_expected_mm3;
    assert!((more / (108.0 * mean) - 1.0).abs() < 0.01, "{more} {}", 108.0 * mean);
    assert_eq!(trace.hit, trace.rays);
}

/// What is foreseen is of first order in the stepover: it is met the better the smaller that is.
#[test]
fn the_witness_finds_the_pixel_error_that_was_foreseen() {
    let folder = folder();
    let pinhole = [
        (
            "[camera.orthographic]\npixels = [160, 120]",
            "[camera.pinhole]\npixels = [160, 120]\nfocal_px = 400\ndistance_mm = 40",
        ),
        ("width_mm = 15", "width_mm = 16"),
    ];
    let shares = |text: &str, angle_deg, stepover_mm| {
        let profile = common::profile(text);
        let angle_deg = Some(angle_deg);
        let cutting = Cutting { ball_mm: 2.0, angle_deg, stepover_mm, as_cut: true, ..CUTTING };
        let found = cut(&profile, cutting, folder.path());
        assert_eq!((found.verdict, &found.reasons[..]), (Verdict::Pass, &[][..]), "{angle_deg:?}");
        let scallops = found.scallops.as_ref().unwrap();
        let foreseen = scallops.pixel_error_px.unwrap();
        let trace = &found.as_cut.as_ref().unwrap().trace;
        assert_eq!(trace.hit, trace.rays);
        let seen = trace.errors.facet_error_px.unwrap();
        // Against the projection both errors add up, as squares.
        let design = found.design_pixel_error_px.unwrap().rms;
        let all = trace.errors.pixel_error_px.unwrap().rms;
        assert!((all / hypot(seen.rms, design) - 1.0).abs() < 0.03, "{all} {design}");
        // The highest scallops stand on the steepest slope, where heights along Z are larger.
        let steep = radians(found.steepest_deg.value);
        let off = trace.worst_vertex.unwrap().off_mm;
        let most = 1e-3 * scallops.scallop_um.value / cos(steep);
        assert!(off < 1.3 * most && off > 0.2 * most, "{off} {most}");
        [seen.rms / foreseen.rms, seen.p95 / foreseen.p95]
    };
    // The facets are chords of a scallop's eighths, whose slopes have 1 - 1/64 of the mean square.
    let chords = (1.0f64 - 1.0 / 64.0).sqrt();
    for (text, angle) in [(SMALL, 17.0), (SMALL, 62.0), (&edited(SMALL, &pinhole), 90.0)] {
        let [rms, p95] = shares(text, angle, 0.21);
        assert!((rms / chords - 1.0).abs() < 0.03, "{angle}: {rms}");
        assert!((p95 - 1.0).abs() < 0.05, "{angle}: {p95}");
    }
    let off = |stepover| (shares(SMALL, 62.0, stepover)[0] / chords - 1.0).abs();
    assert!(off(0.2) < 0.5 * off(0.4));
}

#[test]
fn budgets_are_kept_by_the_stepovers_that_are_found_for_them() {
    let (folder, profile) = (folder(), common::profile(SMALL));
    let asked = Cutting { budget_px: Some(0.5), scallop_um: Some(0.4), ..CUTTING };
    let first = cut(&profile, asked, folder.path());
    assert_eq!((first.verdict, first.reasons.len()), (Verdict::Fail, 2), "{:?}", first.reasons);
    let px = first.budget.stepover_for_px_mm.unwrap();
    let um = first.budget.stepover_for_scallop_mm.unwrap();
    let design = design(&profile, None).unwrap();
    let survey = Survey::new(&design.mirror, &design.camera, design.view.as_ref());
    let angle = radians(first.angle_deg);
    let figures = |stepover_mm| {
        survey.figures(&Raster { ball_mm: 1.0, stepover_mm, angle }).unwrap().unwrap()
    };
    assert!((figures(px).pixel_error_px.unwrap().p95 / 0.5 - 1.0).abs() < 1e-9);
    assert!((figures(um).scallop_um.value / 0.4 - 1.0).abs() < 1e-9);
    let kept = Cutting { stepover_mm: 0.999_999 * px.min(um), ..asked };
    let found = cut(&profile, kept, folder.path());
    assert_eq!(found.verdict, Verdict::Pass, "{:?}", found.reasons);
    // What is printed is enough, too.
    let text = found.text();
    let lines: Vec<_> =
        text.lines().filter_map(|line| line.split_once(": a stepover of ")).collect();
    assert_eq!(lines.len(), 2, "{text}");
    for stepover in lines {
        let printed: f64 = stepover.1.trim_end_matches(" mm").parse().unwrap();
        assert!(printed <= px.max(um) && printed > 0.99 * px.min(um), "{printed}");
    }
}

#[test]
fn the_best_direction_is_the_least_of_all_and_round_mirrors_have_none() {
    let profile = common::profile(SMALL);
    let design = design(&profile, None).unwrap();
    let survey = Survey::new(&design.mirror, &design.camera, design.view.as_ref());
    let raster = |angle_deg| Raster { ball_mm: 1.0, stepover_mm: 0.137, angle: radians(angle_deg) };
    let figures = |angle_deg| survey.figures(&raster(angle_deg)).unwrap().unwrap();
    let rms = |angle_deg| figures(angle_deg).pixel_error_px.unwrap().rms;
    let best = survey.best_for_pixels(&raster(0.0)).unwrap();
    let least = rms(best.angle_deg);
    let others: Vec<f64> = (0..12).map(|k| rms(15.0 * f64::from(k))).collect();
    assert!(others.iter().all(|rms| *rms >= least * (1.0 - 1e-6)), "{least} {others:?}");
    let worst = others.iter().copied().fold(0.0, f64::max);
    assert!(!best.any && best.of_worst < 0.999 && best.of_worst < 1.001 * least / worst);
    assert!(best.of_worst > 0.98 * least / worst);
    let round = load("parabolic").unwrap().profile;
    let found = cut(&round, CUTTING, folder().path());
    assert!(found.best.pixels.unwrap().any && found.best.height.any, "{:?}", found.best);
    assert!(found.text().contains("a spiral about the axis does as well"));
    assert_eq!(found.gouge.left_max_um, 0.0);
}

/// Holes, marks, a rounded border, a land within an annulus: what is around the as-cut face is the part's.
#[test]
fn as_cut_parts_with_all_that_is_around_a_mirror_are_solids() {
    let folder = folder();
    for what in ["conquistador, rounded", "annulus, land"] {
        let profile = parsed(&case(what));
        let (angle_deg, as_cut) = (Some(25.0), true);
        let cutting = Cutting { ball_mm: 6.0, stepover_mm: 1.1, angle_deg, as_cut, ..CUTTING };
        let found = cut(&profile, cutting, folder.path());
        assert_eq!((found.verdict, &found.reasons[..]), (Verdict::Pass, &[][..]), "{what}");
        let trace = found.as_cut.unwrap().trace;
        // Scallops may shadow a few of the rays that all but graze the mirror.
        assert_eq!((trace.missed, trace.back_face), (0, 0), "{what}");
        assert!(trace.shadowed * 10_000 < trace.rays, "{what}: {}", trace.shadowed);
        // The annulus turns some rays to where the law has no image.
        let nowhere = trace.errors.facet_error_px.unwrap().rms.is_nan();
        let warned = found.warnings.iter().any(|w| w.contains("no place in the image"));
        assert_eq!([nowhere, warned], [what.starts_with("annulus"); 2], "{what}");
        assert!(found.stock.removed_mm3 > 0.0 && found.reach.wall_mm > found.reach.face_mm);
    }
}

#[test]
fn a_valley_keeps_a_fillet_that_two_ways_measure_alike() {
    let folder = folder();
    let profile = common::profile(&small_but("\"crest\"", "\"valley\""));
    let cutting =
        Cutting { ball_mm: 0.5, stepover_mm: 0.1, as_cut: true, angle_deg: Some(0.0), ..CUTTING };
    let found = cut(&profile, cutting, folder.path());
    assert_eq!(found.verdict, Verdict::Fail);
    assert!(found.reasons.iter().any(|r| r.contains("fillet of")), "{:?}", found.reasons);
    let fillet = found.fillet.unwrap();
    // The root along each line against the closing of the mirror by the ball.
    let design = design(&profile, None).unwrap();
    let gouge =
        Gouge::new(&design.mirror, corners(&outlines(&design.mirror)), cutting.ball_mm, None);
    let cells = gouge.left.iter().flatten().filter(|left| **left > 0.0).count();
    let area = cells as f64 * gouge.step * gouge.step;
    let exact = fillet.pixels * design.camera.pixel_mm * design.camera.pixel_mm;
    // The map is coarse: a row of it on either side.
    let row = 2.0 * gouge.step * 15.0;
    assert!((area - exact).abs() < row, "{area} {exact}");
    let (left, at) = gouge.most.unwrap();
    assert!((left / fillet.left_max_mm - 1.0).abs() < 1e-3 && at.y == 0.0, "{left} {fillet:?}");
    assert_eq!(gouge.most_beside, None);
    // Ridges that stand out, and those that flatten towards their ends, are none.
    for crest in [common::profile(SMALL), load("conformal").unwrap().profile] {
        let design = morion::design::design(&crest, None).unwrap();
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
    assert_eq!(made.keys().collect::<Vec<_>>(), ["gouge.png", "machining.json"]);
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
        assert_eq!(made.keys().collect::<Vec<_>>(), ["gouge.png", "machining.json"]);
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

#[test]
fn a_mirror_that_no_pixel_sees_is_cut_all_the_same() {
    let folder = folder();
    let profile = unseen_profile();
    let found = cut(&profile, Cutting { stepover_mm: 0.3, ..CUTTING }, folder.path());
    let scallops = found.scallops.as_ref().unwrap();
    assert!(scallops.scallop_um.value > 0.0 && scallops.slope_rms.is_nan());
    assert_eq!((found.verdict, scallops.pixels), (Verdict::Pass, 0));
    assert!(found.warnings.iter().any(|w| w.contains("no pixel sees")), "{:?}", found.warnings);
    assert!(
        found.text().contains("no pixel sees them") && found.json().contains("\"slope_rms\": null")
    );
}

/// An as-cut surface that is too fine is offered a stepover with which it is made.
#[test]
fn the_stepover_that_is_offered_instead_is_taken() {
    let folder = folder();
    let source =
        Source::from(given(RECTANGLE, "terms = [[0, 0, 1], [2, 0, -0.02], [0, 2, -0.01]]"));
    for ball_mm in [0.4, 6.0] {
        let cutting = |stepover_mm| Cutting { ball_mm, stepover_mm, as_cut: true, ..CUTTING };
        let refused = machining(&source, &cutting(1e-4), folder.path(), &Silent).unwrap_err();
        let text = refused.to_string();
        let offered = text.split("at least ").nth(1).and_then(|rest| rest.split(" mm").next());
        let offered: f64 =
            offered.and_then(|mm| mm.parse().ok()).unwrap_or_else(|| panic!("{text}"));
        let found = machining(&source, &cutting(offered), folder.path(), &Silent);
        assert!(found.is_ok(), "{text} {:?}", found.err().map(|error| error.to_string()));
    }
}

/// A map against no search but brute force: all centres of a grid against all nodes of a fine one.
#[test]
fn the_map_of_the_panoramic_mirror_is_that_of_brute_force() {
    let mirror = design(&load("panoramic").unwrap().profile, None).unwrap().mirror;
    let rim = corners(&outlines(&mirror));
    let (ball, fine) = (15.0f64, 0.1);
    let gouge = Gouge::new(&mirror, rim, ball, None);
    let [lo, hi] = rim;
    let count = ((hi - lo) / fine).ceil();
    let node = |k: usize| {
        let share =
            DVec2::new((k % (count.x as usize + 1)) as f64, (k / (count.x as usize + 1)) as f64);
        Place::over(&mirror, lo + (hi - lo) * share / count).unwrap().at
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
    let face: Vec<usize> = (0..gouge.left.len()).filter(|&k| gouge.left[k].is_some()).collect();
    let (mut bad, mut good) = (0, 0);
    for n in 0..16 {
        let k = face[(n * 7919 + 131) * 31 % face.len()];
        let p = gouge.place(k);
        let exact = closed(p) - Place::over(&mirror, p).unwrap().at.z;
        let found = gouge.left[k].unwrap();
        // The nodes lie a tenth of a millimetre apart, under which a ball sinks by a micrometre; from above there are
        // the last steps of the centres.
        assert!(found < exact + 2e-3 && found > exact - 5e-3, "{p}: {found} {exact}");
        if found > 0.0 { bad += 1 } else { good += 1 }
    }
    assert!(bad > 2 && good > 2, "{bad} {good}");
}

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
        (&["--ball-mm", "1", "--stepover-mm", "0.001"], &["stepover of at least", "--no-as-cut"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--budget-px", "0"], &["--budget-px"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--scallop-um", "-1"], &["--scallop-um"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--allowance-mm", "-1"], &["--allowance-mm"]),
        (&["--ball-mm", "1", "--stepover-mm", "0.1", "--angle-deg", "1e4"], &["--angle-deg"]),
        (&["--ball-mm", "one", "--stepover-mm", "0.1"], &["invalid value"]),
        (&["--ball-mm", "1"], &["--stepover-mm"]),
    ] {
        let all = [&["machining", "small.toml", "-q"][..], arguments].concat();
        let (code, out, err) = told(&morion(home, &all));
        assert_eq!((code, &*out), (2, ""), "{arguments:?}: {err}");
        for word in words {
            assert!(err.contains(word), "no {word:?} in {err}");
        }
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
    common::assert_same(&one.1, &three.1, "threads");
    let names: Vec<&str> = one.1.keys().map(String::as_str).collect();
    assert_eq!(names, ["as-cut.stl", "gouge.png", "machining.json"]);
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
    let mesh = morion::export::read_stl(&one.1["as-cut.stl"]).unwrap().mesh;
    let optical = json["as_cut"]["optical_triangles"].as_u64().unwrap() as usize;
    assert!(mesh.triangles.len() > optical);
    assert!((0..optical).all(|t| mesh.area_vector(t).dot(DVec3::Z) > 0.0));
}
