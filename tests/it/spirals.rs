//! Programs that mill a round mirror along a spiral: what they leave, what spoils them, and what programs of other making leave that go around
//! the axis.

use crate::support::builds::{edited, folder, morion, parsed, save, told};
use morion::internals::num::{cos, sin};
use morion::internals::pipeline::{
    Command, OutputFile, ProgramOptions, Silent, Verify, VerifyOptions,
};
use morion::internals::profile::Profile;
use morion::internals::program::ToolPath;
use morion::internals::results::{ProgramReport, Verdict, VerifyReport};
use std::fmt::Write;

/// A small hyperboloid whose picture may be off as far as a polish takes it back.
const ROUND: &str = r#"
camera.pinhole = { pixels = [120, 120], lens_mm = 8, pixel_um = 40, distance_mm = 40 }
projection.hyperbolic.outer_polar_deg = 110
layout.disc = {}
method.vector-field.degree = 16
part = { width_mm = 20, base_mm = 5 }
mesh.facet_px = 3
export.formats = ["stl"]
accept = { pixel_error_rms_px = 3, pixel_error_max_px = 9 }

[program]
path = "spiral"
"#;

/// A sphere of 20 mm radius that is given: a bowl, 20 mm wide.
const BOWL: &str = r#"
camera.orthographic.pixels = [100, 100]
layout.disc = {}
mirror.polynomial = { radius_mm = 20, conic = 0 }
part = { width_mm = 20, base_mm = 5 }
mesh.chord_um = 5
export.formats = ["stl"]

[program]
path = "spiral"
"#;

fn milled(profile: &Profile) -> (ProgramReport, Vec<OutputFile>) {
    ProgramOptions.in_memory(profile, &Silent).unwrap_or_else(|error| panic!("{error}"))
}

fn text(files: &[OutputFile], name: &str) -> String {
    let file = files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("no {name}"));
    String::from_utf8(file.bytes.clone()).unwrap()
}

fn verified(profile: &Profile, program: &str, ball_mm: f64) -> VerifyReport {
    let folder = folder();
    let path = folder.path().join("part.ngc");
    std::fs::write(&path, program).unwrap();
    let options = VerifyOptions { ball_mm: Some(ball_mm), ..VerifyOptions::default() };
    let verify = Verify { path: &path, options };
    verify.in_memory(profile, &Silent).unwrap_or_else(|error| panic!("{error}")).0
}

/// Semi-finishing leaves its allowance within a tenth, finishing goes nowhere deeper than its chords and half a micrometre, the picture
/// is what the study of the turns foresees, and the finishing program stays down: one move comes down, and one goes up.
#[test]
fn a_spiral_leaves_what_it_is_to_leave() {
    let profile =
        parsed(&format!("{ROUND}\nball_mm = 2\nstepover_mm = 0.15\nallowance_mm = 0.4\n"));
    let (report, files) = milled(&profile);
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let left = |kind: usize| report.operations[kind].left.unwrap();
    assert!(left(0).least_um > 0.95 * 400.0, "{:?}", left(0));
    assert!(left(1).least_um > 0.95 * 400.0 && left(1).most_um < 1.1 * 400.0, "{:?}", left(1));
    let facts = report.program.as_ref().unwrap();
    assert!(facts.lowest.off_um > -1.5 && facts.lowest.off_um < 0.0, "{facts:?}");
    assert!((facts.apart_mm / 0.15 - 1.0).abs() < 5e-3, "{facts:?}");
    assert_eq!((facts.angle_deg, facts.parallel, report.angle_deg), (None, None, None));
    assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    let cut = report.as_cut.as_ref().unwrap().trace.errors.facet_error_px.unwrap().rms;
    let study = report.foreseen_px.unwrap().rms;
    assert!((cut / study - 1.0).abs() < 0.04, "{cut} px, foreseen {study} px");
    for name in ["semi-finishing.ngc", "finishing.ngc"] {
        let path = ToolPath::read(text(&files, name).as_bytes()).unwrap();
        let rapid = path.moves.iter().filter(|step| step.feed.is_none()).count();
        assert!(rapid <= 4, "{name}: {rapid} rapid moves");
        assert_eq!(path.moves[path.moves.len() - 2].to.truncate().length(), 0.0, "{name}");
    }
}

/// Scallops are as steep as the turns are apart, and as high as their square.
#[test]
#[ignore = "long: .ci/nightly"]
fn errors_fall_with_the_distance_of_the_turns() {
    let found = [0.3, 0.15, 0.075].map(|stepover| {
        let fine = format!("{ROUND}\nball_mm = 2\nstepover_mm = {stepover}\nchord_um = 0.05\n");
        let (report, _) = milled(&parsed(&fine));
        let error = report.as_cut.unwrap().trace.errors.facet_error_px.unwrap().rms;
        (error, report.program.unwrap().highest.off_um)
    });
    for pair in found.windows(2) {
        let error = pair[0].0 / pair[1].0;
        // (The moves themselves are off by as much as their chord, um.)
        let height_um = pair[1].1 - 0.25 * pair[0].1;
        assert!((1.85..2.15).contains(&error) && height_um.abs() < 0.1, "{found:?}");
    }
}

/// By the words of the program alone: the ball's centre is on the sphere about the bowl's centre whose radius is smaller by the ball.
#[test]
fn a_spiral_follows_the_sphere_that_is_a_ball_smaller() {
    let profile = parsed(&format!("{BOWL}\nball_mm = 3\npolish_um = 8\n"));
    let (report, files) = milled(&profile);
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let path = ToolPath::read(text(&files, "finishing.ngc").as_bytes()).unwrap();
    let mut seen = 0;
    for step in path.moves.iter().filter(|step| step.feed.is_some()) {
        let [x, y, z] = step.to.to_array();
        // The contact is in the mirror's disc where the centre is within 10 (1 - 3 / 20) mm; the last move goes up.
        if step.to.truncate().length() > 8.5 || step.from.truncate() == step.to.truncate() {
            continue;
        }
        // The bowl's bottom is on the base of 5 mm, its centre 20 mm above.
        let off = (x * x + y * y + (z + 3.0 - 25.0) * (z + 3.0 - 25.0)).sqrt() - 17.0;
        assert!(off.abs() < 1.2e-4, "{step:?}: {off}");
        seen += 1;
    }
    assert!(seen > 1000, "{seen}");
    let highest = report.program.unwrap().highest.off_um;
    assert!(highest > 1.5 && highest <= 8.0, "{highest}");
}

/// Of a digit that is changed anywhere along the finishing spiral the mirror fails.
#[test]
fn a_digit_spoils_a_spiral() {
    let profile = parsed(&format!("{ROUND}\nball_mm = 2\nstepover_mm = 0.15\n"));
    let (_, files) = milled(&profile);
    let finishing = text(&files, "finishing.ngc");
    let sound = verified(&profile, &finishing, 2.0);
    assert_eq!(sound.verdict, Verdict::Pass, "{:?}", sound.reasons);
    let lines: Vec<&str> = finishing.lines().collect();
    let cuts: Vec<usize> =
        (0..lines.len()).filter(|&k| lines[k].starts_with('X') && lines[k].contains('Z')).collect();
    for share in [2, 5, 9] {
        let k = cuts[cuts.len() * share / 10];
        let (before, height) = lines[k].split_once('Z').unwrap();
        let (whole, rest) = height.split_once('.').unwrap();
        let lower = whole.parse::<i32>().unwrap() - 1;
        let line = format!("{before}Z{lower}.{rest}");
        let spoilt = [&lines[..k], &[line.as_str()], &lines[k + 1..]].concat().join("\n");
        let found = verified(&profile, &spoilt, 2.0);
        assert_eq!(found.verdict, Verdict::Fail, "line {}", k + 1);
        let lowest = found.program.unwrap().lowest;
        assert!(lowest.off_um < -100.0, "{lowest:?}");
        assert!(lowest.line.abs_diff(k as u32 + 1) <= 1, "{lowest:?}, damaged {}", k + 1);
    }
}

/// Circles of another making are read as turns as well: of a bowl of radius A cut by a ball of radius R their scallops are
/// `W^2 (1 / R - 1 / A) / 8` high, where `W` is w over the cosine of the slope, and nothing is warned of.
#[test]
fn circles_of_another_making_are_turns() {
    let profile = parsed(&edited(BOWL, &[("path = \"spiral\"", "polish_um = 8")]));
    let (ball_mm, apart_mm) = (3.0, 0.25);
    let mut program = "(circles)\nG21 G90 G17 G94\nM3 S12000\nG0 Z30\n".to_owned();
    for k in 0..=40 {
        let contact = 10.125 - apart_mm * f64::from(k);
        let slope = contact / 20.0;
        let [r, z] = [contact - ball_mm * slope, 25.0 - 17.0 * (1.0 - slope * slope).sqrt() - 3.0];
        writeln!(program, "G0 X{r:.5} Y0\nG0 Z{:.5}\nG1 Z{z:.5} F200", z + 1.0).unwrap();
        for n in 1..=720 {
            let angle = 2.0 * std::f64::consts::PI * f64::from(n) / 720.0;
            writeln!(program, "X{:.5} Y{:.5} F900", r * cos(angle), r * sin(angle)).unwrap();
        }
        program += "G0 Z30\n";
    }
    let found = verified(&profile, &program, ball_mm);
    let facts = found.program.unwrap();
    assert_eq!((facts.angle_deg, facts.parallel), (None, None), "{facts:?}");
    assert!((facts.apart_mm / apart_mm - 1.0).abs() < 0.03, "{facts:?}");
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    // The last cusp is on the rim, whose normal leans by a half.
    let cosine = (1.0 - 0.25_f64).sqrt();
    let square = apart_mm * apart_mm / (cosine * cosine);
    let exact_um = 1e3 * square * (1.0 / 3.0 - 1.0 / 20.0) / 8.0;
    assert!((facts.highest.off_um / exact_um - 1.0).abs() < 0.05, "{facts:?}, {exact_um}");
}

/// The same bytes on one thread and on two, and a summary that tells the path.
#[test]
fn a_spiral_is_the_same_on_any_number_of_threads() {
    let made = ["1", "2"].map(|threads| {
        let folder = folder();
        save(folder.path(), &format!("{ROUND}\nball_mm = 2\nstepover_mm = 0.3\npolish_um = 20\n"));
        let args = ["program", "small.toml", "--out", "made", "--threads", threads, "--verbose"];
        let (code, out, said) = told(&morion(folder.path(), &args));
        assert_eq!(code, 0, "{said}{out}");
        assert!(out.contains("a spiral about the axis"), "{out}");
        let at = folder.path().join("made/small/program");
        ["finishing.ngc", "program.json", "as-cut.stl"].map(|name| {
            std::fs::read(at.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
        })
    });
    assert!(made[0] == made[1]);
}
