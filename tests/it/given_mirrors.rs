//! Given mirrors from the profile to the verdict: formulas and grids of heights, against closed
//! forms that are written down here.

use crate::support::builds::{self, edited, files, folder, lasting, morion, save, told};
use crate::support::{placeless, unlimited};
use morion::internals::design::{Design, design};
use morion::internals::export::{read_obj, read_stl};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::stats::Summary;
use morion::internals::num::{hypot, radians, sin, tan};
use morion::internals::pipeline::{Silent, build, load, verify};
use morion::internals::profile::Profile;
use morion::internals::results::{BuildReport, Verdict};
use serde_json::Value;
use std::f64::consts::PI;
use std::{fmt::Write, path::PathBuf};
use tempfile::TempDir;

const ORTHOGRAPHIC: &str = "camera.orthographic.pixels = [96, 96]\n";
const PINHOLE: &str = "camera.pinhole = { pixels = [96, 96], focal_px = 160, distance_mm = 100 }\n";
const DISC: &str = "layout.disc = {}\npart = { width_mm = 60, base_mm = 5 }\n";
const ANNULUS: &str = "layout.annulus.inner_width_mm = 20\npart = { width_mm = 60, base_mm = 5 }\n";
const RECTANGLE: &str = "part = { width_mm = 60, height_mm = 45, base_mm = 5 }\n";
const CHORD: &str = "mesh.chord_um = 20\n";
const FACET: &str = "mesh.facet_px = 1\n";
const GRID: &str = "mirror.grid.file = \"data/sag.csv\"\n";
const HYPERBOLIC: &str = "projection.hyperbolic.outer_polar_deg = 110\n";

/// A build with all that is known about it.
struct Built {
    folder: TempDir,
    path: PathBuf,
    source: Profile,
    design: Design,
    report: BuildReport,
}

impl Built {
    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join("made/small").join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.file(name)).unwrap()
    }

    fn designed_px(&self) -> Summary {
        self.report.design.pixel_error_px.unwrap()
    }

    /// Largest facet and pixel errors of each file.
    fn traced_px(&self) -> Vec<[Summary; 2]> {
        let errors = self.report.trace.iter().map(|trace| trace.errors);
        errors.map(|e| [e.facet_error_px.unwrap(), e.pixel_error_px.unwrap()]).collect()
    }
}

/// The profile `text` on the disk, `heights` beside it.
fn saved(text: &str, heights: Option<&str>) -> (TempDir, PathBuf) {
    let folder = folder();
    let text = format!("{text}export.formats = [\"stl\", \"obj\"]\n");
    let path = save(&folder.path().join("profile"), &text);
    if let Some(heights) = heights {
        std::fs::create_dir(folder.path().join("profile/data")).unwrap();
        std::fs::write(folder.path().join("profile/data/sag.csv"), heights).unwrap();
    }
    (folder, path)
}

/// Builds `text`, which must pass with a sound solid, every ray hitting, and limits kept.
fn built(text: &str, heights: Option<&str>) -> Built {
    let (folder, path) = saved(text, heights);
    let mut source = load(path.to_str().unwrap()).unwrap_or_else(|error| panic!("{error}\n{text}"));
    source = unlimited(source);
    let report = build(&source, &folder.path().join("made"), &Silent)
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(report.verdict, Verdict::Pass, "{:?}\n{text}", report.reasons);
    assert_eq!(report.design.method, "given");
    let (mesh, solid) = (report.mesh.unwrap(), &report.solid.as_ref().unwrap().check);
    assert_eq!((solid.euler, solid.components), (2, 1), "{text}");
    assert!(solid.closed && solid.oriented && solid.manifold);
    assert!(mesh.chord_um.limit.is_none_or(|limit| mesh.chord_um.bound <= limit));
    for trace in &report.trace {
        assert!(trace.rays > 3000 && trace.hit == trace.rays, "{} of {}", trace.hit, trace.rays);
        if let Some(facet) = trace.errors.facet_error_px {
            assert!(facet.max <= mesh.facet_px.bound, "{facet:?} {:?}\n{text}", mesh.facet_px);
        }
    }
    let design = design(&source).unwrap();
    Built { folder, path, source, design, report }
}

/// The volume expected is `exact`, and the solid's is as near as the chords allow.
#[track_caller]
fn has_volume(built: &Built, exact: f64) {
    let solid = built.report.solid.as_ref().unwrap();
    let [expected, found] = [solid.volume_expected_mm3, solid.check.volume_mm3];
    assert!((expected / exact - 1.0).abs() < 1e-10, "{expected} {exact}");
    assert!((found / exact - 1.0).abs() < 2e-3, "{found} {exact}");
}

/// X, Y, Z lines of `f` on `count` x `count` nodes out to `reach`.
fn csv(count: usize, reach: f64, f: impl Fn(DVec2) -> f64) -> String {
    let at = |k: usize| reach * (2.0 * k as f64 / (count - 1) as f64 - 1.0);
    let mut text = "X mm,Y mm,Z mm\n".to_owned();
    for k in 0..count * count {
        let q = DVec2::new(at(k % count), at(k / count));
        writeln!(text, "{},{},{}", q.x, q.y, f(q)).unwrap();
    }
    text
}

/// R and k of the hyperboloid with its foci in the pinhole and in the viewpoint, from which the rim
/// is seen at 110 degrees; and its height, from the vertex.
fn hyperboloid() -> (f64, f64, impl Fn(DVec2) -> f64) {
    let (rim, pinhole, psi) = (30.0, 100.0, radians(110.0));
    let viewpoint = -rim / tan(psi);
    let [to_pinhole, to_viewpoint] = [hypot(rim, pinhole), rim / sin(psi)];
    let (a, c) = (0.5 * (to_pinhole - to_viewpoint), 0.5 * (pinhole - viewpoint));
    let b2 = c * c - a * a;
    let height = move |q: DVec2| -a * ((1.0 + q.length_squared() / b2).sqrt() - 1.0);
    (-b2 / a, -(c / a) * (c / a), height)
}

#[track_caller]
fn near(a: Summary, b: Summary, within: f64) {
    let off = [a.rms - b.rms, a.p95 - b.p95, a.max - b.max];
    assert!(off.iter().all(|off| off.abs() <= within), "{a:?} {b:?}");
}

#[test]
fn without_a_projection_geometry_and_outcomes_are_all_that_is_reported() {
    let rim = 30.0f64;
    let paraboloid = |r: f64| PI * rim * rim * rim * rim / (4.0 * r);
    let cap = |r: f64| {
        let h = r - (r * r - rim * rim).sqrt();
        PI * h * h * (3.0 * r - h) / 3.0
    };
    let bowl = |r: f64| PI * rim * rim * (r - (r * r - rim * rim).sqrt()) - cap(r);
    for (shape, volume) in [
        ("radius_mm = -40, conic = -1", paraboloid(40.0)),
        ("radius_mm = 150, conic = -1", paraboloid(150.0)),
        ("radius_mm = -50", cap(50.0)),
        ("radius_mm = 150", bowl(150.0)),
    ] {
        let mirror = format!("mirror.polynomial = {{ {shape} }}\n");
        let built = built(&[ORTHOGRAPHIC, DISC, CHORD, &mirror].concat(), None);
        has_volume(&built, PI * rim * rim * 5.0 + volume);
        let report: Value = serde_json::from_slice(&built.bytes("report.json")).unwrap();
        let at = |path: &str| report.pointer(path).unwrap_or_else(|| panic!("no {path}"));
        let errors = ["ray_error_mrad", "pixel_error_px", "facet_error_px"];
        let spreads = ["rms", "p95", "max"].map(|of| errors.map(|key| format!("{key}/{of}")));
        let spreads = spreads.as_flattened();
        let mut nulls: Vec<String> = spreads.iter().map(|s| format!("/trace/0/{s}")).collect();
        nulls.extend(spreads.iter().map(|s| format!("/trace/1/{s}")));
        let own = spreads.iter().filter(|s| !s.starts_with("facet"));
        nulls.extend(own.map(|s| format!("/design/{s}")));
        nulls.extend(["/frame", "/design/curl/max", "/mesh/facet_px/limit"].map(String::from));
        for path in nulls {
            assert!(at(&path).is_null(), "{path} is {}", at(&path));
        }
        for key in ["missed", "shadowed", "back_face"] {
            assert_eq!([0, 1].map(|k| at(&format!("/trace/{k}/{key}")).as_u64()), [Some(0); 2]);
        }
        assert!(at("/mesh/over_optimum/chord").as_f64().unwrap() >= 1.0);
        assert_eq!((at("/verdict"), at("/reasons")), (&"pass".into(), &Value::Array(vec![])));
    }
}

#[test]
fn the_paraboloid_of_the_law_is_the_designed_one() {
    let c = -0.5 * tan(radians(50.0)) / 30.0;
    let heights = csv(21, 30.0, |q| c * q.length_squared());
    let law = "projection.parabolic.outer_polar_deg = 100\n";
    let rest = [ORTHOGRAPHIC, DISC, FACET, law].concat();
    let (folder, path) = saved(&format!("{rest}method.vector-field.degree = 12\n"), None);
    let source = load(path.to_str().unwrap()).unwrap();
    let designed = build(&source, &folder.path().join("made"), &Silent).unwrap();
    let smooth = design(&source).unwrap().mirror;
    for mirror in [
        format!("mirror.polynomial = {{ radius_mm = {}, conic = -1 }}\n", 0.5 / c),
        format!("mirror.polynomial.terms = [[2, 0, {c}], [0, 2, {c}]]\n"),
        GRID.to_owned(),
    ] {
        let built = built(&format!("{rest}{mirror}"), Some(&heights));
        near(built.designed_px(), designed.design.pixel_error_px.unwrap(), 1e-6);
        for [facet, pixel] in built.traced_px() {
            near(facet, pixel, 1e-6);
        }
        // Another mesh of the same mirror: the same within what meshes differ by.
        let theirs = designed.trace[0].errors.pixel_error_px.unwrap().rms;
        let ours = built.traced_px()[0][1].rms;
        assert!((ours / theirs - 1.0).abs() < 0.35, "{ours} {theirs}");
        let frames = [&built.report, &designed].map(|report| report.frame.clone().unwrap());
        assert!((frames[0].filled - frames[1].filled).abs() < 1e-3);
        for (q, _) in smooth.outline.samples(12).concat() {
            let [a, b] = [&smooth, &built.design.mirror].map(|m| m.position(q, &m.surface.at(q)));
            assert!((a - b).length() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn the_hyperboloid_of_the_law_shows_the_facets_errors_alone() {
    let (radius, conic, _) = hyperboloid();
    let mirror = format!("mirror.polynomial = {{ radius_mm = {radius}, conic = {conic} }}\n");
    let seen = built(&[PINHOLE, DISC, FACET, HYPERBOLIC, &mirror].concat(), None);
    let frame = seen.report.frame.as_ref().unwrap();
    assert!(seen.designed_px().max < 1e-6 && frame.filled > 0.75);
    for [facet, pixel] in seen.traced_px() {
        near(facet, pixel, 1e-6);
        assert!(facet.max > 0.3, "{facet:?}");
    }
    let unseen = built(&[PINHOLE, DISC, CHORD, &mirror].concat(), None).report;
    assert!(unseen.frame.is_none() && unseen.trace[0].errors.pixel_error_px.is_none());
}

/// A spline's height is of the fourth order in the step, its slope of the third.
#[test]
fn a_grid_of_heights_shows_its_mirror_to_the_third_order() {
    let (_, _, height) = hyperboloid();
    let text = [PINHOLE, DISC, FACET, HYPERBOLIC, GRID].concat();
    let rms = [11, 21, 41].map(|count| {
        let (_folder, path) = saved(&text, Some(&csv(count, 30.0, &height)));
        let source = load(path.to_str().unwrap()).unwrap();
        let design = design(&source).unwrap();
        design.facts.pixel_error_px.unwrap().rms
    });
    assert!(rms.windows(2).all(|pair| pair[0] / pair[1] > 7.0), "{rms:?}");
    let built = built(&text, Some(&csv(41, 30.0, &height)));
    for [facet, pixel] in built.traced_px() {
        near(facet, pixel, 2.0 * built.designed_px().max);
    }
}

#[test]
fn faults_of_the_heights_are_told_once_with_their_place() {
    let text = [ORTHOGRAPHIC, DISC, CHORD, GRID].concat();
    let whole = csv(7, 30.0, |q| -0.01 * q.length_squared());
    let with = |from: &str, to: &str| edited(&whole, &[(from, to)]);
    for (heights, places) in [
        (None, ["sag.csv", "cannot read"]),
        (Some(with("\n0,-30,", "\n0,-30,low")), ["sag.csv: line 5: Z", "\"low"]),
        (Some(with("\n0,-30,-9\n", "\n0,-30\n")), ["sag.csv: line 5: ", "\"0,-30\""]),
        (Some(csv(3, 30.0, |_| 0.0)), ["sag.csv: ", "4 x 4 nodes, found 3 x 3"]),
        (Some(with("\n0,-30,", "\n3,-30,")), ["sag.csv: line 5: X", "found 3"]),
        (Some(with("\n0,-30,-9\n", "\n")), ["sag.csv: ", "missing, the first at X = 0, Y = -30"]),
        (Some(with("\n0,-30,", "\n10,-30,")), ["sag.csv: line 6: ", "of line 5 again"]),
        (Some(csv(7, 29.0, |_| 0.0)), ["X from -30 to 30", "X from -29 to 29"]),
    ] {
        let (folder, _) = saved(&text, heights.as_deref());
        let arguments = ["build", "profile/small.toml", "--out", "made", "--quiet"];
        let (code, out, err) = told(&morion(folder.path(), &arguments));
        assert_eq!((code, &*out, err.lines().count()), (2, "", 1), "{err}");
        assert!(places.iter().all(|place| err.contains(place)), "{err}");
        let made = std::fs::read_dir(folder.path().join("made/small"));
        assert_eq!(made.map_or(0, Iterator::count), 0);
    }
}

#[test]
fn facets_of_a_polynomial_are_on_its_closed_form() {
    type Sag = fn(DVec2) -> f64;
    let cases: [(&str, Sag); 3] = [
        ("[[1, 1, 0.01]]", |q| 0.01 * q.x * q.y),
        ("[[2, 0, 0.006], [0, 2, -0.008]]", |q| 0.006 * q.x * q.x - 0.008 * q.y * q.y),
        ("[[2, 0, -0.01], [1, 2, 2e-4], [0, 3, 1e-4], [0, 1, 0.1], [4, 0, 1e-6]]", |q| {
            let DVec2 { x, y } = q;
            -0.01 * x * x + 2e-4 * x * y * y + 1e-4 * y * y * y + 0.1 * y + 1e-6 * x * x * x * x
        }),
    ];
    for (terms, sag) in cases {
        let mirror = format!("mirror.polynomial.terms = {terms}\n");
        let built = built(&[ORTHOGRAPHIC, RECTANGLE, CHORD, &mirror].concat(), None);
        let (facts, mirror) = (built.report.mesh.unwrap(), &built.design.mirror);
        let mesh = read_obj(&built.bytes("mirror.obj")).unwrap().mesh;
        let up = mesh.corners(0)[0].z - sag(mesh.corners(0)[0].truncate());
        let bound = 1e-3 * facts.chord_um.bound + 1e-12;
        let (mut worst, mut lowest, mut at_corners) = (0.0f64, f64::INFINITY, 0);
        for t in 0..facts.optical_triangles {
            let corners = mesh.corners(t);
            for v in corners {
                let smooth = mirror.position(v.truncate(), &mirror.row(v.y).at(v.x));
                assert_eq!(v.z.to_bits(), smooth.z.to_bits(), "{v}");
                assert!((v.z - sag(v.truncate()) - up).abs() < 1e-12, "{v} {terms}");
                assert!(v.x.abs() <= 30.0 && v.y.abs() <= 22.5);
                at_corners += usize::from(v.x.abs() == 30.0 && v.y.abs() == 22.5);
                lowest = lowest.min(v.z);
            }
            for (i, j) in (0..=15).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let [a, b] = [i, j].map(|k| f64::from(k) / 15.0);
                let p = corners[0] * (1.0 - a) + corners[1] * (a - b) + corners[2] * b;
                worst = worst.max((p.z - sag(p.truncate()) - up).abs());
            }
        }
        assert!(worst <= bound && worst > 0.4 * bound, "{worst} {bound} {terms}");
        assert!(at_corners >= 4 && (lowest - 5.0).abs() < bound);
    }
}

/// Whatever the mirror shows, even the world behind what is wanted, half a turn away.
#[test]
#[ignore = "long: .ci/nightly"]
fn facets_of_a_strip_keep_their_bound() {
    let strip = "layout.strip = {}\npart = { width_mm = 60, base_mm = 5 }
projection.equirectangular = { azimuth_deg = [-90, 90], elevation_deg = [-30, 40] }\n";
    let tilts = [-0.6, 0.6].into_iter();
    for (tilt, camera) in tilts.flat_map(|tilt| [(tilt, PINHOLE), (tilt, ORTHOGRAPHIC)]) {
        let terms = format!("radius_mm = -60, terms = [[0, 1, {tilt}], [3, 0, 1e-5]]");
        let terms = format!("mirror.polynomial = {{ {terms} }}\n");
        let wave = |q: DVec2| tilt * q.y - q.length_squared() / 120.0 + 0.1 * sin(q.x / 9.0);
        for mirror in [&terms, GRID] {
            let text = [camera, strip, CHORD, FACET, mirror].concat();
            let built = built(&text, Some(&csv(31, 30.0, wave)));
            assert_eq!(built.designed_px().max > 80.0, tilt > 0.0);
            for [facet, _] in built.traced_px() {
                let bound = built.report.mesh.unwrap().facet_px.bound;
                assert!(facet.max > 0.2 * bound && bound <= 1.0, "{facet:?} {bound}");
            }
        }
    }
}

#[test]
fn an_annulus_has_a_flat_land_and_no_hole() {
    let (a, b) = (30.0f64, 10.0f64);
    let part = PI * (a * a - b * b) / 4.0;
    for (radius, volume) in
        [(-40.0, part * (a * a + b * b) / 40.0), (150.0, part * (a * a - b * b) / 150.0)]
    {
        for camera in [ORTHOGRAPHIC, PINHOLE] {
            let mirror = format!("mirror.polynomial = {{ radius_mm = {radius}, conic = -1 }}\n");
            let built = built(&[camera, ANNULUS, CHORD, &mirror].concat(), None);
            has_volume(&built, PI * a * a * 5.0 + volume);
            let land = (b * b - if radius < 0.0 { a * a } else { b * b }) / (2.0 * radius) + 5.0;
            let inside = |v: &&DVec3| v.truncate().length() < b - 1e-6 && v.z > 0.0;
            let obj = read_obj(&built.bytes("mirror.obj")).unwrap();
            for v in obj.mesh.vertices.iter().filter(inside) {
                assert!((v.z - land).abs() < 1e-6, "{v}, land {land}");
            }
        }
    }
}

#[test]
fn verify_passes_the_own_file_and_finds_a_vertex_ten_micrometres_off() {
    let terms = "mirror.polynomial.terms = [[1, 1, 0.01], [2, 0, -0.004]]\n";
    let heights = csv(21, 30.0, |q| 0.01 * q.x * q.y - 0.004 * q.x * q.x);
    for (camera, mirror) in [(ORTHOGRAPHIC, terms), (PINHOLE, GRID)] {
        let built =
            built(&[camera, RECTANGLE, "mesh.chord_um = 5\n", mirror].concat(), Some(&heights));
        let profile = built.path.to_str().unwrap();
        for name in ["mirror.stl", "mirror.obj"] {
            let report = verify(&built.source, &built.file(name), &Silent).unwrap();
            assert_eq!(report.verdict, Verdict::Pass, "{:?}", report.reasons);
            let file = built.file(name).display().to_string();
            let arguments = ["verify", &*file, "--profile", profile, "--quiet"];
            let (code, out, err) = told(&morion(built.folder.path(), &arguments));
            assert_eq!(code, 0, "{out}{err}");
        }
        let mut stl = built.bytes("mirror.stl");
        let mesh = read_stl(&stl).unwrap().mesh;
        let inside = |v: &&DVec3| v.x.abs() < 25.0 && v.y.abs() < 20.0 && v.z > 0.0;
        let v = mesh.vertices.iter().filter(inside).nth(100).unwrap().as_vec3();
        let bytes = |z: f32| [v.x, v.y, z].map(f32::to_le_bytes).concat();
        let (from, to) = (bytes(v.z), bytes(v.z + 0.01));
        let corners = stl[84..].chunks_mut(50).flat_map(|facet| facet[12..48].chunks_mut(12));
        let moved = corners.filter(|corner| *corner == from).map(|c| c.copy_from_slice(&to));
        assert!(moved.count() >= 3);
        std::fs::write(built.file("moved.stl"), stl).unwrap();
        let report = verify(&built.source, &built.file("moved.stl"), &Silent).unwrap();
        let worst = report.trace[0].worst_vertex.unwrap();
        assert!((worst.off_mm - 0.01).abs() < 2e-5, "{worst:?}");
        assert_eq!((report.verdict, report.reasons.len()), (Verdict::Fail, 1));
        assert!(report.reasons[0].to_string().contains(&format!("the vertex ({}", f64::from(v.x))));
        let arguments = ["verify", "made/small/moved.stl", "--profile", profile, "--quiet"];
        assert_eq!(told(&morion(built.folder.path(), &arguments)).0, 1);
    }
}

#[test]
fn one_thread_and_two_write_the_same_bytes() {
    let (radius, conic, height) = hyperboloid();
    let conic = format!("mirror.polynomial = {{ radius_mm = {radius}, conic = {conic} }}\n");
    let terms = "mirror.polynomial = { radius_mm = -90, terms = [[1, 1, 0.01]] }\n";
    let heights = csv(15, 30.0, height);
    for text in [
        [PINHOLE, DISC, FACET, HYPERBOLIC, &conic].concat(),
        [PINHOLE, ANNULUS, CHORD, GRID].concat(),
        [ORTHOGRAPHIC, RECTANGLE, CHORD, terms].concat(),
    ] {
        let (folder, _) = saved(&text, Some(&heights));
        let made = ["1", "2"].map(|n| {
            let arguments = ["build", "profile/small.toml", "--out", n, "--threads", n];
            let (code, out, err) = told(&morion(folder.path(), &arguments));
            assert_eq!(code, 0, "{out}{err}");
            (placeless(&out), lasting(files(&folder.path().join(n).join("small"))))
        });
        assert_eq!(made[0].0, made[1].0);
        builds::assert_same(&made[0].1, &made[1].1, "1 thread and 2");
    }
}
