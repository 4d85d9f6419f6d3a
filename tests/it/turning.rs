//! Programs that turn a mirror on a lathe: what they leave, what spoils them, and what they are refused for.

use crate::support::builds::{edited, folder, morion, parsed, told};
use morion::internals::pipeline::{
    Command, Error, OutputFile, ProgramOptions, Silent, Verify, VerifyOptions,
};
use morion::internals::profile::Profile;
use morion::internals::program::TurningPath;
use morion::internals::results::{ProgramReport, SlopeOrigin, Verdict};

/// A small hyperboloid whose picture may be off as far as a polish takes it back.
const ROUND: &str = r#"
camera.pinhole = { pixels = [120, 120], lens_mm = 8, pixel_um = 40, distance_mm = 40 }
projection.hyperbolic.outer_polar_deg = 110
layout.disc = {}
method.vector-field.degree = 16
part = { width_mm = 20, base_mm = 3 }
mesh.facet_px = 3
export.formats = ["stl"]
accept = { pixel_error_rms_px = 2, pixel_error_max_px = 6 }

[program]
machine = "turn"
"#;

/// A sphere of 20 mm radius that is given: a dome, 20 mm wide.
const DOME: &str = r#"
camera.orthographic.pixels = [100, 100]
layout.disc = {}
mirror.polynomial = { radius_mm = -20, conic = 0 }
part = { width_mm = 20, base_mm = 3 }
mesh.chord_um = 5
export.formats = ["stl"]

[program]
machine = "turn"
"#;

fn turned(profile: &Profile) -> (ProgramReport, Vec<OutputFile>) {
    ProgramOptions.in_memory(profile, &Silent).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(profile: &Profile) -> String {
    match ProgramOptions.in_memory(profile, &Silent) {
        Err(error @ Error::Turning { .. }) => error.to_string(),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("it is turned"),
    }
}

fn text(files: &[OutputFile], name: &str) -> String {
    let file = files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("no {name}"));
    String::from_utf8(file.bytes.clone()).unwrap()
}

/// Each stop of a program is later by the time in which the acceleration is built up, and nothing else changes.
#[test]
fn a_jerk_makes_turning_take_longer() {
    let facing =
        |more: &str| turned(&parsed(&format!("{DOME}nose_mm = 1.5\nfeed_mm_rev = 0.12\n{more}")));
    let ((quick, files), (slow, same)) = (facing(""), facing("jerk_mm_s3 = 5000\n"));
    for (quick, slow) in quick.operations.iter().zip(&slow.operations) {
        let stops = 60.0 * (slow.machine_min - quick.machine_min) / 0.1;
        assert!(stops > 0.9 && (stops - stops.round()).abs() < 1e-3, "{stops}");
    }
    let program = |files: &[OutputFile]| text(files, "finishing.ngc");
    let moves = |text: String| {
        text.lines().filter(|line| !line.starts_with('(')).map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(moves(program(&files)), moves(program(&same)));
}

/// Roughing leaves its allowance and semi-finishing a third of it, within a tenth; finishing goes nowhere deeper than its chords and
/// half a micrometre, its highest cusps have T117's height, and the picture is what its slopes are foreseen to do.
#[test]
fn programs_of_a_lathe_leave_what_they_are_to_leave() {
    let profile = parsed(&format!("{ROUND}\nnose_mm = 1.5\nfeed_mm_rev = 0.12\n"));
    let (report, _) = turned(&profile);
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    for (done, asked_um) in report.operations.iter().zip([300.0, 100.0]) {
        let left = done.left.unwrap();
        assert!(left.least_um > 0.97 * asked_um && left.most_um < 1.1 * asked_um, "{left:?}");
    }
    let facts = report.program.as_ref().unwrap();
    assert!(facts.lowest.off_um > -1.5 && facts.lowest.off_um < -0.2, "{facts:?}");
    // At the apex the mirror bulges most; a plane would have the height without the curvature.
    let plane_um = 1e3 * 0.12 * 0.12 / (8.0 * 1.5);
    assert!((0.8..1.001).contains(&(facts.highest.off_um / plane_um)), "{facts:?} {plane_um}");
    let cut = report.as_cut.as_ref().unwrap().trace.errors.facet_error_px.unwrap().rms;
    let study = report.foreseen_px.unwrap().rms;
    assert!((cut / study - 1.0).abs() < 0.04, "{cut} px, foreseen {study} px");
    for done in &report.operations {
        let parts = [done.at_feed_min, done.changing_min, done.rapid_min];
        assert!((parts.iter().sum::<f64>() / done.machine_min - 1.0).abs() < 1e-12);
    }
}

/// The picture's error is proportional to the feed, and the cusps' height to its square.
#[test]
#[ignore = "long: .ci/nightly"]
fn errors_fall_with_the_feed() {
    let found = [0.24, 0.12, 0.06].map(|feed| {
        let (report, _) = turned(&parsed(&format!(
            "{ROUND}\nnose_mm = 1.5\nfeed_mm_rev = {feed}\nchord_um = 0.05\n"
        )));
        let error = report.as_cut.unwrap().trace.errors.facet_error_px.unwrap().rms;
        (error, report.program.unwrap().highest.off_um)
    });
    for pair in found.windows(2) {
        let error = pair[0].0 / pair[1].0;
        // (The moves themselves are off by as much as their chord, um.)
        let height_um = pair[1].1 - 0.25 * pair[0].1;
        assert!((1.85..2.15).contains(&error) && height_um.abs() < 0.05, "{found:?}");
    }
}

/// Turns that are too near each other for facets: the slopes that the moves leave displace the picture as is foreseen, in proportion to
/// the feed; what is left counts the cusps that the facets are without, and the file by itself has the same figures.
#[test]
fn slopes_of_fine_turns_are_those_that_the_moves_leave() {
    let fine = |feed: f64| {
        parsed(&format!("{ROUND}\nnose_mm = 1.5\nfeed_mm_rev = {feed}\nchord_um = 0.02\n"))
    };
    let profile = fine(0.008);
    let (report, files) = turned(&profile);
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let facts = report.program.as_ref().unwrap();
    assert_eq!(facts.slopes, SlopeOrigin::Path);
    assert!(facts.optical_triangles < 2_000_000, "{facts:?}");
    let errors = report.as_cut.as_ref().unwrap().trace.errors;
    let (cut, study) = (errors.facet_error_px.unwrap(), report.foreseen_px.unwrap());
    assert!((cut.rms / study.rms - 1.0).abs() < 0.03, "{cut:?}, foreseen {study:?}");
    // At the apex the mirror bulges most; a plane would have the height without the curvature. Chords are up to 0.02 um off.
    let plane_um = 1e3 * 0.008 * 0.008 / (8.0 * 1.5);
    let highest_um = facts.highest.off_um;
    assert!(highest_um > 0.7 * plane_um && highest_um < plane_um + 0.025, "{facts:?}");
    assert!(facts.lowest.off_um > -0.025, "{facts:?}");
    let folder = folder();
    let path = folder.path().join("finishing.ngc");
    std::fs::write(&path, text(&files, "finishing.ngc")).unwrap();
    let options = VerifyOptions { nose_mm: Some(1.5), ..VerifyOptions::default() };
    let (alone, _) = Verify { path: &path, options }.in_memory(&profile, &Silent).unwrap();
    assert_eq!(alone.verdict, Verdict::Pass, "{:?}", alone.reasons);
    let own = alone.trace[0].errors.pixel_error_px.unwrap();
    // (The part as cut has the coordinates of single precision.)
    assert!((own.rms / errors.pixel_error_px.unwrap().rms - 1.0).abs() < 1e-3, "{own:?}");
}

/// The feed that a lathe and a slow tool servo choose keeps the picture within its limits as it comes off the machine.
#[test]
fn the_feed_that_is_chosen_keeps_the_picture() {
    let limits = (
        "pixel_error_rms_px = 2, pixel_error_max_px = 6",
        "pixel_error_rms_px = 0.6, pixel_error_max_px = 1.2",
    );
    let text = edited(ROUND, &[limits]);
    for machine in ["turn", "sts"] {
        let own = edited(&text, &[("\"turn\"", &format!("\"{machine}\""))]);
        let (report, _) = turned(&parsed(&format!("{own}\nnose_mm = 1.5\n")));
        assert_eq!(report.verdict, Verdict::Pass, "{machine}: {:?}", report.reasons);
        assert_eq!(report.program.unwrap().slopes, SlopeOrigin::Path, "{machine}");
        let [cut, study] = [
            report.as_cut.unwrap().trace.errors.facet_error_px.unwrap(),
            report.foreseen_px.unwrap(),
        ];
        assert!((cut.rms / study.rms - 1.0).abs() < 0.03, "{machine}: {cut:?}, foreseen {study:?}");
        // Not finer than it has to be.
        assert!(cut.max > 0.6 || cut.rms > 0.3, "{machine}: {cut:?}");
    }
}

/// Facets that follow the cusps and slopes that the moves leave have errors in one proportion to the feed.
#[test]
#[ignore = "long: .ci/nightly"]
fn facets_and_the_path_agree_about_slopes() {
    let found = [0.12, 0.06, 0.02, 0.005].map(|feed| {
        let (report, _) = turned(&parsed(&format!(
            "{ROUND}\nnose_mm = 1.5\nfeed_mm_rev = {feed}\nchord_um = 0.02\n"
        )));
        let error = report.as_cut.unwrap().trace.errors.facet_error_px.unwrap().rms;
        (report.program.unwrap().slopes, error / feed)
    });
    let [followed, by_path] = [SlopeOrigin::Facets, SlopeOrigin::Path];
    assert!(found[0].0 == followed && found[3].0 == by_path, "{found:?}");
    for (_, error) in found {
        assert!((error / found[0].1 - 1.0).abs() < 0.03, "{found:?}");
    }
}

/// Places of the feed moves by their words alone: distance from the axis, and Z, of the tool point.
fn places(program: &str) -> Vec<[f64; 2]> {
    let (mut place, mut is_feed, mut found) = ([f64::NAN; 2], false, Vec::new());
    for line in program.lines().filter(|line| !line.starts_with('(')) {
        let before = place;
        for word in line.split_whitespace() {
            match word {
                "G1" => is_feed = true,
                "G0" => is_feed = false,
                "G4" => break,
                _ => {
                    if let Some(x) = word.strip_prefix('X') {
                        place[0] = 0.5 * x.parse::<f64>().unwrap();
                    } else if let Some(z) = word.strip_prefix('Z') {
                        place[1] = z.parse().unwrap();
                    }
                }
            }
        }
        if is_feed && place != before {
            found.push(place);
        }
    }
    found
}

/// By the program's words alone: the nose's centre is on the sphere about the mirror's centre whose radius is larger by the nose, or
/// smaller in a bowl; it ends in the axis, X at minus a nose's diameter.
#[test]
fn finishing_follows_the_sphere_that_is_a_nose_larger() {
    let bowl = edited(DOME, &[("radius_mm = -20", "radius_mm = 20")]);
    for (text_of, sphere_mm) in [(DOME, 20.0), (bowl.as_str(), -20.0)] {
        let profile = parsed(&format!("{text_of}\npolish_um = 5\nnose_mm = 1.5\n"));
        let (report, files) = turned(&profile);
        assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
        let all = places(&text(&files, "finishing.ngc"));
        assert_eq!(all[all.len() - 1][0], -1.5);
        let sag = 20.0 - f64::sqrt(400.0 - 100.0);
        let middle_mm = if sphere_mm > 0.0 { 3.0 + sag - 20.0 } else { 3.0 + 20.0 };
        let over: Vec<f64> = all
            .iter()
            .map(|[x, z]| (x + 1.5, z + 1.5 - middle_mm))
            .filter(|(x, _)| *x < 9.0)
            .map(|(x, z)| (x * x + z * z).sqrt() - (sphere_mm + 1.5_f64).abs())
            .collect();
        assert!(over.len() > 10);
        // (Figures are to a tenth of a micrometre, X as a diameter.)
        assert!(over.iter().all(|off| off.abs() < 1e-4), "{over:?}");
        let highest = report.program.unwrap().highest.off_um;
        assert!(highest > 1.5 && highest <= 5.0, "{highest}");
    }
}

/// LinuxCNC and Fanuc read the same moves. Of a digit that is changed anywhere along the finishing cut the mirror fails.
#[test]
fn both_controls_read_the_same_moves_and_a_digit_spoils_them() {
    let profile = parsed(&format!("{ROUND}\nnose_mm = 1.5\nfeed_mm_rev = 0.12\n"));
    let fanuc =
        parsed(&format!("{ROUND}\nnose_mm = 1.5\nfeed_mm_rev = 0.12\ncontrol = \"fanuc\"\n"));
    let (_, one) = turned(&profile);
    let (_, other) = turned(&fanuc);
    let moves = |files: &[OutputFile], name: &str| {
        let path = TurningPath::read(text(files, name).as_bytes()).unwrap();
        let moves = path.tool.moves.into_iter().map(|step| (step.from, step.to, step.feed));
        (moves.collect::<Vec<_>>(), path.turns)
    };
    for name in ["roughing.ngc", "semi-finishing.ngc", "finishing.ngc"] {
        assert_eq!(moves(&one, name), moves(&other, name), "{name}");
    }
    let finishing = text(&one, "finishing.ngc");
    let folder = folder();
    let path = folder.path().join("part.ngc");
    let verdict = |program: &str| {
        std::fs::write(&path, program).unwrap();
        let options = VerifyOptions { nose_mm: Some(1.5), ..VerifyOptions::default() };
        let verify = Verify { path: &path, options };
        let report =
            verify.in_memory(&profile, &Silent).unwrap_or_else(|error| panic!("{error}")).0;
        (report.verdict, report.program)
    };
    let (passed, program) = verdict(&finishing);
    assert_eq!(passed, Verdict::Pass);
    assert_eq!(program.unwrap().nose_mm, Some(1.5));
    let lines: Vec<&str> = finishing.lines().collect();
    let cuts: Vec<usize> =
        (0..lines.len()).filter(|&k| lines[k].starts_with('X') && lines[k].contains('Z')).collect();
    for share in [3, 5, 7, 8] {
        let k = cuts[cuts.len() * share / 10];
        let (before, height) = lines[k].split_once('Z').unwrap();
        let (whole, rest) = height.split_once('.').unwrap();
        // A digit of the tenths of a millimetre: one less, or from 0 to 9.
        let tenths: u32 = rest[..1].parse().unwrap();
        let changed = (tenths + 9) % 10;
        let line = format!("{before}Z{whole}.{changed}{}", &rest[1..]);
        let spoilt = [&lines[..k], &[line.as_str()], &lines[k + 1..]].concat().join("\n");
        assert_eq!(verdict(&spoilt).0, Verdict::Fail, "{}: {line}", lines[k]);
    }
    // A feed ten times as large leaves cusps a hundred times as high.
    let (before, after) = finishing.split_once("F0.12").unwrap();
    assert_eq!(verdict(&format!("{before}F1.2{after}")).0, Verdict::Fail);
}

/// The files of the program are the same on one thread and on two.
#[test]
fn a_lathes_files_are_the_same_on_any_number_of_threads() {
    let folder = folder();
    let text = format!("{ROUND}\nnose_mm = 1.5\nfeed_mm_rev = 0.2\n");
    std::fs::write(folder.path().join("turned.toml"), text).unwrap();
    let made = ["1", "2"].map(|threads| {
        let out = format!("out{threads}");
        let (code, _, said) = told(&morion(
            folder.path(),
            &["program", "turned.toml", "--threads", threads, "--out", &out, "--quiet"],
        ));
        assert!(code < 2, "{said}");
        let files = [
            "roughing.ngc",
            "semi-finishing.ngc",
            "finishing.ngc",
            "as-cut.stl",
            "program.json",
            "program.html",
        ];
        files.map(|name| {
            std::fs::read(folder.path().join(&out).join("turned/program").join(name)).unwrap()
        })
    });
    assert!(made[0] == made[1]);
}

#[test]
fn what_cannot_be_turned_is_refused_with_what_would() {
    let bowl = edited(DOME, &[("radius_mm = -20", "radius_mm = 20")]);
    let said = refused(&parsed(&format!("{bowl}\nnose_mm = 19.8\npolish_um = 5\n")));
    assert!(
        said.contains("hollow with a radius of 20.0000 mm") && said.contains("program.nose_mm"),
        "{said}"
    );
    // Its rim is 30 degrees steep.
    let said = refused(&parsed(&format!("{DOME}\ninner_edge_deg = 29\nouter_edge_deg = 0\n")));
    assert!(
        said.contains("30.00 degrees steep") && said.contains("program.inner_edge_deg, has 29"),
        "{said}"
    );
    turned(&parsed(&format!(
        "{DOME}\ninner_edge_deg = 31\nouter_edge_deg = 0\nfeed_mm_rev = 0.2\n"
    )));
    let said = refused(&parsed(&format!("{bowl}\nouter_edge_deg = 29\n")));
    assert!(said.contains("program.outer_edge_deg, has 29"), "{said}");
    let said = refused(&parsed(&format!("{DOME}\ntravel_mm = [100, 5]\n")));
    assert!(said.contains("along Z, and program.travel_mm has 5 mm"), "{said}");
    let low = edited(DOME, &[("base_mm = 3", "base_mm = 0.1")]);
    let said = refused(&parsed(&format!("{low}\nnose_mm = 5\n")));
    assert!(said.contains("below the base around it; raise part.base_mm"), "{said}");
    let tilted = edited(DOME, &[("conic = 0 }", "conic = 0, terms = [[1, 0, 0.01]] }")]);
    let said = refused(&parsed(&tilted));
    assert!(said.contains("no function of the distance from the axis"), "{said}");
}

/// What verifies a lathe's program asks for one tool, and for a mirror that is round.
#[test]
fn a_lathes_program_is_verified_with_its_nose_alone() {
    let folder = folder();
    std::fs::write(folder.path().join("round.toml"), DOME).unwrap();
    let plane = "G8 G95 G97 S100 M3\nG0 X12 Z3.1\nG1 X-1 F0.1\nG4 P1\nM2\n";
    std::fs::write(folder.path().join("part.ngc"), plane).unwrap();
    let verify = |options: &[&str]| {
        let arguments = [&["verify", "part.ngc", "--profile"], options].concat();
        told(&morion(folder.path(), &arguments))
    };
    let (code, _, said) = verify(&["round.toml", "--ball-mm", "3", "--nose-mm", "1"]);
    assert!(code == 2 && said.contains("left out with --nose-mm"), "{said}");
    let (code, _, said) = verify(&["round.toml"]);
    assert!(code == 2 && said.contains("or on a lathe --nose-mm"), "{said}");
    let (code, _, said) = verify(&["conquistador", "--nose-mm", "1"]);
    assert!(code == 2 && said.contains("the mirror's outline is a rectangle"), "{said}");
    // A plane a tenth of a millimetre over the rim cuts the dome's apex off, by sag less that.
    let (code, out, said) = verify(&["round.toml", "--nose-mm", "1", "--format", "json"]);
    assert!(code < 2, "{out} {said}");
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    let lowest = report["program"]["lowest"]["off_um"].as_f64().unwrap();
    let sag = 20.0 - f64::sqrt(400.0 - 100.0);
    assert!((lowest + 1e3 * (sag - 0.1)).abs() < 2.0, "{lowest}");
    assert!(report["program"].get("ball_mm").is_none(), "{out}");
}
