//! Perspective and fisheye views: where they are exact, what their least error is, and that the file shows them.

use morion::internals::design::{Design, design};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{cos, log, radians, sin};
use morion::internals::optics::stereographic;
use morion::internals::profile::Profile;

fn designed(text: &str) -> Design {
    let profile =
        Profile::parse("v", "v.toml", text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    design(&profile).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// A view of a pinhole camera with `frame_deg` across 640 x 480 pixels, 150 mm away.
fn view(mount: &str, projection: &str, degree: usize, width_mm: f64) -> Design {
    designed(&format!(
        "camera.pinhole = {{ pixels = [640, 480], hfov_deg = 24, distance_mm = 150 }}\n{mount}\n{projection}\n\
         layout.rectangle = {{}}\nmethod.vector-field.degree = {degree}\n\
         part = {{ width_mm = {width_mm}, base_mm = 5 }}\nmesh.facet_px = 1\nexport.formats = [\"stl\"]\n"
    ))
}

/// F = -log(n . d) for a flat mirror, whatever its pose: all its points lie in one plane, and the picture is exact.
#[test]
fn a_view_of_the_cameras_own_angle_is_a_flat_mirrors() {
    for (fold, towards, [azimuth, elevation], degree) in [
        (0.0, 0.0, [0.0, 90.0], 8),
        (0.0, 0.0, [40.0, 62.0], 22),
        (60.0, 90.0, [90.0, 30.0], 22),
        (60.0, 90.0, [77.0, 41.0], 26),
        (-70.0, 30.0, [215.0, 12.0], 26),
    ] {
        let mount = format!("mount = {{ fold_deg = {fold}, towards_deg = {towards} }}");
        let projection = format!(
            "projection.perspective = {{ hfov_deg = 24, centre_deg = [{azimuth}, {elevation}] }}"
        );
        let design = view(&mount, &projection, degree, 80.0);
        let ray = design.facts.ray_error_mrad.unwrap();
        assert!(ray.max < 1e-8, "{fold} {towards}: {ray:?}");
        // The plane's normal halves the angle between the camera and the middle of the view.
        let wanted = design.view.as_ref().unwrap().projection.direction_of([0.0; 2]);
        let normal = (stereographic::direction(wanted) + design.camera.axis()).normalize();
        let mirror = &design.mirror;
        let over = |q: DVec2| mirror.position(q, &mirror.at(q)).dot(normal);
        let middle = over(DVec2::ZERO);
        for k in 0..25 {
            let share = DVec2::new(f64::from(k % 5) - 2.0, f64::from(k / 5) - 2.0) / 2.0;
            let q = design.camera.picture.chart_point(share * design.camera.half_frame());
            if mirror.outline.contains(q) {
                let off = over(q) - middle;
                assert!(off.abs() < 1e-10, "{fold} {towards} at {q}: {off:e} mm");
            }
        }
    }
}

/// The closed form itself, in the camera's own chart: f = log(n . d) / k up to its mean.
#[test]
fn a_flat_mirrors_height_is_the_logarithm_of_its_depth() {
    let design =
        view("", "projection.perspective = { hfov_deg = 24, centre_deg = [0, 50] }", 26, 63.7);
    let half = radians(20.0);
    let normal = DVec3::new(0.0, sin(half), cos(half));
    let (k, mirror) = (design.camera.chart.vergence, &design.mirror);
    let f = |q: DVec2| log(normal.dot(DVec3::new(q.x * k, q.y * k, -1.0)).abs()) / k;
    let middle = mirror.surface.at(DVec2::ZERO).f - f(DVec2::ZERO);
    for (x, y) in [(30.0, 20.0), (-14.0, 22.0), (5.0, -23.0)] {
        let q = DVec2::new(x, y);
        let off = mirror.surface.at(q).f - middle - f(q);
        assert!(off.abs() < 1e-11, "{q}: {off:e}");
    }
}

#[test]
fn views_straight_back_are_exact() {
    for projection in [
        "projection.perspective = { hfov_deg = 70, centre_deg = [0, 90] }",
        "projection.fisheye = { hfov_deg = 110, centre_deg = [0, 90] }",
        "projection.fisheye = { law = \"equisolid\", hfov_deg = 110, centre_deg = [0, 90] }",
        "projection.fisheye = { law = \"stereographic\", hfov_deg = 110 }",
    ] {
        let design = view("", projection, 20, 63.7);
        let ray = design.facts.ray_error_mrad.unwrap();
        assert!(ray.max < 1e-6, "{projection}: {ray:?}");
    }
}

/// A saddle shows left and right as they are: for a small angle a hyperbolic paraboloid, exact under the
/// stereographic law and parallel rays.
#[test]
fn a_stereographic_view_that_is_not_mirrored_is_an_exact_saddle() {
    let design = designed(
        "camera.orthographic.pixels = [640, 480]\nlayout.rectangle = {}\n\
         projection.fisheye = { law = \"stereographic\", hfov_deg = 150, mirrored = false }\n\
         method.vector-field.degree = 6\npart = { width_mm = 60, base_mm = 5 }\nmesh.facet_px = 1\n\
         export.formats = [\"stl\"]\n",
    );
    assert!(design.facts.ray_error_mrad.unwrap().max < 1e-9);
    assert!(design.mirror.surface.hessian(DVec2::new(9.0, 4.0)).det() < 0.0);
}

/// 45 degrees for an eye with 17 by a fold of 60 degrees: the least-squares RMS of the ray error over the frame
/// is 5.785 mrad for degrees from 12 on, whatever the plane that the part is made on (found by an independent
/// program over image coordinates, on the camera's axis).
#[test]
fn the_drivers_view_has_the_least_ray_error_known() {
    let text = |mount: &str, centre: &str, width: f64| {
        format!(
            "camera.pinhole = {{ pixels = [1280, 768], hfov_deg = 17, distance_mm = 600 }}\n{mount}\n\
             projection.perspective = {{ hfov_deg = 45{centre} }}\nlayout.rectangle = {{}}\n\
             method.vector-field.degree = 14\npart = {{ width_mm = {width}, base_mm = 5 }}\nmesh.facet_px = 1\n\
             export.formats = [\"stl\"]\n"
        )
    };
    let on_axis = designed(&text("", ", centre_deg = [90, 30]", 179.3417));
    let folded = designed(&text("mount = { fold_deg = 60, towards_deg = 90 }", "", 229.0));
    let across = designed(&text(
        "mount = { fold_deg = 40, towards_deg = 90 }",
        ", centre_deg = [90, 30]",
        210.0,
    ));
    for design in [on_axis, folded, across] {
        let ray = design.facts.ray_error_mrad.unwrap();
        assert!((ray.rms - 5.785).abs() < 0.002, "{ray:?}");
        assert!((ray.max - 14.6).abs() < 0.1, "{ray:?}");
    }
}

/// A strip under a camera of these keys.
fn strip(camera: &str) -> Design {
    designed(&format!(
        "{camera}\nprojection.equirectangular = {{ azimuth_deg = [-70, 70], elevation_deg = [-25, 25] }}\n\
         layout.strip = {{}}\nmethod.vector-field.degree = 14\n\
         part = {{ width_mm = 60, base_mm = 5 }}\nmesh.facet_px = 1\nexport.formats = [\"stl\"]\n"
    ))
}

#[test]
fn a_calibrated_camera_without_distortion_is_a_pinhole() {
    let pinhole =
        strip("camera.pinhole = { pixels = [640, 480], focal_px = 900, distance_mm = 120 }");
    let calibrated = strip(
        "camera.calibrated = { pixels = [640, 480], focal_px = [900, 900], principal_px = [319.5, 239.5], \
         distance_mm = 120 }",
    );
    // The fit's places differ: the exact mirror of the least squares is one.
    for (x, y) in [(0.0, 0.0), (25.0, 9.0), (-14.0, -10.0), (29.0, -11.0)] {
        let q = DVec2::new(x, y);
        let off = pinhole.mirror.surface.at(q).f - calibrated.mirror.surface.at(q).f;
        assert!(off.abs() < 1e-9, "{q}: {off:e}");
    }
    let [a, b] = [&pinhole, &calibrated].map(|design| design.facts.pixel_error_px.unwrap());
    assert!((a.rms - b.rms).abs() < 1e-3 * a.rms, "{a:?} {b:?}");
}

/// The mirror compensates the lens: the picture is off by half a pixel as through a lens without distortion (what no
/// mirror shows exactly differs a little), where a lens that is not compensated shifts it by many pixels.
#[test]
fn the_mirror_makes_up_for_the_lens() {
    let camera = |distortion: &str| {
        format!(
            "camera.calibrated = {{ pixels = [640, 480], focal_px = [900, 904], principal_px = [328.1, 233.7], \
             distance_mm = 120{distortion} }}"
        )
    };
    let plain = strip(&camera(""));
    let bent = strip(&camera(", distortion = [-0.31, 0.14, 0.0011, -0.0006, -0.02]"));
    let [a, b] = [&plain, &bent].map(|design| design.facts.pixel_error_px.unwrap());
    assert!(a.rms < 0.6 && b.rms < 0.6, "{a:?} {b:?}");
    // A corner of the picture through both lenses.
    let corner = bent.camera.half_frame() * DVec2::new(0.98, 0.5);
    let [straight, through] =
        [&plain, &bent].map(|design| design.camera.picture.chart_point(corner));
    assert!((straight - through).length() > 5.0 * bent.camera.pixel_mm);
}
