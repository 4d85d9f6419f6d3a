//! Where surfaces are, which way they face, and on which side of an edge.

use super::reading::{Surface, height};
use morion::internals::geom::{DVec2, DVec3};
use morion::internals::num::{cos, sin};

/// The distance of a point from a surface.
pub fn distance(surface: &Surface, p: DVec3) -> f64 {
    let flat = |at: &DVec3| (p - *at).truncate().length();
    match surface {
        Surface::Plane { at, normal } => (p - *at).dot(*normal).abs(),
        Surface::Cylinder { at, radius } => (flat(at) - radius).abs(),
        Surface::Cone { at, radius, angle } => {
            let (sine, cosine) = (sin(*angle), cos(*angle));
            ((flat(at) - radius) * cosine - (p.z - at.z) * sine).abs()
        }
        Surface::Turned { axis, points } => {
            let rho = flat(&DVec3::ZERO);
            let on = height(axis, points, rho.clamp(axis.ends()[0], axis.ends()[1]));
            (on - DVec3::new(rho, 0.0, p.z)).length()
        }
        Surface::Spline { .. } => (surface.at(nearest(surface, p)) - p).length(),
    }
}

/// The parameters of the point of a spline that is nearest to `p`.
fn nearest(surface: &Surface, p: DVec3) -> DVec2 {
    let [u, v] = surface.ends();
    let inside = |q: DVec2| DVec2::new(q.x.clamp(u[0], u[1]), q.y.clamp(v[0], v[1]));
    let off = |q: DVec2| (surface.at(q) - p).length();
    let straight = inside(p.truncate());
    if off(straight) < 1e-7 {
        return straight;
    }
    // Newton's method from the best of a few.
    let start = |k: usize| {
        let share = DVec2::new((k % 9) as f64 + 0.5, (k / 9) as f64 + 0.5) / 9.0;
        DVec2::new(u[0] + (u[1] - u[0]) * share.x, v[0] + (v[1] - v[0]) * share.y)
    };
    let mut q = (0..81).map(start).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap();
    for _ in 0..12 {
        let [a, b] = surface.slopes(q);
        let (aa, ab, bb, r) = (a.dot(a), a.dot(b), b.dot(b), p - surface.at(q));
        let det = aa * bb - ab * ab;
        // On an edge that is a point one of them is nothing.
        if det <= 1e-12 * aa * bb {
            break;
        }
        let (x, y) = (a.dot(r), b.dot(r));
        q = inside(q + DVec2::new(bb * x - ab * y, aa * y - ab * x) / det);
    }
    q
}

/// The surface's own normal at a point of it.
pub fn normal(surface: &Surface, p: DVec3) -> DVec3 {
    let away = |at: &DVec3| (p - *at).truncate().normalize().extend(0.0);
    match surface {
        Surface::Plane { normal, .. } => *normal,
        Surface::Cylinder { at, .. } => away(at),
        Surface::Cone { at, angle, .. } => away(at) * cos(*angle) - DVec3::Z * sin(*angle),
        Surface::Turned { axis, points } => {
            let out = away(&DVec3::ZERO);
            let rho = p.truncate().length();
            let [lo, hi] = axis.ends();
            let at = |rho: f64| height(axis, points, rho.clamp(lo, hi));
            let along = at(rho + 1e-3) - at(rho - 1e-3);
            DVec3::Z.cross(out).cross(out * along.x + DVec3::Z * along.z).normalize()
        }
        Surface::Spline { .. } => {
            let [a, b] = surface.slopes(nearest(surface, p));
            a.cross(b).normalize()
        }
    }
}

/// An edge that a loop ran along: where, and where its left was half way.
pub struct Travelled {
    pub id: u32,
    pub left: DVec3,
    /// Whether the face is.
    pub upright: bool,
    pub places: Vec<DVec3>,
}

/// Whether a face that lies about evenly around its middle is on an edge's left. That between two
/// closed edges lies towards the other, one of four edges towards that opposite; a seam has it on both sides.
pub fn keeps_left(rim: &[Travelled], edge: usize) -> bool {
    let is_seam = |id: u32| rim.iter().filter(|other| other.id == id).count() == 2;
    let Travelled { id, left, upright, places } = &rim[edge];
    if is_seam(*id) {
        return true;
    }
    let p = places[26];
    let is_closed = |edge: &Travelled| (edge.places[0] - edge.places[53]).length() < 1e-9;
    let all = rim.iter().flat_map(|edge| &edge.places);
    let middle = all.sum::<DVec3>() / (54 * rim.len()) as f64;
    let towards = rim
        .iter()
        .find(|other| other.id != *id && is_closed(other) && !is_seam(other.id))
        .and_then(|other| {
            other.places.iter().min_by(|a, b| (**a - p).length().total_cmp(&(**b - p).length()))
        });
    let opposite = (rim.len() == 4).then(|| rim[(edge + 2) % 4].places[26]);
    let towards = towards.copied().or(opposite).unwrap_or(middle);
    // Waves of a face that is not upright do not count.
    let counts = if *upright { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
    left.dot((towards - p) * counts) > 0.0
}
