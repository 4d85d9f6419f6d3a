//! Pictures given as data: the same mirrors as by their laws, gaps, and what is refused.

use crate::support::builds::folder;
use morion::internals::design::{Design, design};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::optics::stereographic;
use morion::internals::pipeline::{Command, Silent, ToleranceOptions, build};
use morion::internals::profile::{NamedFiles, Profile, shipped};
use morion::internals::results::{BuildReport, Verdict};
use std::fmt::Write;

/// Unit directions, row by row from the upper left, of a picture of so many columns and rows that covers the frame of
/// `design`.
fn directions(design: &Design, [columns, rows]: [usize; 2]) -> Vec<[f64; 3]> {
    let view = design.view.as_ref().unwrap();
    let frame = design.camera.frame();
    let cell = frame.size() / DVec2::new(columns as f64, rows as f64);
    let direction = |k: usize| {
        let at = DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5) * cell;
        let image = DVec2::new(frame.min.x + at.x, frame.max.y - at.y);
        let sigma = view.projection.direction_of(image.to_array());
        stereographic::direction(sigma).to_array()
    };
    (0..columns * rows).map(direction).collect()
}

fn npy(columns: usize, vectors: &[[f64; 3]]) -> Vec<u8> {
    let shape = format!("({}, {columns}, 3)", vectors.len() / columns);
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(vectors.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// The text of a shipped profile, another picture in the place of its own.
fn with_projection(text: &str, projection: &str) -> String {
    let mut out = String::new();
    let mut is_projection = false;
    for line in text.lines() {
        if line.starts_with('[') {
            is_projection = line.starts_with("[projection");
        }
        if !is_projection {
            writeln!(out, "{line}").unwrap();
        }
    }
    format!("{out}\n[projection.map]\n{projection}\n")
}

fn parsed(text: &str, file: &[u8]) -> Result<Profile, String> {
    let read = |_: &str, _| Ok(file.to_vec());
    let files = NamedFiles { bytes: &read, ..NamedFiles::NONE };
    Profile::parse_with("m", "m.toml", text.as_bytes(), files).map_err(|found| found.to_string())
}

/// Largest difference of height over the part, mm.
fn apart(a: &Design, b: &Design) -> f64 {
    let area = a.mirror.outline.bounds();
    let height = |design: &Design, q: DVec2| {
        let mirror = &design.mirror;
        mirror.position(q, &mirror.at(q)).z
    };
    let places = (0..41 * 41).map(|k| {
        let share = DVec2::new(f64::from(k % 41), f64::from(k / 41)) / 40.0;
        area.min + share * area.size()
    });
    places.fold(0.0, |most, q| f64::max(most, (height(a, q) - height(b, q)).abs()))
}

/// A fisheye view behind a lens.
const LENS: &str =
    "camera.calibrated = { pixels = [640, 480], focal_px = [820, 818], principal_px = [331, 229], \
                    distortion = [-0.21, 0.05, 0.001, -0.0006], distance_mm = 150 }
[projection.fisheye]
hfov_deg = 70
law = \"equisolid\"
[layout.rectangle]
[method.vector-field]
degree = 12
[part]
width_mm = 100
base_mm = 5
[mesh]
facet_px = 1
[export]
formats = [\"stl\"]
";

/// The text of a shipped profile whose mirror ends before the frame: beyond it a law goes on, and a map need not.
fn narrow(name: &str) -> String {
    let text = shipped().iter().find(|profile| profile.name == name).unwrap().text;
    let line = text.lines().find(|line| line.starts_with("width_mm")).unwrap();
    text.replace(line, "width_mm = 40")
}

/// Views far away and of a near plane, behind a lens and not, on a mount and not: mirrors through maps are the same.
#[test]
fn a_law_through_a_map_is_itself() {
    for (name, text, target) in [
        ("driver", narrow("driver"), ""),
        ("floor", narrow("floor"), "target_plane_mm = 1050"),
        ("lens", LENS.to_owned(), ""),
    ] {
        let own = design(&Profile::parse(name, name, text.as_bytes()).unwrap()).unwrap();
        let size = own.camera.pixels.map(|n| n as usize);
        let file = npy(size[0], &directions(&own, size));
        let text = with_projection(&text, &format!("file = \"w.npy\"\n{target}"));
        let profile = parsed(&text, &file).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let by_map = design(&profile).unwrap();
        let off = apart(&own, &by_map);
        println!(
            "{name}: {off:e} mm, {:?} {:?}",
            by_map.facts.pixel_error_px, own.facts.pixel_error_px
        );
        assert!(off < 1e-9, "{name}: {off:e}");
    }
}

/// A view straight back by a small camera, as data with a change.
fn small(change: impl Fn(usize, &mut [f64; 3])) -> Vec<u8> {
    let mut vectors: Vec<[f64; 3]> = (0..40 * 30)
        .map(|k| {
            let [x, y] = [(k % 40) as f64 - 19.5, 14.5 - (k / 40) as f64].map(|x| 0.04 * x);
            let length = (x * x + y * y + 1.0).sqrt();
            [x / length, y / length, 1.0 / length]
        })
        .collect();
    vectors.iter_mut().enumerate().for_each(|(k, vector)| change(k, vector));
    npy(40, &vectors)
}

const SMALL: &str = "camera.pinhole = { pixels = [160, 120], hfov_deg = 30, distance_mm = 60 }
projection.map = { file = \"w.npy\" }
layout.rectangle = {}
method.vector-field.degree = 8
part = { width_mm = 32, base_mm = 3 }
mesh.facet_px = 1
export.formats = [\"stl\"]
";

/// Nothing is wanted of the middle and of a corner: their pixels have no errors and are not filled, and the others are
/// shown as before.
#[test]
fn gaps_in_a_map_are_left_out_of_the_picture() {
    let folder = folder();
    let built = |name: &str, file: &[u8]| {
        let mut profile = parsed(SMALL, file).unwrap();
        profile.name = name.to_owned();
        build(&profile, folder.path(), &Silent).unwrap()
    };
    let is_gap = |k: usize| {
        let (column, row) = (k % 40, k / 40);
        column < 8 && row < 6 || (15..25).contains(&column) && (10..20).contains(&row)
    };
    let gapped = |k: usize, vector: &mut [f64; 3]| {
        if is_gap(k) {
            *vector = [f64::NAN; 3];
        }
    };
    let (whole, gapped) = (built("whole", &small(|_, _| ())), built("gapped", &small(gapped)));
    let traced = |report: &BuildReport| report.trace[0].clone();
    // A sample covers 4 x 4 pixels; 148 of 1200 are gaps.
    let (all, some) = (traced(&whole), traced(&gapped));
    assert_eq!(all.rays, 160 * 120);
    assert_eq!(all.rays - some.rays, 148 * 16);
    assert_eq!(gapped.design.map.unwrap().gaps, 148.0 / 1200.0);
    // The mirror is exact here but for the interpolation beside a gap.
    for report in [&whole, &gapped] {
        let px = report.design.pixel_error_px.unwrap();
        assert!(px.rms < 0.005 && px.max < 0.2, "{px:?}");
        assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    }
    let filled = |report: &BuildReport| report.frame.as_ref().unwrap().filled;
    let lost = filled(&whole) - filled(&gapped);
    assert!((lost - 148.0 / 1200.0).abs() < 0.01, "{lost}");
}

#[test]
fn what_is_no_map_is_refused_at_its_place() {
    let refused = |text: &str, file: &[u8]| parsed(text, file).unwrap_err();
    let told = |text: &str, file: &[u8], wanted: &str| {
        let found = refused(text, file);
        assert!(found.contains(wanted), "{found}\n{wanted}");
    };
    // Degrees in the place of directions.
    let degrees = small(|_, v| *v = [v[0].to_degrees(), v[1].to_degrees(), 0.0]);
    told(
        SMALL,
        &degrees,
        "m.toml:2:27: projection.map.file: w.npy: row 1, column 1: a direction must have the length 1",
    );
    told(
        SMALL,
        &small(|k, v| {
            if k % 40 > 20 {
                v[0] = -v[0]
            }
        }),
        "the picture folds over there",
    );
    told(SMALL, &degrees[..999], "numbers of 8 bytes are 28800 bytes, found");
    told(SMALL, b"1 2 3\n", "w.npy: line 1: it must hold row, column, X, Y and Z, found 3 of them");
    let with = |more: &str| SMALL.replace("\"w.npy\" }", &format!("\"w.npy\", {more} }}"));
    told(&with("kind = \"angle\""), &degrees, "projection.map.kind must be");
    let points = small(|_, v| *v = v.map(|x| x * 500.0 / v[2]));
    told(&with("kind = \"point\""), &points, "must come with a target");
    let on = "kind = \"point\", target_plane_mm = ";
    assert_eq!(parsed(&with(&format!("{on}500")), &points).err(), None);
    told(
        &with(&format!("{on}501")),
        &points,
        "each point must be on the target, target_plane_mm = 501; found",
    );
    told(&with("target_plane_mm = -500"), &small(|_, _| ()), "each direction must meet the target");
    let strip = SMALL.replace("layout.rectangle", "layout.strip");
    told(
        &strip,
        &small(|_, _| ()),
        "layout must be [layout.rectangle] with [projection.map], found [layout.strip]",
    );
    let missing = SMALL.replace("file = \"w.npy\"", "");
    told(&missing, b"", "projection.map.file must be the name of a file, found nothing");
}

/// Each method makes the same mirror of a map as of the law that the map was made of.
#[test]
#[ignore = "long: .ci/nightly"]
fn every_method_makes_a_law_s_mirror_of_its_map() {
    let vector = "[method.vector-field]\ndegree = 12";
    for method in [
        "[method.fixed-surface]\ndegree = 10",
        "[method.distribution]\ndegree = 10",
        "[method.vector-field]\nminimax = true\ndegree = 8",
        "[method.fixed-surface]\nminimax = true\ndegree = 8",
        "[method.distribution]\nminimax = true\ndegree = 8",
    ] {
        let text = LENS.replace(vector, method);
        assert_ne!(text, LENS);
        let own = design(&Profile::parse("l", "l", text.as_bytes()).unwrap()).unwrap();
        let size = own.camera.pixels.map(|n| n as usize);
        let file = npy(size[0], &directions(&own, size));
        let text = with_projection(&text, "file = \"w.npy\"");
        let by_map = design(&parsed(&text, &file).unwrap()).unwrap();
        let off = apart(&own, &by_map);
        println!("{method}: {off:e} mm, {:?}", by_map.facts.pixel_error_px);
        assert!(off < 1e-7, "{method}: {off:e}");
    }
}

/// A view nearly straight back, and straight back: three quarters of the frame and one.
const PANELS: &str =
    "camera.pinhole = { pixels = [160, 120], hfov_deg = 30, distance_mm = 60, pupil_mm = 0.5 }
layout.rectangle = {}
method.vector-field.degree = 8
part = { width_mm = 32.2, base_mm = 3 }
mesh.facet_px = 1
export.formats = [\"stl\"]
accept = { pixel_error_rms_px = 1, pixel_error_max_px = 3 }
[[panel]]
columns = [0, 120]
rows = [0, 120]
VIEW
[[panel]]
columns = [120, 160]
rows = [0, 120]
centre_deg = [0, 90]
hfov_deg = 20
";
const VIEW: &str = "centre_deg = [-90, 80]\nhfov_deg = 30";

/// The directions of a panel between two columns of the frame, some of them gaps.
fn panel(
    own: &Design,
    [left, right]: [u32; 2],
    [columns, rows]: [usize; 2],
    is_gap: impl Fn(usize) -> bool,
) -> Vec<u8> {
    let view = own.view.as_ref().unwrap().of_panel(usize::from(left > 0));
    let direction = |k: usize| {
        let [across, down] = [k % columns, k / columns].map(|k| k as f64 + 0.5);
        let x = f64::from(left) + f64::from(right - left) * across / columns as f64;
        let y = 120.0 * down / rows as f64;
        let seen = view.direction_of(own.camera.image_point(x, y), DVec3::ZERO).to_array();
        if is_gap(k) { [f64::NAN; 3] } else { seen }
    };
    let vectors: Vec<[f64; 3]> = (0..columns * rows).map(direction).collect();
    npy(columns, &vectors)
}

/// One of two panels is given as data: the mirror is the same, and so is the other panel.
#[test]
fn a_panel_s_view_through_a_map_is_itself() {
    let text = PANELS.replace("VIEW", VIEW);
    let own = design(&Profile::parse("p", "p", text.as_bytes()).unwrap()).unwrap();
    let file = panel(&own, [0, 120], [480, 480], |_| false);
    let by_map = design(&parsed(&PANELS.replace("VIEW", "file = \"w.npy\""), &file).unwrap());
    let by_map = by_map.unwrap();
    let off = apart(&own, &by_map);
    println!("{off:e} mm, {:?}", by_map.facts.map);
    assert!(off < 1e-9, "{off:e}");
    assert_eq!(by_map.facts.map.unwrap().samples, [480, 480]);
}

/// Before a near wall too, and of a wall that its directions do not meet it is told where they are.
#[test]
fn a_panel_s_map_is_held_against_the_target() {
    let text = PANELS.replace("VIEW", VIEW);
    let own = design(&Profile::parse("p", "p", text.as_bytes()).unwrap()).unwrap();
    let file = panel(&own, [0, 120], [120, 120], |_| false);
    let at = |z: i32| {
        let target = format!("target.plane = {{ point_mm = [0, 0, {z}], normal = [0, 0, 1] }}\n");
        target + PANELS
    };
    let before =
        |z: i32| design(&parsed(&at(z).replace("VIEW", "file = \"w.npy\""), &file).unwrap());
    let by_view = Profile::parse("p", "p", at(400).replace("VIEW", VIEW).as_bytes()).unwrap();
    let off = apart(&before(400).unwrap(), &design(&by_view).unwrap());
    assert!(off < 1e-6, "{off:e}");
    let behind = parsed(&at(-400).replace("VIEW", "file = \"w.npy\""), &file).unwrap_err();
    let told =
        "panel[1].file: w.npy: row 1, column 1: each direction must meet the target, [target]";
    assert!(behind.contains(told), "{behind}");
}

/// Behind a lens that bends lines between panels both maps go on beyond their part of the frame: the part passes, and its picture is that of
/// the views that they were made of.
#[test]
fn panels_of_maps_behind_a_lens_have_the_picture_of_their_views() {
    let pinhole = PANELS.lines().next().unwrap();
    let lens = "camera.calibrated = { pixels = [160, 120], focal_px = [299, 299], principal_px = [83, 57], \
                distortion = [-0.3, 0.05, 0, 0], distance_mm = 60, pupil_mm = 0.5 }";
    let text = PANELS.replace(pinhole, lens).replace("VIEW", VIEW).replace("32.2", "34");
    let own = design(&Profile::parse("p", "p", text.as_bytes()).unwrap()).unwrap();
    let files = [[0, 120], [120, 160]].map(|columns| panel(&own, columns, [160, 240], |_| false));
    let text = text.replace(VIEW, "file = \"0\"");
    let text = text.replace("centre_deg = [0, 90]\nhfov_deg = 20", "file = \"1\"");
    let read = |named: &str, _| Ok(files[usize::from(named == "1")].clone());
    let named = NamedFiles { bytes: &read, ..NamedFiles::NONE };
    let profile = Profile::parse_with("maps", "maps.toml", text.as_bytes(), named);
    let profile = profile.unwrap_or_else(|error| panic!("{error}\n{text}"));
    let report = build(&profile, folder().path(), &Silent).unwrap();
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let bent = report.design.dividing_lines.unwrap().departure_px;
    assert!(bent > 0.1, "{bent}");
    let [by_map, by_view] =
        [report.design.pixel_error_px, own.facts.pixel_error_px].map(|px| px.unwrap().rms);
    assert!((by_map / by_view - 1.0).abs() < 0.01, "{by_map} px, of views {by_view}");
    assert_eq!(report.design.map.unwrap().samples, [160, 240]);
}

/// Nothing is wanted of gaps in a panel's map, and the part is made and passes; keys of a view beside a file are refused.
#[test]
fn gaps_in_a_panel_s_map_are_left_out_of_the_picture() {
    let text = PANELS.replace("VIEW", VIEW);
    let own = design(&Profile::parse("p", "p", text.as_bytes()).unwrap()).unwrap();
    let folder = folder();
    let by_map = PANELS.replace("VIEW", "file = \"w.npy\"");
    let built = |gap: bool| {
        let is_gap = |k: usize| gap && (10..20).contains(&(k % 60)) && (20..30).contains(&(k / 60));
        let mut profile = parsed(&by_map, &panel(&own, [0, 120], [60, 60], is_gap)).unwrap();
        profile.name = if gap { "gapped" } else { "whole" }.to_owned();
        build(&profile, folder.path(), &Silent).unwrap()
    };
    let [whole, gapped] = [false, true].map(built);
    for report in [&whole, &gapped] {
        assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    }
    // A sample covers 2 x 2 pixels.
    assert_eq!(whole.trace[0].rays - gapped.trace[0].rays, 400);
    assert_eq!(gapped.design.map.unwrap().gaps, 100.0 / 3600.0);

    let both = by_map.replace("file =", "hfov_deg = 40\nfile =");
    let found = parsed(&both, &panel(&own, [0, 120], [60, 60], |_| false)).unwrap_err();
    assert!(found.contains("panel[1].file must be alone, found a view's hfov_deg"), "{found}");
}

/// A tolerance study looks at the pixels of which something is wanted: their 95th percentile is no more than the largest error of the design there.
#[test]
fn a_tolerance_study_leaves_gaps_out() {
    let text = SMALL.to_owned() + "tolerance.reference = \"projection\"\n";
    let gapped = small(|k, vector| {
        if k % 40 < 14 {
            *vector = [f64::NAN; 3];
        }
    });
    let profile = parsed(&text, &gapped).unwrap();
    let own = design(&profile).unwrap().facts.pixel_error_px.unwrap();
    let trials = ToleranceOptions { range: 0..2, ..ToleranceOptions::default() };
    let nominal = trials.in_memory(&profile, &Silent).unwrap().0.study.nominal;
    assert!(nominal.p95_px < own.max, "{nominal:?} {own:?}");
    assert!((nominal.rms_px / own.rms - 1.0).abs() < 0.05, "{nominal:?} {own:?}");
}
