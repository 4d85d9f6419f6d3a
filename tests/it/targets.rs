//! Target surfaces in any pose: where a mirror for them is known, and that the file shows them.

use crate::support::builds::folder;
use crate::support::share;
use morion::internals::design::{Design, DesignError, FailureCause, LocalFailure, design};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{atan, cos, degrees, radians, sin};
use morion::internals::optics::reflect;
use morion::internals::pipeline::{Silent, build};
use morion::internals::profile::{Profile, shipped};
use morion::internals::results::{BuildReport, Verdict};

/// Surfaces in sight of a mirror that looks up along Z, or, folded, to the side.
const SURFACES: [&str; 6] = [
    "target.plane = { point_mm = [0, 30, 400], normal = [0.3, -0.2, 1]",
    "target.plane = { point_mm = [50, 0, 700], normal = [0.1, 0.4, -1]",
    "target.sphere = { centre_mm = [20, -35, 90], radius_mm = 400",
    "target.sphere = { centre_mm = [10, 25, 900], radius_mm = 700",
    "target.cylinder = { point_mm = [0, 9, 50], axis = [3, 1, 0.2], radius_mm = 500",
    "target.cylinder = { point_mm = [0, 40, 900], axis = [3, 1, 0.2], radius_mm = 700",
];

fn parsed(text: &str) -> Profile {
    Profile::parse("t", "t.toml", text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn designed(text: &str) -> Design {
    design(&parsed(text)).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A view of a pinhole camera with 24 degrees across 640 x 480 pixels, 150 mm away.
fn view(rest: &str, degree: usize) -> String {
    format!(
        "camera.pinhole = {{ pixels = [640, 480], hfov_deg = 24, distance_mm = 150 }}\n{rest}\n\
         layout.rectangle = {{}}\nmethod.vector-field.degree = {degree}\n\
         part = {{ width_mm = 70, base_mm = 5 }}\nmesh.facet_px = 1\nexport.formats = [\"stl\"]\n"
    )
}

/// What a camera sees in a flat mirror is what it would see from behind it: from there the picture of any surface
/// is in perspective, and the flat mirror exact.
#[test]
fn from_behind_a_flat_mirror_every_surface_is_in_perspective() {
    for (fold, towards) in [(0.0, 0.0), (20.0, 90.0), (-12.0, 30.0)] {
        let tilt = radians(0.5 * fold);
        let [s, c] = [sin(radians(towards)), cos(radians(towards))];
        // The camera is folded away from where the view is folded to.
        let pupil = 150.0 * DVec3::new(-s * sin(tilt), -c * sin(tilt), cos(tilt));
        for surface in SURFACES {
            let mount = format!("mount = {{ fold_deg = {fold}, towards_deg = {towards} }}");
            let viewpoint = [pupil.x, pupil.y, -pupil.z];
            let rest = format!(
                "{mount}\nprojection.perspective.hfov_deg = 24\n{surface}, viewpoint_mm = {viewpoint:?} }}"
            );
            let design = designed(&view(&rest, 8));
            let mirror = &design.mirror;
            let seen = design.camera.chart.pupil().unwrap();
            let middle = design.view.as_ref().unwrap().origin_mm;
            assert!((seen - DVec3::Z * middle).distance(pupil) < 1e-9, "{seen}");
            let ray = design.facts.ray_error_mrad.unwrap();
            assert!(ray.max < 1e-9, "{rest}: {ray:?}");
            for k in 0..25 {
                let share = DVec2::new(f64::from(k % 5), f64::from(k / 5)) / 4.0;
                let area = mirror.outline.bounds();
                let q = area.min + share * area.size();
                let off = mirror.position(q, &mirror.at(q)).z - middle;
                assert!(off.abs() < 1e-9, "{rest} at {q}: {off:e} mm");
            }
        }
    }
}

/// From another viewpoint no surface is shown without error, and the viewpoint counts.
#[test]
fn surfaces_and_viewpoints_differ() {
    let error = |target: &str| {
        let rest = format!("projection.perspective.hfov_deg = 30\n{target}");
        let report = designed(&view(&rest, 10)).facts;
        report.ray_error_mrad.unwrap().max
    };
    for surface in SURFACES {
        let [here, there] =
            ["", ", viewpoint_mm = [0, 40, -20]"].map(|v| error(&format!("{surface}{v} }}")));
        assert!(here > 0.0 && there > 0.1, "{surface}: {here} {there}");
        assert!((here - there).abs() > 1e-3, "{surface}: {here} {there}");
    }
}

/// The plane across the axis and the cylinder about it make the mirrors that their own keys make.
#[test]
fn surfaces_about_the_axis_are_those_of_the_projections_own_keys() {
    for (keys, target, layout) in [
        (
            "projection.perspective = { hfov_deg = 60, target_plane_mm = 300 }",
            "projection.perspective.hfov_deg = 60\n\
             target.plane = { point_mm = [70, 3, 300], normal = [0, 0, -2] }",
            "rectangle",
        ),
        (
            "projection.equirectangular = { azimuth_deg = [-60, 90], elevation_deg = [-20, 20], \
             target_radius_mm = 200 }",
            "projection.equirectangular = { azimuth_deg = [-60, 90], elevation_deg = [-20, 20] }\n\
             target.cylinder = { point_mm = [0, 0, 8], axis = [0, 0, 1], radius_mm = 200 }",
            "strip",
        ),
    ] {
        let [own, posed] =
            [keys, target].map(|rest| designed(&view(rest, 10).replace("rectangle", layout)));
        let area = own.mirror.outline.bounds();
        for k in 0..81 {
            let share = DVec2::new(f64::from(k % 9), f64::from(k / 9)) / 8.0;
            let q = area.min + share * area.size();
            let [a, b] = [&own, &posed].map(|design| design.mirror.at(q).f);
            assert!((a - b).abs() < 1e-9, "{layout} at {q}: {a} {b}");
        }
    }
}

/// The dome's picture by vectors alone: the angle between what a pixel shows on the dome and what it should, from the
/// seat.
#[test]
fn the_dome_shows_its_picture_as_far_off_as_the_report_says() {
    let text = shipped().iter().find(|shipped| shipped.name == "dome").unwrap().text;
    let design = designed(text);
    let middle = DVec3::Z * design.view.as_ref().unwrap().origin_mm;
    let tilt = radians(22.5);
    let zenith = DVec3::new(0.0, sin(tilt), cos(tilt));
    let (right, up) = (DVec3::X, DVec3::new(0.0, cos(tilt), -sin(tilt)));
    let (centre, seat) = (DVec3::new(0.0, 115.0, 277.0), DVec3::new(0.0, 459.0, 1109.0));
    // Equidistant: 100 degrees across 1280 pixels.
    let radians_per_px = radians(100.0) / 1280.0;
    let pixel_mm = design.camera.pixel_mm;
    let (mirror, pupil) = (&design.mirror, design.camera.chart.pupil().unwrap());
    let (mut sum, mut most, mut count) = (0.0, 0.0f64, 0);
    for k in 0..60 * 40 {
        // In the middles of as many parts of the frame.
        let part = DVec2::new(f64::from(k % 60) + 0.5, f64::from(k / 60) + 0.5);
        let image = (part / DVec2::new(30.0, 20.0) - 1.0) * design.camera.half_frame();
        let q = design.camera.picture.chart_point(image);
        let point = mirror.at(q);
        let at = mirror.position(q, &point);
        let slope = mirror.slope(q, &point);
        let seen = reflect((at - pupil).normalize(), DVec3::new(-slope.x, -slope.y, 1.0));
        // Out to the dome, from inside.
        let from = at - middle - centre;
        let b = from.dot(seen);
        let way = -b + (b * b + 2500.0 * 2500.0 - from.length_squared()).sqrt();
        let shown = (at - middle + seen * way - seat).normalize();
        // Where the picture has that direction, px from its middle.
        let [x, y, z] = [right, up, zenith].map(|axis| shown.dot(axis));
        let across = DVec2::new(x, y);
        let angle = 2.0 * atan(across.length() / (1.0 + z));
        let place = across.normalize() * angle / radians_per_px;
        let off = place.distance(image / pixel_mm);
        (sum, most, count) = (sum + off * off, most.max(off), count + 1);
    }
    let rms = (sum / f64::from(count)).sqrt();
    let said = design.facts.pixel_error_px.unwrap();
    println!("{rms} px RMS, {most} px of {said:?}, {:.1} deg up", degrees(tilt));
    assert!((rms / said.rms - 1.0).abs() < 0.02, "{rms} {said:?}");
    assert!(most <= said.max * (1.0 + 1e-9) && most > 0.9 * said.max, "{most} {said:?}");
}

/// Mesh, witness and STEP: of a sphere from inside and a cylinder from outside, and of all in a long run.
#[test]
#[ignore = "long: .ci/nightly"]
fn files_show_every_kind_of_surface() {
    for surface in share(3, 2, SURFACES) {
        let rest = format!(
            "projection.perspective.hfov_deg = 40\n{surface}, viewpoint_mm = [5, -9, -60] }}"
        );
        let text = view(&rest, 10).replace("\"stl\"", "\"stl\", \"step\"");
        let folder = folder();
        let report: BuildReport = build(&parsed(&text), folder.path(), &Silent).unwrap();
        assert_eq!(report.verdict, Verdict::Pass, "{surface}: {:?}", report.reasons);
        let errors = &report.trace[0].errors;
        let (facet, pixel) = (errors.facet_error_px.unwrap(), errors.pixel_error_px.unwrap());
        assert!(facet.max > 0.8 && facet.max <= 1.0, "{surface}: {facet:?}");
        let designed = report.design.pixel_error_px.unwrap();
        assert!((pixel.max - designed.max).abs() <= 1.0, "{surface}: {pixel:?} {designed:?}");
    }
}

#[test]
fn what_never_meets_the_surface_is_named() {
    let cause = |target: &str, degree: usize| {
        let rest = format!("projection.perspective.hfov_deg = 60\n{target}");
        match design(&parsed(&view(&rest, degree))) {
            Err(DesignError::Unsolved { cause, .. }) => cause,
            other => panic!("{target}: {other:?}"),
        }
    };
    for target in [
        "target.plane = { point_mm = [0, 0, 500], normal = [1, 0, 0.3] }",
        "target.sphere = { centre_mm = [0, 0, 800], radius_mm = 300 }",
        "target.cylinder = { point_mm = [0, 0, 800], axis = [0, 1, 0], radius_mm = 300 }",
    ] {
        let cause = cause(target, 6);
        let failure = LocalFailure::WantedMissesTarget { angles_deg: [0.0; 2] };
        let FailureCause::At { failure: found, .. } = &cause else { panic!("{cause}") };
        assert_eq!(std::mem::discriminant(found), std::mem::discriminant(&failure), "{cause}");
    }
    let through = cause("target.sphere = { centre_mm = [0, 0, 59], radius_mm = 60 }", 6);
    let failure = LocalFailure::ThroughTarget;
    assert!(through.to_string().contains(&failure.to_string()), "{through}");
}
