//! Programs of any making, read, cut and traced: what they leave is what the ball cutter's study foresees, and what would
//! spoil a part is found.

use crate::support::builds::{SMALL, edited, folder, morion, parsed, save, told};
use crate::support::{designed, share, shipped};
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{cos, sin};
use morion::internals::pipeline::{Command, MachiningOptions, Silent, Verify, VerifyOptions};
use morion::internals::profile::Profile;
use morion::internals::results::{
    CuttingFault, FileFault, ReasonKind, SlopeOrigin, Verdict, VerifyReport,
};
use std::fmt::Write;

/// Tip of a ball that touches the mirror over a place of the plan, mm; none beyond the mirror.
fn tip(design: &Design, at: DVec2, ball_mm: f64) -> Option<DVec3> {
    let mirror = &design.mirror;
    let (q, _) = mirror.chart.coordinates(at.extend(mirror.chart.plane_mm));
    let near = mirror.full_outline().nearest(q);
    let z_mm = mirror.position(near, &mirror.at(near)).z;
    let place = mirror.local_surface_over(at, z_mm)?;
    Some(place.at + ball_mm * (place.normal() - DVec3::Z))
}

/// A program of lines along X, one of them `phase` stepovers off the axis, there and back, each from beyond one side of the mirror
/// to beyond the other.
fn raster(design: &Design, ball_mm: f64, stepover_mm: f64, phase: f64) -> String {
    raster_along(DVec2::X, design, ball_mm, (stepover_mm, phase))
}

/// The same along X or Y.
fn raster_along(
    along: DVec2,
    design: &Design,
    ball_mm: f64,
    (stepover_mm, phase): (f64, f64),
) -> String {
    let (half, across) = (0.5 * design.plan_bounds().size(), along.perp());
    let [long, wide] = [along, across].map(|way| half.dot(way.abs()));
    let lines = (wide / stepover_mm).ceil() as i32 + 1;
    // Chords much shorter than lines are apart, so that the cut along them is smooth.
    let steps = (6.0 * long / stepover_mm).ceil() as i32 + 4;
    let safe = design.mounting.size_mm[2] + 5.0;
    let mut text = format!("(a raster)\nG21 G90 G17 G94\nM3 S12000\nG0 Z{safe:.4}\n");
    for k in -lines..lines {
        let y = (f64::from(k) + phase) * stepover_mm;
        let x = |n: i32| long * (f64::from(2 * n) / f64::from(steps) - 1.0) * 1.03;
        let place = |n: i32| along * x(if k % 2 == 0 { n } else { steps - n }) + across * y;
        let tips: Vec<DVec3> =
            (0..=steps).map(place).filter_map(|at| tip(design, at, ball_mm)).collect();
        let [Some(first), Some(last)] = [tips.first(), tips.last()] else { continue };
        writeln!(text, "G0 X{:.4} Y{:.4}\nG1 Z{:.4} F200", first.x, first.y, first.z).unwrap();
        for tip in &tips {
            writeln!(text, "X{:.4} Y{:.4} Z{:.4} F900", tip.x, tip.y, tip.z).unwrap();
        }
        writeln!(text, "G0 X{:.4} Y{:.4} Z{safe:.4}", last.x, last.y).unwrap();
    }
    text + "M30\n"
}

fn verified(profile: &Profile, program: &str, ball_mm: f64) -> VerifyReport {
    let options = VerifyOptions { ball_mm: Some(ball_mm), ..VerifyOptions::default() };
    verified_with(profile, program, options)
}

/// The same of a cutter with a flat end, flat where its corner is 0.
fn flat_verified(
    profile: &Profile,
    program: &str,
    (radius_mm, corner_mm): (f64, f64),
) -> VerifyReport {
    let (cutter_mm, corner_mm) = (Some(radius_mm), Some(corner_mm).filter(|mm| *mm > 0.0));
    let options = VerifyOptions { cutter_mm, corner_mm, ..VerifyOptions::default() };
    verified_with(profile, program, options)
}

fn verified_with(profile: &Profile, program: &str, options: VerifyOptions) -> VerifyReport {
    let folder = folder();
    let path = folder.path().join("part.ngc");
    std::fs::write(&path, program).unwrap();
    let verify = Verify { path: &path, options };
    verify.in_memory(profile, &Silent).unwrap_or_else(|error| panic!("{error}")).0
}

/// The slopes of what a program leaves displace the picture as the study of its raster says, within 2 %, and its depth is that
/// of the scallops.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_raster_cuts_what_machining_foresees() {
    // Lines may be anywhere.
    let cases = [("conquistador", 0.4, 0.8), ("panoramic", 0.3, 0.5), ("hyperbolic", 0.4, 0.5625)];
    for (name, stepover_mm, phase) in share(3, 0, cases) {
        let profile = shipped(name);
        let design = designed(&profile);
        let ball_mm = 3.0;
        let found = verified(&profile, &raster(&design, ball_mm, stepover_mm, phase), ball_mm);
        let options = MachiningOptions {
            ball_mm,
            stepover_mm: Some(stepover_mm),
            angle_deg: Some(0.0),
            ..MachiningOptions::default()
        };
        let foreseen = options.in_memory(&profile, &Silent).unwrap().0;
        let cut = found.trace[0].errors.facet_error_px.unwrap().rms;
        let study = foreseen.scallops.unwrap().pixel_error_px.unwrap().rms;
        assert!((cut / study - 1.0).abs() < 0.02, "{name}: {cut} px, foreseen {study} px");
        let facts = found.program.unwrap();
        assert!((facts.apart_mm / stepover_mm - 1.0).abs() < 2e-3, "{name}: {facts:?}");
        assert!(facts.parallel.unwrap() > 0.98 && facts.cutting_min > 1.0, "{name}: {facts:?}");
        // Numbers of four decimals, and chords as long as a stepover between them.
        assert!(facts.lowest.off_um > -3.0, "{name}: {:?}", facts.lowest);
        assert_eq!(found.files[0].format, "ngc");
        // Slopes of scallops at the rim turn some rays into the mirror.
        let trace = &found.trace[0];
        let share = trace.hit as f64 / trace.rays as f64;
        assert!(trace.missed == 0 && share > 0.999, "{name}: {trace:?}");
    }
}

/// The small conquistador, held to what a cutter leaves.
fn rough() -> String {
    edited(
        SMALL,
        &[
            ("pixel_error_rms_px = 2", "pixel_error_rms_px = 4"),
            ("pixel_error_max_px = 5", "pixel_error_max_px = 12"),
        ],
    )
}

fn small() -> (Profile, Design, String) {
    let profile = parsed(&rough());
    let design = designed(&profile);
    let program = raster(&design, 1.5, 0.12, 0.5);
    (profile, design, program)
}

/// A ball nearly as large as the mirror's radius of curvature: where its lines touch is found nevertheless.
#[test]
fn lines_over_a_tightly_curved_mirror_are_read_as_parallel() {
    let (profile, design, _) = small();
    let found = verified(&profile, &raster(&design, 3.0, 0.15, 0.5), 3.0);
    let facts = found.program.unwrap();
    assert!(facts.parallel.unwrap() > 0.999, "{facts:?}");
    assert!((facts.apart_mm / 0.15 - 1.0).abs() < 2e-3, "{facts:?}");
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
}

/// Lines along X and along Y over a mirror: facets cannot follow both, and slopes are those of the moves. The lower of two scallops of the same
/// stepover is what is left: over a place u and v off the nearest lines that is the one with the smaller of u and v. Even ones from 0 to a have
/// the mean square `a^2 / 3`, the smaller one `a^2 / 6`, and it is as often of this direction as of that: the errors of both together are
/// the root of a quarter of the sum of their squares.
#[test]
fn crossed_lines_leave_the_lower_of_their_scallops() {
    let profile = straight_back([160, 120], 16.0);
    let design = designed(&profile);
    let [along_x, along_y] =
        [DVec2::X, DVec2::Y].map(|along| raster_along(along, &design, 1.5, (0.12, 0.5)));
    let crossed = along_x.replace("M30\n", "") + &along_y;
    let [a, b, both] =
        [&along_x, &along_y, &crossed].map(|program| verified(&profile, program, 1.5));
    let slopes = [&a, &b, &both].map(|found| found.program.as_ref().unwrap().slopes);
    assert_eq!(slopes, [SlopeOrigin::Facets, SlopeOrigin::Facets, SlopeOrigin::Path]);
    assert!(both.warnings.is_empty(), "{:?}", both.warnings);
    let facts = both.program.as_ref().unwrap();
    assert!(facts.parallel.unwrap() < 0.98, "{facts:?}");
    let [a_px, b_px, both_px] =
        [&a, &b, &both].map(|found| found.trace[0].errors.facet_error_px.unwrap().rms);
    let exact = 0.5 * f64::sqrt(a_px * a_px + b_px * b_px);
    println!("{a_px} {b_px}: {both_px} px, {exact}");
    assert!((both_px / exact - 1.0).abs() < 0.03, "{a_px} {b_px}: {both_px} px, {exact}");
    // Cusps remain where both do.
    let [high, both_high] = [&a, &both].map(|found| found.program.as_ref().unwrap().highest.off_um);
    assert!((both_high / high - 1.0).abs() < 0.05, "{high} {both_high}");
}

fn cutting(report: &VerifyReport) -> Vec<&CuttingFault> {
    let kinds = report.reasons.iter().map(|reason| &reason.kind);
    kinds
        .filter_map(|kind| match kind {
            ReasonKind::Cutting(fault) => Some(fault),
            _ => None,
        })
        .collect()
}

/// A digit of one place is another: the program no longer passes, and the figures tell the line.
#[test]
fn a_program_damaged_by_a_digit_fails() {
    let (profile, _, program) = small();
    let sound = verified(&profile, &program, 1.5);
    assert_eq!(sound.verdict, Verdict::Pass, "{:?}", sound.reasons);
    let lines: Vec<&str> = program.lines().collect();
    let is_inside = |line: &str| line.starts_with("X0.") && line.contains(" Z");
    let middle = (lines.len() / 2..).find(|&k| is_inside(lines[k])).unwrap();
    let (number, line) = (middle..).find_map(|k| Some((k, lines[k].split_once(" Z")?))).unwrap();
    let (z, rest) = line.1.split_once(' ').unwrap();
    let lower = z.parse::<f64>().unwrap() - 1.0;
    let mut damaged: Vec<String> = lines.iter().map(|&line| line.to_owned()).collect();
    damaged[number] = format!("{} Z{lower:.4} {rest}", line.0);
    let found = verified(&profile, &damaged.join("\n"), 1.5);
    assert_eq!(found.verdict, Verdict::Fail);
    let lowest = found.program.unwrap().lowest;
    // Lower by a millimetre, less the slope there.
    assert!(lowest.off_um < -300.0, "{lowest:?}");
    // The move to that place or from it.
    assert!(lowest.line.abs_diff(number as u32 + 1) <= 1, "{lowest:?}, damaged {}", number + 1);
}

#[test]
#[ignore = "long: .ci/nightly"]
fn what_would_spoil_the_part_is_named() {
    let (profile, _, program) = small();
    // A rapid move to the next line through the mirror instead of over it.
    let low = program.replacen("G0 X", "G0 Z1\nG0 X", 40);
    let found = verified(&profile, &low, 1.5);
    assert!(matches!(cutting(&found)[..], [CuttingFault::Rapid { .. }]), "{:?}", found.reasons);
    // Half of the lines.
    let half: String =
        program.lines().take(program.lines().count() / 2).map(|l| format!("{l}\n")).collect();
    let found = verified(&profile, &half, 1.5);
    assert!(matches!(cutting(&found)[..], [CuttingFault::Uncut { .. }]), "{:?}", found.reasons);
    let beside = "G0 Z20\nG0 X100 Y100\nG1 Z1 F100\nX110\n";
    let found = verified(&profile, beside, 1.5);
    assert_eq!(cutting(&found), [&CuttingFault::Elsewhere], "{:?}", found.reasons);
    // What is not known is not skipped.
    let unknown = program.replacen("G0 X", "G81 X", 1);
    let found = verified(&profile, &unknown, 1.5);
    let told: Vec<String> = found.reasons.iter().map(|reason| reason.to_string()).collect();
    assert!(told[0].contains("line 5: G81 is no word that is known here"), "{told:?}");
    assert!(matches!(found.reasons[0].kind, ReasonKind::File(FileFault::Unreadable(_))));
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_command_takes_a_program_with_its_ball() {
    let (_, _, program) = small();
    let folder = folder();
    save(folder.path(), &rough());
    std::fs::write(folder.path().join("part.nc"), program).unwrap();
    let at = |rest: &[&str]| {
        let mut args = vec!["verify", "part.nc", "--profile", "small.toml"];
        args.extend(rest);
        told(&morion(folder.path(), &args))
    };
    let (code, _, said) = at(&[]);
    assert_eq!(code, 2);
    assert!(said.contains("give --ball-mm, the radius of the ball whose tip it moves"), "{said}");
    let (code, _, said) = at(&["--ball-mm", "1.5", "--align"]);
    assert!(code == 2 && said.contains("--align must be left out for a program"), "{said}");
    let (code, out, said) = at(&["--ball-mm", "1.5", "--out", "made"]);
    assert_eq!(code, 0, "{said}{out}");
    assert!(out.contains("cut by a ball of 1.5 mm radius"), "{out}");
    let report = std::fs::read(folder.path().join("made/small-verify/report.json")).unwrap();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert_eq!(report["program"]["ball_mm"], 1.5);
    let args = ["verify", "small.stl", "--profile", "small.toml", "--ball-mm", "1.5"];
    std::fs::write(folder.path().join("small.stl"), "solid").unwrap();
    let (code, _, said) = told(&morion(folder.path(), &args));
    assert!(code == 2 && said.contains("--ball-mm must be left out but for a program"), "{said}");
}

/// A cutter with a flat end that goes up a tilted plane leaves the plane along its lines: the edge that comes last touches it, or the circle of the corner. Between
/// lines it leaves what the circle of its edge does, and of a corner more, as its flat part is smaller.
#[test]
fn cutters_with_a_flat_end_leave_the_envelope_of_their_edge() {
    let tilt = 0.2;
    let profile = parsed(&format!(
        "camera.orthographic.pixels = [80, 60]\nmirror.polynomial.terms = [[1, 0, {tilt}]]\n\
         part = {{ width_mm = 20, height_mm = 15, base_mm = 5 }}\nmesh.chord_um = 5\nexport.formats = [\"stl\"]\n"
    ));
    let design = designed(&profile);
    let middle = design.mirror.position(DVec2::ZERO, &design.mirror.at(DVec2::ZERO)).z;
    for (radius_mm, corner_mm) in [(2.0, 0.0), (2.0, 0.5), (1.5, 1.5)] {
        let flat = radius_mm - corner_mm;
        let rest = tilt * flat + corner_mm * (f64::sqrt(1.0 + tilt * tilt) - 1.0);
        let mut program = String::from("G21 G90\nG0 Z40\n");
        for k in -45..=45 {
            let at = |n: i32| {
                let x = 0.5 * f64::from(n);
                format!("X{x:.4} Z{:.6}", middle + tilt * x + rest)
            };
            writeln!(program, "G0 X-14 Y{:.4}\nG1 {} F300", 0.2 * f64::from(k), at(-28)).unwrap();
            (-27..=28).for_each(|n| writeln!(program, "{}", at(n)).unwrap());
            writeln!(program, "G0 Z40").unwrap();
        }
        let found = flat_verified(&profile, &(program + "M2\n"), (radius_mm, corner_mm));
        let facts = found.program.unwrap_or_else(|| panic!("{:?}", found.reasons));
        let is_ball = corner_mm == radius_mm;
        assert_eq!(facts.slopes == SlopeOrigin::Facets, is_ball);
        assert_eq!(
            facts.radius_mm.zip(facts.corner_mm),
            (!is_ball).then_some((radius_mm, corner_mm))
        );
        // A circle of this radius, half a line's distance beside its middle.
        let beside = |radius: f64| 1e3 * (radius - f64::sqrt(radius * radius - 0.01));
        let upright = tilt / f64::sqrt(1.0 + tilt * tilt);
        let [least, most] = match is_ball {
            true => [beside(radius_mm); 2],
            false => [upright * beside(radius_mm), upright * beside(flat)],
        };
        let highest = facts.highest.off_um;
        assert!(facts.lowest.off_um.abs() < 0.02, "{radius_mm} {corner_mm}: {:?}", facts.lowest);
        assert!(
            highest > 0.97 * least - 0.02 && highest < most + 0.02,
            "{least} {most}: {facts:?}"
        );
    }
}

/// A dome of 30 mm radius below a camera at 40 mm.
fn dome(part: &str, pixels: [u32; 2], layout: &str) -> Profile {
    parsed(&format!(
        "{layout}camera.pinhole = {{ pixels = {pixels:?}, hfov_deg = 40, distance_mm = 40 }}\n\
         mirror.polynomial = {{ radius_mm = -30, conic = 0 }}\n\
         part = {{ {part}, base_mm = 5 }}\nmesh.chord_um = 2\nexport.formats = [\"stl\"]\n"
    ))
}

/// A mirror that shows 60 degrees straight back.
fn straight_back(pixels: [u32; 2], width_mm: f64) -> Profile {
    parsed(&format!(
        "camera.pinhole = {{ pixels = {pixels:?}, hfov_deg = 40, distance_mm = 40 }}\n\
         projection.perspective = {{ hfov_deg = 60 }}\nlayout.rectangle = {{}}\nmethod.vector-field.degree = 12\n\
         part = {{ width_mm = {width_mm}, base_mm = 5 }}\nmesh.facet_px = 1\nexport.formats = [\"stl\"]\n"
    ))
}

/// The camera sees the rim of a part elsewhere that is cut deeper, or less deep, all over: no ray that may pass by it is held against the part.
#[test]
fn a_rim_that_is_cut_too_deep_is_where_the_camera_sees_it() {
    let given = dome("width_mm = 20, height_mm = 15", [320, 240], "");
    let program = raster(&designed(&given), 1.5, 0.15, 0.5);
    rims_are_seen(&given, &program);
    // A mirror that is designed for its camera has the camera's chart. The outer columns are a tenth of a pixel within the rim.
    let own = straight_back([320, 240], 19.94);
    let program = raster(&designed(&own), 1.5, 0.15, 0.5);
    rims_are_seen(&own, &program);
}

fn rims_are_seen(profile: &Profile, program: &str) {
    let moved = |up_mm: f64| -> String {
        let line = |line: &str| match line.split_once('Z') {
            Some((before, z)) => {
                let (z, rest) = z.split_once(' ').unwrap_or((z, ""));
                format!("{before}Z{:.4} {rest}\n", z.parse::<f64>().unwrap() + up_mm)
            }
            None => format!("{line}\n"),
        };
        program.lines().map(line).collect()
    };
    let [own, lower, higher] = [0.0, -0.05, 0.05].map(|up_mm| {
        let found = verified(profile, &moved(up_mm), 1.5);
        let facts = found.program.as_ref().unwrap();
        assert!((facts.lowest.off_um - 1e3 * up_mm).abs() < 12.0, "{facts:?}");
        let trace = &found.trace[0];
        assert_eq!(trace.missed, 0, "{up_mm}: {trace:?}");
        trace.rays
    });
    // Less than half a row of pixels at each side.
    let [columns, rows] = designed(profile).camera.pixels;
    let most = (columns + rows) as usize;
    assert!(
        lower < own && higher < own && lower.min(higher) + most > own,
        "{own} {lower} {higher}"
    );
}

/// Circles of a bull-nosed cutter about the axis of a dome leave cusps of its corner: `w^2 / 8 (1 / c + 1 / R)`, w along the dome.
#[test]
fn a_bull_nosed_cutter_in_circles_leaves_the_cusps_of_its_corner() {
    let profile = dome("width_mm = 18", [80, 80], "layout.disc = {}\n");
    let design = designed(&profile);
    let top_mm = design.mirror.position(DVec2::ZERO, &design.mirror.at(DVec2::ZERO)).z;
    let (radius_mm, corner_mm, apart_mm) = (2.0, 0.6, 0.12);
    let mut program = String::from("G21 G90\nG0 Z40\n");
    for k in 0..78 {
        let touched = (f64::from(k) + 0.5) * apart_mm;
        let upright = f64::sqrt(900.0 - touched * touched) / 30.0;
        // The corner's circle touches the dome on the side of the axis.
        let out = touched * (1.0 + corner_mm / 30.0) + radius_mm - corner_mm;
        let tip = top_mm - (30.0 + corner_mm) * (1.0 - upright);
        let at = |n: i32| {
            let angle = f64::from(n) * std::f64::consts::TAU / 720.0;
            format!("X{:.5} Y{:.5} Z{tip:.6}", out * cos(angle), out * sin(angle))
        };
        writeln!(program, "G0 {}\nG1 {} F300", at(0), at(0)).unwrap();
        (1..=720).for_each(|n| writeln!(program, "{}", at(n)).unwrap());
        writeln!(program, "G0 Z40").unwrap();
    }
    let found = flat_verified(&profile, &(program + "M2\n"), (radius_mm, corner_mm));
    let facts = found.program.unwrap_or_else(|| panic!("{:?}", found.reasons));
    assert_eq!(facts.slopes, SlopeOrigin::Path);
    // (Of tips, which are farther apart on a dome than places of contact.)
    assert!((1.0..1.06).contains(&(facts.apart_mm / apart_mm)), "{facts:?}");
    let [x, y, _] = facts.highest.at_mm;
    let along = apart_mm / f64::sqrt(1.0 - (x * x + y * y) / 900.0);
    let cusp_um = 125.0 * along * along * (1.0 / corner_mm + 1.0 / 30.0);
    assert!((facts.highest.off_um / cusp_um - 1.0).abs() < 0.05, "{cusp_um}: {facts:?}");
    assert!(facts.lowest.off_um.abs() < 0.2, "{facts:?}");
    assert_eq!(found.trace[0].missed, 0, "{:?}", found.trace[0]);
}

/// Radii of cutters that contradict each other, or the file, are refused by name.
#[test]
fn cutters_that_contradict_each_other_are_refused() {
    let profile = parsed(SMALL);
    let given = |name: &str, options: VerifyOptions| {
        let folder = folder();
        let path = folder.path().join(name);
        std::fs::write(&path, "G0 X0 Y0 Z9\nG1 X5 F100\n").unwrap();
        Verify { path: &path, options }.in_memory(&profile, &Silent).unwrap_err().to_string()
    };
    let options = VerifyOptions::default();
    let (ball, cutter) = (Some(1.0), Some(2.0));
    for (name, options, said) in [
        (
            "a.ngc",
            VerifyOptions { corner_mm: ball, ball_mm: ball, ..options },
            "--corner-mm must be left out without --cutter-mm",
        ),
        (
            "a.ngc",
            VerifyOptions { cutter_mm: ball, corner_mm: cutter, ..options },
            "--corner-mm must be no more than --cutter-mm",
        ),
        (
            "a.ngc",
            VerifyOptions { cutter_mm: cutter, ball_mm: ball, ..options },
            "--ball-mm must be left out with --cutter-mm",
        ),
        (
            "a.ngc",
            VerifyOptions { cutter_mm: cutter, nose_mm: ball, ..options },
            "--cutter-mm must be left out with --nose-mm",
        ),
        (
            "a.xzc",
            VerifyOptions { cutter_mm: cutter, ..options },
            "--cutter-mm must be left out for a table of points",
        ),
        (
            "a.stl",
            VerifyOptions { cutter_mm: cutter, ..options },
            "--cutter-mm must be left out but for a program",
        ),
        ("a.ngc", options, "or --cutter-mm of a flat or bull-nosed cutter"),
    ] {
        let found = given(name, options);
        assert!(found.contains(said), "{name}: {found}");
    }
}

/// A program for what the mirror is formed on has another face than the mirror's, and is not held against it.
#[test]
fn a_program_for_a_forming_tool_is_refused() {
    let profile =
        parsed(&edited(SMALL, &[("base_mm = 2", "base_mm = 2\nborder_mm = 3\nform = \"mould\"")]));
    let folder = folder();
    let path = folder.path().join("part.ngc");
    std::fs::write(&path, "G0 X0 Y0 Z9\nG1 X5 F100\n").unwrap();
    for options in [
        VerifyOptions { ball_mm: Some(1.0), ..VerifyOptions::default() },
        VerifyOptions { nose_mm: Some(1.0), ..VerifyOptions::default() },
    ] {
        let found = Verify { path: &path, options }.in_memory(&profile, &Silent).unwrap_err();
        let said = found.to_string();
        assert!(
            said.contains("its file is a mould") && said.contains("leave part.form out"),
            "{said}"
        );
    }
}
