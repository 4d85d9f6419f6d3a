//! Every facet keeps the bound that was proven for it, and the limit that was asked for; the face
//! is straight-rimmed, upright and symmetric to the last bit.
//!
//! The true errors are sampled here from the mirror itself, with nothing of the proof.

use crate::support::{designed, limits, meshed, profile, sag, share, shipped, with_limits};
use morion::internals::design::Design;
use morion::internals::geom::{
    DVec2, DVec3, Outline, PartFeatures, Precision, Rect, TriMesh, turn,
};
use morion::internals::mesh::{ErrorBound, ErrorBounder, Face, Limits};
use morion::internals::profile::Profile;
use morion::internals::solid::Solid;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// What rounding in the samples themselves may add, mm: an ulp of the sag and of the image.
const ULP: f64 = 1e-12;
/// Facets that are sampled densely.
const DENSE: usize = 3000;

/// Largest sampled errors, mm.
#[derive(Debug, Clone, Copy, Default)]
struct Sampled {
    chord: f64,
    facet: f64,
}

impl Sampled {
    fn max(self, other: Self) -> Self {
        Self { chord: self.chord.max(other.chord), facet: self.facet.max(other.facet) }
    }
}

/// Barycentric weights of an even grid of `n` steps a side, rim included.
fn weights(n: u32) -> Vec<[f64; 3]> {
    (0..=n)
        .flat_map(|i| (0..=n - i).map(move |j| [i, j, n - i - j]))
        .map(|w| w.map(|k| f64::from(k) / f64::from(n)))
        .collect()
}

/// The errors of the flat facet against the mirror at the given places of it.
fn sampled(design: &Design, corners: [DVec3; 3], places: &[[f64; 3]]) -> Sampled {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let flat = -normal.truncate() / normal.z;
    let (mirror, view) = (&design.mirror, design.view.as_ref().unwrap());
    let at = |w: &[f64; 3]| {
        let point = a * w[0] + b * w[1] + c * w[2];
        // On one camera ray.
        let (q, _) = mirror.chart.coordinates(point);
        let smooth = mirror.surface.at(q);
        let place = mirror.position(q, &smooth);
        let shown = |at: DVec3, slope: DVec2| {
            let content =
                view.image_of_seen(&design.camera.chart, at.to_array(), slope.to_array(), q);
            DVec2::from_array(content)
        };
        let facet = (shown(point, flat) - shown(place, mirror.slope(q, &smooth))).length();
        Sampled { chord: (point - place).length(), facet }
    };
    // A NaN is no error that `max` would pass on.
    let checked = |s: Sampled| {
        assert!(s.chord.is_finite() && s.facet.is_finite(), "{corners:?}: {s:?}");
        s
    };
    places.iter().map(at).map(checked).fold(Sampled::default(), Sampled::max)
}

fn rounded(corner: DVec3) -> DVec3 {
    corner.as_vec3().as_dvec3()
}

/// Samples every facet of the designed panel coarsely and an even choice of them densely, as
/// designed and as single precision leaves it; each must keep its own bound.
fn largest_errors(design: &Design, face: &Face) -> Sampled {
    let bounder = ErrorBounder::new(
        &design.mirror,
        &design.camera.chart,
        design.view.as_ref(),
        Precision::Single,
    );
    let (coarse, dense) = (weights(2), weights(9));
    let stride = face.designed.div_ceil(DENSE);
    let facet = |t: usize| {
        let corners = face.mesh.corners(t);
        let vertex = |v: DVec3| {
            let (q, _) = design.mirror.chart.coordinates(v);
            // Under parallel rays meshed at single-precision image points.
            let single = design.mirror.chart.vergence == 0.0;
            let q = if single { q.as_vec2().as_dvec2() } else { q };
            bounder.vertex_at(q)
        };
        let [a, b, c] = corners.map(vertex);
        let bound = bounder.bound([&a, &b, &c]);
        let places = if t.is_multiple_of(stride) { &dense } else { &coarse };
        let exact = sampled(design, corners, places);
        let single = sampled(design, corners.map(rounded), places);
        for (found, digits) in [(exact, "double"), (single, "single")] {
            assert!(
                found.chord <= bound.chord_mm + ULP && found.facet <= bound.facet_mm + ULP,
                "facet {t} at {} in {digits} precision has {found:?}, over its {bound:?}",
                corners[0]
            );
        }
        exact.max(single)
    };
    (0..face.designed).into_par_iter().map(facet).reduce(Sampled::default, Sampled::max)
}

fn keeps(bound: &ErrorBound, limits: &Limits) -> bool {
    let within = |found: f64, limit: Option<f64>| limit.is_none_or(|limit| found <= limit);
    within(bound.chord_mm, limits.chord_mm) && within(bound.facet_mm, limits.facet_mm)
}

/// Meshes `profile` and holds everything about its face; returns what share of the bounds the
/// samples reach.
fn hold(profile: &Profile) -> Sampled {
    let design = designed(profile);
    let face = meshed(profile, &design).unwrap_or_else(|error| panic!("{error}"));
    let limits = limits(profile, &design);
    assert!(keeps(&face.bound, &limits), "{:?} over {limits:?}", face.bound);
    let found = largest_errors(&design, &face);
    assert!(
        found.chord <= face.bound.chord_mm + ULP && found.facet <= face.bound.facet_mm + ULP,
        "{found:?} over the reported {:?}",
        face.bound
    );
    hold_shape(&design, &face);
    let share = Sampled {
        chord: found.chord / face.bound.chord_mm,
        facet: found.facet / face.bound.facet_mm,
    };
    println!(
        "{} facets; bound {:.4} um {:.4} px; sampled over bound: chord {:.3}, facet {:.3}",
        face.mesh.triangles.len(),
        face.bound.chord_mm * 1e3,
        face.bound.facet_mm / design.camera.pixel_mm,
        share.chord,
        share.facet
    );
    share
}

/// The face's outline, facets and symmetry, to the last bit.
fn hold_shape(design: &Design, face: &Face) {
    let mesh = &face.mesh;
    for &v in &mesh.vertices {
        let (q, _) = design.mirror.chart.coordinates(v);
        if design.mirror.chart.vergence != 0.0 {
            continue;
        }
        assert_eq!(q.as_vec2().as_dvec2(), q, "X and Y are no single-precision numbers");
    }
    let mut shadow = 0.0;
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t).map(|v| rounded(v).truncate());
        let area = turn(a, b, c);
        assert!(area > 0.0, "facet {t} is empty or inverted: {a} {b} {c}");
        shadow += 0.5 * area;
    }
    match design.mirror.full_outline() {
        Outline::Rect(rect) if design.mirror.chart.vergence == 0.0 => {
            assert!((shadow / rect.area() - 1.0).abs() < 1e-9, "{shadow} of {}", rect.area());
            hold_rim(rect, mesh);
        }
        Outline::Rect(_) => {}
        Outline::Ring { inner, outer } => hold_round_rims(design, mesh, [inner, outer], shadow),
    }
    for (even, axis) in design.mirror.mirror_symmetric.into_iter().zip([DVec3::X, DVec3::Y]) {
        assert!(!even || is_symmetric(mesh, 1.0 - 2.0 * axis), "not symmetric along {axis}");
    }
    if design.mirror.folded {
        assert_eq!(2 * face.designed, mesh.triangles.len());
        assert!(is_symmetric(mesh, DVec3::new(1.0, -1.0, 1.0)), "not symmetric in Y");
    }
    for precision in [Precision::Single, Precision::Double] {
        let solid = Solid::from_face(mesh, PartFeatures::NONE, precision);
        assert!(solid.is_ok(), "{precision:?}: {}", solid.unwrap_err());
    }
}

/// How many facets each edge has.
fn edges(mesh: &TriMesh) -> HashMap<(u32, u32), u32> {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from.min(to), from.max(to))).or_default() += 1;
        }
    }
    edges
}

/// Every edge with one facet runs along one of the round rims, cutting little of it.
fn hold_round_rims(design: &Design, mesh: &TriMesh, radii: [f64; 2], shadow: f64) {
    let rims = radii.map(|r| {
        let q = DVec2::new(r, 0.0);
        design.mirror.position(q, &design.mirror.surface.at(q)).x
    });
    let mut counts = [0; 2];
    for ((a, b), _) in edges(mesh).into_iter().filter(|&(_, count)| count == 1) {
        let [a, b] = [a, b].map(|v| mesh.vertices[v as usize].truncate());
        let rim = usize::from(rims[0] == 0.0 || (a.length() - rims[1]).abs() < 1e-4 * rims[1]);
        for end in [a, b] {
            assert!((end.length() / rims[rim] - 1.0).abs() < 2e-7, "{end} off the rim {rims:?}");
        }
        let cut = 1.0 - (0.5 * (a + b)).length() / rims[rim];
        assert!(cut < 1.01 * Outline::EDGE, "a chord of the rim cuts {cut}");
        counts[rim] += 1;
    }
    assert!(counts[1] > 100 && (counts[0] > 50) == (rims[0] > 0.0), "{counts:?}");
    let area = std::f64::consts::PI * (rims[1] - rims[0]) * (rims[1] + rims[0]);
    assert!((shadow / area - 1.0).abs() < 2.0 * Outline::EDGE, "{shadow} of {area}");
}

/// Every edge with one facet lies on one side of the outline, and the corners are vertices.
fn hold_rim(outline: Rect, mesh: &TriMesh) {
    let edges = edges(mesh);
    let sides = |v: u32| {
        let q = mesh.vertices[v as usize];
        [q.x == outline.min.x, q.x == outline.max.x, q.y == outline.min.y, q.y == outline.max.y]
    };
    let mut corners = HashSet::new();
    for (&(a, b), &count) in &edges {
        assert!(count <= 2, "an edge with {count} facets");
        if count == 1 {
            let (on_a, on_b) = (sides(a), sides(b));
            let shared = on_a.iter().zip(on_b).filter(|&(a, b)| *a && b).count();
            assert_eq!(shared, 1, "a rim edge leaves the outline {outline:?}");
            for (v, on) in [(a, on_a), (b, on_b)] {
                if on.iter().filter(|&&on| on).count() == 2 {
                    corners.insert(v);
                }
            }
        }
    }
    assert_eq!(corners.len(), 4, "the outline's corners");
}

/// Whether the facets are, bit for bit, those of the mesh's mirror image.
fn is_symmetric(mesh: &TriMesh, flip: DVec3) -> bool {
    let bits = |v: DVec3| (v + DVec3::ZERO).to_array().map(f64::to_bits);
    let facets = |flip: DVec3| {
        let mut facets: Vec<_> = (0..mesh.triangles.len())
            .map(|t| {
                let mut corners = mesh.corners(t).map(|v| bits(v * flip));
                corners.sort_unstable();
                corners
            })
            .collect();
        facets.sort_unstable();
        facets
    };
    facets(DVec3::ONE) == facets(flip)
}

const SHIPPED: [&str; 3] = ["panoramic", "conquistador", "conformal"];

/// A few of the round ones, for both cameras, discs and rings.
const ROUND: [&str; 5] = ["parabolic", "hyperbolic", "conical", "plane", "cylinder"];

#[test]
#[ignore = "long: .ci/nightly"]
fn round_mirrors_keep_their_bounds_and_have_round_rims() {
    for name in share(2, 0, ROUND) {
        println!("{name}");
        let share = hold(&shipped(name));
        assert!(share.facet >= 0.7, "{name}: samples reach {share:?} of the bounds");
    }
}

#[test]
fn chord_limits_of_round_mirrors_are_kept_and_not_idle() {
    for name in share(2, 1, ROUND) {
        println!("{name}");
        let share = hold(&with_limits(shipped(name), Some(5.0), None));
        assert!(share.chord >= 0.5, "{name}: samples reach {share:?}");
    }
}

const PINHOLE: &[(&str, &str)] = &[(
    "camera.orthographic.pixels = [640, 480]",
    "camera.pinhole = { pixels = [640, 480], focal_px = 1600, distance_mm = 150 }",
)];
const NEAR: (&str, &str) = ("[-30, 30] }", "[-30, 30], target_radius_mm = 400 }");

#[test]
#[ignore = "long: .ci/nightly"]
fn pinholes_and_near_targets_keep_their_bounds() {
    let crest = ("layout.strip = {}", "layout.conquistador = {}");
    let cases = [
        ("pinhole", vec![PINHOLE[0]]),
        ("near", vec![NEAR]),
        ("both, folded", vec![PINHOLE[0], NEAR, crest]),
        ("both", vec![PINHOLE[0], NEAR]),
    ];
    for (what, edits) in share(2, 0, &cases) {
        println!("{what}");
        let share = hold(&profile(edits));
        assert!(share.facet >= 0.6, "{what}: samples reach {share:?} of the bounds");
    }
    for (what, edits) in share(2, 1, &cases) {
        println!("{what}, chord");
        hold(&with_limits(profile(edits), Some(10.0), None));
    }
}

#[test]
#[ignore = "long: .ci/nightly"]
fn shipped_profiles_keep_their_bounds_and_the_facet_bound_is_not_idle() {
    for name in share(2, 0, SHIPPED) {
        let share = hold(&shipped(name));
        assert!(share.facet >= 0.8, "{name}: samples reach {share:?} of the bounds");
    }
}

#[test]
fn chord_limits_alone_are_kept_and_not_idle() {
    for (k, name) in SHIPPED.into_iter().enumerate() {
        for um in share(3, k, [0.5, 2.0, 20.0]) {
            let share = hold(&with_limits(shipped(name), Some(um), None));
            assert!(share.chord >= 0.6, "{name} at {um} um: samples reach {share:?}");
        }
    }
}

#[test]
fn facet_limits_alone_are_kept_and_not_idle() {
    for (k, name) in SHIPPED.into_iter().enumerate() {
        for px in share(3, k, [2.0, 3.0, 10.0]) {
            let share = hold(&with_limits(shipped(name), None, Some(px)));
            assert!(share.facet >= 0.7, "{name} at {px} px: samples reach {share:?}");
        }
    }
}

#[test]
fn both_limits_are_kept_whichever_rules() {
    for (k, name) in SHIPPED.into_iter().enumerate() {
        for (um, px) in share(3, k, [(5.0, 5.0), (50.0, 2.0), (1.0, 10.0)]) {
            hold(&with_limits(shipped(name), Some(um), Some(px)));
        }
    }
}

/// Layouts and projections at the far ends of what a profile may ask, each with its edits.
const CASES: [(&str, &[(&str, &str)]); 14] = [
    ("uneven azimuth", &[("[-180, 180]", "[-170, 60]")]),
    ("a small window far round", &[("[-180, 180]", "[200, 290]"), ("[-30, 30]", "[5, 20]")]),
    ("a window about the back", &[("[-180, 180]", "[90, 270]")]),
    ("section", &[("layout.strip", "layout.conquistador"), ("{}", "{ panel = \"section\" }")]),
    ("valley", &[("layout.strip", "layout.conquistador"), ("{}", "{ ridge = \"valley\" }")]),
    (
        "a section's valley",
        &[
            (
                "layout.strip = {}",
                "layout.conquistador = { panel = \"section\", ridge = \"valley\" }",
            ),
            ("cylindrical", "mercator"),
        ],
    ),
    ("a filled frame", &[("{}", "{ fill_frame = true }"), ("640, 480", "640, 240")]),
    (
        "a filled conformal frame",
        &[("{}", "{ fill_frame = true }"), ("cylindrical", "mercator"), ("640, 480", "480, 480")],
    ),
    ("60 degrees", &[("[-30, 30]", "[-60, 60]"), ("degree = 12", "degree = 24")]),
    ("60 degrees, conformal", &[("[-30, 30]", "[-60, 60]"), ("cylindrical", "mercator")]),
    (
        "75 degrees, conformal",
        &[("[-30, 30]", "[-75, 75]"), ("cylindrical", "mercator"), ("degree = 12", "degree = 24")],
    ),
    ("low degree", &[("degree = 12", "degree = 3"), ("[-180, 180]", "[-60, 60]")]),
    ("high degree", &[("degree = 12", "degree = 24")]),
    ("looking up", &[("[-30, 30]", "[10, 50]"), ("cylindrical", "mercator")]),
];

#[test]
fn every_layout_and_range_keeps_its_bounds() {
    for (what, edits) in share(3, 0, CASES) {
        println!("{what}");
        hold(&profile(edits));
    }
}

#[test]
fn every_layout_and_range_keeps_a_chord_limit() {
    for (what, edits) in share(3, 1, CASES) {
        println!("{what}");
        let share = hold(&with_limits(profile(edits), Some(10.0), None));
        assert!(share.chord >= 0.6, "{what}: samples reach {share:?}");
    }
}

#[test]
fn samples_see_a_facet_that_is_off() {
    let design = designed(&shipped("panoramic"));
    let corner = |x: f64, y: f64| {
        let q = DVec2::new(x, y);
        q.extend(sag(&design, q))
    };
    let corners = [corner(1.0, 1.0), corner(1.2, 1.0), corner(1.1, 1.2)];
    let before = sampled(&design, corners, &weights(9));
    let tilted = [corners[0] + DVec3::Z * 0.01, corners[1], corners[2]];
    let after = sampled(&design, tilted, &weights(9));
    assert!(after.chord > 0.009 && after.chord > 5.0 * before.chord);
    assert!(after.facet > before.facet + 0.2);
}
