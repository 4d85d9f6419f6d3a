//! Lines of the terminal: they keep to its width, the plain facts first.

use crate::support::builds::{SMALL, command, folder, save, told};
use crate::support::shipped_builds;
use morion::internals::profile::shipped;
use morion::internals::report::{Answer, TextLayout};
use std::path::Path;

const COLUMNS: usize = 80;

#[track_caller]
fn fits(text: &str, what: &str) {
    for line in text.lines() {
        assert!(line.chars().count() <= COLUMNS, "{what}: {line:?}");
    }
}

/// What a command prints on both streams of a terminal of [`COLUMNS`] columns.
#[track_caller]
fn printed(folder: &Path, arguments: &str) -> [String; 2] {
    let mut command = command(folder);
    command.env("COLUMNS", COLUMNS.to_string()).args(arguments.split(' '));
    let (_, out, err) = told(&command.output().expect("the program starts"));
    [out, err]
}

#[test]
fn summaries_of_shipped_profiles_fit_a_terminal() {
    for shipped in shipped() {
        let report = shipped_builds::report(shipped.name);
        for details in [false, true] {
            let folder = Some("out/of-a-long-name");
            let layout = TextLayout { columns: Some(COLUMNS), details, folder };
            fits(&report.laid_out(&layout), shipped.name);
        }
    }
}

#[test]
fn pages_say_what_each_figure_means() {
    for shipped in shipped() {
        let page = shipped_builds::folder().join(shipped.name).join("report.html");
        let page = std::fs::read_to_string(page).unwrap();
        let rows: Vec<&str> =
            page.split("<tr>").filter(|row| row.contains("class=\"meaning\"")).collect();
        assert!(rows.len() > 10, "{}: {} rows", shipped.name, rows.len());
        let is_silent = |row: &&str| row.contains("meaning\"></td>");
        let silent: Vec<&str> = rows.into_iter().filter(is_silent).collect();
        assert!(silent.is_empty(), "{}: {silent:?}", shipped.name);
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn every_command_fits_a_terminal() {
    let folder = folder();
    save(folder.path(), SMALL);
    let study = "profile = 'small.toml'\n[[axis]]\nkey = 'part.width_mm'\nvalues = [10, -1, 15]\n\
                 [[column]]\nkey = 'design.pixel_error_px.rms'\ngoal = 'least'\n";
    std::fs::write(folder.path().join("study.toml"), study).unwrap();
    std::fs::write(folder.path().join("faulty.toml"), "[part]\nwidth = 3\nholes_mm = [[1, 2]]\n")
        .unwrap();
    for arguments in [
        "build faulty.toml",
        "build small.toml",
        "build small.toml --force --verbose",
        "build small.toml --dry-run",
        "build cylinder robot-floor --dry-run",
        "check small.toml",
        "verify out/small/mirror.stl --profile small.toml -v",
        "verify out/small/mirror.stl --profile small.toml --align -v",
        "render small.toml --scene errors",
        "unwrap out/small/preview.png --profile small.toml",
        "unwrap out/small/preview.png --profile small.toml --ground -40 --range-mm 200",
        "unwrap out/small/preview.png --profile small.toml --view -150,10,60 --map npy",
        "frame small.toml -v",
        "blur small.toml --na 0.002 -v",
        "blur webcam",
        "tolerance small.toml --trials 30 -v",
        "tolerance small.toml --trials 30 --replay 2",
        "machining small.toml --ball-mm 1 -v",
        "program small.toml -v",
        "table small.toml --floor-mm -40 -v",
        "drawing small.toml -v",
        "inspect small.toml -v",
        "verify out/small/inspection.csv --profile small.toml --align -v",
        "sweep study.toml",
        "sweep study.toml --shard 1/2",
        "sweep no-such-study",
        "profiles",
        "build no-such-profile",
        "render small.toml --scene no-such-scene",
    ] {
        let [out, err] = printed(folder.path(), arguments);
        assert!(!(out.is_empty() && err.is_empty()), "{arguments}");
        fits(&out, arguments);
        fits(&err, arguments);
    }
}

#[test]
fn details_are_for_those_who_ask_and_the_picture_is_for_all() {
    let folder = folder();
    save(folder.path(), SMALL);
    let [plain, _] = printed(folder.path(), "build small.toml");
    let [all, _] = printed(folder.path(), "build small.toml --force -v");
    let places =
        ["  part  ", "  camera  ", "  picture  off by ", "  file  ", "  folder   out/small\n"];
    let places = places.map(|row| plain.find(row).unwrap_or_else(|| panic!("{row}: {plain}")));
    assert!(places.is_sorted(), "{plain}");
    for detail in ["  design  ", "  mesh  ", "  witness  "] {
        assert!(!plain.contains(detail) && all.contains(detail), "{detail}: {plain}{all}");
    }
    assert!(plain.contains("360 deg around"), "{plain}");
}
