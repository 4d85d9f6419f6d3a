//! What the commands tell of obstacles, and which they refuse.

use super::{HYPERBOLIC, hidden_by, traced};
use crate::support::builds::{edited, folder, morion, parsed, save, told};
use crate::support::refused;
use morion::internals::num::{asin, atan, degrees};
use serde_json::Value;
use std::path::Path;

const LEGS: &str = "
[[obstacle]]
name = \"leg in the north\"
cylinder = { from_mm = [0, 16, -30], to_mm = [0, 16, 4], radius_mm = 1.5 }
[[obstacle]]
name = \"leg across the cut\"
cylinder = { from_mm = [0, -16, -30], to_mm = [0, -16, 4], radius_mm = 1 }
";

fn with_body() -> String {
    HYPERBOLIC.replace("distance_mm = 60", "distance_mm = 60, body_mm = [20, 20, 40]") + LEGS
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let arguments = [arguments, &["--format", "json", "--quiet"]].concat();
    let (code, out, err) = told(&morion(folder, &arguments));
    assert!(code < 2, "{arguments:?}: {err}");
    serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"))
}

#[test]
fn frame_tells_what_each_obstacle_hides() {
    let folder = folder();
    save(folder.path(), &with_body());
    let found = json(folder.path(), &["frame", "small.toml"]);
    let (design, ends) = traced(&parsed(&with_body()));
    let obstacles = found["obstacles"].as_array().unwrap();
    let names: Vec<&str> = obstacles.iter().map(|o| o["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["leg in the north", "leg across the cut", "camera body"]);
    // The pixels of the whole picture that are not aimed at the rim of the facets.
    let counts: Vec<u64> = obstacles.iter().map(|o| o["pixels"].as_u64().unwrap()).collect();
    for (number, count) in counts.iter().enumerate() {
        let all = ends.iter().filter(|end| hidden_by(end) == Some(number as u32)).count() as u64;
        assert!(*count <= all && *count * 20 > all * 19, "{count} of {all}");
    }
    assert_eq!(found["frame"]["lost"]["obstacle"].as_u64(), Some(counts.iter().sum()));
    // A leg hides asin(r / d) on both sides of its azimuth: a pixel of the rim is 1 / 120 radians, and facets turn rays
    // by less than half of that.
    let range = |k: usize| {
        let ranges = obstacles[k]["azimuth_deg"].as_array().unwrap();
        assert_eq!(ranges.len(), 1, "{ranges:?}");
        [0, 1].map(|end| ranges[0][end].as_f64().unwrap())
    };
    for (k, azimuth, radius) in [(0, 0.0, 1.5), (1, 180.0, 1.0)] {
        let half = degrees(asin(radius / 16.0));
        let [from, to] = range(k);
        for off in [from - (azimuth - half), (azimuth + half) - to] {
            assert!(off > -0.25 && off < 0.5, "{from} to {to}, not {azimuth} +- {half}");
        }
    }
    assert_eq!(range(2), [-180.0, 180.0]);
    let top = design.mounting.pupil_mm.unwrap()[2];
    assert!(top > 60.0);
    let lowest = obstacles[2]["elevation_deg"][0].as_f64().unwrap();
    // The corner of the body, 10 sqrt(2) mm from the axis, from the viewpoint 60 mm - 3.64 mm below: a pixel there is
    // tan(55 degrees) / (5 / 60) / 720 radians or 1.37 degrees, and centres are at most one and a half from a corner.
    let corner = 90.0 - degrees(atan(14.142 / 56.36));
    assert!(lowest > corner - 0.25 && lowest < corner + 2.06, "{lowest} for {corner}");
    let (_, text, _) = told(&morion(folder.path(), &["frame", "small.toml", "--quiet"]));
    for words in ["behind obstacles", "obstacle", "leg in the north: ", "camera body: "] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// Hidden pixels have no errors, and count as not filled.
#[test]
fn what_is_hidden_is_no_error_and_not_filled() {
    let folder = folder();
    let build = |text: &str| {
        save(folder.path(), text);
        json(folder.path(), &["build", "small.toml"])
    };
    let (free, hidden) = (build(HYPERBOLIC), build(&with_body()));
    let count = |report: &Value, key: &str| report["trace"][0][key].as_u64().unwrap_or(0);
    let frame = |report: &Value, key: &str| report["frame"]["lost"][key].as_u64().unwrap_or(0);
    assert_eq!(count(&free, "rays"), count(&hidden, "rays"));
    assert!(free["trace"][0].get("obstructed").is_none());
    assert!(free["frame"]["lost"].get("obstacle").is_none());
    let lost = count(&hidden, "obstructed");
    assert!(lost > 1000 && lost == frame(&hidden, "obstacle"), "{lost}");
    assert_eq!(count(&free, "hit"), count(&hidden, "hit") + lost);
    let filled = |report: &Value| report["frame"]["filled"].as_f64().unwrap() * 240.0 * 240.0;
    let less = filled(&free) - filled(&hidden);
    assert!((less - lost as f64).abs() < 20.0, "{less} for {lost}");
    let error = |report: &Value| report["trace"][0]["pixel_error_px"]["max"].as_f64().unwrap();
    assert!(error(&hidden) <= error(&free));
    assert_eq!((&free["verdict"], &hidden["verdict"]), (&"pass".into(), &"pass".into()));
    let file = json(folder.path(), &["verify", "out/small/mirror.stl", "--profile", "small.toml"]);
    assert_eq!((count(&file, "obstructed"), frame(&file, "obstacle")), (lost, lost));
    // Where more is asked for than obstacles leave, the reason names them, and its way out is one.
    let between = 0.5 * (filled(&free) + filled(&hidden)) / (240.0 * 240.0);
    let filling = format!("frame_filled = {between}");
    let asked = with_body().replace("frame_filled = 0.1", &filling);
    let failed = build(&asked);
    assert_eq!(failed["verdict"], "fail");
    let reason = failed["reasons"][0].to_string();
    assert!(reason.contains("are behind obstacles"), "{reason}");
    let (_, share) = reason.split_once("write frame_filled = ").unwrap();
    let share = share.split(' ').next().unwrap();
    let accepted = build(&asked.replace(&filling, &format!("frame_filled = {share}")));
    assert_eq!(accepted["verdict"], "pass", "{share}");
}

#[test]
fn pictures_show_obstacles_in_one_grey() {
    let folder = folder();
    save(folder.path(), &with_body());
    let (_, ends) = traced(&parsed(&with_body()));
    for smooth in [true, false] {
        let mut arguments = vec!["render", "small.toml", "--scene", "grid"];
        arguments.extend(smooth.then_some("--smooth"));
        let report = json(folder.path(), &arguments);
        let file = report["file"].as_str().unwrap();
        let bytes = std::fs::read(folder.path().join(file)).unwrap();
        let picture = image(&bytes);
        let is_grey = |k: usize| picture[3 * k..3 * k + 3] == [0x9a; 3];
        let (mut grey, mut hidden, mut both) = (0, 0, 0);
        for (k, end) in ends.iter().enumerate() {
            let is_hidden = hidden_by(end).is_some();
            grey += usize::from(is_grey(k));
            hidden += usize::from(is_hidden);
            both += usize::from(is_grey(k) && is_hidden);
        }
        // At the edges of what is hidden a pixel is grey in part.
        assert!(both * 10 > hidden * 7 && both * 50 > grey * 49, "{grey} {hidden} {both}");
    }
}

/// Red, green and blue of a PNG's pixels.
fn image(bytes: &[u8]) -> Vec<u8> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut out = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut out).unwrap();
    out
}

#[test]
fn obstacles_that_leave_no_picture_are_refused_at_their_place() {
    let folder = folder();
    let cases = [
        ("box = { centre_mm = [0, 0, 60], size_mm = [9, 9, 9] }", "the entrance pupil inside it"),
        (
            "cylinder = { from_mm = [0, 5, -9], to_mm = [0, 5, 9], radius_mm = 2 }",
            "the mirror's point (",
        ),
        ("box = { centre_mm = [0, 0, 40], size_mm = [40, 40, 5] }", "none that sees past it"),
    ];
    for (shape, words) in cases {
        let free = "[[obstacle]]\nbox = { centre_mm = [0, 0, -90], size_mm = [9, 9, 9] }\n";
        save(
            folder.path(),
            &format!("{HYPERBOLIC}{free}[[obstacle]]\nname = \"bad one\"\n{shape}\n"),
        );
        let words = ["small.toml:11:1: obstacle \"bad one\" must ", words, "hint: "];
        for command in [&["build"][..], &["frame"], &["render", "--scene", "grid", "--smooth"]] {
            refused(folder.path(), &[command, &["small.toml", "--quiet"]].concat(), &words);
        }
    }
    // Of a mirror that looks up alone a body may hide everything.
    let body = edited(
        HYPERBOLIC,
        &[
            ("distance_mm = 60", "distance_mm = 60, body_mm = [1e5, 1e5, 9]"),
            ("outer_polar_deg = 110", "outer_polar_deg = 80"),
        ],
    );
    save(folder.path(), &body);
    let words = ["small.toml:1:", "camera.pinhole.body_mm must leave a pixel free"];
    refused(folder.path(), &["build", "small.toml", "--quiet"], &words);
}

#[test]
fn an_stl_that_is_none_is_refused_at_its_place() {
    let folder = folder();
    save(folder.path(), &format!("{HYPERBOLIC}[[obstacle]]\nstl.file = \"data/bracket.stl\"\n"));
    let refuse = |words: &str| {
        let words = ["small.toml:10:12: obstacle.stl.file: ", words];
        refused(folder.path(), &["check", "small.toml"], &words);
    };
    refuse("cannot read");
    let path = folder.path().join("data/bracket.stl");
    std::fs::create_dir(folder.path().join("data")).unwrap();
    std::fs::write(&path, "solid bracket\n facet normal 0 0 1\n  outer loop\n").unwrap();
    refuse("data/bracket.stl: not a readable STL: ");
    std::fs::write(&path, "solid bracket\nendsolid bracket\n").unwrap();
    refuse("data/bracket.stl: the file holds no facets");
    let mut bytes = vec![0; 84 + 50];
    bytes[80] = 2;
    std::fs::write(&path, bytes).unwrap();
    refuse("data/bracket.stl: the STL says 2 facets");
}
