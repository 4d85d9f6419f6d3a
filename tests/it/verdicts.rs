//! Verdicts on mirrors that are sound parts and poor pictures, and the ways out that they name.

use crate::support::builds::{folder, parsed};
use morion::internals::pipeline::{Command, Silent, Verify, VerifyOptions, build};
use morion::internals::results::{BuildReport, PictureFault, ReasonKind, Verdict};

/// A lab's camera, of a third of its pixels: 12.5 mm over 3.45 um, 1920 x 1080.
const LAB: &str =
    "camera.pinhole = { pixels = [640, 360], lens_mm = 12.5, pixel_um = 10.35, distance_mm = 200 }";
const TURN: &str = "{ azimuth_deg = [-180, 180], elevation_deg = [-20, 20] }";

fn profile(camera: &str, projection: &str, layout: &str, width_mm: &str) -> String {
    format!(
        "{camera}\n{projection}\n{layout}\nmethod.vector-field.degree = 12\n\
         part = {{ width_mm = {width_mm}, base_mm = 5 }}\nmesh.max_triangles = 20000\n\
         export.formats = [\"obj\"]\n"
    )
}

fn built(text: &str) -> BuildReport {
    let source = parsed(text);
    build(&source, folder().path(), &Silent).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The first reason of a kind, in words.
fn of(report: &BuildReport, is_kind: fn(&ReasonKind) -> bool) -> Option<String> {
    let reason = report.reasons.iter().find(|reason| is_kind(&reason.kind));
    reason.map(ToString::to_string)
}

fn unfilled(kind: &ReasonKind) -> bool {
    matches!(kind, ReasonKind::Picture(PictureFault::FrameFilled { .. }))
}

fn off(kind: &ReasonKind) -> bool {
    matches!(kind, ReasonKind::Picture(PictureFault::PixelError { .. }))
}

/// The value after `key = ` in a reason.
fn told<'r>(reason: &'r str, key: &str) -> &'r str {
    let (_, rest) = reason.split_once(&format!("{key} = ")).unwrap_or_else(|| panic!("{reason}"));
    rest.split([',', ';', ' ']).next().unwrap()
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_mirror_too_small_for_its_camera_is_told_its_width() {
    let law = format!("projection.equirectangular = {TURN}");
    let report = built(&profile(LAB, &law, "layout.strip = {}", "40"));
    assert_eq!(report.verdict, Verdict::Fail);
    let reason = of(&report, unfilled).expect("little is filled");
    assert!(report.frame.as_ref().unwrap().filled < 0.05);
    assert!(
        reason.contains("10.000 % are usual (accept.frame_filled sets another share)"),
        "{reason}"
    );
    assert!(reason.contains("[layout.conquistador] folds the turn into the frame"), "{reason}");
    let width = told(&reason, "width_mm");
    // 640 * 10.35 um * 200 / 12.5.
    assert_eq!(width, "105.984");
    let wider = built(&profile(LAB, &law, "layout.strip = {}", width));
    assert!(of(&wider, unfilled).is_none(), "{:?}", wider.reasons);
    let folded = "layout.conquistador.fill_frame = true";
    let folded = built(&profile(LAB, &law, folded, width));
    assert!(of(&folded, unfilled).is_none(), "{:?}", folded.reasons);
    assert!(folded.frame.unwrap().filled > 0.995);
}

#[test]
#[ignore = "long: .ci/nightly"]
fn a_law_that_does_not_suit_is_told_what_the_best_one_leaves() {
    let range = "{ azimuth_deg = [-30, 30], elevation_deg = [32, 58] }";
    let camera = "camera.pinhole = { pixels = [640, 480], hfov_deg = 14.25, distance_mm = 600 }";
    let with = |law: &str| {
        built(&profile(camera, &format!("projection.{law} = {range}"), "layout.strip = {}", "150"))
    };
    let report = with("cylindrical");
    assert_eq!(report.verdict, Verdict::Fail);
    let reason = of(&report, off).expect("the picture is far off");
    assert!(
        reason.contains("over the 3.2 px that are usual, 0.5 % of the frame's width"),
        "{reason}"
    );
    let (_, rest) =
        reason.split_once("[projection.best] in the place of this law is off by ").unwrap();
    let found: f64 = rest.split(' ').next().unwrap().parse().unwrap();
    let best = with("best");
    assert_eq!(best.verdict, Verdict::Pass, "{:?}", best.reasons);
    let rms = best.design.pixel_error_px.unwrap().rms;
    assert!((rms - found).abs() < 6e-4 && rms < 0.5, "{rms} {found}");
}

/// Usual limits scale with the frame; those that a profile names are its own.
#[test]
fn limits_that_a_profile_names_take_the_place_of_the_usual_ones() {
    let law = "projection.cylindrical = { azimuth_deg = [-180, 180], elevation_deg = [-30, 30] }";
    let camera = "camera.orthographic.pixels = [320, 240]";
    let text = profile(camera, law, "layout.conquistador.fill_frame = true", "60");
    let report = built(&text);
    let accepted = report.accepted.unwrap();
    assert!(accepted.pixel_error_rms_px.usual && accepted.frame_filled.usual);
    assert_eq!(accepted.pixel_error_rms_px.value, 1.6);
    assert_eq!(accepted.pixel_error_max_px.value, 4.8);
    assert_eq!(accepted.frame_filled.value, 0.995);
    assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
    let named = built(&format!("{text}accept.pixel_error_rms_px = 0.1\n"));
    let accepted = named.accepted.unwrap();
    assert!(!accepted.pixel_error_rms_px.usual && accepted.pixel_error_max_px.usual);
    let reason = of(&named, off).expect("named");
    assert!(reason.contains("over the 0.1 px of accept.pixel_error_rms_px"), "{reason}");
}

/// A view with an exact mirror, of few pixels.
fn view(mesh: &str, degree: usize, accept: &str) -> String {
    format!(
        "camera.pinhole = {{ pixels = [96, 72], hfov_deg = 30, distance_mm = 120 }}\n\
         projection.perspective = {{ centre_deg = [0, 90], hfov_deg = 60 }}\nlayout.rectangle = {{}}\n\
         method.vector-field.degree = {degree}\npart = {{ width_mm = 64, base_mm = 3 }}\nmesh = {{ {mesh} }}\n\
         export.formats = [\"obj\"]\n{accept}"
    )
}

#[test]
fn facets_that_displace_the_picture_are_told_their_limit() {
    for mesh in ["facet_px = 3", "chord_um = 60", "max_triangles = 500"] {
        let report = built(&view(mesh, 10, ""));
        let reason = of(&report, off).unwrap_or_else(|| panic!("{mesh} passes"));
        assert!(reason.contains("its flat facets by the rest"), "{mesh}: {reason}");
        assert_eq!(
            reason.contains("in the place of max_triangles"),
            mesh.contains("max"),
            "{reason}"
        );
        let finer = built(&view(&format!("facet_px = {}", told(&reason, "facet_px")), 10, ""));
        assert_eq!(finer.verdict, Verdict::Pass, "{mesh}: {reason}; {:?}", finer.reasons);
    }
}

/// Limits that only a mesh keeps which is too large to be made: no key is told that would be refused.
#[test]
fn facets_too_fine_for_a_mesh_are_told_to_nobody() {
    let accept = "accept = { pixel_error_rms_px = 0.0015, pixel_error_max_px = 0.0045 }\n";
    let reason = of(&built(&view("facet_px = 1", 20, accept)), off).expect("facets displace it");
    assert!(!reason.contains("facet_px = "), "{reason}");
}

/// A file that is coarser than the profile asks for is told that, and no key that would change nothing.
#[test]
fn a_file_of_another_making_is_told_no_key() {
    let (coarse, folder) = (parsed(&view("facet_px = 3", 10, "")), folder());
    build(&coarse, folder.path(), &Silent).unwrap();
    let path = folder.path().join(&coarse.name).join("mirror.obj");
    let verify = Verify { path: &path, options: VerifyOptions::default() };
    let (found, _) = verify.in_memory(&parsed(&view("facet_px = 0.8", 10, "")), &Silent).unwrap();
    let reason = found.reasons.iter().find(|reason| off(&reason.kind)).expect("facets displace it");
    assert_eq!(reason.way_out, None);
}

#[test]
fn a_degree_that_is_too_low_is_told_a_higher_one() {
    let accept = "accept = { pixel_error_rms_px = 0.1, pixel_error_max_px = 0.3 }\n";
    let report = built(&view("facet_px = 0.1", 2, accept));
    let reason = of(&report, off).expect("a bowl of second degree is far off");
    let degree = told(&reason, "degree").parse().unwrap();
    let higher = built(&view("facet_px = 0.1", degree, accept));
    assert_eq!(higher.verdict, Verdict::Pass, "{reason}; {:?}", higher.reasons);
    assert!(higher.design.pixel_error_px.unwrap().rms < 0.1);
    // What facets leave no room for is not offered.
    let coarse = of(&built(&view("facet_px = 3", 2, accept)), off).unwrap();
    assert!(!coarse.contains("degree ="), "{coarse}");
}
