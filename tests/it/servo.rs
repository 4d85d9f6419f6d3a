//! Programs of a slow tool servo: mirrors of any shape within a disc, what is left of them, what spoils them, and what they are refused for.

use crate::support::builds::{edited, folder, morion, parsed, told};
use morion::internals::num::{cos, hypot};
use morion::internals::pipeline::{
    Command, Error, OutputFile, ProgramOptions, Silent, Verify, VerifyOptions,
};
use morion::internals::program::{TurnedSurface, TurningPath};
use morion::internals::results::{ProgramReport, Verdict};
use morion::internals::turning::ServoLimit;
use std::f64::consts::TAU;

/// A saddle Z = c (X^2 - Y^2) of 16 mm width.
const SADDLE: &str = r#"
camera.orthographic.pixels = [100, 100]
layout.disc = {}
mirror.polynomial.terms = [[2, 0, 0.004], [0, 2, -0.004]]
part = { width_mm = 16, base_mm = 3 }
mesh.chord_um = 5
export.formats = ["stl"]

[program]
machine = "sts"
nose_mm = 1.5
feed_mm_rev = 0.2
"#;

/// Its c, 1/mm, and radius, mm.
const SADDLE_C: f64 = 0.004;
const RADIUS_MM: f64 = 8.0;

fn cut(text: &str) -> (ProgramReport, Vec<OutputFile>) {
    ProgramOptions.in_memory(&parsed(text), &Silent).unwrap_or_else(|error| panic!("{error}"))
}

fn refused(text: &str) -> String {
    match ProgramOptions.in_memory(&parsed(text), &Silent) {
        Err(error @ Error::Turning { .. }) => error.to_string(),
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("it is cut"),
    }
}

fn text(files: &[OutputFile], name: &str) -> String {
    let file = files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("no {name}"));
    String::from_utf8(file.bytes.clone()).unwrap()
}

/// X, Z and C in degrees of the tool point at each point of a program, by its words alone.
fn points(program: &str) -> Vec<[f64; 3]> {
    let (mut place, mut found) = ([f64::NAN; 3], Vec::new());
    for line in program.lines().filter(|line| line.starts_with("G1 ")) {
        for word in line.split_whitespace() {
            for (letter, at) in [('X', 0), ('Z', 1), ('C', 2)] {
                if let Some(number) = word.strip_prefix(letter) {
                    place[at] = number.parse().unwrap();
                }
            }
        }
        if place.iter().all(|at| at.is_finite()) {
            found.push(place);
        }
    }
    found
}

/// Least distance of a nose's centre from a section up to a radius, by trying places and refining the best by halves.
fn off_section(centre: [f64; 2], radius_mm: f64, section: impl Fn(f64) -> f64) -> f64 {
    let off = |x: f64| hypot(x - centre[0], section(x) - centre[1]);
    let (mut best, mut step) = (centre[0].clamp(-radius_mm, radius_mm), 0.05);
    for k in -40..=40 {
        let x = (centre[0] + 0.05 * f64::from(k)).clamp(-radius_mm, radius_mm);
        if off(x) < off(best) {
            best = x;
        }
    }
    for _ in 0..40 {
        step *= 0.5;
        for x in [best - step, best + step] {
            if x.abs() <= radius_mm && off(x) < off(best) {
                best = x;
            }
        }
    }
    off(best)
}

/// That a program keeps the nose its radius off the section of the saddle, whose lowest place within a circle is at `bottom`, at each point's C,
/// in the middle of moves too within their chord; C grows evenly.
fn keeps_off_saddle(all: &[[f64; 3]], radius_mm: f64, bottom: f64) {
    assert!(all.len() > 2000);
    let mut over = 0;
    for pair in all.windows(2) {
        assert!((pair[1][2] - pair[0][2] - (all[1][2] - all[0][2])).abs() < 1e-9);
        for share in [0.0, 0.5] {
            let [x, z, c] = std::array::from_fn(|k| pair[0][k] + share * (pair[1][k] - pair[0][k]));
            let cosine = cos(TAU * c / 180.0);
            let centre = [x + 1.5, z + 1.5];
            let section = |rho: f64| bottom + SADDLE_C * rho * rho * cosine;
            let off = off_section(centre, radius_mm, section) - 1.5;
            assert!(off > -1.01e-3, "{x} {z} {c}: {off}");
            if centre[0] < radius_mm - 0.5 && off < 0.5 {
                over += usize::from(off.abs() < 1.01e-3);
            }
        }
    }
    assert!(over > 2 * all.len() / 3, "{over} of {}", all.len());
}

/// By the words of the program alone: the nose keeps off the saddle, and X shrinks.
#[test]
fn the_nose_is_its_radius_off_the_section_at_each_point() {
    let (report, files) = cut(&format!("{SADDLE}\npolish_um = 8\n"));
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let all = points(&text(&files, "finishing.ngc"));
    // The lowest place of the saddle is on the base.
    keeps_off_saddle(&all, RADIUS_MM, 3.0 + SADDLE_C * RADIUS_MM * RADIUS_MM);
    let operation = &report.operations[2];
    assert_eq!(operation.feed_mm_rev, Some(0.2));
    let turn = operation.servo.unwrap().points_rev;
    // From a turn to the next X comes nearer by the feed.
    let k = all.len() / 2;
    assert!((all[k][0] - all[k + turn][0] - 0.2).abs() < 1e-5);
}

/// A rectangle is cut as the disc around it: beside a quadric's rim its extension is the quadric. The face that is read back has the
/// rectangle's corners, and its area.
#[test]
fn a_rectangle_is_cut_as_the_disc_around_it() {
    let text_of = edited(
        SADDLE,
        &[
            ("pixels = [100, 100]", "pixels = [150, 100]"),
            ("layout.disc = {}\n", ""),
            ("width_mm = 16", "width_mm = 12, height_mm = 8"),
        ],
    );
    let (report, files) = cut(&format!("{text_of}\npolish_um = 8\n"));
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let half = [6.0, 4.0];
    let bottom = 3.0 + SADDLE_C * half[1] * half[1];
    keeps_off_saddle(&points(&text(&files, "finishing.ngc")), hypot(half[0], half[1]), bottom);
    for (done, asked_um) in report.operations.iter().zip([300.0, 100.0]) {
        let left = done.left.unwrap();
        assert!(left.least_um > 0.95 * asked_um && left.most_um < 1.1 * asked_um, "{left:?}");
    }
    let facts = report.program.as_ref().unwrap();
    assert!(facts.lowest.off_um > -1.5, "{facts:?}");
    let as_cut = files.iter().find(|file| file.name == "as-cut.stl").unwrap();
    let cut_face = Facets::of_stl(&as_cut.bytes);
    for (x, y) in [(6.0, 4.0), (-6.0, 4.0), (-6.0, -4.0), (6.0, -4.0)] {
        let off = cut_face.0.iter().flatten().map(|v| hypot(v[0] - x, v[1] - y));
        let off = off.fold(f64::INFINITY, f64::min);
        assert!(off < 1e-5, "{x} {y}: {off}");
    }
    let area = cut_face.area_from_above();
    assert!((area / 96.0 - 1.0).abs() < 1e-6, "{area}");
}

/// Corners of the facets of a binary STL.
struct Facets(Vec<[[f64; 3]; 3]>);

impl Facets {
    fn of_stl(bytes: &[u8]) -> Self {
        let number =
            |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
        let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
        let corner = |k: usize, v: usize| {
            std::array::from_fn(|axis| number(84 + 50 * k + 12 + 12 * v + 4 * axis))
        };
        Self((0..count).map(|k| std::array::from_fn(|v| corner(k, v))).collect())
    }

    /// Area in the plan of the facets that are seen from above, mm^2.
    fn area_from_above(&self) -> f64 {
        let area = |[a, b, c]: &[[f64; 3]; 3]| {
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        };
        self.0.iter().map(area).filter(|area| *area > 0.0).sum()
    }
}

/// Z'' of the saddle at the rim is 4 c rho^2 w^2, of Z = c rho^2 cos 2t: the speed that is chosen is the root of the acceleration over that,
/// to which the nose adds little; a fourth of the acceleration halves it. What the program asks for, read back, is the limit.
#[test]
fn the_speed_of_c_is_the_largest_that_the_acceleration_allows() {
    let limited = |acceleration: f64| {
        let (report, _) = cut(&format!(
            "{SADDLE}\npolish_um = 8\nacceleration_mm_s2 = {acceleration}\nmax_spindle_rpm = 5000\n"
        ));
        let done = report.operations[2].clone();
        let servo = done.servo.unwrap();
        assert_eq!(servo.limited_by, ServoLimit::Acceleration);
        assert!((servo.acceleration_mm_s2 / acceleration - 1.0).abs() < 2e-3, "{servo:?}");
        done.speeds.spindle_rpm
    };
    let [slow, fast] = [50.0, 200.0].map(limited);
    assert!((fast / slow - 2.0).abs() < 2e-3, "{slow} {fast}");
    let second = 4.0 * SADDLE_C * RADIUS_MM * RADIUS_MM;
    let exact = 60.0 / TAU * (50.0 / second).sqrt();
    // Beside the rim the nose goes on, and around its section's slope it swings.
    assert!(slow < exact && slow > 0.8 * exact, "{slow} {exact}");
}

/// Roughing and semi-finishing leave their allowances within a tenth; finishing cuts no deeper than its chords and half a micrometre, and its
/// cusps are f^2 / (8 r) high where the section is nearly straight.
#[test]
fn what_is_left_is_what_is_asked_for() {
    for (feed_mm, control) in [(0.2, "linuxcnc"), (0.1, "xzc")] {
        let text = edited(SADDLE, &[("feed_mm_rev = 0.2", &format!("feed_mm_rev = {feed_mm}"))]);
        let (report, files) = cut(&format!("{text}\npolish_um = 8\ncontrol = \"{control}\"\n"));
        assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
        for (done, asked_um) in report.operations.iter().zip([300.0, 100.0]) {
            let left = done.left.unwrap();
            assert!(left.least_um > 0.95 * asked_um && left.most_um < 1.1 * asked_um, "{left:?}");
        }
        let facts = report.program.as_ref().unwrap();
        assert!(facts.lowest.off_um > -1.5, "{facts:?}");
        let cusp_um = 1e3 * feed_mm * feed_mm / (8.0 * 1.5);
        // Where the section is most hollow, c rho^2 cos 2t, cusps are higher by 1 / (1 - 2 c r).
        let highest = facts.highest.off_um;
        assert!(highest > 0.98 * cusp_um - 1.0 && highest < 1.02 * cusp_um + 1.0, "{highest}");
        assert!((facts.apart_mm / feed_mm - 1.0).abs() < 0.04, "{facts:?}");
        let name = format!("finishing.{}", if control == "xzc" { "xzc" } else { "ngc" });
        assert!(files.iter().any(|file| file.name == name));
        assert!(report.files.iter().any(|file| file.name == name), "{:?}", report.files);
    }
}

/// Over z = a x - b (x^2 + y^2) a section has the slope p = a cos t - 2 b rho and bulges by k = 2 b / (1 + p^2)^(3/2). Circles whose centres come
/// nearer to the axis by f leave cusps f^2 (1 + p^2) / (8 r (1 + r k)) over it: of a tilted plane and of a paraboloid off its axis what is left
/// most is that, within the chord, and what is left least is the chord.
#[test]
#[ignore = "long: .ci/nightly"]
fn cusps_are_those_of_the_closed_form_over_a_sweep_of_feeds() {
    let (a, nose_mm, chord_um) = (0.1, 1.5, 0.1);
    for feed_mm in [0.1, 0.2, 0.4] {
        for b in [0.0, 0.02] {
            let terms = match b > 0.0 {
                true => format!("[[1, 0, {a}], [2, 0, -{b}], [0, 2, -{b}]]"),
                false => format!("[[1, 0, {a}]]"),
            };
            let text = edited(
                SADDLE,
                &[
                    ("[[2, 0, 0.004], [0, 2, -0.004]]", &terms),
                    ("feed_mm_rev = 0.2", &format!("feed_mm_rev = {feed_mm}")),
                ],
            );
            let more = format!("polish_um = 50\nchord_um = {chord_um}\nclearance_deg = 40\n");
            let facts = cut(&format!("{text}\n{more}")).0.program.unwrap();
            let [x, y, _] = facts.highest.at_mm;
            let rho = hypot(x, y);
            let slope = a * x / rho - 2.0 * b * rho;
            let stretch = 1.0 + slope * slope;
            let bulge = 2.0 * b / (stretch * stretch.sqrt());
            let cusp_um =
                1e3 * feed_mm * feed_mm * stretch / (8.0 * nose_mm * (1.0 + nose_mm * bulge));
            let off = facts.highest.off_um - cusp_um;
            // The closed form is of the second order: a share of (f / r)^2 / 16 is left out.
            assert!(
                off > -0.01 * cusp_um && off < chord_um + 0.01 * cusp_um,
                "{off} of {cusp_um}: {facts:?}"
            );
            assert!(facts.lowest.off_um > -chord_um - 0.01, "{facts:?}");
        }
    }
}

/// A round mirror that is turned and one that a slow tool servo cuts are the same within the chords of both.
#[test]
fn a_round_mirror_is_the_same_as_a_turned_one() {
    let dome = edited(
        SADDLE,
        &[("terms = [[2, 0, 0.004], [0, 2, -0.004]]", "terms = [[2, 0, -0.02], [0, 2, -0.02]]")],
    );
    let round = edited(
        SADDLE,
        &[
            (
                "mirror.polynomial.terms = [[2, 0, 0.004], [0, 2, -0.004]]",
                "mirror.polynomial = { radius_mm = -25, conic = -1 }",
            ),
            ("machine = \"sts\"", "machine = \"turn\""),
        ],
    );
    let sections = [(dome, "ngc"), (round, "ngc")].map(|(text_of, ending)| {
        let (_, files) = cut(&format!("{text_of}\npolish_um = 8\nchord_um = 0.02\n"));
        let path =
            TurningPath::read(text(&files, &format!("finishing.{ending}")).as_bytes()).unwrap();
        TurnedSurface::new(&path, 1.5).section(0.3)
    });
    // Cusps are where each begins its turns: the circles' lower sides are on one curve.
    let lowest = |k: usize, from: f64| {
        let all = (0..=400).map(|i| from + 0.001 * f64::from(i));
        let off = all.filter_map(|x| Some(sections[k].lowest(x)?.z_mm + 0.02 * x * x));
        off.fold(f64::INFINITY, f64::min)
    };
    for k in 0..18 {
        let from = 0.4 * f64::from(k) + 0.2;
        let [servo, turn] = [0, 1].map(|k| lowest(k, from));
        // (Figures of a lathe's program are to a tenth of a micrometre.)
        assert!((servo - turn).abs() < 1.2e-4, "{from}: {servo} {turn}");
    }
}

/// Of a digit that is changed anywhere the mirror fails, of both formats.
#[test]
fn a_digit_spoils_a_program_of_either_control() {
    let text_of = format!("{SADDLE}\npolish_um = 8\n");
    for (control, ending) in [("linuxcnc", "ngc"), ("xzc", "xzc")] {
        let controlled = format!("{text_of}control = \"{control}\"\n");
        let (_, files) = cut(&controlled);
        let program = text(&files, &format!("finishing.{ending}"));
        let profile = parsed(&controlled);
        let folder = folder();
        let path = folder.path().join(format!("part.{ending}"));
        let verdict = |program: &str| {
            std::fs::write(&path, program).unwrap();
            let options = VerifyOptions { nose_mm: Some(1.5), ..VerifyOptions::default() };
            let verify = Verify { path: &path, options };
            let report =
                verify.in_memory(&profile, &Silent).unwrap_or_else(|error| panic!("{error}")).0;
            report.verdict
        };
        assert_eq!(verdict(&program), Verdict::Pass, "{control}");
        let lines: Vec<&str> = program.lines().collect();
        let cuts: Vec<usize> = (0..lines.len())
            .filter(|&k| {
                lines[k].starts_with("G1 X") || lines[k].starts_with(|c: char| c.is_ascii_digit())
            })
            .collect();
        for (share, word, before) in [(4, 0, 1), (5, 1, 1), (6, 2, 2), (7, 1, 1)] {
            let k = cuts[cuts.len() * share / 10];
            let words: Vec<&str> = lines[k].split(' ').filter(|word| *word != "G1").collect();
            let word = words[word];
            // A digit before the point, of C that of ten degrees: one more, or from 9 to 0.
            let at = word.find('.').unwrap() - before;
            let digit = (word.as_bytes()[at] - b'0' + 1) % 10;
            let changed = format!("{}{digit}{}", &word[..at], &word[at + 1..]);
            let line = lines[k].replacen(word, &changed, 1);
            let spoilt = [&lines[..k], &[line.as_str()], &lines[k + 1..]].concat().join("\n");
            assert_eq!(verdict(&spoilt), Verdict::Fail, "{}: {line}", lines[k]);
        }
    }
}

#[test]
fn what_cannot_be_cut_is_refused_with_what_would() {
    let said = refused(&format!("{SADDLE}\nclearance_deg = 2\n"));
    // Along the circle it falls by 2 c rho sin 2t at the most: 3.66 degrees.
    assert!(said.contains("8.000 mm from the axis") && said.contains("3.66 degrees"), "{said}");
    assert!(said.contains("program.clearance_deg, has 2 degrees"), "{said}");
    let said = refused(&format!("{SADDLE}\ninner_edge_deg = 3\n"));
    assert!(said.contains("program.inner_edge_deg, has 3"), "{said}");
    let trough = ("[[2, 0, 0.004], [0, 2, -0.004]]", "[[2, 0, 0.04]]");
    let hollow = edited(SADDLE, &[trough, ("nose_mm = 1.5", "nose_mm = 13")]);
    let said = refused(&format!("{hollow}\nclearance_deg = 90\n"));
    assert!(
        said.contains("hollow with a radius of 12.5") && said.contains("program.nose_mm"),
        "{said}"
    );
    let fine = edited(SADDLE, &[("feed_mm_rev = 0.2", "feed_mm_rev = 0.001")]);
    let said = refused(&fine);
    assert!(said.contains("take a program.feed_mm_rev of 0."), "{said}");
    let said = refused(&format!("{SADDLE}\ntravel_mm = [100, 5]\n"));
    assert!(said.contains("along Z, and program.travel_mm has 5 mm"), "{said}");
    let low = edited(SADDLE, &[("base_mm = 3", "base_mm = 0.001")]);
    let said = refused(&low);
    assert!(said.contains("below the base around it; raise part.base_mm"), "{said}");
}

/// What a refusal of too many points of a turn names.
fn chord_that_will_do(text: &str) -> f64 {
    let said = refused(text);
    assert!(said.contains("finishing would take more than 2880 points of a turn"), "{said}");
    let (_, chord) = said.split_once("take a program.chord_um of ").unwrap();
    chord.split_once(" um or more").unwrap().0.parse().unwrap()
}

/// A saddle bends around the axis by 4 c rho^2, of which a move around the axis cuts off an eighth times its angle squared.
#[test]
fn the_chord_that_a_refusal_names_makes_the_mirror() {
    let wide = edited(
        SADDLE,
        &[
            ("[[2, 0, 0.004], [0, 2, -0.004]]", "[[2, 0, 0.001], [0, 2, -0.001]]"),
            ("width_mm = 16, base_mm = 3", "width_mm = 140, base_mm = 12"),
            ("feed_mm_rev = 0.2", "feed_mm_rev = 0.5"),
        ],
    );
    let chord_um = chord_that_will_do(&format!("{wide}\nchord_um = 0.01\n"));
    let angle = TAU / 2880.0;
    let least_um = 1e3 * 0.125 * 4.0 * 0.001 * 70.0 * 70.0 * angle * angle;
    assert!(chord_um > least_um && chord_um < 1.2 * least_um, "{chord_um} {least_um}");
    let (report, _) = cut(&format!("{wide}\nchord_um = {chord_um}\n"));
    assert_eq!(report.operations.len(), 3);
}

/// Beside the rectangle of a driver's mirror the extension has corners, which its derivatives do not tell of.
#[test]
#[ignore = "long: .ci/nightly"]
fn the_chord_that_a_refusal_names_follows_corners() {
    let shipped = morion::shipped().iter().find(|shipped| shipped.name == "driver").unwrap();
    let with = |chord_um: f64| {
        let program = "[program]\nmachine = \"sts\"\nnose_mm = 1\npolish_um = 50";
        format!("{}\n{program}\nchord_um = {chord_um}\n", shipped.text)
    };
    let chord_um = chord_that_will_do(&with(1.0));
    let (report, _) = cut(&with(chord_um));
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    assert!(chord_that_will_do(&with(0.99 * chord_um)) <= chord_um);
}

/// The files of both controls are the same on one thread and on two, and what is written by one command is verified by another.
#[test]
fn files_are_the_same_on_any_number_of_threads() {
    let folder = folder();
    std::fs::write(
        folder.path().join("saddle.toml"),
        format!("{SADDLE}\npolish_um = 8\ncontrol = \"xzc\"\n"),
    )
    .unwrap();
    let made = ["1", "2"].map(|threads| {
        let out = format!("out{threads}");
        let (code, _, said) = told(&morion(
            folder.path(),
            &["program", "saddle.toml", "--threads", threads, "--out", &out, "--quiet"],
        ));
        assert_eq!(code, 0, "{said}");
        let files = [
            "roughing.xzc",
            "semi-finishing.xzc",
            "finishing.xzc",
            "as-cut.stl",
            "program.json",
            "program.html",
        ];
        files.map(|name| {
            std::fs::read(folder.path().join(&out).join("saddle/program").join(name)).unwrap()
        })
    });
    assert!(made[0] == made[1]);
    let table = "out1/saddle/program/finishing.xzc";
    let verify = |file: &str, options: &[&str]| {
        let arguments = [&["verify", file, "--profile", "saddle.toml"], options].concat();
        told(&morion(folder.path(), &arguments))
    };
    let (code, out, said) = verify(table, &["--nose-mm", "1.5", "--format", "json"]);
    assert_eq!(code, 0, "{said}");
    let report: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["files"][0]["format"], "xzc");
    assert_eq!(report["program"]["nose_mm"], 1.5);
    let (code, _, said) = verify(table, &["--ball-mm", "1.5"]);
    assert!(code == 2 && said.contains("left out for a table of points"), "{said}");
    let (code, _, said) = verify(table, &[]);
    assert!(code == 2 && said.contains("--nose-mm"), "{said}");
    // A rapid move through it, with C where it is.
    let through = "G8 G93\nG0 X10 Z9 C0\nG0 Z1\nG0 X-3\nG1 X-2 C360 F60\nG1 C720 F60\nG0 Z9\nM2\n";
    std::fs::write(folder.path().join("through.ngc"), through).unwrap();
    let (code, out, said) = verify("through.ngc", &["--nose-mm", "1.5"]);
    assert_eq!(code, 1, "{out} {said}");
}
