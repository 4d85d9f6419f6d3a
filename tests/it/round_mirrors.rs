//! Round mirrors against the literature's closed forms, or quadratures of the law's definition.

use crate::support::oracle::{self, Wish, acos, eye, integral, pinhole, polar, rad, trace};
use crate::support::{builds::parsed, rims, shipped_text};
use morion::internals::design::{Design, DesignError, FailureCause, design};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{atan, atan2, cos, exp, hypot, log, sin, tan};

const WIDTH: f64 = 60.0;

/// A round mirror by its definition alone.
struct Round {
    name: &'static str,
    /// Infinite for parallel rays.
    distance: f64,
    inner_mm: f64,
    psi: [f64; 2],
}

/// Every shipped round mirror, as its profile says.
const SHIPPED: [Round; 9] = [
    Round { name: "parabolic", distance: f64::INFINITY, inner_mm: 0.0, psi: [0.0, 100.0] },
    Round { name: "hyperbolic", distance: 100.0, inner_mm: 0.0, psi: [0.0, 110.0] },
    Round { name: "conical", distance: 100.0, inner_mm: 16.0, psi: [f64::NAN, 100.0] },
    Round { name: "equiangular", distance: 100.0, inner_mm: 0.0, psi: [0.0, 120.0] },
    Round { name: "tangent-proportional", distance: 100.0, inner_mm: 0.0, psi: [0.0, 120.0] },
    Round { name: "area-proportional", distance: 100.0, inner_mm: 16.0, psi: [20.0, 120.0] },
    Round { name: "plane", distance: f64::INFINITY, inner_mm: 0.0, psi: [0.0, 65.0] },
    Round { name: "equi-areal", distance: f64::INFINITY, inner_mm: 0.0, psi: [0.0, 110.0] },
    Round { name: "cylinder", distance: 100.0, inner_mm: 16.0, psi: [60.0, 120.0] },
];

impl Round {
    fn design(&self) -> Design {
        design(&parsed(shipped_text(self.name))).unwrap()
    }

    /// theta of image radius `r`.
    fn theta(&self, r: f64) -> f64 {
        atan(r / self.distance)
    }

    /// psi at image radius `r` when the inner rim is at image radius `inner`.
    fn polar(&self, r: f64, inner: f64) -> f64 {
        let [psi0, psi1] = self.psi.map(rad);
        let outer = 0.5 * WIDTH;
        let between = |x: f64, x0: f64, x1: f64| (x - x0) / (x1 - x0);
        let angle = |r: f64| if self.distance.is_finite() { self.theta(r) } else { r };
        let linear = |t: f64, a: f64, b: f64| a + (b - a) * t;
        match self.name {
            "parabolic" => 2.0 * atan(tan(0.5 * psi1) * r / outer),
            "hyperbolic" => {
                let [z2, a2] = self.hyperboloid();
                // The point at distance rho along theta with |P F1| - |P F2| = 2a.
                let t = self.theta(r);
                let rho = (z2 * z2 - a2 * a2) / (2.0 * (-a2 - z2 * cos(t)));
                let [x, z] = [rho * sin(t), -rho * cos(t)];
                atan2(x, z - z2)
            }
            "conical" => psi1 - self.theta(outer) + self.theta(r),
            "equiangular" => linear(between(angle(r), angle(inner), angle(outer)), psi0, psi1),
            "tangent-proportional" => linear(between(r, inner, outer), psi0, psi1),
            "area-proportional" => linear(between(r * r, inner * inner, outer * outer), psi0, psi1),
            "plane" => atan(tan(psi1) * r / outer),
            "equi-areal" => {
                let t = between(r * r, inner * inner, outer * outer);
                acos(linear(t, cos(psi0), cos(psi1)))
            }
            "cylinder" => {
                let t = between(r, inner, outer);
                0.5 * std::f64::consts::PI - atan(linear(t, 1.0 / tan(psi0), 1.0 / tan(psi1)))
            }
            _ => panic!("{}", self.name),
        }
    }

    /// Z of the second focus over the pinhole, and |P F1| - |P F2|: from the rim's ray.
    fn hyperboloid(&self) -> [f64; 2] {
        let (r, z, psi) = (0.5 * WIDTH, -self.distance, rad(self.psi[1]));
        let z2 = z - r / tan(psi);
        [z2, hypot(r, z) - r / sin(psi)]
    }

    /// Z over the outer rim at image radius `r`, from the rule of docs/theory.md, T18, by quadrature.
    fn sag(&self, r: f64, inner: f64) -> f64 {
        let outer = 0.5 * WIDTH;
        if self.distance.is_infinite() {
            return integral(r, outer, |r| tan(0.5 * self.polar(r, inner)));
        }
        self.distance - self.depth(r, inner).1
    }

    /// Distance from the axis and depth under the pinhole at image radius `r`.
    fn depth(&self, r: f64, inner: f64) -> (f64, f64) {
        let outer = 0.5 * WIDTH;
        let [t, rim] = [self.theta(r), self.theta(outer)];
        let lag = integral(t, rim, |t| tan(0.5 * (self.polar(self.distance * tan(t), inner) + t)));
        let rho = hypot(self.distance, outer) * exp(-lag);
        (rho * sin(t), rho * cos(t))
    }

    /// The image radius whose mirror point is the inner rim of the part.
    fn inner(&self) -> f64 {
        if self.distance.is_infinite() || self.inner_mm == 0.0 {
            return 0.5 * self.inner_mm;
        }
        let (mut lo, mut hi) = (0.5 * self.inner_mm * 0.5, 0.5 * self.inner_mm * 2.0);
        for _ in 0..60 {
            let mid = 0.5 * (lo + hi);
            if self.depth(mid, mid).0 < 0.5 * self.inner_mm { lo = mid } else { hi = mid }
        }
        0.5 * (lo + hi)
    }
}

fn radii([inner, outer]: [f64; 2], n: u32) -> impl Iterator<Item = f64> {
    (0..=n).map(move |k| inner + (outer - inner) * f64::from(k) / f64::from(n))
}

fn way(k: u32) -> DVec2 {
    let a = 0.3 + 1.7 * f64::from(k);
    DVec2::new(cos(a), sin(a))
}

#[test]
fn sag_is_that_of_the_law() {
    for round in &SHIPPED {
        let design = round.design();
        let found = rims(&design);
        let inner = round.inner();
        assert!((found[0] - inner).abs() < 1e-11 * WIDTH, "{} {found:?} {inner}", round.name);
        assert_eq!(found[1], 0.5 * WIDTH);
        let rim = trace(&design, None, DVec2::new(found[1], 0.0)).at.z;
        let range = round.sag(found[0], inner);
        let mut worst: f64 = 0.0;
        for r in radii(found, 40) {
            for k in 0..3 {
                let at = trace(&design, None, way(k) * r).at;
                worst = worst.max((at.z - rim - round.sag(r, inner)).abs() / range.abs());
            }
        }
        println!("{}: {worst:e} of {range}", round.name);
        assert!(worst < 1e-12, "{}: {worst:e} of {range}", round.name);
    }
}

#[test]
fn rims_are_where_the_profile_says_and_see_what_it_says() {
    for round in &SHIPPED {
        let design = round.design();
        let [inner, outer] = rims(&design);
        let eye = eye(&design, round.distance);
        for k in 0..5 {
            let rim = trace(&design, eye, way(k) * outer);
            let width = 2.0 * rim.at.truncate().length();
            assert!((width - WIDTH).abs() < 1e-12 * WIDTH, "{} {width}", round.name);
            let psi = polar(rim.seen);
            assert!((psi - rad(round.psi[1])).abs() < 1e-9, "{} {psi}", round.name);
            if inner > 0.0 {
                let rim = trace(&design, eye, way(k) * inner);
                let width = 2.0 * rim.at.truncate().length();
                let off = (width - round.inner_mm).abs();
                assert!(off < 1e-12 * WIDTH, "{} {width}", round.name);
                if round.psi[0].is_finite() {
                    let psi = polar(rim.seen);
                    assert!((psi - rad(round.psi[0])).abs() < 1e-9, "{} {psi}", round.name);
                }
            } else {
                // Round the centre it looks back along the axis.
                let centre = trace(&design, eye, way(k) * 1e-9);
                assert!(centre.seen.z > 1.0 - 1e-15, "{}", round.name);
            }
        }
    }
}

#[test]
fn every_image_point_sees_its_polar_angle_in_its_own_azimuth() {
    for round in &SHIPPED {
        let design = round.design();
        let eye = eye(&design, round.distance);
        let inner = round.inner();
        let mut worst: f64 = 0.0;
        for r in radii(rims(&design), 37).skip(1) {
            for k in 0..5 {
                let q = way(k) * r;
                let seen = trace(&design, eye, q).seen;
                let psi = round.polar(r, inner);
                let wanted = (way(k) * sin(psi)).extend(cos(psi));
                worst = worst.max((seen - wanted).length());
                assert!((seen.length() - 1.0).abs() < 1e-14);
            }
        }
        println!("{}: {worst:e}", round.name);
        assert!(worst < 1e-12, "{}: {worst:e}", round.name);
    }
}

#[test]
fn the_paraboloid_has_its_closed_form() {
    let design = SHIPPED[0].design();
    let h = 30.0 / tan(rad(50.0));
    let rim = trace(&design, None, DVec2::X * 30.0).at.z;
    for r in radii([0.0, 30.0], 50) {
        let z = trace(&design, None, way(1) * r).at.z - rim;
        assert!((z - (900.0 - r * r) / (2.0 * h)).abs() < 1e-10, "{r} {z}");
    }
}

#[test]
fn distances_to_the_hyperboloids_foci_differ_by_a_constant() {
    let round = &SHIPPED[1];
    let design = round.design();
    let first = eye(&design, round.distance).unwrap();
    let [z2, difference] = round.hyperboloid();
    let second = first + DVec3::Z * z2;
    for r in radii([0.0, 30.0], 50) {
        for k in 0..3 {
            let at = trace(&design, Some(first), way(k) * r).at;
            let found = (at - first).length() - (at - second).length();
            assert!((found - difference).abs() < 1e-10, "{r}: {found} {difference}");
        }
    }
}

#[test]
fn the_cone_is_straight() {
    let round = &SHIPPED[2];
    let design = round.design();
    let [inner, outer] = rims(&design);
    let point = |r: f64| {
        let at = trace(&design, None, way(2) * r).at;
        DVec2::new(at.truncate().length(), at.z)
    };
    let (a, b) = (point(inner), point(outer));
    let line = (b - a).normalize();
    for r in radii([inner, outer], 50) {
        assert!((point(r) - a).perp_dot(line).abs() < 1e-12 * WIDTH, "{r}");
    }
    // And as steep as half the angle between the rim's ray and what it sees.
    let slope = tan(0.5 * (rad(100.0) - round.theta(outer)));
    assert!((line.y / line.x + slope).abs() < 1e-12);
}

#[test]
fn the_equiangular_mirror_has_its_closed_form() {
    let round = &SHIPPED[3];
    let design = round.design();
    let eye = eye(&design, round.distance).unwrap();
    let rim = round.theta(30.0);
    let half = 0.5 * (1.0 + rad(120.0) / rim);
    let vertex = hypot(100.0, 30.0) * exp(log(cos(half * rim)) / half);
    for r in radii([0.0, 30.0], 50) {
        let rho = (trace(&design, Some(eye), way(1) * r).at - eye).length();
        let closed = exp(-half * log(rho / vertex)) - cos(half * round.theta(r));
        assert!(closed.abs() < 1e-11, "{r}: {closed:e}");
    }
}

/// The largest distance of the rays seen, extended backwards, from where the rim's meets the axis.
fn spread(round: &Round) -> f64 {
    let design = round.design();
    let eye = eye(&design, round.distance);
    let [inner, outer] = rims(&design);
    let rim = trace(&design, eye, DVec2::X * outer);
    let viewpoint = rim.at - rim.seen * (rim.at.x / rim.seen.x);
    let mut worst: f64 = 0.0;
    for r in radii([inner, outer], 40) {
        for k in 0..4 {
            let ray = trace(&design, eye, way(k) * r);
            worst = worst.max((viewpoint - ray.at).cross(ray.seen).length());
        }
    }
    worst / WIDTH
}

#[test]
fn only_the_paraboloid_and_the_hyperboloid_have_a_single_viewpoint() {
    for round in &SHIPPED {
        let spread = spread(round);
        println!("{}: {spread:e}", round.name);
        if matches!(round.name, "parabolic" | "hyperbolic") {
            assert!(spread < 1e-13, "{}: {spread:e}", round.name);
        } else {
            assert!(spread > 1e-3, "{}: {spread:e}", round.name);
        }
    }
}

#[test]
fn curl_vanishes_and_so_do_the_errors() {
    for round in &SHIPPED {
        let facts = round.design().facts;
        let (curl, ray) = (facts.curl.unwrap(), facts.ray_error_mrad.unwrap());
        println!("{}: {curl:?} {ray:?} {:?}", round.name, facts.condition);
        assert!(curl.max <= 1e-12 && curl.rms <= curl.max, "{}: {curl:?}", round.name);
        assert!(ray.max < 1e-6 && ray.rms <= ray.max, "{}: {ray:?}", round.name);
    }
}

#[test]
fn normals_are_those_of_the_surface() {
    for round in &SHIPPED {
        let design = round.design();
        let q = way(4) * 21.0;
        let at = |q: DVec2| trace(&design, None, q).at;
        let h = 1e-3;
        let along = |e: DVec2| {
            // Central differences of two step sizes, the error of order four.
            let d = |h: f64| (at(q + e * h) - at(q - e * h)) / (2.0 * h);
            (d(h) * 4.0 - d(2.0 * h)) / 3.0
        };
        let normal = along(DVec2::X).cross(along(DVec2::Y)).normalize();
        let found = trace(&design, None, q).normal;
        assert!((normal - found).length() < 1e-10, "{}: {normal} {found}", round.name);
    }
}

/// Every law that both cameras have, at angles of its own.
#[test]
fn laws_hold_with_either_camera_and_either_rim() {
    let laws = [
        ("equiangular", true),
        ("tangent-proportional", true),
        ("equi-areal", true),
        ("area-proportional", true),
        ("cylinder", true),
        ("plane", false),
        ("parabolic", false),
        ("hyperbolic", false),
        ("conical", false),
    ];
    for (name, two) in laws {
        for distance in [f64::INFINITY, 300.0, 40.0] {
            let only = match name {
                "parabolic" => distance.is_infinite(),
                "hyperbolic" | "conical" => distance.is_finite(),
                _ => true,
            };
            for inner_mm in [0.0, 20.0] {
                let ring = matches!(name, "area-proportional" | "cylinder" | "conical");
                if !only || (inner_mm == 0.0 && ring) {
                    continue;
                }
                let first = if inner_mm > 0.0 && two { 35.0 } else { 0.0 };
                let round = Round { name, distance, inner_mm, psi: [first, 70.0] };
                let mut law = format!("[projection.{name}]\nouter_polar_deg = 70");
                if first > 0.0 {
                    law += "\ninner_polar_deg = 35";
                }
                let camera = match distance.is_finite() {
                    true => pinhole(distance),
                    false => oracle::ORTHOGRAPHIC.into(),
                };
                let design = Wish::round(&camera, &law, inner_mm, 30).made();
                let (eye, inner) = (eye(&design, distance), round.inner());
                for r in radii(rims(&design), 23).skip(1) {
                    let psi = round.polar(r, inner);
                    let wanted = (way(1) * sin(psi)).extend(cos(psi));
                    let off = (trace(&design, eye, way(1) * r).seen - wanted).length();
                    assert!(off < 1e-10, "{name} {distance} {inner_mm} {r}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn what_lies_behind_the_mirror_is_refused() {
    // The rim's ray is 16.7 degrees off the axis: beyond 163.3 degrees no mirror can send it.
    let rim = 180.0 - morion::internals::num::degrees(atan(0.3));
    for law in ["equiangular", "tangent-proportional", "equi-areal", "hyperbolic"] {
        for (off, seen) in [(-8.0, true), (1.0, false), (8.0, false)] {
            let law = format!("[projection.{law}]\nouter_polar_deg = {:?}", rim + off);
            let found = Wish::round(&pinhole(100.0), &law, 0.0, 40).design();
            match found {
                Ok(_) => assert!(seen, "{law}"),
                Err(DesignError::Unsolved {
                    cause: FailureCause::BackFacing { from_axis_mm },
                    ..
                }) => {
                    assert!(!seen && (0.0..=30.0).contains(&from_axis_mm), "{law} {from_axis_mm}");
                }
                Err(error) => assert!(!seen, "{law}: {error}"),
            }
        }
    }
}
