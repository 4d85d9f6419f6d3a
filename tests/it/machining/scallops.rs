//! What a ball cutter leaves of a mirror that it fits into.

use super::{CUTTING, DISC, RECTANGLE, cut, given, unseen_profile};
use crate::support::builds::{self, SMALL, edited, folder, parsed};
use crate::support::parts::case;
use morion::internals::design::design;
use morion::internals::geom::DVec2;
use morion::internals::machining::{
    BallRaster, Passes, SurfaceAnalysis, bounding_corners, plan_outlines,
};
use morion::internals::num::{cos, hypot, radians};
use morion::internals::pipeline::{Command, MachiningOptions, Silent, load};
use morion::internals::report::Answer;
use morion::internals::results::Verdict;

/// A ball that touches a sphere of radius rho at height u has its centre at u (1 + R / rho), on the ray from the
/// sphere's centre: where a raster crosses the sphere's meridian plane the cut is a row of circles.
#[test]
fn the_cut_of_a_sphere_meets_its_closed_form_along_a_meridian() {
    let (ball, w) = (3.0, 0.5);
    for rho in [25.0f64, -25.0] {
        // A positive radius opens upwards in a profile.
        let profile = given(DISC, &format!("radius_mm = {}, conic = 0", -rho));
        let mirror = design(&profile).unwrap().mirror;
        for angle in [0.0, 90.0] {
            let raster = BallRaster { ball_mm: ball, stepover_mm: w, angle: radians(angle) };
            let passes =
                Passes::new(&mirror, bounding_corners(&plan_outlines(&mirror)), raster).unwrap();
            let apex = mirror.extended_surface(DVec2::ZERO).at.z;
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
    let cutting = MachiningOptions {
        stepover_mm: Some(0.3),
        as_cut: true,
        allowance_mm: 2.0,
        scallop_um: Some(12.0),
        ..CUTTING
    };
    let found = cut(&profile, cutting, folder.path());
    assert_eq!((found.verdict, &found.reasons[..]), (Verdict::Pass, &[][..]));
    let w = cutting.stepover_mm.unwrap();
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
#[ignore = "long: .ci/nightly"]
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
        let profile = builds::parsed(text);
        let angle_deg = Some(angle_deg);
        let stepover_mm = Some(stepover_mm);
        let budget_px = Some(1e6);
        let cutting = MachiningOptions {
            ball_mm: 2.0,
            angle_deg,
            stepover_mm,
            budget_px,
            as_cut: true,
            ..CUTTING
        };
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
    let (folder, profile) = (folder(), builds::parsed(SMALL));
    let asked = MachiningOptions { budget_px: Some(0.5), scallop_um: Some(0.4), ..CUTTING };
    let first = cut(&profile, asked, folder.path());
    assert_eq!((first.verdict, first.reasons.len()), (Verdict::Fail, 2), "{:?}", first.reasons);
    let px = first.budget.stepover_for_px_mm.unwrap();
    let um = first.budget.stepover_for_scallop_mm.unwrap();
    let design = design(&profile).unwrap();
    let survey = SurfaceAnalysis::new(&design.mirror, &design.camera, design.view.as_ref());
    let angle = radians(first.angle_deg);
    let figures = |stepover_mm| {
        survey.figures(&BallRaster { ball_mm: 1.0, stepover_mm, angle }).unwrap().unwrap()
    };
    assert!((figures(px).pixel_error_px.unwrap().p95 / 0.5 - 1.0).abs() < 1e-9);
    assert!((figures(um).scallop_um.value / 0.4 - 1.0).abs() < 1e-9);
    let kept = MachiningOptions { stepover_mm: Some(0.999_999 * px.min(um)), ..asked };
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
    let profile = builds::parsed(SMALL);
    let design = design(&profile).unwrap();
    let survey = SurfaceAnalysis::new(&design.mirror, &design.camera, design.view.as_ref());
    let raster =
        |angle_deg| BallRaster { ball_mm: 1.0, stepover_mm: 0.137, angle: radians(angle_deg) };
    let figures = |angle_deg| survey.figures(&raster(angle_deg)).unwrap().unwrap();
    let rms = |angle_deg| figures(angle_deg).pixel_error_px.unwrap().rms;
    let best = survey.best_for_pixels(&raster(0.0)).unwrap();
    let least = rms(best.angle_deg);
    let others: Vec<f64> = (0..12).map(|k| rms(15.0 * f64::from(k))).collect();
    assert!(others.iter().all(|rms| *rms >= least * (1.0 - 1e-6)), "{least} {others:?}");
    let worst = others.iter().copied().fold(0.0, f64::max);
    assert!(!best.any && best.of_worst < 0.999 && best.of_worst < 1.001 * least / worst);
    assert!(best.of_worst > 0.98 * least / worst);
    let round = load("parabolic").unwrap();
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
        let (angle_deg, budget_px, as_cut) = (Some(25.0), Some(1e6), true);
        let cutting = MachiningOptions {
            ball_mm: 6.0,
            stepover_mm: Some(1.1),
            angle_deg,
            budget_px,
            as_cut,
            ..CUTTING
        };
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
fn a_mirror_that_no_pixel_sees_is_cut_all_the_same() {
    let folder = folder();
    let profile = unseen_profile();
    let found =
        cut(&profile, MachiningOptions { stepover_mm: Some(0.3), ..CUTTING }, folder.path());
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
#[ignore = "makes the largest surface that there may be, which takes long: .ci/nightly has it"]
fn the_stepover_that_is_offered_instead_is_taken() {
    let folder = folder();
    let source = given(RECTANGLE, "terms = [[0, 0, 1], [2, 0, -0.02], [0, 2, -0.01]]");
    for ball_mm in [0.4, 6.0] {
        let cutting =
            |mm: f64| MachiningOptions { ball_mm, stepover_mm: Some(mm), as_cut: true, ..CUTTING };
        let found = cutting(1e-4).publish(&source, folder.path(), &Silent).unwrap();
        assert!(found.as_cut.is_none());
        let text = found.warnings.concat();
        let offered = text.split("at least ").nth(1).and_then(|rest| rest.split(" mm").next());
        let offered: f64 =
            offered.and_then(|mm| mm.parse().ok()).unwrap_or_else(|| panic!("{text}"));
        let found = cutting(offered).publish(&source, folder.path(), &Silent);
        let found = found.unwrap_or_else(|error| panic!("{text} {error}"));
        assert!(found.as_cut.is_some(), "{:?}", found.warnings);
    }
}

/// Without a stepover the largest is taken that keeps what is asked for, or, where nothing is, what a build
/// is held to; written down it keeps it too. An as-cut part of too many facets is left out with a note.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_stepover_that_is_not_given_is_the_largest_that_keeps_the_budget() {
    let folder = folder();
    let source = builds::parsed(SMALL);
    let run = |cutting: MachiningOptions| cutting.publish(&source, folder.path(), &Silent).unwrap();
    let free = MachiningOptions { ball_mm: 2.0, stepover_mm: None, as_cut: false, ..CUTTING };
    for (budget_px, scallop_um) in [(Some(0.3), None), (Some(0.3), Some(0.05)), (None, None)] {
        let asked = MachiningOptions { budget_px, scallop_um, ..free };
        let found = run(asked);
        assert_eq!(found.verdict, Verdict::Pass, "{:?}", found.reasons);
        let px = found.budget.p95_px.unwrap();
        assert_eq!(px, budget_px.unwrap_or(source.acceptance_limits().pixel_error_max_px.value));
        let scallops = found.scallops.unwrap();
        let used = [
            scallops.pixel_error_px.unwrap().p95 / px,
            scallop_um.map_or(0.0, |um| scallops.scallop_um.value / um),
        ];
        let most = used[0].max(used[1]);
        assert!(most <= 1.0 && most > 0.99, "{used:?}");
        let again = run(MachiningOptions { stepover_mm: Some(found.stepover_mm), ..asked });
        assert_eq!(again.verdict, Verdict::Pass);
        let wider = run(MachiningOptions { stepover_mm: Some(1.02 * found.stepover_mm), ..asked });
        assert_eq!(wider.verdict, Verdict::Fail);
    }
    let fine = run(MachiningOptions { stepover_mm: Some(2e-5), as_cut: true, ..free });
    assert!(fine.as_cut.is_none());
    assert!(
        fine.warnings.iter().any(|w| w.contains("the as-cut part was not made: with a stepover"))
    );
}
