//! Tables of polar angles on discs and annuli: mirrors of the laws that they are samples of, and `soccer`.

use crate::support::oracle::{self, Trace, Wish, eye, order, pinhole, polar, trace};
use crate::support::{designed, rims, share, shipped, shipped_but};
use morion::internals::design::Design;
use morion::internals::geom::DVec2;
use morion::internals::num::{atan, degrees, radians};

const FAR: f64 = f64::INFINITY;
/// The outer polar angle of every law here, degrees.
const OUTER: f64 = 80.0;

fn camera(distance: f64) -> String {
    if distance.is_finite() { pinhole(distance) } else { oracle::ORTHOGRAPHIC.into() }
}

/// The polar angle that image radius `r` must see from the target's origin, radians.
fn wanted(design: &Design, r: f64) -> f64 {
    let [x, y] = design.view.as_ref().unwrap().projection.direction_of([r, 0.0]);
    2.0 * atan(DVec2::new(x, y).length())
}

/// The key of the table of `n` + 1 even samples of the law of a mirror.
fn table(design: &Design, n: u32) -> String {
    let [inner, outer] = rims(design);
    let row = |k: u32| {
        let share = f64::from(k) / f64::from(n);
        let r = inner + share * (outer - inner);
        [share, if r == 0.0 { 0.0 } else { degrees(wanted(design, r)) }]
    };
    let rows: Vec<[f64; 2]> = (0..=n).map(row).collect();
    format!("[projection.table]\npolar_deg = {rows:?}")
}

/// The largest difference of two round mirrors' heights at equal shares of the way between their rims, of the width.
fn apart(a: &Design, b: &Design) -> f64 {
    let height = |design: &Design, share: f64| {
        let [inner, outer] = rims(design);
        let at = trace(design, None, DVec2::X * (inner + share * (outer - inner))).at;
        at.z - design.mirror.chart.plane_mm
    };
    let share = |k: u32| f64::from(k) / 60.0;
    let off = |k| (height(a, share(k)) - height(b, share(k))).abs();
    (0..=60).map(off).fold(0.0, f64::max) / 60.0
}

/// A law as a profile names it, and the mirror that it makes.
struct Named {
    name: &'static str,
    distance: f64,
    inner_mm: f64,
    target: &'static str,
}

impl Named {
    fn wish(&self) -> Wish {
        let two =
            ["equiangular", "tangent-proportional", "area-proportional", "equi-areal", "cylinder"];
        let inner = match self.inner_mm > 0.0 && two.contains(&self.name) {
            true => "\ninner_polar_deg = 35",
            false => "",
        };
        let law = format!("[projection.{}]\nouter_polar_deg = {OUTER:?}{inner}", self.name);
        Wish::round(&camera(self.distance), &law, self.inner_mm, 40).before(self.target)
    }

    /// The mirror of a table, in the place of the law.
    fn of(&self, table: &str) -> Design {
        Wish::round(&camera(self.distance), table, self.inner_mm, 40).before(self.target).made()
    }
}

/// Every law with the cameras and rims that it has, far away and before targets.
fn laws() -> Vec<Named> {
    let mut laws = Vec::new();
    for name in [
        "parabolic",
        "hyperbolic",
        "conical",
        "equiangular",
        "tangent-proportional",
        "area-proportional",
        "plane",
        "equi-areal",
        "cylinder",
    ] {
        for distance in [FAR, 100.0] {
            let has_camera = match name {
                "parabolic" => distance == FAR,
                "hyperbolic" | "conical" => distance < FAR,
                _ => true,
            };
            let ring = ["conical", "area-proportional", "cylinder"].contains(&name);
            for (inner_mm, target) in [
                (0.0, ""),
                (16.0, ""),
                (0.0, "target_plane_mm = 400"),
                (16.0, "target_plane_mm = 400"),
                (16.0, "target_radius_mm = 300"),
            ] {
                // What lies along the axis never meets a cylinder: these laws choose their inner angle.
                let on_axis = name == "plane" && target.contains("radius");
                if has_camera && (inner_mm > 0.0 || !ring) && !on_axis {
                    laws.push(Named { name, distance, inner_mm, target });
                }
            }
        }
    }
    laws
}

#[test]
#[ignore = "long: .ci/nightly"]
fn tables_of_a_law_give_its_mirror_to_third_order() {
    for law in share(4, 1, laws()) {
        let named = law.wish().made();
        let points =
            [8u32, 16, 32].map(|n| (f64::from(n), apart(&named, &law.of(&table(&named, n)))));
        let what = format!("{} {} {} {}", law.name, law.distance, law.inner_mm, law.target);
        let order = order(&points);
        println!("{what}: {order:.2} {points:?}");
        // Heights are integrals of slopes that err by either sign: the order may be higher.
        assert!(points[2].1 < 1e-5, "{what}: {points:?}");
        assert!(points[0].1 < 1e-11 || order < -2.7, "{what}: {order} {points:?}");
    }
}

#[test]
fn two_entries_are_the_law_that_is_linear_in_the_radius() {
    for distance in [FAR, 100.0] {
        for inner_mm in [0.0, 16.0] {
            for target in ["", "target_plane_mm = 400"] {
                let law = Named { name: "tangent-proportional", distance, inner_mm, target };
                let named = law.wish().made();
                let inner = if inner_mm > 0.0 { 35.0 } else { 0.0 };
                let rows = format!("polar_deg = [[0, {inner:?}], [1, {OUTER:?}]]");
                let table = law.of(&format!("[projection.table]\n{rows}"));
                let off = apart(&named, &table);
                assert!(off < 1e-13, "{distance} {inner_mm} {target}: {off:e}");
            }
        }
    }
}

/// Near the axis the polar angle is a rate times the image radius, r = D theta, and the normal halves the angle between
/// the ray back to the camera, at -theta, and what is seen: its slope over X = d theta is (rate D - 1) / 2d at the
/// depth d of the centre, under parallel rays rate / 2.
#[test]
fn the_centre_is_curved_by_the_tables_rate() {
    for distance in [FAR, 100.0] {
        let law = Named { name: "table", distance, inner_mm: 0.0, target: "" };
        let design = law.of("[projection.table]\npolar_deg = [[0, 0], [0.5, 40], [1, 80]]");
        let eye = eye(&design, distance);
        let Trace { at, normal, .. } = trace(&design, eye, DVec2::X * 1e-3);
        let rate = radians(OUTER) / 30.0;
        let curvature = match eye {
            Some(eye) => (rate * distance - 1.0) / (2.0 * (eye.z - at.z)),
            None => 0.5 * rate,
        };
        let found = normal.x / normal.z / at.x;
        assert!((found / curvature - 1.0).abs() < 1e-7, "{distance}: {found} {curvature}");
    }
}

/// Entries are met by the mirror itself: image points at the shares see the polar angles.
#[test]
fn entries_are_seen_where_the_table_has_them() {
    let rows = [[0.0, 30.0], [0.2, 41.0], [0.35, 44.0], [0.6, 80.0], [1.0, 104.0]];
    for distance in [FAR, 100.0] {
        for (first, inner_mm) in [(0.0, 0.0), (30.0, 16.0)] {
            let mut rows = rows;
            rows[0][1] = first;
            let keys = format!("[projection.table]\npolar_deg = {rows:?}");
            let design = Wish::round(&camera(distance), &keys, inner_mm, 40).made();
            let ([inner, outer], eye) = (rims(&design), eye(&design, distance));
            for [share, degrees_wanted] in rows.into_iter().skip(1) {
                let q = DVec2::new(0.6, -0.8) * (inner + share * (outer - inner));
                // The design's projection has them exactly, the polynomial to what it can follow.
                let off = degrees(wanted(&design, q.length())) - degrees_wanted;
                assert!(off.abs() < 1e-11, "{share}: {off:e}");
                let seen = degrees(polar(trace(&design, eye, q).seen)) - degrees_wanted;
                assert!(seen.abs() < 0.1, "{distance} {inner_mm} {share}: {seen:e}");
            }
            let width = 2.0 * trace(&design, eye, DVec2::X * inner).at.x;
            assert!((width - inner_mm).abs() < 1e-10, "{width}");
        }
    }
}

/// Height of the mirror's rim over the floor in the comments of `soccer`, mm.
const RIM_MM: f64 = 200.0;

#[test]
fn soccer_shows_the_floor_in_even_steps_and_the_horizon_in_a_ring() {
    let design = designed(&shipped("soccer"));
    let [_, outer] = rims(&design);
    let eye = eye(&design, 68.1);
    let look = |share: f64| trace(&design, eye, DVec2::new(-0.8, 0.6) * (share * outer));
    let rim = look(1.0).at.z;
    for k in 6..=60 {
        let share = f64::from(k) / 100.0;
        let Trace { at, seen, .. } = look(share);
        // The floor is on the camera's side of the mirror.
        let floor = at + seen * ((rim + RIM_MM - at.z) / seen.z);
        let steps = floor.truncate().length() / (1000.0 / 0.6 * share);
        assert!((steps - 1.0).abs() < 0.02, "{share}: {steps}");
    }
    let angle = |share: f64| degrees(polar(look(share).seen));
    for k in 0..=30 {
        let share = 0.7 + f64::from(k) / 100.0;
        let even = 83.0 + 40.0 * (share - 0.7);
        assert!((angle(share) - even).abs() < 0.1, "{share}: {}", angle(share));
    }
}

/// The law's second derivative jumps at entries, and what a polynomial leaves of that falls with its degree squared.
#[test]
fn what_the_polynomial_leaves_falls_with_the_square_of_its_degree() {
    let points = [20u32, 24, 28, 32, 36, 40].map(|degree| {
        let text = format!("degree = {degree} ");
        let design = designed(&shipped_but("soccer", &[("degree = 40 ", &text)]));
        (f64::from(degree), design.facts.pixel_error_px.unwrap().rms)
    });
    println!("{points:?}");
    assert!(order(&points) < -2.0, "{points:?}");
}
