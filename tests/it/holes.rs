//! Blind, threaded, counterbored and dowel holes: closed bodies of their closed forms in every format, and refusals where
//! they meet the mirror.

use crate::support::builds::{folder, parsed};
use crate::support::parts::{ANNULUS, CONQUISTADOR, DISC, GIVEN, PINHOLE, STRIP};
use crate::support::{designed, share, unlimited};
use morion::internals::design::{DesignError, design};
use morion::internals::pipeline::{Silent, build, verify};
use morion::internals::profile::Profile;
use morion::internals::results::{Reason, Verdict};
use std::f64::consts::PI;

const PART: &str = "part = { width_mm = 60, base_mm = 8 }\n";
const BORDERED: &str = "part = { width_mm = 60, base_mm = 12, border_mm = 12, rim_mm = 6 }\n";
const FORMATS: (&str, &str) =
    ("[\"stl\", \"obj\"]", "[\"stl\", \"obj\", \"3mf\", \"glb\", \"step\"]");

/// A threaded hole, two dowel holes and a counterbored flat one, each less than 6 mm deep, within 20 mm of the axis.
const BLIND: &str = "
[[hole]]
at_mm = [[14, 3]]
thread = \"M3\"
thread_depth_mm = 3

[[hole]]
at_mm = [[-14, -2], [3, 1]]
dowel_mm = 2
depth_mm = 4
chamfer_mm = 0.2

[[hole]]
at_mm = [[-4, -3.5]]
diameter_mm = 2
depth_mm = 5
bottom = \"flat\"
counterbore_diameter_mm = 4
counterbore_depth_mm = 1.5
";

/// Holes through the flat rim on the left and the right.
const THROUGH: &str = "
[[hole]]
at_mm = [[37.5, 2]]
screw = \"M4\"

[[hole]]
at_mm = [[-37.5, 2]]
thread = \"M5\"
chamfer_mm = 0.4
";

/// A cylinder, and the ring that a chamfer of 45 degrees cuts off its edge: Pappus' theorem.
fn cylinder(diameter_mm: f64, depth_mm: f64) -> f64 {
    0.25 * PI * diameter_mm * diameter_mm * depth_mm
}

fn chamfer(diameter_mm: f64, leg_mm: f64) -> f64 {
    2.0 * PI * (0.5 * diameter_mm + leg_mm / 3.0) * (0.5 * leg_mm * leg_mm)
}

/// The cone of 118 degrees.
fn point(diameter_mm: f64) -> f64 {
    let height = 0.5 * diameter_mm / morion::internals::num::tan(59.0 / 180.0 * PI);
    cylinder(diameter_mm, height) / 3.0
}

/// Volume of the holes of [`BLIND`].
fn blind_mm3() -> f64 {
    let threaded = cylinder(2.5, 3.0 + 4.0 * 0.5) + point(2.5);
    let dowel = cylinder(2.0, 4.0) + point(2.0) + chamfer(2.0, 0.2);
    threaded + 2.0 * dowel + cylinder(2.0, 5.0) + cylinder(4.0, 1.5) - cylinder(2.0, 1.5)
}

/// Volume of the holes of [`THROUGH`] in a rim of 6 mm.
fn through_mm3() -> f64 {
    let screw = cylinder(4.5, 6.0) + cylinder(8.0, 4.4) - cylinder(4.5, 4.4);
    screw + cylinder(4.2, 6.0) + 2.0 * chamfer(4.2, 0.4)
}

#[test]
fn a_part_is_smaller_by_the_closed_forms_of_its_holes() {
    for base in [STRIP, DISC, ANNULUS, PINHOLE] {
        for (part, holes, exact) in [
            (PART, BLIND.to_owned(), blind_mm3()),
            (BORDERED, format!("{BLIND}{THROUGH}"), blind_mm3() + through_mm3()),
        ] {
            let plain = designed(&parsed(&format!("{base}{part}"))).volume();
            let drilled = designed(&parsed(&format!("{base}{part}{holes}"))).volume();
            let off = (plain - drilled) / exact - 1.0;
            assert!(off.abs() < 1e-9, "{base}{part}: {off:e}");
        }
    }
}

/// Every format of every layout passes: closed, of the expected volume, each vertex and curved face where it is designed.
#[test]
fn parts_with_holes_of_every_kind_pass_in_every_format() {
    let cases = [
        (CONQUISTADOR, PART, ""),
        (DISC, PART, ""),
        (PINHOLE, PART, ""),
        (STRIP, BORDERED, THROUGH),
        (ANNULUS, BORDERED, THROUGH),
    ];
    for (base, part, through) in share(4, 0, cases) {
        let text = format!("{base}{part}{BLIND}{through}").replace(FORMATS.0, FORMATS.1);
        let folder = folder();
        let source = unlimited(parsed(&text));
        let report =
            build(&source, folder.path(), &Silent).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(report.verdict, Verdict::Pass, "{text}: {:?}", report.reasons);
        assert_eq!(report.trace.len(), 5, "{text}");
        let bored = usize::from(!through.is_empty()) * 2;
        for trace in &report.trace {
            assert_eq!(trace.solid.check.euler, 2 - 2 * bored as i64, "{text}");
        }
        let words: Vec<&str> = report.holes.iter().map(|hole| hole.words.as_str()).collect();
        let blind = [
            "M3 x 0.5 - 6H, 3 deep, pilot 2.5, 5 deep",
            "diameter 2 H7 (+0.010/0), 4 deep, chamfer 0.2 x 45 deg",
            "diameter 2 H7 (+0.010/0), 4 deep, chamfer 0.2 x 45 deg",
            "diameter 2, 5 deep, flat, counterbore 4, 1.5 deep",
        ];
        assert_eq!(words[bored..], blind);
        if bored > 0 {
            assert_eq!(
                words[..bored],
                [
                    "diameter 4.5, through, for a screw M4, counterbore 8, 4.4 deep",
                    "M5 x 0.8 - 6H, through, pilot 4.2, chamfer 0.4 x 45 deg",
                ]
            );
        }
        assert_eq!(report.holes[bored].depth_mm, Some(5.0));
        assert_eq!(report.holes[bored].at_mm, [14.0, 3.0]);
    }
}

#[test]
fn a_vertex_off_a_blind_hole_fails() {
    let text = format!("{STRIP}{PART}{BLIND}");
    let folder = folder();
    let source = unlimited(parsed(&text));
    build(&source, folder.path(), &Silent).unwrap();
    let plain = std::fs::read_to_string(folder.path().join("small/mirror.obj")).unwrap();
    // The flat ground's middle, the counterbore's ground and a chamfer's edge; each 0.1 mm off.
    for (from, to) in [
        ("v -4 -3.5 5\n", "v -4 -3.5 5.1\n"),
        ("v -2 -3.5 1.5\n", "v -2 -3.5 1.6\n"),
        ("v 4.2 1 0\n", "v 4.2 1 -0.1\n"),
    ] {
        assert_eq!(plain.matches(from).count(), 1, "{from}");
        let path = folder.path().join("moved.obj");
        std::fs::write(&path, plain.replace(from, to)).unwrap();
        let report = verify(&source, &path, &Silent).unwrap();
        let off = report.trace[0].worst_vertex.unwrap().off_mm;
        assert!((0.07..0.1 + 1e-9).contains(&off), "{to}: {off}");
        assert_eq!(report.verdict, Verdict::Fail);
        let told = |r: &Reason| r.to_string().contains("off the designed part");
        assert!(report.reasons.iter().any(told), "{:?}", report.reasons);
    }
}

/// The profile's text with the settings of a hint, each in the place of the key's line.
fn pasted(text: &str, hint: &str) -> String {
    let (_, settings) = hint.rsplit_once("; set ").unwrap_or_else(|| panic!("{hint}"));
    let mut text = text.to_owned();
    for setting in settings.split(" and ") {
        let setting = setting.trim_start_matches("part.").trim_end_matches(" or more");
        let (key, value) = setting.split_once(" = ").unwrap();
        let found = ["\n", " "].iter().find_map(|before| {
            let line = format!("{before}{key} = ");
            Some(text.find(&line)? + line.len())
        });
        match found {
            Some(from) => {
                let length = text[from..].find([',', ' ', '\n']).unwrap();
                text.replace_range(from..from + length, value);
            }
            None => text.push_str(&format!("{key} = {value}\n")),
        }
    }
    text
}

/// Under a spherical dome the thinnest wall is over the edge of a flat ground: it has a closed form.
#[test]
fn the_least_wall_under_a_sphere_is_where_geometry_has_it() {
    let given = GIVEN.replace(", terms = [[3, 0, 1e-5], [0, 1, 0.01]]", "");
    let part = "part = { width_mm = 60, height_mm = 40, base_mm = 8 }\n";
    // The lowest points are the corners, on the base of 8 mm.
    let centre = 8.0 - f64::sqrt(80.0 * 80.0 - 30.0 * 30.0 - 20.0 * 20.0);
    let (x, y, r) = (9.0, 12.0, 2.0);
    let deepest = centre + f64::sqrt(79.0 * 79.0 - (15.0 + r) * (15.0 + r));
    let made = |depth: f64| {
        let hole = format!(
            "[[hole]]\nat_mm = [[{x}, {y}]]\ndiameter_mm = {}\nbottom = \"flat\"\ndepth_mm = {depth}\n",
            2.0 * r
        );
        let text = format!("{given}{part}{hole}");
        (design(&parsed(&text)), text)
    };
    assert!(deepest > 8.0, "{deepest}");
    assert!(made(deepest - 2e-6).0.is_ok());
    for more in [2e-5, 0.3, 3.0, 40.0] {
        let (refused, text) = made(deepest + more);
        let Err(DesignError::Border { message, hint }) = refused else { panic!("{more}") };
        assert!(message.contains("must leave 1 mm of material under the mirror"), "{message}");
        assert!(message.contains("the hole at [9, 12] (line"), "{message}");
        // The wall has the same normal at all these depths while it is there, and the remedy is the depth above.
        let depth: f64 = hint.strip_prefix("set depth_mm = ").unwrap().parse().unwrap();
        assert!((0.0..2e-3).contains(&(deepest - depth)), "{hint}, not {deepest}");
        assert!(design(&parsed(&pasted(&text, &format!("; {hint}")))).is_ok(), "{hint}");
    }
}

#[test]
fn holes_that_come_too_near_the_mirror_are_refused_and_their_hints_work() {
    let hole = |at: &str, rest: &str| format!("[[hole]]\nat_mm = [{at}]\n{rest}\n");
    for base in [STRIP, CONQUISTADOR, DISC, PINHOLE, ANNULUS] {
        for rest in [
            "thread = \"M3\"\nthread_depth_mm = 26",
            "thread = \"M2.5\"\ndepth_mm = 30",
            "dowel_mm = 3\ndepth_mm = 40",
        ] {
            let text = format!("{base}{PART}{}", hole("[20, 1.5]", rest));
            let error = design(&parsed(&text)).unwrap_err();
            assert!(matches!(error, DesignError::Border { .. }), "{error}");
            let mended = pasted(&text, &error.to_string());
            let found =
                design(&parsed(&mended)).unwrap_or_else(|e| panic!("{error}\n{mended}\n{e}"));
            assert_eq!(found.blind_holes.len(), 1);
        }
        // No depth is of use in so thin a base.
        let text = format!(
            "{base}{}{}",
            PART.replace("= 8", "= 1.2"),
            hole("[20, 1.5]", "thread = \"M8\"\nthread_depth_mm = 12")
        );
        let error = design(&parsed(&text)).unwrap_err().to_string();
        if error.contains("set part.base_mm = ") {
            let mended = pasted(&text, &error);
            assert!(design(&parsed(&mended)).is_ok(), "{error}\n{mended}");
        }
    }
    // The sides of a pinhole's strip are curved; the design tells where they are.
    let text = format!("{PINHOLE}{PART}{}", hole("[33, 0]", "diameter_mm = 3\ndepth_mm = 3"));
    let error = design(&parsed(&text)).unwrap_err().to_string();
    assert!(error.contains("must stay 0.1 mm clear of the part's side"), "{error}");
}

#[test]
fn a_table_of_a_hole_that_says_too_little_or_too_much_is_refused_at_its_line() {
    let refused = |part: &str, hole: &str| {
        let text = format!("{}{part}[[hole]]\n{hole}\n", STRIP.trim_start());
        let complaints = Profile::parse("p", "p.toml", text.as_bytes()).expect_err(hole);
        complaints.0.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    for (part, hole, expected) in [
        (
            PART,
            "diameter_mm = 3",
            "p.toml:8:1: hole.at_mm must be a list of 1 to 100 entries [x, y]",
        ),
        (
            PART,
            "at_mm = [[0, 0]]",
            "p.toml:8:1: hole must have exactly one of diameter_mm, thread, screw and dowel_mm, found none",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\nthread = \"M3\"\ndiameter_mm = 3",
            "p.toml:8:1: hole must have exactly one of diameter_mm, thread, screw and dowel_mm, found 2",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\nthread = \"M7\"",
            "p.toml:10:10: hole.thread must be \"M2\", \"M2.5\", \"M3\"",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\ndowel_mm = 12",
            "p.toml:10:12: hole.dowel_mm must be a number from 1 to 10, found 12",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\ndiameter_mm = 3",
            "p.toml:9:10: hole.depth_mm must be given in a part without a flat rim",
        ),
        (
            BORDERED,
            "at_mm = [[36, 0]]\ndiameter_mm = 3\nbottom = \"flat\"",
            "p.toml:8:1: hole.bottom must go with depth_mm",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\ndiameter_mm = 3\ndepth_mm = 3\nthread_depth_mm = 2",
            "p.toml:12:19: hole.thread_depth_mm must go with thread",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\nthread = \"M3\"\ndepth_mm = 2",
            "p.toml:11:12: hole.depth_mm must be at least 2.5, for one turn of M3 x 0.5",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\nthread = \"M3\"\ndepth_mm = 4\nthread_depth_mm = 4.5",
            "p.toml:12:19: hole.thread_depth_mm must be at most depth_mm = 4, found 4.5",
        ),
        (
            BORDERED,
            "at_mm = [[36, 0]]\nscrew = \"M3\"\ndepth_mm = 4",
            "p.toml:11:12: hole.depth_mm must be left out with screw",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\ndiameter_mm = 3\ndepth_mm = 4\ncounterbore_depth_mm = 1",
            "p.toml:12:24: hole.counterbore_depth_mm must go with counterbore_diameter_mm",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\ndiameter_mm = 3\ndepth_mm = 4\ncounterbore_depth_mm = 1\ncounterbore_diameter_mm = 3",
            "p.toml:13:27: hole.counterbore_diameter_mm must be more than the hole's diameter, 3, found 3",
        ),
        (
            PART,
            "at_mm = [[0, 0]]\ndiameter_mm = 3\ndepth_mm = 1\ncounterbore_depth_mm = 1\ncounterbore_diameter_mm = 5",
            "p.toml:11:12: hole.depth_mm must be at least 1.100",
        ),
        (
            PART,
            "at_mm = [[29, 0]]\ndiameter_mm = 3\ndepth_mm = 3",
            "p.toml:9:10: hole.at_mm must stay 0.1 mm clear of the part's side, found [29, 0, 3]",
        ),
        (
            PART,
            "at_mm = [[0, 0], [2, 1]]\ndiameter_mm = 3\ndepth_mm = 3",
            "p.toml:9:18: hole.at_mm must stay 0.1 mm clear of the hole [0, 0, 3]",
        ),
        (
            BORDERED,
            "at_mm = [[31, 0]]\ndiameter_mm = 3",
            "p.toml:9:10: hole.at_mm must stay 0.1 mm clear of the mirror, found [31, 0, 3]",
        ),
        (
            BORDERED,
            "at_mm = [[35, 0]]\nscrew = \"M6\"",
            "p.toml:9:10: hole.at_mm must stay 0.1 mm clear of the mirror, found [35, 0, 11]",
        ),
        (
            BORDERED,
            "at_mm = [[36, 0]]\nscrew = \"M5\"",
            "p.toml:9:10: the through hole at [36, 0] must leave 1 mm beside its mouths, found a counterbore 5.4 mm deep",
        ),
        (
            BORDERED,
            "at_mm = [[36, 0]]\nthread = \"M3\"\nthread_depth_mm = 4",
            "p.toml:9:10: the blind hole at [36, 0] must leave 1 mm under the flat rim, found -0.751 mm",
        ),
    ] {
        let found = refused(part, hole);
        let first = &found[0];
        assert!(found.len() == 1 && first.starts_with(expected), "{hole}: {found:#?}");
        assert!(first.contains("\n  hint: "), "{first}");
    }
}

/// The part that other programs are asked about.
#[test]
fn the_fixture_with_blind_holes_passes() {
    let source = unlimited(parsed(include_str!("../fixtures/drilled.toml")));
    let report = build(&source, folder().path(), &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    assert_eq!((report.holes.len(), report.solid.unwrap().check.euler), (6, 2));
}
