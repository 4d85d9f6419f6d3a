//! Strips and round mirrors before both cameras and all targets, ray by ray on plain vectors.

use crate::support::oracle::{
    self, Errors, Strip, Trace, Wish, World, eye, integral, order, pinhole, rad, trace,
};
use crate::support::{designed, panel, rims, shipped_builds, shipped_but};
use morion::internals::export::{read_3mf, read_stl};
use morion::internals::geom::{DVec2, DVec3, Rect};
use morion::internals::num::quadrature::gauss_legendre;
use morion::internals::num::{cos, exp, log, sin, tan};
use std::f64::consts::PI;

const FAR: f64 = f64::INFINITY;

fn strip(law: &str) -> Strip<'_> {
    Strip {
        law,
        azimuth_deg: [-90.0, 200.0],
        elevation_deg: [-20.0, 45.0],
        distance: FAR,
        target: World::Far,
    }
}

fn agree(found: f64, exact: f64, share: f64) -> bool {
    (found - exact).abs() <= share * exact.abs()
}

/// That the facts of a design are its errors by definition.
#[track_caller]
fn check_facts(strip: &Strip, degree: usize) -> Errors {
    let design = strip.wish(degree).made();
    let own = strip.errors(&design, 100);
    let facts = &design.facts;
    let (ray, pixel) = (facts.ray_error_mrad.unwrap(), facts.pixel_error_px.unwrap());
    let what = format!("{} {} {:?}", strip.law, strip.distance, strip.target);
    println!("{what}: {own:?} {ray:?} {pixel:?}");
    assert!(agree(ray.rms, own.ray_mrad[0], 1e-9), "{what}: {ray:?} {own:?}");
    assert!(agree(ray.max, own.ray_mrad[1], 3e-3), "{what}: {ray:?} {own:?}");
    assert!(agree(pixel.rms, own.pixel_px[0], 1e-9), "{what}: {pixel:?} {own:?}");
    assert!(agree(pixel.max, own.pixel_px[1], 3e-3), "{what}: {pixel:?} {own:?}");
    own
}

#[test]
fn errors_of_strips_are_those_of_the_laws_definitions() {
    for law in ["cylindrical", "equirectangular", "equal-area"] {
        for distance in [FAR, 250.0] {
            check_facts(&Strip { distance, ..strip(law) }, 12);
        }
    }
    check_facts(&Strip { distance: 250.0, ..strip("mercator") }, 12);
}

#[test]
fn errors_before_finite_targets_are_those_of_their_definitions() {
    let up = Strip { elevation_deg: [20.0, 60.0], azimuth_deg: [-50.0, 40.0], ..strip("mercator") };
    for law in ["cylindrical", "mercator", "equal-area"] {
        for distance in [FAR, 250.0] {
            for target in [World::Cylinder(80.0), World::Cylinder(3000.0)] {
                check_facts(&Strip { distance, target, ..strip(law) }, 10);
            }
            check_facts(&Strip { law, distance, target: World::Plane(200.0), ..up }, 10);
        }
    }
    let down = Strip { elevation_deg: [-60.0, -20.0], ..up };
    check_facts(&Strip { target: World::Plane(-150.0), ..down }, 10);
}

#[test]
fn the_mercator_strip_sees_exactly_what_it_should() {
    let strip = strip("mercator");
    let design = strip.wish(24).made();
    let paper = strip.paper(&design);
    let mut worst: f64 = 0.0;
    for (q, _) in oracle::gauss_grid(panel(&design), 40) {
        worst = worst.max(strip.error(&design, &paper, q)[0]);
        assert!((trace(&design, None, q).seen.length() - 1.0).abs() < 1e-14);
    }
    assert!(worst < 1e-9, "{worst:e}");
    // The folded one too, its other panel seeing the world upside down: the image turned by half
    // a turn about the middle of the frame shows the azimuth mirrored in the ridge.
    let design = Wish::conquistador("mercator", 20).made();
    let Rect { min, max } = panel(&design);
    assert_eq!(min.y, 0.0);
    for (q, _) in oracle::gauss_grid(Rect { min, max }, 20) {
        // Half a turn over the width, and as much elevation on either side of the horizon.
        let scale = 60.0 / PI;
        let z = (q.y - 0.5 * (max.y - min.y)) / scale;
        let wanted = oracle::direction(q.x / scale, oracle::elevation("mercator", z));
        let flip = DVec3::new(1.0, -1.0, 1.0);
        let below = trace(&design, None, q * flip.truncate()).seen;
        assert!((trace(&design, None, q).seen - wanted).length() < 1e-9, "{q}");
        assert!((below - wanted * flip).length() < 1e-9, "{q}");
    }
}

/// Where a round mirror's rays must meet a target: height over the origin on a cylinder, distance
/// from the axis on a plane.
fn check_round(name: &str, distance: f64, inner_mm: f64, psi_deg: [f64; 2], world: World) {
    let mut law = format!("[projection.{name}]\nouter_polar_deg = {:?}", psi_deg[1]);
    if psi_deg[0] > 0.0 {
        law += &format!("\ninner_polar_deg = {:?}", psi_deg[0]);
    }
    let camera = if distance.is_finite() { pinhole(distance) } else { oracle::ORTHOGRAPHIC.into() };
    let design = Wish::round(&camera, &law, inner_mm, 36).before(&world.key()).made();
    let eye = eye(&design, distance);
    let [inner, outer] = rims(&design);
    // The area-mean over the image of the height (of the logarithm of the depth).
    let depth = |r: f64| {
        let z = trace(&design, None, DVec2::X * r).at.z - design.mirror.chart.plane_mm;
        if eye.is_some() { log(1.0 - z / distance) } else { z }
    };
    let mean = 2.0 * integral(inner, outer, |r| r * depth(r)) / (outer * outer - inner * inner);
    let mean =
        if eye.is_some() { distance * (1.0 - morion::internals::num::exp(mean)) } else { mean };
    let origin = design.view.as_ref().unwrap().origin_mm;
    assert!((origin - design.mirror.chart.plane_mm - mean).abs() < 1e-9, "{name} {origin}");
    let [psi0, psi1] = psi_deg.map(rad);
    let mut worst: f64 = 0.0;
    for k in 1..=40 {
        let r = inner + (outer - inner) * f64::from(k) / 40.0;
        let t = (r - inner) / (outer - inner);
        let t2 = (r * r - inner * inner) / (outer * outer - inner * inner);
        let psi = match name {
            "equiangular" if eye.is_some() => {
                let [t0, t1, t] =
                    [inner, outer, r].map(|r| morion::internals::num::atan(r / distance));
                psi0 + (psi1 - psi0) * (t - t0) / (t1 - t0)
            }
            "equiangular" | "tangent-proportional" => psi0 + (psi1 - psi0) * t,
            "area-proportional" => psi0 + (psi1 - psi0) * t2,
            "equi-areal" => oracle::acos(cos(psi0) + (cos(psi1) - cos(psi0)) * t2),
            "plane" => morion::internals::num::atan(tan(psi1) * r / outer),
            "cylinder" => {
                let cot = 1.0 / tan(psi0) + (1.0 / tan(psi1) - 1.0 / tan(psi0)) * t;
                0.5 * PI - morion::internals::num::atan(cot)
            }
            "conical" => {
                let [t1, t] = [outer, r].map(|r| morion::internals::num::atan(r / distance));
                psi1 - t1 + t
            }
            _ => panic!("{name}"),
        };
        for a in [0.4, 2.9, 5.0] {
            let way = DVec2::new(cos(a), sin(a));
            let Trace { at, seen, .. } = trace(&design, eye, way * r);
            let from = at - DVec3::Z * origin;
            let exact = world.point((way * sin(psi)).extend(cos(psi)));
            worst = worst.max((world.hit(from, seen) - exact).length() / exact.length());
        }
        if let World::Cylinder(radius) = world {
            // What Gaechter and Pajdla ask for, in their words: equal steps, equal heights.
            let hit = |r: f64| {
                let Trace { at, seen, .. } = trace(&design, eye, DVec2::X * r);
                world.hit(at, seen).z
            };
            let linear = hit(inner) + (hit(outer) - hit(inner)) * t;
            assert!(name != "cylinder" || (hit(r) - linear).abs() < 1e-9 * radius);
        }
    }
    println!("{name} {distance} {world:?}: {worst:e} in {} steps", design.facts.steps);
    assert!(worst < 1e-9, "{name} {distance} {world:?}: {worst:e}");
    let curl = design.facts.curl.unwrap().max;
    assert!(curl <= 1e-12, "{name} {distance} {world:?}: curl {curl:e}");
}

#[test]
fn round_mirrors_before_finite_targets_are_exact() {
    for distance in [FAR, 100.0] {
        let inner = 16.0;
        for radius in [100.0, 500.0] {
            let world = World::Cylinder(radius);
            check_round("cylinder", distance, inner, [60.0, 120.0], world);
            check_round("equiangular", distance, inner, [50.0, 110.0], world);
            check_round("tangent-proportional", distance, inner, [50.0, 110.0], world);
            check_round("area-proportional", distance, inner, [40.0, 100.0], world);
            check_round("equi-areal", distance, inner, [50.0, 110.0], world);
        }
        for height in [150.0, 2000.0] {
            let world = World::Plane(height);
            check_round("plane", distance, 0.0, [0.0, 50.0], world);
            check_round("plane", distance, inner, [0.0, 50.0], world);
            check_round("equi-areal", distance, 0.0, [0.0, 60.0], world);
        }
        check_round("equi-areal", distance, inner, [120.0, 150.0], World::Plane(-300.0));
    }
    check_round("conical", 100.0, 16.0, [0.0, 100.0], World::Cylinder(200.0));
}

/// The largest difference of two mirrors' heights over the same image points, of the width.
fn apart(a: &Wish, b: &Wish) -> f64 {
    let (a, b) = (a.made(), b.made());
    let area = a.mirror.outline.bounds();
    let mut worst: f64 = 0.0;
    for k in 0..31 * 31 {
        let q = area.min + area.size() * DVec2::new(f64::from(k % 31), f64::from(k / 31)) / 30.0;
        if a.mirror.outline.contains(q) && b.mirror.outline.contains(q) {
            let z = [&a, &b].map(|d| trace(d, None, q).at.z - d.mirror.chart.plane_mm);
            worst = worst.max((z[0] - z[1]).abs());
        }
    }
    worst / 60.0
}

#[test]
fn a_far_pinhole_is_an_orthographic_camera() {
    let round = |law: &str, inner: f64| Wish::round(oracle::ORTHOGRAPHIC, law, inner, 24);
    let folded = Wish {
        layout: "[layout.conquistador]\npanel = \"section\"\nridge = \"valley\"".into(),
        ..Wish::panoramic("cylindrical", 12)
    };
    let wishes = [
        Wish::panoramic("cylindrical", 12),
        folded,
        Wish { method: "distribution", ..Wish::panoramic("mercator", 8) },
        round("[projection.equiangular]\nouter_polar_deg = 120", 0.0),
        round("[projection.cylinder]\ninner_polar_deg = 60\nouter_polar_deg = 120", 16.0),
        round("[projection.plane]\nouter_polar_deg = 60", 0.0),
        round("[projection.equi-areal]\nouter_polar_deg = 110", 0.0).before(""),
        round("[projection.cylinder]\ninner_polar_deg = 60\nouter_polar_deg = 120", 16.0)
            .before("target_radius_mm = 300"),
    ];
    for wish in wishes {
        let points: Vec<(f64, f64)> = [1e2, 1e3, 1e4, 1e5]
            .map(|widths| (widths, Wish { camera: pinhole(60.0 * widths), ..wish.clone() }))
            .map(|(widths, far)| (widths, apart(&wish, &far)))
            .to_vec();
        let order = order(&points);
        println!("{} {}: {order} {points:?}", wish.projection, wish.layout);
        assert!((order + 1.0).abs() < 0.05, "{}: {order} {points:?}", wish.projection);
        assert!(points[2].1 < 1e-3);
    }
    // A hyperboloid becomes the paraboloid.
    let parabolic = round("[projection.parabolic]\nouter_polar_deg = 100", 0.0);
    let points = [1e2, 1e3, 1e4, 1e5].map(|widths| {
        let law = "[projection.hyperbolic]\nouter_polar_deg = 100";
        let far = Wish::round(&pinhole(60.0 * widths), law, 0.0, 24);
        (widths, apart(&parabolic, &far))
    });
    assert!((order(&points) + 1.0).abs() < 0.05, "{points:?}");
}

#[test]
fn a_far_target_is_at_infinity() {
    let wishes = [
        (Wish::panoramic("cylindrical", 12), "radius"),
        (Wish::conquistador("mercator", 12), "radius"),
        (Wish { camera: pinhole(200.0), ..Wish::panoramic("equal-area", 10) }, "radius"),
        (Wish { method: "fixed-surface", ..Wish::panoramic("cylindrical", 8) }, "radius"),
        (
            Wish::round(
                &pinhole(100.0),
                "[projection.cylinder]\ninner_polar_deg = 60\nouter_polar_deg = 120",
                16.0,
                24,
            ),
            "radius",
        ),
        (
            Wish::round(oracle::ORTHOGRAPHIC, "[projection.plane]\nouter_polar_deg = 60", 0.0, 24),
            "plane",
        ),
    ];
    for (wish, kind) in wishes {
        let points = [1e4, 1e5, 1e6, 1e7].map(|reach: f64| {
            let near = wish.clone().before(&format!("target_{kind}_mm = {reach:?}"));
            (reach, apart(&wish, &near))
        });
        let order = order(&points);
        println!("{}: {order} {points:?}", wish.projection);
        assert!((order + 1.0).abs() < 0.01, "{}: {order} {points:?}", wish.projection);
        let foreseen = points[2].1 / 10.0;
        assert!(agree(points[3].1, foreseen, 1e-2), "{}: {points:?}", wish.projection);
    }
}

/// Means over the picture of the panel: of Z, and the geometric one of depths below `eye_mm`.
fn means(design: &morion::internals::design::Design, eye_mm: f64) -> [f64; 2] {
    let mirror = &design.mirror;
    let area = mirror.outline.bounds();
    let (nodes, weights) = gauss_legendre(40);
    let (mut height, mut depth) = (0.0, 0.0);
    for (u, a) in nodes.iter().zip(&weights) {
        for (v, b) in nodes.iter().zip(&weights) {
            let q = area.centre() + 0.5 * area.size() * DVec2::new(*u, *v);
            let z = mirror.position(q, &mirror.surface.at(q)).z;
            height += 0.25 * a * b * z;
            depth += 0.25 * a * b * log(eye_mm - z);
        }
    }
    [height, exp(depth)]
}

#[test]
fn camera_and_target_are_where_the_profile_says_of_the_panel_that_is_made() {
    let lens = "[camera.pinhole]\nhfov_deg = 22.6\ndistance_mm = 150\npixels = [640, 480]";
    for panel in ["refit", "section"] {
        let cut = format!("panel = \"{panel}\"");
        for (camera, target) in
            [(true, ""), (true, "target_radius_mm = 300\n"), (false, "target_radius_mm = 200\n")]
        {
            let law = format!("{target}azimuth_deg = [-180, 180]");
            let mut edits = vec![("panel = \"refit\"", &*cut), ("azimuth_deg = [-180, 180]", &law)];
            if camera {
                edits.push(("[camera.orthographic]", lens));
                edits.push(("\npixels = [640, 480]              #", "\n#"));
            }
            let design = designed(&shipped_but("conquistador", &edits));
            let mounting = &design.mounting;
            let eye_mm = mounting.pupil_mm.map_or(1e3, |[.., z]| z);
            assert_eq!(mounting.pupil_mm.is_some(), camera);
            let [height, depth] = means(&design, eye_mm);
            if camera {
                assert!((depth - 150.0).abs() < 1e-9, "{panel} {target}: {depth}");
            }
            let origin = design.view.expect("a projection").origin_mm;
            let wanted = if camera { eye_mm - 150.0 } else { height };
            assert!((origin - wanted).abs() < 1e-9, "{panel} {target}: {origin} {wanted}");
            assert!((mounting.mean_mm - wanted).abs() < 1e-9, "{panel} {target}: {mounting:?}");
            let told = mounting.target_origin_mm.map(|[.., z]| z);
            assert_eq!(told, (!target.is_empty()).then_some(origin), "{panel} {target}");
            assert_eq!(mounting.up, [0.0, 0.0, 1.0]);
        }
    }
}

/// A given mirror 80 mm wide under a pinhole 150 mm from it.
const GIVEN: &str = "camera.pinhole = { pixels = [640, 480], hfov_deg = 40, distance_mm = 150 }
part = { width_mm = 80, base_mm = 5 }
layout.strip = {}
mirror.polynomial = { radius_mm = -60, terms = [[0, 1, 0.2], [3, 0, 1e-4]] }
projection.cylindrical = { target_radius_mm = 400, azimuth_deg = [-60, 60], elevation_deg = [-20, 20] }
mesh.facet_px = 1
export.formats = [\"stl\"]
";

#[test]
#[ignore = "long: .ci/nightly"]
fn a_given_mirror_is_as_far_as_the_profile_says_by_the_pixels_that_see_it() {
    let design = designed(&crate::support::builds::parsed(GIVEN));
    let (camera, mirror) = (&design.camera, &design.mirror);
    let eye_mm = design.mounting.pupil_mm.expect("a pinhole")[2];
    // Finer than pixels, and the whole picture that the mirror can be in.
    let (steps, reach) = (400, 60.0);
    let (mut sum, mut count) = (0.0, 0u32);
    for k in 0..steps * steps {
        let at = DVec2::new(f64::from(k % steps) + 0.5, f64::from(k / steps) + 0.5);
        let image = (at * 2.0 / f64::from(steps) - DVec2::ONE) * reach;
        let Some(q) = mirror.intersect_camera_ray(&camera.chart, image) else { continue };
        if mirror.outline.contains(q) {
            sum += log(eye_mm - mirror.position(q, &mirror.surface.at(q)).z);
            count += 1;
        }
    }
    let found = exp(sum / f64::from(count));
    assert!(count > 20_000 && (found - 150.0).abs() < 5e-3, "{found} {count}");
    let [mean, origin] = [design.mounting.mean_mm, design.mounting.target_origin_mm.unwrap()[2]];
    assert!((eye_mm - 150.0 - mean).abs() < 1e-9 && mean == origin, "{mean} {origin}");
    // That is not the mean over the plan, by which such mirrors were placed before.
    let plan = mirror.mean_mm(&mirror.chart);
    assert!((plan - mean).abs() > 0.1, "{plan} {mean}");
}

#[test]
#[ignore = "long: .ci/nightly"]
fn the_part_is_as_large_and_the_camera_where_the_report_says() {
    for shipped in morion::internals::profile::shipped() {
        let report = shipped_builds::report(shipped.name);
        let layout = report.layout.expect("in every report of a build");
        let folder = shipped_builds::folder().join(shipped.name);
        let file = |name: &str| std::fs::read(folder.join(name));
        let corners = match file("mirror.stl") {
            Ok(stl) => read_stl(&stl).unwrap().mesh.vertices,
            Err(_) => read_3mf(&file("mirror.3mf").unwrap()).unwrap().mesh.vertices,
        };
        let low = corners.iter().copied().reduce(DVec3::min).unwrap();
        let high = corners.iter().copied().reduce(DVec3::max).unwrap();
        let off = (high - low - DVec3::from_array(layout.size_mm)).abs().max_element();
        // Polygons and facets are inside circles and crests by the chord that they are allowed.
        let chord = 1e-3 * report.mesh.unwrap().chord_um.bound.max(2.0);
        assert!(off < chord, "{}: off by {off} mm of {chord}", shipped.name);
        assert!(low.z == 0.0, "{}", shipped.name);
        let design = designed(&crate::support::shipped(shipped.name));
        let ray = design.camera.ray(DVec2::ZERO, 1.0);
        if let Some(pupil) = layout.pupil_mm {
            assert!(ray.origin.abs_diff_eq(DVec3::from_array(pupil), 1e-9), "{}", shipped.name);
        }
    }
}
