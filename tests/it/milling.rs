//! Programs that mill a mirror: what they leave, and what they are refused for.

use crate::support::builds::{SMALL, edited, folder, parsed};
use crate::support::{shipped, times};
use morion::internals::milling::OperationKind;
use morion::internals::pipeline::{
    Command, Error, MachiningOptions, OutputFile, ProgramOptions, Silent, Verify, VerifyOptions,
};
use morion::internals::profile::{MillControl, MillSpec, Profile};
use morion::internals::program::ToolPath;
use morion::internals::results::{OperationFacts, ProgramReport, ReasonKind, Verdict};

/// From line to line of finishing, mm.
const STEPOVER_MM: f64 = 0.3;

fn mill(profile: &mut Profile) -> &mut MillSpec {
    profile.program.mill_mut().unwrap()
}

fn milled(profile: &Profile) -> (ProgramReport, Vec<OutputFile>) {
    ProgramOptions.in_memory(profile, &Silent).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(profile: &Profile) -> String {
    match ProgramOptions.in_memory(profile, &Silent) {
        Err(error @ Error::Milling { .. }) => error.to_string(),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("it is milled"),
    }
}

fn text(files: &[OutputFile], name: &str) -> String {
    let file = files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("no {name}"));
    String::from_utf8(file.bytes.clone()).unwrap()
}

fn cutting_faults(report: &ProgramReport) -> Vec<String> {
    let cutting =
        report.reasons.iter().filter(|reason| matches!(reason.kind, ReasonKind::Cutting(_)));
    cutting.map(ToString::to_string).collect()
}

/// A crest, a round mirror and a strip: no rapid move and no plunge meets the stock, roughing and semi-finishing leave their allowance
/// within a tenth, finishing cuts nowhere deeper than a micrometre and a half, its chords included, and its picture is what the
/// study of its raster foresees.
#[test]
#[ignore = "long: .ci/nightly"]
fn programs_leave_what_they_are_to_leave() {
    for name in ["conquistador", "hyperbolic", "panoramic"] {
        let mut profile = shipped(name);
        mill(&mut profile).finishing.stepover_mm = Some(STEPOVER_MM);
        mill(&mut profile).roughing.allowance_mm = 0.4;
        let (report, files) = milled(&profile);
        assert_eq!(cutting_faults(&report), [""; 0], "{name}");
        let left = |kind: usize| report.operations[kind].left.unwrap();
        assert!(left(0).least_um > 0.95 * 400.0, "{name}: {:?}", left(0));
        assert!(left(1).least_um > 0.95 * 400.0, "{name}: {:?}", left(1));
        // (The allowances of both sides of a crest meet above it, where more stands.)
        let is_even = name == "conquistador" || left(1).most_um < 1.1 * 400.0;
        assert!(is_even, "{name}: {:?}", left(1));
        let program = report.program.as_ref().unwrap();
        assert!(program.lowest.off_um > -1.5, "{name}: {:?}", program.lowest);
        let options = MachiningOptions {
            ball_mm: 3.0,
            stepover_mm: Some(STEPOVER_MM),
            angle_deg: report.angle_deg,
            ..MachiningOptions::default()
        };
        let foreseen = options.in_memory(&profile, &Silent).unwrap().0;
        let cut = report.as_cut.as_ref().unwrap().trace.errors.facet_error_px.unwrap().rms;
        let study = foreseen.scallops.unwrap().pixel_error_px.unwrap().rms;
        assert!((cut / study - 1.0).abs() < 0.02, "{name}: {cut} px, foreseen {study} px");
        for operation in &report.operations {
            let OperationFacts { at_feed_min, changing_min, rapid_min, .. } = *operation;
            let parts = [at_feed_min, changing_min, rapid_min];
            assert!(parts.iter().all(|min| *min > 0.0), "{name}: {parts:?}");
            assert!((parts.iter().sum::<f64>() / operation.machine_min - 1.0).abs() < 1e-12);
            let path = ToolPath::read(text(&files, &operation.file).as_bytes()).unwrap();
            assert!(operation.machine_min > path.cutting_min(), "{name}: {operation:?}");
            assert!(path.moves.iter().all(|step| step.to.z >= 0.0));
        }
    }
}

fn small(more: &str) -> Profile {
    let rough = edited(
        SMALL,
        &[
            ("pixel_error_rms_px = 2", "pixel_error_rms_px = 4"),
            ("pixel_error_max_px = 5", "pixel_error_max_px = 12"),
        ],
    );
    parsed(&format!("{rough}\n[program]\n{more}\n"))
}

/// Lines beside a bulging rim are interrupted, and go on above what is beside them.
#[test]
#[ignore = "long: .ci/nightly"]
fn no_line_goes_through_the_mirror_where_it_is_interrupted() {
    let mut profile = shipped("driver");
    mill(&mut profile).finishing.stepover_mm = Some(times(2, 1) as f64);
    mill(&mut profile).finishing.polish_um = Some(times(400, 100) as f64);
    let (report, _) = milled(&profile);
    assert_eq!(cutting_faults(&report), [""; 0]);
}

/// A spherical bowl of 20 mm radius that is given.
const BOWL: &str = r#"
[camera.orthographic]
pixels = [100, 100]

[layout.disc]

[mirror.polynomial]
radius_mm = 20
conic = 0

[part]
width_mm = 20
base_mm = 5

[mesh]
chord_um = 5

[export]
formats = ["stl"]
"#;

/// All controls get the same moves, which take longer where a jerk is told; and the file that is written is the one that passes when it is verified by itself.
#[test]
fn every_control_reads_the_same_moves_and_a_digit_spoils_them() {
    let read = |control: MillControl, more: &str| {
        // Lines that are farther apart are sooner cut, and displace the picture in proportion.
        let mut profile = small(&format!("ball_mm = 1.5\nstepover_mm = 0.12\n{more}"));
        let coarser = times(5, 2) as f64 / 2.0;
        mill(&mut profile).finishing.stepover_mm = Some(0.12 * coarser);
        profile.accept.pixel_error_rms_px = Some(4.0 * coarser);
        profile.accept.pixel_error_max_px = Some(12.0 * coarser);
        mill(&mut profile).control = control;
        let (report, files) = milled(&profile);
        assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
        let programs = OperationKind::ALL.map(|kind| text(&files, &format!("{}.ngc", kind.name())));
        (profile, programs, report.operations.iter().map(|done| done.machine_min).sum::<f64>())
    };
    let (profile, one, quick_min) = read(MillControl::Linuxcnc, "");
    let moves = |program: &str| {
        let moves = ToolPath::read(program.as_bytes()).unwrap().moves;
        moves.into_iter().map(|step| (step.from, step.to, step.feed)).collect::<Vec<_>>()
    };
    let programs = one.len() as f64;
    for (control, jerk) in [(MillControl::Grbl, ""), (MillControl::Fanuc, "jerk_mm_s3 = 5000")] {
        let (_, other, minutes) = read(control, jerk);
        // A tenth of a second for each stop: at the end of each program, as no move goes back the way that it came.
        let stops = 600.0 * (minutes - quick_min);
        let expected = if jerk.is_empty() { 0.0 } else { programs };
        assert!((stops - expected).abs() < 1e-6, "{control:?}: {stops}");
        for (a, b) in one.iter().zip(&other) {
            assert_eq!(moves(a), moves(b), "{control:?}");
        }
        assert!(other.iter().flat_map(|text| text.lines()).all(|line| line.len() < 80));
    }
    let folder = folder();
    let path = folder.path().join("part.ngc");
    let verdict = |program: &str| {
        std::fs::write(&path, program).unwrap();
        let options = VerifyOptions { ball_mm: Some(1.5), ..VerifyOptions::default() };
        let verify = Verify { path: &path, options };
        verify.in_memory(&profile, &Silent).unwrap_or_else(|error| panic!("{error}")).0.verdict
    };
    let finishing = &one[2];
    assert_eq!(verdict(finishing), Verdict::Pass);
    // A digit of the height of a line in the middle: nine tenths of a millimetre, or a millimetre.
    let lines: Vec<&str> = finishing.lines().collect();
    let middle = lines.len() / 2;
    let damaged =
        lines[middle..].iter().position(|line| line.starts_with('X') && line.contains('Z'));
    let k = middle + damaged.unwrap();
    let (before, height) = lines[k].split_once('Z').unwrap();
    let (whole, tenths) = height.split_once('.').unwrap();
    let lower = whole.parse::<i32>().unwrap() - 1;
    let line = format!("{before}Z{lower}.{tenths}");
    let spoilt = [&lines[..k], &[line.as_str()], &lines[k + 1..]].concat().join("\n");
    assert_eq!(verdict(&spoilt), Verdict::Fail);
}

/// A face that is to be polished is held to what is polished off, and its picture is told.
#[test]
#[ignore = "long: .ci/nightly"]
fn a_polished_face_is_held_to_its_scallops() {
    let mut profile = small("ball_mm = 1.5\npolish_um = 4");
    profile.accept.pixel_error_max_px = Some(0.001);
    let (report, _) = milled(&profile);
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let highest = report.program.as_ref().unwrap().highest.off_um;
    assert!(highest > 1.5 && highest <= 4.0, "{highest}");
    assert!(report.as_cut.unwrap().trace.errors.pixel_error_px.unwrap().rms > 0.1);
    mill(&mut profile).finishing.stepover_mm = Some(0.6);
    let (report, _) = milled(&profile);
    let said = cutting_faults(&report).concat();
    assert!(said.contains("over the 4 um of program.polish_um"), "{said}");
}

/// Over a dome of 20 mm radius, 20 mm wide, a holder that covers it has the apex with its allowance over the lowest tip; the ball has
/// as much of the stock beside its tip as a level is deep, at least. Cutters that are a tenth shorter fail, by line and place.
#[test]
#[ignore = "long: .ci/nightly"]
fn shank_and_holder_stay_clear_of_what_is_left() {
    let dome =
        edited(BOWL, &[("radius_mm = 20", "radius_mm = -20"), ("base_mm = 5", "base_mm = 8")]);
    let program = "[program]\nstepover_mm = 0.3\nallowance_mm = 0.4\nstepdown_mm = 0.9\nholder_diameter_mm = 60";
    let with = |more: &str| milled(&parsed(&format!("{dome}\n{program}\n{more}\n")));
    let (report, files) = with("");
    assert_eq!(cutting_faults(&report), [""; 0]);
    let apex_mm = 8.0 + 20.0 - f64::sqrt(400.0 - 100.0);
    let finishing = ToolPath::read(text(&files, "finishing.ngc").as_bytes()).unwrap();
    let lowest = finishing.moves.iter().map(|step| step.to.z).fold(f64::INFINITY, f64::min);
    let needed =
        |k: usize| [report.operations[k].flute, report.operations[k].stickout].map(Option::unwrap);
    let [_, stickout] = needed(2);
    let over = stickout.least_mm - (apex_mm - lowest);
    assert!((0.9 * 0.4..1.1 * 0.4).contains(&over), "{over}: {stickout:?}");
    assert!(stickout.at_mm.iter().all(|mm| mm.abs() < 1.5), "{stickout:?}");
    let [flute, _] = needed(0);
    assert!(flute.least_mm > 0.9 - 1e-9 && flute.least_mm < 3.0, "{flute:?}");
    let longest = |length: usize| (0..3).map(|k| needed(k)[length].least_mm).fold(0.0, f64::max);
    let held = |flute: f64, stickout: f64| {
        let (report, _) = with(&format!("flute_mm = {flute}\nstickout_mm = {stickout}"));
        cutting_faults(&report).join("\n")
    };
    let stickout = longest(1);
    assert_eq!(held(longest(0).max(3.0) + 0.1, stickout + 0.1), "");
    let said = held(3.0, 0.9 * stickout);
    assert!(
        said.contains("the holder meets the stock") && said.contains("stands out of it by"),
        "{said}"
    );
    let thick = with("flute_mm = 3\nshank_diameter_mm = 12").0;
    let said = cutting_faults(&thick).join("\n");
    assert!(
        said.contains("the cutter's shank meets the stock") && said.contains("longer teeth"),
        "{said}"
    );
}

/// Roughed by a cutter: no fault, and no less than nineteen twentieths of the allowance is left.
fn roughed(text_of: &str, cutter: &str) -> Vec<OutputFile> {
    let program = "[program]\nball_mm = 3\nstepover_mm = 0.8\nallowance_mm = 0.4\npolish_um = 200";
    let (report, files) = milled(&parsed(&format!("{text_of}\n{program}\n{cutter}\n")));
    assert_eq!(cutting_faults(&report), [""; 0], "{cutter}");
    let left = report.operations[0].left.unwrap();
    assert!(left.least_um > 0.95 * 400.0, "{cutter}: {left:?}");
    let left = report.operations[1].left.unwrap();
    assert!(left.least_um > 0.95 * 400.0 && left.most_um < 1.1 * 400.0, "{cutter}: {left:?}");
    files
}

/// In a bowl a bull-nosed cutter leaves its allowance and meets no stock in rapid moves.
#[test]
fn a_bull_nosed_cutter_roughs_a_bowl() {
    let files = roughed(BOWL, "rough_radius_mm = 3\nrough_corner_mm = 1");
    assert!(
        text(&files, "roughing.ngc").contains("(BULL-NOSED CUTTER OF 3 MM RADIUS, CORNER 1 MM")
    );
}

/// The same of flat and bull-nosed cutters over a dome and a bowl; what finishes them is as after a ball.
#[test]
#[ignore = "long: .ci/nightly"]
fn flat_and_bull_nosed_cutters_rough() {
    let dome =
        edited(BOWL, &[("radius_mm = 20", "radius_mm = -20"), ("base_mm = 5", "base_mm = 8")]);
    for text_of in [BOWL, dome.as_str()] {
        let ball = roughed(text_of, "rough_ball_mm = 2");
        for corner in ["0", "0.5"] {
            let files =
                roughed(text_of, &format!("rough_radius_mm = 2\nrough_corner_mm = {corner}"));
            // (Comments name the profile, which is another, and how far the tip comes down at first, in Z alone, is told by what is left there.)
            let moves = |files: &[OutputFile]| -> Vec<String> {
                let text = text(files, "finishing.ngc");
                let lines = text.lines().filter(|line| !line.starts_with(['(', 'Z']));
                lines.map(str::to_owned).collect()
            };
            let [after, before] = [&files, &ball].map(|files| moves(files));
            assert!(after == before && after.len() > 100, "{corner}");
        }
    }
}

#[test]
fn what_cannot_be_milled_is_refused_with_what_would() {
    let said = refused(&small("ball_mm = 1.5\nstepover_mm = 0.5\ntravel_mm = [400, 400, 2]"));
    assert!(said.contains("along Z, and program.travel_mm has 2 mm"), "{said}");
    // Hollow with a radius of 20 mm.
    let said = refused(&parsed(&format!(
        "{BOWL}\n[program]\nball_mm = 3\nstepover_mm = 1\nrough_ball_mm = 19.9\n"
    )));
    assert!(
        said.contains("roughing with such a ball") && said.contains("program.rough_ball_mm"),
        "{said}"
    );
    let said = refused(&parsed(&format!("{BOWL}\n[program]\nball_mm = 25\nstepover_mm = 1\n")));
    assert!(
        said.contains("finishing with such a ball") && said.contains("program.ball_mm"),
        "{said}"
    );
    let panels = refused(&shipped("four-views"));
    assert!(panels.contains("panels"), "{panels}");
}
