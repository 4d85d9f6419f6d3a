//! The blur against pencils of rays, each of which is traced to the smooth mirror by itself.

use crate::support::builds::{folder, morion, told};
use crate::support::{designed, profile, shipped};
use morion::internals::design::Design;
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{asin, cos, sin, tan};
use morion::internals::optics::{reflect, stereographic};
use morion::internals::pencil::{BlurEllipse, Pencil, map_pencils, quantiles};
use serde_json::Value;
use std::f64::consts::TAU;

/// What the ray from `origin` along `way` shows: it meets the smooth mirror by the secant method,
/// knows its height and normal there and nothing of its curvature.
fn shown(design: &Design, origin: DVec3, way: DVec3, start: f64) -> DVec2 {
    let Design { mirror, view, .. } = design;
    let way = way.normalize();
    let above = |t: f64| {
        let (q, f) = mirror.chart.coordinates(origin + way * t);
        f - mirror.row(q.y).at(q.x).f
    };
    let (mut a, mut b) = (start - 1e-3, start);
    let (mut fa, mut fb) = (above(a), above(b));
    for _ in 0..40 {
        if fb == fa {
            break;
        }
        let next = b - fb * (b - a) / (fb - fa);
        (a, fa) = (b, fb);
        b = next;
        fb = above(b);
    }
    assert!(fb.abs() < 1e-10, "the ray misses: {fb:e}");
    let at = origin + way * b;
    let (q, _) = mirror.chart.coordinates(at);
    let direction = reflect(way, mirror.normal(q, &mirror.row(q.y).at(q.x)));
    let seen = view.as_ref().map_or(direction, |view| view.direction_from_origin(at, direction));
    DVec2::from_array(stereographic::sigma(seen.to_array()))
}

/// A lens at one pixel.
struct Bench<'a> {
    design: &'a Design,
    image: DVec2,
    /// The point of the mirror under it.
    at: DVec3,
}

impl<'a> Bench<'a> {
    fn new(design: &'a Design, image: DVec2) -> Self {
        let mirror = &design.mirror;
        assert_eq!(mirror.chart, design.camera.chart);
        let at = mirror.position(image, &mirror.row(image.y).at(image.x));
        Self { design, image, at }
    }

    /// What the ray through pupil point `pupil` and the point of the plane in focus that belongs to
    /// image point `image` shows, the focus `focus_mm` as on the command line.
    fn through(&self, pupil: DVec2, image: DVec2, focus_mm: f64) -> DVec2 {
        let chart = &self.design.camera.chart;
        let (origin, way) = if chart.vergence == 0.0 {
            let focus = image.extend(focus_mm);
            let way = pupil.extend(-1.0);
            (focus - way * (60.0 + focus_mm.abs()), way)
        } else {
            let distance = 1.0 / chart.vergence;
            let eye = DVec3::new(0.0, 0.0, chart.plane_mm + distance);
            let focus = eye + (image / distance).extend(-1.0) * focus_mm;
            let origin = eye + pupil.extend(0.0);
            (origin, focus - origin)
        };
        let start = (self.at - origin).dot(way.normalize());
        shown(self.design, origin, way, start)
    }

    /// How far from the pixel, mm of the image, the chief ray is that shows what the ray through
    /// `pupil` shows.
    fn shift(&self, pupil: DVec2, focus_mm: f64) -> DVec2 {
        let wanted = self.through(pupil, self.image, focus_mm);
        let chief = |image: DVec2| self.through(DVec2::ZERO, image, focus_mm);
        let h = 1e-3 * self.design.camera.pixel_mm;
        let slope =
            |way: DVec2| (chief(self.image + way * h) - chief(self.image - way * h)) / (2.0 * h);
        let (x, y) = (slope(DVec2::X), slope(DVec2::Y));
        let mut image = self.image;
        for _ in 0..12 {
            let miss = wanted - chief(image);
            let size = x.perp_dot(y);
            image += DVec2::new(miss.perp_dot(y), x.perp_dot(miss)) / size;
        }
        image - self.image
    }

    /// The shift that the mirror's curvature predicts.
    fn predicted(&self, pupil: DVec2, focus_mm: f64) -> DVec2 {
        let Design { mirror, camera, view, .. } = self.design;
        let quadric = mirror.local_surface(self.image);
        let pencil = Pencil::new(camera, view.as_ref(), self.image, &quadric).unwrap();
        pencil.focus * pupil - pupil * phi(self.design, focus_mm)
    }
}

fn phi(design: &Design, focus_mm: f64) -> f64 {
    let chart = &design.camera.chart;
    if chart.vergence == 0.0 {
        chart.plane_mm - focus_mm
    } else {
        1.0 / (chart.vergence * focus_mm)
    }
}

/// Directions across a pupil.
fn rim(count: u32) -> impl Iterator<Item = DVec2> {
    (0..count).map(move |k| {
        let angle = TAU * (f64::from(k) + 0.3) / f64::from(count);
        DVec2::new(cos(angle), sin(angle))
    })
}

/// Designs with the apertures that a lens may have with them (mm, or tangents), and a focus.
fn designs() -> Vec<(&'static str, Design, f64, f64)> {
    let pinhole = "camera.pinhole = { pixels = [640, 480], focal_px = 1600, distance_mm = 150 }";
    let strip = profile(&[
        ("camera.orthographic.pixels = [640, 480]", pinhole),
        ("[-180, 180]", "[-90, 90]"),
        ("30] }", "30], target_radius_mm = 400 }"),
    ]);
    let shipped = |name| designed(&shipped(name));
    vec![
        ("conquistador", shipped("conquistador"), 0.02, 3.0),
        ("panoramic", shipped("panoramic"), 0.02, -9.0),
        ("parabolic", shipped("parabolic"), 0.02, -8.0),
        ("hyperbolic", shipped("hyperbolic"), 2.0, 112.0),
        ("conical", shipped("conical"), 2.0, 180.0),
        ("cylinder", shipped("cylinder"), 2.0, 95.0),
        ("pinhole strip in a near world", designed(&strip), 2.0, 170.0),
    ]
}

/// Image points well inside the mirror and off its ridge.
fn places(design: &Design) -> Vec<DVec2> {
    let whole = design.mirror.full_outline();
    let bounds = whole.bounds();
    let shares = [0.09, 0.23, 0.41, 0.62, 0.77, 0.93];
    let grid = shares.iter().flat_map(|x| shares.iter().map(|y| DVec2::new(*x, *y)));
    let point = |share: DVec2| bounds.min + bounds.size() * share;
    let clear = |p: &DVec2| whole.contains(*p * 1.05) && whole.contains(*p * 0.85);
    let places: Vec<DVec2> = grid.map(point).filter(clear).collect();
    assert!(places.len() > 12);
    places
}

#[test]
fn rays_spread_as_the_curvature_says_but_for_the_square_of_the_aperture() {
    for (name, design, aperture, focus) in designs() {
        for image in places(&design) {
            let bench = Bench::new(&design, image);
            let off = |radius: f64| {
                let off = rim(8).map(|way| {
                    let pupil = way * radius;
                    (bench.shift(pupil, focus) - bench.predicted(pupil, focus)).length()
                });
                off.fold(0.0, f64::max)
            };
            let size = rim(8).map(|way| bench.predicted(way * aperture, focus).length());
            let size = size.fold(0.0, f64::max);
            let [coarse, middle, fine] = [1.0, 0.5, 0.25].map(|share| off(share * aperture));
            // Second order, until differences and rounding show.
            let floor = 1e-9 * size;
            let falls = |a: f64, b: f64| b <= floor || (3.2..4.8).contains(&(a / b));
            assert!(
                falls(coarse, middle) && falls(middle, fine) && fine < 0.05 * size,
                "{name} at {image}: {coarse:e} {middle:e} {fine:e} of {size:e}"
            );
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_largest_aperture_blurs_to_one_pixel_by_rays_too() {
    let folder = folder();
    for (name, option) in
        [("conquistador", "--na"), ("hyperbolic", "--pupil-mm"), ("conical", "--pupil-mm")]
    {
        let asked = if option == "--na" { "0.03" } else { "3" };
        let arguments = ["blur", name, option, asked, "--quiet", "--format", "json"];
        let (code, out, err) = told(&morion(folder.path(), &arguments));
        assert_eq!((code, &*err), (0, ""));
        let json: Value = serde_json::from_str(&out).unwrap();
        let number = |pointer: &str| json.pointer(pointer).and_then(Value::as_f64).unwrap();
        let radius = if option == "--na" {
            tan(asin(number("/spots/largest/na")))
        } else {
            0.5 * number("/spots/largest/pupil_mm")
        };
        let place = if option == "--na" { "z_mm" } else { "distance_mm" };
        let focus = number(&format!("/spots/focus/{place}"));
        let design = designed(&shipped(name));
        let camera = &design.camera;
        // A sample of the pixels, away from the ridge and the rims.
        let mut lengths = Vec::new();
        for row in (7..camera.pixels[1]).step_by(23) {
            for column in (5..camera.pixels[0]).step_by(19) {
                let image = camera.image_point(f64::from(column) + 0.5, f64::from(row) + 0.5);
                let whole = design.mirror.full_outline();
                let edge = 3.0 * camera.pixel_mm;
                let near = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
                let inside = near.iter().all(|way| whole.contains(image + *way * edge));
                if !inside || image.y.abs() < edge {
                    continue;
                }
                let bench = Bench::new(&design, image);
                let across = |way: DVec2| {
                    let pupil = way * radius;
                    (bench.shift(pupil, focus) - bench.shift(-pupil, focus)).length()
                };
                lengths.push(rim(32).take(16).map(across).fold(0.0, f64::max) / camera.pixel_mm);
            }
        }
        let p95 = quantiles(lengths).unwrap().p95;
        assert!((p95 - 1.0).abs() < 0.05, "{name}: {p95}");
    }
}

#[test]
fn mirrors_of_a_single_viewpoint_have_no_astigmatism() {
    // Meridional and sagittal curvature of a paraboloid are cos^3 / h and cos / h, and incidence is
    // the slope's angle: both Coddington equations give h / (2 cos^2). The hyperboloid is its
    // projective image.
    for (name, most) in [("parabolic", 1e-9), ("hyperbolic", 1e-9)] {
        let design = designed(&shipped(name));
        let Design { mirror, camera, view, .. } = &design;
        let [width, height] = camera.pixels;
        let spots =
            map_pencils(mirror, camera, view.as_ref(), [0..width, 0..height], BlurEllipse::new);
        let apart = spots.iter().flatten().map(|spot| {
            let [a, b] = spot.foci();
            (b - a) / b.abs().max(a.abs())
        });
        let worst = apart.fold(0.0, f64::max);
        assert!(worst < most, "{name}: {worst:e}");
    }
    let design = designed(&shipped("parabolic"));
    let camera = &design.camera;
    // t = r / h = tan(psi / 2) at the rim, and the slope is -t.
    let h = 30.0 / tan(0.5 * morion::internals::num::radians(100.0));
    for r in [0.0, 7.0, 18.0, 29.0] {
        let quadric = design.mirror.local_surface(DVec2::new(r, 0.0));
        let image = DVec2::new(r, 0.0);
        let pencil = Pencil::new(camera, None, image, &quadric).unwrap();
        let behind = 0.5 * h * (1.0 + r * r / (h * h));
        for phi in BlurEllipse::new(&pencil).foci() {
            let found = quadric.at.z - (camera.chart.plane_mm - phi);
            assert!((found - behind).abs() < 1e-7, "{r}: {found} {behind}");
        }
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_best_focus_is_better_than_others_and_apertures_scale_the_spot() {
    let folder = folder();
    let run = |more: &[&str]| -> Value {
        let arguments = [&["blur", "equiangular", "--quiet", "--format", "json"], more].concat();
        let (code, out, err) = told(&morion(folder.path(), &arguments));
        assert_eq!((code, &*err), (0, ""));
        serde_json::from_str(&out).unwrap()
    };
    let number =
        |json: &Value, pointer: &str| json.pointer(pointer).and_then(Value::as_f64).unwrap();
    let best = run(&["--pupil-mm", "1"]);
    assert_eq!(best["spots"], best["best"]);
    let [p95, z] = ["/spots/length_px/p95", "/spots/focus/distance_mm"].map(|p| number(&best, p));
    let [far, near] = ["/images/range/0", "/images/range/1"]
        .map(|end| number(&best, &format!("{end}/distance_mm")));
    assert!(near < z && z < far, "{near} {z} {far}");
    for share in [0.9, 0.97, 1.03, 1.1] {
        let other = run(&["--pupil-mm", "1", "--focus-mm", &format!("{}", share * z)]);
        assert!(number(&other, "/spots/length_px/p95") > p95);
        assert_eq!(other["best"], best["best"]);
    }
    let double = run(&["--pupil-mm", "2"]);
    assert!((number(&double, "/spots/length_px/p95") / p95 - 2.0).abs() < 1e-12);
    let largest = |json: &Value| number(json, "/spots/largest/pupil_mm");
    assert!((largest(&double) - largest(&best)).abs() < 1e-12);
    assert!((largest(&best) * p95 - 1.0).abs() < 1e-12);
}

#[test]
fn a_given_sphere_under_either_camera_keeps_coddingtons_equations() {
    // The mirror's own chart is that of parallel rays.
    let r = 25.0;
    for camera in [
        "camera.orthographic.pixels = [64, 48]",
        "camera.pinhole = { pixels = [64, 48], focal_px = 150, distance_mm = 90 }",
    ] {
        let text = format!(
            "{camera}
mirror.polynomial = {{ radius_mm = -{r}, terms = [[0, 0, 0.5]] }}
part = {{ width_mm = 24, height_mm = 18, base_mm = 5 }}
mesh.chord_um = 20
export.formats = [\"stl\"]
"
        );
        let design = designed(
            &morion::internals::profile::Profile::parse("s", "s", text.as_bytes()).unwrap(),
        );
        let Design { mirror, camera, .. } = &design;
        let [width, height] = camera.pixels;
        let spots = map_pencils(mirror, camera, None, [0..width, 0..height], BlurEllipse::new);
        let centre = mirror.position(DVec2::ZERO, &mirror.surface.at(DVec2::ZERO)) - DVec3::Z * r;
        let mut compared = 0;
        for (k, spot) in spots.iter().enumerate() {
            let Some(spot) = spot else { continue };
            let pixel = |k: u32| f64::from(k) + 0.5;
            let image = camera.image_point(pixel(k as u32 % width), pixel(k as u32 / width));
            let ray = camera.ray(image, 200.0);
            // Where it meets the sphere.
            let (from, way) = (ray.origin - centre, ray.direction);
            let along = from.dot(way);
            let t = -along - (along * along - from.length_squared() + r * r).sqrt();
            let at = from + way * t;
            let c = -way.dot(at) / r;
            let z = |behind: f64| (centre + at + way * behind).z;
            let exact = [0.5 * r * c, 0.5 * r / c].map(z);
            let [a, b] = spot.foci().map(|phi| {
                let chart = &camera.chart;
                if chart.vergence == 0.0 {
                    chart.plane_mm - phi
                } else {
                    chart.plane_mm + (1.0 - 1.0 / phi) / chart.vergence
                }
            });
            let off = (a.max(b) - exact[0]).abs() + (a.min(b) - exact[1]).abs();
            assert!(off < 1e-6, "{image}: {a} {b} {exact:?}");
            compared += 1;
        }
        assert!(compared > 1000, "{compared}");
    }
}

/// The figures of a run of `blur` or, of its sharpness, of `build`.
fn json(home: &std::path::Path, arguments: &[&str]) -> Value {
    let (code, out, err) = told(&morion(home, &[arguments, &["--format", "json"]].concat()));
    assert!(code < 2, "{err}");
    serde_json::from_str(&out).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

const LENS: (&str, &str) = ("distance_mm = 200 ", "f_number = 4\ndistance_mm = 200 ");

/// Ellipse, Airy disc and pixel by hand, at the aperture of the profile and at the best of many.
#[test]
#[ignore = "long: .ci/nightly"]
fn spots_with_diffraction_are_sums_of_squares_and_the_best_aperture_is_named() {
    let folder = folder();
    let home = folder.path();
    let text = crate::support::builds::edited(
        crate::support::shipped_text("machine-vision"),
        &[LENS, ("[1920, 1080]", "[480, 270]"), ("pixel_um = 3.45 ", "pixel_um = 13.8 ")],
    );
    std::fs::write(home.join("lab.toml"), text).unwrap();
    let blur = json(home, &["blur", "lab.toml"]);
    let pupil = 12.5 / 4.0;
    assert_eq!(number(&blur["aperture"]["pupil_mm"]), pupil);
    let airy = |pupil_mm: f64| 2.0 * 1.219_669_891_266_504_5 * 550e-6 / pupil_mm * 12.5 / 0.0138;
    let length = number(&blur["spots"]["length_px"]["p95"]);
    let given = &blur["sharpness"]["given"];
    assert!((number(&given["f_number"]) - 4.0).abs() < 1e-12);
    assert!((number(&given["diffraction_px"]) / airy(pupil) - 1.0).abs() < 1e-9);
    assert!((number(&given["geometric_px"]) / length - 1.0).abs() < 1e-9);
    let spot = |pupil_mm: f64| {
        let ellipse = length * pupil_mm / pupil;
        (ellipse * ellipse + airy(pupil_mm) * airy(pupil_mm) + 1.0).sqrt()
    };
    assert!((number(&given["spot_px"]) / spot(pupil) - 1.0).abs() < 1e-9);
    let best = &blur["sharpness"]["best"];
    let least = (1..4000).map(|k| spot(1e-3 * f64::from(k))).fold(f64::MAX, f64::min);
    assert!((number(&best["spot_px"]) / least - 1.0).abs() < 1e-5);
    let across = number(&best["resolved"][0]);
    assert!((across * least / 480.0 - 1.0).abs() < 0.06, "{across}");
    // A build looks at some of the pixels.
    let built = json(home, &["build", "lab.toml"]);
    let of = |what: &str| number(&built["sharpness"][what]["spot_px"]);
    assert!((of("best") / least - 1.0).abs() < 0.02);
    assert!((of("given") / number(&given["spot_px"]) - 1.0).abs() < 0.02);
}

/// The paper's mirror of 60 mm: its images lie at depths 34 mm apart, and no aperture is both small and
/// large enough. One four times as large is twice as sharp.
#[test]
#[ignore = "long: .ci/nightly"]
fn no_aperture_resolves_the_papers_mirror_and_a_larger_one_is_sharper() {
    let folder = folder();
    let home = folder.path();
    let spot = |width: &str| {
        let text = crate::support::builds::edited(
            crate::support::shipped_text("conquistador"),
            &[
                ("width_mm = 60", width),
                ("chord_um = 2", "chord_um = 400"),
                ("facet_px = 1 ", "facet_px = 20 "),
                ("pixel_error_rms_px = 2", "pixel_error_rms_px = 20"),
                ("pixel_error_max_px = 7", "pixel_error_max_px = 40"),
            ],
        );
        std::fs::write(home.join("large.toml"), text).unwrap();
        let report = json(home, &["build", "large.toml"]);
        let best = &report["sharpness"]["best"];
        let warned = report["warnings"].to_string().contains("no aperture resolves the pixels");
        assert_eq!(warned, number(&best["spot_px"]) > 3.0);
        [number(&best["na"]), number(&best["geometric_px"]), number(&best["spot_px"])]
    };
    let [na, ellipse, whole] = spot("width_mm = 60");
    assert!((na - 0.003).abs() < 1e-4 && (whole - 3.48).abs() < 0.1, "{na} {whole}");
    let [_, half, _] = spot("width_mm = 240");
    assert!((2.0 * half / ellipse - 1.0).abs() < 1e-3, "{half} {ellipse}");
}

#[test]
fn spots_over_the_limit_fail_and_name_the_best_aperture() {
    let folder = folder();
    let home = folder.path();
    let with = |lines: &str| {
        let small = crate::support::builds::SMALL;
        let text = small.replace("pixels = [160, 120]", &format!("pixels = [160, 120]\n{lines}"));
        let text = text.replace("[accept]", "[accept]\nblur_p95_px = 1.5");
        std::fs::write(home.join("small.toml"), text).unwrap();
        json(home, &["build", "small.toml"])
    };
    // Wide open.
    let report = with("na = 0.2");
    let reasons = report["reasons"].to_string();
    assert_eq!(report["verdict"], "fail");
    assert!(reasons.contains("px of accept.blur_p95_px; a numerical aperture of "), "{reasons}");
    // Unknown, the best one counts.
    let report = with("wavelength_nm = 400");
    let spot = number(&report["sharpness"]["best"]["spot_px"]);
    let blamed = report["reasons"].to_string().contains("accept.blur_p95_px");
    assert_eq!(blamed, spot > 1.5, "{spot}");
    // Without an aperture there is no spot to show.
    let (code, _, err) = told(&morion(home, &["blur", "small.toml"]));
    assert_eq!(code, 2);
    assert!(err.contains("give --na") && err.contains("camera.orthographic.na"), "{err}");
}
