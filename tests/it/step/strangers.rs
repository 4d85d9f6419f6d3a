//! STEP files that OpenCASCADE wrote (`tests/outside/step_fixtures.py`): volumes and places of rays in closed form.

use crate::support::draws::Draws;
use morion::internals::brep::Body;
use morion::internals::geom::{DVec3, Ray};
use morion::internals::num::{cos, sin};
use std::f64::consts::PI;

/// Share of a volume, of 12 decimals in the file.
const VOLUME: f64 = 1e-10;
/// Distance from a surface in closed form, mm.
const SURFACE_MM: f64 = 1e-9;

pub fn body(name: &str) -> Body {
    let file = format!("{}/fuzz/seeds/step/{name}.step", env!("CARGO_MANIFEST_DIR"));
    Body::read(&std::fs::read(file).unwrap()).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Volume of the block with all edges rounded.
fn rounded_block() -> f64 {
    let (r, [a, b, c]) = (1.5, [17.0, 13.0, 2.0]);
    let (faces, edges) = (a * b + b * c + c * a, a + b + c);
    a * b * c + 2.0 * r * faces + PI * r * r * edges + 4.0 / 3.0 * PI * r * r * r
}

#[test]
fn volumes_are_those_in_closed_form() {
    let (block, torus) = (20.0 * 16.0 * 5.0, 2.0 * PI * PI * 7.0 * 4.0);
    let dimpled = block - 2.0 / 3.0 * PI * 64.0;
    // Half the integral of X^2 over Z, mm^3, of the profile that is turned and extruded: exact sums of cubics.
    let moment = 6_282_319.0 / 60_480.0;
    let wanted = [
        ("box", 6, block),
        ("drilled", 7, block - PI * 9.0 * 5.0),
        ("dimpled", 7, dimpled),
        ("dimpled-AP203", 7, dimpled),
        ("dimpled-AP242DIS", 7, dimpled),
        ("dimpled-inch", 7, dimpled),
        ("nurbs", 7, dimpled),
        ("countersunk", 7, block - PI * 9.0),
        ("rounded", 26, rounded_block()),
        ("nurbs-rounded", 26, rounded_block()),
        ("cylinder", 3, PI * 16.0 * 7.0),
        ("elliptic", 3, PI * 15.0 * 6.0),
        ("oblique", 3, PI * 16.0 * 4.0 * 1.25f64.sqrt()),
        ("cone", 3, PI * 2.0 * (25.0 + 10.0 + 4.0)),
        ("pointed", 2, PI * 2.0 * 25.0),
        ("sphere", 1, 4.0 / 3.0 * PI * 125.0),
        ("torus", 1, torus),
        ("nurbs-torus", 1, torus),
        ("extruded", 6, 1592.0 / 15.0),
        ("turned", 4, 2.0 * PI * moment),
        ("sector", 6, 1.9 * moment),
    ];
    for (name, faces, volume) in wanted {
        let facts = body(name).facts();
        let off = (facts.volume_mm3 / volume - 1.0).abs();
        assert!(off < VOLUME, "{name}: {off:e} {facts:?}");
        assert_eq!(facts.faces, faces, "{name}");
        // A hole right through, and rings.
        let has_handle = ["drilled", "torus", "nurbs-torus", "turned"].contains(&name);
        let euler = if has_handle { 0 } else { 2 };
        assert_eq!((facts.euler, facts.components), (euler, 1), "{name}: {facts:?}");
        assert!(facts.gap_mm < 1e-11, "{name}: {facts:?}");
        let inch = if name.ends_with("inch") { 25.4 } else { 1.0 };
        assert_eq!(facts.unit_mm, inch, "{name}");
    }
}

fn block(p: DVec3) -> f64 {
    (p.x.abs() - 10.0).max(p.y.abs() - 8.0).max((p.z - 2.5).abs() - 2.5)
}

fn dimpled(p: DVec3) -> f64 {
    block(p).max(4.0 - p.distance(DVec3::Z * 5.0))
}

fn rounded(p: DVec3) -> f64 {
    let q = (p - DVec3::Z * 2.5).abs() - DVec3::new(8.5, 6.5, 1.0);
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0) - 1.5
}

/// Distances from an axis and along it.
fn round(p: DVec3, at: [f64; 3], axis: [f64; 3]) -> (f64, f64) {
    let (off, axis) = (p - DVec3::from(at), DVec3::from(axis).normalize());
    let along = off.dot(axis);
    ((off - axis * along).length(), along)
}

fn torus(p: DVec3) -> f64 {
    let (r, h) = round(p, [1.0, 2.0, 3.0], [0.0, 1.0, 1.0]);
    ((r - 7.0) * (r - 7.0) + h * h).sqrt() - 2.0
}

fn oblique(p: DVec3) -> f64 {
    let (_, along) = round(p, [0.0, 0.0, 8.0], [-0.5, 0.0, 1.0]);
    ((p.x * p.x + p.y * p.y).sqrt() - 4.0).max((along - 2.0).abs() - 2.0)
}

/// A function of places that is negative inside a body.
type Shape = fn(DVec3) -> f64;

/// Bodies by functions that are negative inside, at most 1 mm a mm steep or, of the ellipse, a little more.
fn shapes() -> Vec<(&'static str, Shape)> {
    vec![
        ("box", block),
        ("drilled", |p| block(p).max(3.0 - round(p, [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]).0)),
        ("dimpled", dimpled),
        ("dimpled-AP203", dimpled),
        ("dimpled-AP242DIS", dimpled),
        ("dimpled-inch", dimpled),
        ("nurbs", dimpled),
        ("countersunk", |p| {
            let (r, h) = round(p, [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]);
            block(p).max((h - r) * 0.5f64.sqrt())
        }),
        ("rounded", rounded),
        ("nurbs-rounded", rounded),
        ("cylinder", |p| {
            let (r, h) = round(p, [1.0, 2.0, 3.0], [1.0, 1.0, 1.0]);
            (r - 4.0).max((h - 3.5).abs() - 3.5)
        }),
        ("elliptic", |p| {
            let side = (p.x * p.x / 25.0 + p.y * p.y / 9.0).sqrt() - 1.0;
            (3.0 * side).max((p.z - 3.0).abs() - 3.0)
        }),
        ("oblique", oblique),
        ("cone", |p| {
            let (r, h) = round(p, [1.0, 2.0, 3.0], [1.0, -1.0, 2.0]);
            ((r - 5.0 + 0.5 * h) / 1.25f64.sqrt()).max((h - 3.0).abs() - 3.0)
        }),
        ("sphere", |p| p.distance(DVec3::new(1.0, 2.0, 3.0)) - 5.0),
        ("torus", torus),
        ("nurbs-torus", torus),
    ]
}

/// Distance along a ray at which it enters a shape, by steps of the distance from it; none if it passes at more than
/// 1e-6 mm, and nothing sure if it passes nearer.
fn entered(shape: Shape, ray: &Ray) -> Result<Option<f64>, ()> {
    let (mut t, mut nearest) = (0.0, f64::INFINITY);
    while t < 80.0 {
        let off = shape(ray.at(t));
        nearest = off.min(nearest);
        if off < 1e-12 {
            return Ok(Some(t));
        }
        t += (0.6 * off).max(1e-12);
        if off < 1e-6 && shape(ray.at(t + 1e-6)) > off {
            return Err(());
        }
    }
    if nearest > 1e-6 { Ok(None) } else { Err(()) }
}

#[test]
fn rays_meet_bodies_where_closed_forms_say() {
    for (name, shape) in shapes() {
        let (body, mut draws, mut met, mut passed) = (body(name), Draws::new(7), 0, 0);
        let mut place = |size: f64| DVec3::from([0; 3].map(|_| draws.inside([-size, size])));
        for _ in 0..2000 {
            let (origin, to) = (place(1.0).normalize() * 40.0, place(9.0) + DVec3::Z * 2.0);
            let ray = Ray { origin, direction: (to - origin).normalize() };
            let Ok(wanted) = entered(shape, &ray) else { continue };
            let hit = body.nearest_hit(&ray, 0.0, f64::INFINITY);
            assert_eq!(hit.is_some(), wanted.is_some(), "{name} {ray:?} {wanted:?} {hit:?}");
            let (Some(hit), Some(wanted)) = (hit, wanted) else {
                passed += 1;
                continue;
            };
            met += 1;
            let off = shape(ray.at(hit.t)).abs();
            assert!(off < SURFACE_MM, "{name} {ray:?}: {off:e}, {wanted} {hit:?}");
            assert!((hit.t - wanted).abs() < 1e-4, "{name} {ray:?}: {wanted} {hit:?}");
            let gradient = DVec3::AXES.map(|axis| {
                shape(ray.at(hit.t) + axis * 1e-6) - shape(ray.at(hit.t) - axis * 1e-6)
            });
            let normal = DVec3::from(gradient).normalize();
            // (Beside an edge the difference takes a second face in.)
            let is_beside = (DVec3::from(gradient).length() / 2e-6 - 1.0).abs() > 1e-3;
            assert!(is_beside || hit.normal.distance(normal) < 1e-4, "{name} {ray:?} {hit:?}");
        }
        assert!(met > 200 && passed > 100, "{name}: {met} met, {passed} passed");
    }
}

#[test]
fn rays_meet_a_slanting_cap_up_to_its_rim() {
    let body = body("cylinder");
    let axis = DVec3::ONE.normalize();
    let across = axis.any_orthonormal_pair();
    for k in 0..1000 {
        let angle = 2.0 * PI * f64::from(k) / 1000.0;
        let out = across.0 * cos(angle) + across.1 * sin(angle);
        let rim = DVec3::new(1.0, 2.0, 3.0) + axis * 7.0 + out * 3.9999;
        let ray = Ray { origin: rim + axis * 5.0, direction: -axis };
        let hit = body.nearest_hit(&ray, 0.0, f64::INFINITY).unwrap();
        assert!(
            (hit.t - 5.0).abs() < SURFACE_MM && hit.normal.distance(axis) < 1e-9,
            "{k}: {hit:?}"
        );
    }
}
