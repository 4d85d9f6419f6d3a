//! Perspective and fisheye views: where they are exact, what their least error is, and that the file shows them.

use crate::support::builds::folder;
use morion::internals::design::{Design, design};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{cos, log, radians, sin, tan};
use morion::internals::optics::{ThinnedFrame, stereographic};
use morion::internals::pipeline::{Silent, build};
use morion::internals::profile::{Profile, shipped};
use morion::internals::render::pixel_errors;
use morion::internals::report::design_error_map;

fn designed(text: &str) -> Design {
    let profile =
        Profile::parse("v", "v.toml", text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    design(&profile).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Largest departure of straight lines from straight in the picture.
fn departure_px(design: &Design) -> f64 {
    design.facts.straightness.unwrap().departure_px
}

/// A view of a pinhole camera with `frame_deg` across 640 x 480 pixels, 150 mm away.
fn view(mount: &str, projection: &str, degree: usize, width_mm: f64) -> Design {
    designed(&format!(
        "camera.pinhole = {{ pixels = [640, 480], hfov_deg = 24, distance_mm = 150 }}\n{mount}\n{projection}\n\
         layout.rectangle = {{}}\nmethod.vector-field.degree = {degree}\n\
         part = {{ width_mm = {width_mm}, base_mm = 5 }}\nmesh.facet_px = 1\nexport.formats = [\"stl\"]\n"
    ))
}

/// What is even in X or in Y is solved for by even functions alone: so is a view turned by a billionth of a degree, by all of them.
#[test]
fn a_mirror_is_even_wherever_picture_and_world_are() {
    let floor = "projection.perspective = { hfov_deg = 100, centre_deg = [0, 90], target_plane_mm = 900, roll_deg = ROLL }";
    let aside = "projection.perspective = { hfov_deg = 45, roll_deg = ROLL }";
    let fisheye = "projection.fisheye = { law = \"equidistant\", hfov_deg = 80, centre_deg = [180, 35], roll_deg = ROLL }";
    for (mount, projection, symmetric) in [
        ("", floor, [true; 2]),
        ("", fisheye, [true, false]),
        ("mount = { fold_deg = 60, towards_deg = 90 }", aside, [false, true]),
        ("mount = { fold_deg = 60 }", aside, [true, false]),
        ("mount = { fold_deg = 60, towards_deg = 45 }", aside, [false; 2]),
    ] {
        let [even, all] =
            ["0", "1e-9"].map(|roll| view(mount, &projection.replace("ROLL", roll), 12, 70.0));
        assert_eq!(even.mirror.mirror_symmetric, symmetric, "{mount} {projection}");
        assert_eq!(all.mirror.mirror_symmetric, [false; 2]);
        let bounds = even.mirror.outline.bounds();
        for k in 0..81 {
            let share = DVec2::new(f64::from(k % 9), f64::from(k / 9)) / 8.0;
            let q = bounds.min + share * bounds.size();
            let [a, b] = [&even, &all].map(|design| design.mirror.at(q));
            let off = (a.f - b.f).abs().max((a.slope - b.slope).length());
            assert!(off < 1e-8, "{mount} {projection} at {q}: {off:e}");
        }
    }
}

/// F = -log(n . d) for a flat mirror, whatever its pose: all its points lie in one plane, and the picture is exact.
#[test]
#[ignore = "long: .ci/nightly"]
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
        assert!(departure_px(&design) < 1e-7, "{fold} {towards}: {:?}", design.facts);
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
        // A perspective picture keeps lines straight; a fisheye is not held to that.
        let is_perspective = projection.contains("perspective");
        assert_eq!(design.facts.straightness.is_some(), is_perspective, "{projection}");
        assert!(!is_perspective || departure_px(&design) < 1e-5, "{:?}", design.facts);
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

/// The shipped view of that name.
fn shipped_view(name: &str) -> Design {
    let text = shipped().iter().find(|shipped| shipped.name == name).unwrap().text;
    designed(text)
}

/// The driver's picture by vectors alone: the unit direction that is seen at an image point in mm; none off the mirror
/// and beyond the frame.
struct DriversEye {
    design: Design,
    /// The world's directions to the right, upwards and to the middle in the wanted picture: those of the camera
    /// after reflection in a flat part.
    world: [DVec3; 3],
    /// Tangent of half the angle of view, in half the frame's width.
    tangent_per_mm: f64,
}

impl DriversEye {
    fn new() -> Self {
        let design = shipped_view("driver");
        let half_fold = radians(30.0);
        let axis = DVec3::new(-sin(half_fold), 0.0, cos(half_fold));
        let right = DVec3::new(cos(half_fold), 0.0, sin(half_fold));
        let world = [right, DVec3::Y, -axis].map(|d| d * DVec3::new(1.0, 1.0, -1.0));
        let half_mm = 320.0 * design.camera.pixel_mm;
        Self { design, world, tangent_per_mm: tan(radians(22.5)) / half_mm }
    }

    /// The direction that is wanted at an image point, not of unit length.
    fn wanted(&self, image: DVec2) -> DVec3 {
        let [right, up, middle] = self.world;
        middle + (right * image.x + up * image.y) * self.tangent_per_mm
    }

    /// The direction seen, by the law of reflection, and whether the place is on the mirror and in the frame.
    fn seen(&self, image: DVec2) -> (DVec3, bool) {
        let Design { camera, mirror, .. } = &self.design;
        let q = camera.picture.chart_point(image);
        let point = mirror.at(q);
        let normal = mirror.normal(q, &point).normalize();
        let arriving = mirror.position(q, &point) - camera.chart.pupil().unwrap();
        let seen = arriving - 2.0 * arriving.dot(normal) * normal;
        (seen.normalize(), mirror.outline.contains(q) && camera.frames(image))
    }

    /// Where a point of a world line is seen: on the plane through the line and the eye, and on one across it. By
    /// secants from a small triangle of image points.
    fn place_of(&self, plane: DVec3, across: DVec3, near: DVec2) -> Option<DVec2> {
        let off = |image: DVec2| {
            let (seen, _) = self.seen(image);
            DVec2::new(seen.dot(plane), seen.dot(across))
        };
        let (step, mut image) = (1e-3, near);
        for _ in 0..12 {
            let here = off(image);
            let [along, up] = [DVec2::X, DVec2::Y].map(|d| (off(image + d * step) - here) / step);
            let size = along.perp_dot(up);
            image -= DVec2::new(here.perp_dot(up), along.perp_dot(here)) / size;
        }
        assert!(off(image).length() < 1e-12, "{near}: {}", off(image));
        self.seen(image).1.then_some(image)
    }

    /// The largest distance of the image of a world line from the chord through the ends of what is seen of it, px.
    fn departure_px(&self, [first, last]: [DVec2; 2]) -> Option<f64> {
        // Points of a line in space.
        let [a, b] = [first, last].map(|end| self.wanted(end));
        let plane = a.cross(b).normalize();
        let place = |k: usize| {
            let share = k as f64 / 32.0;
            let across = plane.cross(a.lerp(b, share)).normalize();
            self.place_of(plane, across, first.lerp(last, share))
        };
        let places: Vec<DVec2> = (0..33).filter_map(place).collect();
        let (from, to) = (*places.first()?, *places.last()?);
        let distance = |at: &DVec2| (to - from).perp_dot(*at - from).abs() / (to - from).length();
        let largest = places.iter().map(distance).reduce(f64::max);
        Some(largest? / self.design.camera.pixel_mm)
    }
}

/// The world lines' images are traced anew by the law of reflection and planes through the eye. Where pixels are off by
/// e at most, lines lie in bands 2 e wide, and so do their chords.
#[test]
fn the_drivers_lines_are_as_straight_as_world_lines_that_are_traced() {
    let eye = DriversEye::new();
    let half = eye.design.camera.half_frame();
    let shares = (0..9).map(|k| 0.25 * f64::from(k) - 1.0);
    let lines = shares.flat_map(|at| {
        [[-1.0, 1.0].map(|end| DVec2::new(end, at)), [-1.0, 1.0].map(|end| DVec2::new(at, end))]
    });
    let diagonals = [-1.0, 1.0].map(|up| [DVec2::new(-1.0, -up), DVec2::new(1.0, up)]);
    let traced = lines.chain(diagonals).map(|ends| eye.departure_px(ends.map(|end| end * half)));
    let largest = traced.flatten().fold(0.0, f64::max);
    let found = eye.design.facts.straightness.unwrap();
    assert!((found.departure_px - largest).abs() < 1e-6, "{found:?} {largest}");
    assert!((found.departure_percent - largest / 6.4).abs() < 1e-6, "{found:?}");
    let error = eye.design.facts.pixel_error_px.unwrap();
    assert!(found.departure_px > 0.1 * error.max && found.departure_px < 2.0 * error.max);
}

/// Wanted is a perspective picture in raw pixels: the lens's own bend, some 20 px at the edges, is not in it.
#[test]
fn a_view_through_a_lens_is_as_straight_as_through_none() {
    let through = |distortion: &str| {
        let camera = format!(
            "camera.calibrated = {{ pixels = [640, 480], focal_px = [900, 904], principal_px = [328.1, 233.7], \
             distance_mm = 120{distortion} }}"
        );
        designed(&format!(
            "{camera}\nprojection.perspective = {{ hfov_deg = 60, centre_deg = [0, 90] }}\n\
             layout.rectangle = {{}}\nmethod.vector-field.degree = 20\n\
             part = {{ width_mm = 92, base_mm = 5 }}\nmesh.facet_px = 1\nexport.formats = [\"stl\"]\n"
        ))
    };
    let plain = departure_px(&through(""));
    let bent = departure_px(&through(", distortion = [-0.31, 0.14, 0.0011, -0.0006, -0.02]"));
    assert!(plain < 1.0 && bent < 1.0, "{plain} {bent}");
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

/// Under a camera beside the axis too, each pixel of a strip shows the azimuth of its column and the elevation of its row, in the part's frame, but for what
/// no mirror can show: rays are met and reflected here by the mirror's places and normals alone. A small fold changes that little by little.
#[test]
fn a_strip_under_a_camera_beside_the_axis_shows_its_azimuths() {
    let under = |mount: &str| {
        strip(&format!(
            "{mount}\ncamera.pinhole = {{ pixels = [640, 480], focal_px = 900, distance_mm = 120 }}"
        ))
    };
    let plain = under("").facts.ray_error_mrad.unwrap().rms;
    for (mount, most) in [
        ("mount = { fold_deg = 2, towards_deg = 30 }", 1.1),
        ("mount = { fold_deg = 30, towards_deg = 0 }", 4.0),
        ("mount = { fold_deg = 24, towards_deg = 90 }", 4.0),
    ] {
        let design = under(mount);
        let (camera, mirror) = (&design.camera, &design.mirror);
        let (mut square, mut count) = (0.0, 0.0);
        for k in 0..30 * 24 {
            let [x, y] =
                [f64::from(k % 30) / 30.0, f64::from(k / 30) / 24.0].map(|at| at + 1.0 / 60.0);
            // 140 degrees across the 60 mm of the part, and 50 down at the same scale.
            let size = DVec2::new(60.0, 60.0 * 50.0 / 140.0);
            let image = (DVec2::new(x, y) - 0.5) * size;
            let q = camera.picture.chart_point(image);
            let surface = mirror.at(q);
            let at = mirror.position(q, &surface);
            let place = mirror.local_surface_over(at.truncate(), at.z).unwrap();
            let ray = camera.ray(image, 200.0);
            assert!((at - ray.origin).cross(ray.direction).length() < 1e-9);
            let normal = place.normal();
            let seen = ray.direction - 2.0 * ray.direction.dot(normal) * normal;
            let [azimuth, elevation] = [-70.0 + 140.0 * x, -25.0 + 50.0 * y].map(radians);
            let wanted = DVec3::new(
                cos(elevation) * sin(azimuth),
                cos(elevation) * cos(azimuth),
                sin(elevation),
            );
            let off = seen.cross(wanted).length();
            assert!(seen.dot(wanted) > 0.9, "{mount}: {seen} for {wanted}");
            (square, count) = (square + off * off, count + 1.0);
        }
        let rms = 1e3 * f64::sqrt(square / count);
        // What is told is over all of the mirror that the frame shows, which is more than the strip.
        let told = design.facts.ray_error_mrad.unwrap().rms;
        assert!((0.7..1.1).contains(&(rms / told)), "{mount}: {rms} mrad, told {told}");
        assert!(told < most * plain.max(1.0), "{mount}: {told} mrad, {plain} on the axis");
    }
}

/// The file is the map of the smooth mirror's errors. A mirror that is to show nothing has none, and that of an older
/// profile in its folder goes.
#[test]
fn a_build_maps_the_errors_of_its_design() {
    let folder = folder();
    let path = folder.path().join("v/design_error.png");
    let built = |shape: &str, height: &str| {
        let text = format!(
            "camera.orthographic.pixels = [160, 120]\n{shape}\npart = {{ width_mm = 20, base_mm = 5{height} }}\n\
             mesh.chord_um = 20\nexport.formats = [\"stl\"]\n"
        );
        let profile = Profile::parse("v", "v.toml", text.as_bytes()).unwrap();
        build(&profile, folder.path(), &Silent).unwrap();
        design(&profile).unwrap()
    };
    let view = "projection.perspective = { hfov_deg = 60, centre_deg = [0, 90] }\nlayout.rectangle = {}\n\
                method.vector-field.degree = 4";
    let design = built(view, "");
    let errors = pixel_errors(&design, ThinnedFrame::new([160, 120]));
    assert!(errors.iter().flatten().count() > 19_000);
    let map = design_error_map([160, 120], &errors, &design.facts);
    assert!(map.title.ends_with(" deg)"), "{}", map.title);
    assert_eq!(std::fs::read(&path).unwrap(), map.png().unwrap());
    built("mirror.polynomial = { radius_mm = -40 }", ", height_mm = 15");
    assert!(!path.exists());
}
