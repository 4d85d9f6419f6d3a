//! The edge of a mirror in the plan, where its camera stands beside the axis: what is a rectangle in the chart is
//! then none in the plan, and need not be seen once in each direction from the axis.

use crate::geom::{DVec2, DVec3, Outline, Rect};
use crate::mirror::Mirror;
use crate::num::Dual;

/// Sides of the edge.
const SIDES: usize = 4;
/// Samples of a side, from which the nearest place is searched for.
const SAMPLES: usize = 128;
/// Most of Newton's steps to the nearest place.
const STEPS: usize = 8;
/// A last step of so small a share of a side leaves nothing but rounding.
const CLOSE: f64 = 1e-12;

/// The edge of a mirror and samples of it.
pub(super) struct PlanEdge<'a> {
    mirror: &'a Mirror,
    rect: Rect,
    /// X and Y, mm, side by side.
    samples: Vec<DVec2>,
}

impl<'a> PlanEdge<'a> {
    /// The edge of a mirror under a chart that leans, which only rectangles have; none of others.
    pub(super) fn new(mirror: &'a Mirror) -> Option<Self> {
        let Outline::Rect(rect) = mirror.full_outline() else { return None };
        if mirror.chart.lean == DVec2::ZERO {
            return None;
        }
        let mut edge = Self { mirror, rect, samples: Vec::new() };
        let places = (0..SIDES * SAMPLES).map(|k| (k / SAMPLES, share(k % SAMPLES)));
        edge.samples = places.map(|(side, at)| edge.point(side, at).0.truncate()).collect();
        Some(edge)
    }

    /// The place of the edge that is nearest to X and Y in the plan, and how far `across` lies beyond it, mm; negative
    /// inside.
    pub(super) fn nearest(&self, across: DVec2) -> (DVec3, f64) {
        let away = |k: &usize| self.samples[*k].distance_squared(across);
        let first = (0..self.samples.len()).min_by(|a, b| away(a).total_cmp(&away(b)));
        let (side, k) = first.map_or((0, 0), |k| (k / SAMPLES, k % SAMPLES));
        let here = self.refined(side, share(k), across);
        // The corner belongs to the side before too.
        let before = (k == 0).then(|| self.refined((side + SIDES - 1) % SIDES, 1.0, across));
        let all = [Some(here), before];
        let nearer = |a: Found, b: Found| {
            if b.point.truncate().distance(across) < a.point.truncate().distance(across) {
                b
            } else {
                a
            }
        };
        let found = all.into_iter().flatten().reduce(nearer).unwrap_or(here);
        let beyond = all.into_iter().flatten().any(|found| found.beyond > 0.0);
        let distance = found.point.truncate().distance(across);
        (found.point, if beyond { distance } else { -distance })
    }

    /// The place of a side that is nearest, from a place near to it.
    fn refined(&self, side: usize, mut at: f64, across: DVec2) -> Found {
        let (mut point, mut way) = self.point(side, at);
        for _ in 0..STEPS {
            let step = (across - point.truncate()).dot(way) / way.length_squared();
            let next = (at + step).clamp(0.0, 1.0);
            let is_close = (next - at).abs() <= CLOSE;
            at = next;
            (point, way) = self.point(side, at);
            if is_close {
                break;
            }
        }
        // The sides go round anticlockwise.
        Found { point, beyond: (across - point.truncate()).perp_dot(way) }
    }

    /// The point of the edge at a share of a side, and its derivative in the plan by that share.
    fn point(&self, side: usize, at: f64) -> (DVec3, DVec2) {
        let Rect { min, max } = self.rect;
        let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        let (from, to) = (corners[side], corners[(side + 1) % SIDES]);
        let (q, by_share) = (from.lerp(to, at), to - from);
        let surface = self.mirror.row(q.y).at(q.x);
        let f = Dual { value: surface.f, slope: [surface.slope.dot(by_share)] };
        let q = [0, 1].map(|k| Dual { value: q[k], slope: [by_share[k]] });
        let point = self.mirror.chart.position(q, f);
        let [x, y, _] = point.map(|coordinate| coordinate.slope[0]);
        (DVec3::from_array(point.map(|coordinate| coordinate.value)), DVec2::new(x, y))
    }
}

/// A place of the edge.
#[derive(Clone, Copy)]
struct Found {
    point: DVec3,
    /// Positive beyond the edge.
    beyond: f64,
}

/// Share of a side at a sample.
fn share(k: usize) -> f64 {
    k as f64 / SAMPLES as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::design;
    use crate::num::sample::Draws;
    use crate::profile::Profile;

    fn mirror() -> Mirror {
        let text = "camera.pinhole = { pixels = [64, 48], hfov_deg = 30, distance_mm = 80 }\n\
                    mount = { fold_deg = 70, towards_deg = 30 }\n\
                    projection.perspective.hfov_deg = 60\nlayout.rectangle = {}\nmethod.vector-field.degree = 6\n\
                    part = { width_mm = 45, base_mm = 5, height_mm = 32 }\nmesh.chord_um = 1\n\
                    export.formats = [\"stl\"]\n";
        design(&Profile::parse("e", "e.toml", text.as_bytes()).unwrap()).unwrap().mirror
    }

    /// Against many points of the edge, and against how often it goes round a place.
    #[test]
    fn the_nearest_of_many_points_is_no_nearer_and_the_side_is_right() {
        let mirror = mirror();
        let edge = PlanEdge::new(&mirror).unwrap();
        const MANY: usize = 40_000;
        let points: Vec<DVec2> = (0..SIDES * MANY)
            .map(|k| edge.point(k / MANY, (k % MANY) as f64 / MANY as f64).0.truncate())
            .collect();
        let mut draws = Draws::new(7);
        for _ in 0..200 {
            let across = DVec2::new(draws.inside([-25.0, 25.0]), draws.inside([-25.0, 25.0]));
            let (point, beyond) = edge.nearest(across);
            let least = points.iter().map(|p| p.distance(across)).fold(f64::INFINITY, f64::min);
            let found = point.truncate().distance(across);
            assert!(found <= least + 1e-9 && least <= found + 1e-5, "{across}: {found} {least}");
            assert!((beyond.abs() - found).abs() < 1e-12, "{across}: {beyond}");
            let turns: f64 = (0..points.len())
                .map(|k| {
                    let [a, b] = [points[k], points[(k + 1) % points.len()]].map(|p| p - across);
                    crate::num::atan2(a.perp_dot(b), a.dot(b))
                })
                .sum();
            assert_eq!(beyond < 0.0, turns > 3.0, "{across}: {beyond}, {turns}");
        }
        // On the edge itself, corners too.
        for k in 0..SIDES * 64 {
            let (place, _) = edge.point(k / 64, (k % 64) as f64 / 64.0);
            let (point, beyond) = edge.nearest(place.truncate());
            assert!(point.distance(place) < 1e-9 && beyond.abs() < 1e-9, "{place} {point}");
        }
    }
}
