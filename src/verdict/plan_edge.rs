//! The edge of a mirror in the plan, where it need not be seen once in each direction from the axis: where the camera
//! stands beside the axis, what is a rectangle in the chart is none in the plan, and panels of different heights make
//! an edge with steps.

use crate::geom::{DVec2, DVec3, Outline, Rect};
use crate::mirror::Mirror;

/// Sides of the outline.
const SIDES: usize = 4;
/// Samples of a piece of the edge, from which the nearest place is searched for.
const SAMPLES: usize = 128;
/// Newton's steps to the nearest place: four are enough from a sample.
const STEPS: usize = 8;
/// Step of differences along a piece, in pieces.
const STEP: f64 = 1e-6;
/// Places of two pieces that are this near are the one in which they meet, mm.
const SAME_MM: f64 = 1e-9;

/// The edge of a mirror and samples of it.
pub(super) struct PlanEdge {
    panels: Vec<Mirror>,
    /// Anticlockwise, each where the one before ends.
    pieces: Vec<EdgePiece>,
    /// X and Y, mm, piece by piece.
    samples: Vec<DVec2>,
    /// Longest distance of neighbouring samples.
    spacing_mm: f64,
}

/// A piece of the edge: from a place of the chart over a panel to another place, or to the other panel there.
struct EdgePiece {
    ends: [(usize, DVec2); 2],
}

impl PlanEdge {
    /// The edge of a mirror under a chart that leans, which only rectangles have, or of one with steps; none of others.
    pub(super) fn new(mirror: &Mirror) -> Option<Self> {
        let Outline::Rect(rect) = mirror.full_outline() else { return None };
        if mirror.chart.lean == DVec2::ZERO && !mirror.has_steps() {
            return None;
        }
        let panels = mirror.panels();
        let rims: Vec<EdgePiece> = (0..SIDES).flat_map(|side| rims(&panels, rect, side)).collect();
        let mut pieces = Vec::new();
        for (k, rim) in rims.iter().enumerate() {
            let before = rims[(k + rims.len() - 1) % rims.len()].ends[1];
            if before.0 != rim.ends[0].0 {
                pieces.push(EdgePiece { ends: [before, rim.ends[0]] });
            }
            pieces.push(EdgePiece { ends: rim.ends });
        }
        let mut edge = Self { panels, pieces, samples: Vec::new(), spacing_mm: 0.0 };
        let places = (0..edge.pieces.len() * SAMPLES).map(|k| (k / SAMPLES, share(k % SAMPLES)));
        edge.samples = places.map(|(piece, at)| edge.point(piece, at).truncate()).collect();
        let next = edge.samples.iter().cycle().skip(1);
        let spacing = edge.samples.iter().zip(next).map(|(a, b)| a.distance(*b));
        edge.spacing_mm = spacing.fold(0.0, f64::max);
        Some(edge)
    }

    /// The place of the edge that is nearest to X and Y in the plan, and how far `across` lies beyond it, mm; negative
    /// inside.
    pub(super) fn nearest(&self, across: DVec2) -> (DVec3, f64) {
        // The nearest sample of each piece, and how far it is.
        let nearest = |samples: &[DVec2]| {
            let away = samples.iter().map(|sample| sample.distance(across)).enumerate();
            away.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY))
        };
        let sampled: Vec<(usize, f64)> = self.samples.chunks(SAMPLES).map(nearest).collect();
        let least = sampled.iter().fold(f64::INFINITY, |least, (_, away)| least.min(*away));
        let found: Vec<Found> = sampled
            .iter()
            .enumerate()
            .filter(|(_, (_, away))| *away <= least + self.spacing_mm)
            .map(|(piece, (k, _))| self.refined(piece, share(*k), across))
            .collect();
        let away = |found: &Found| found.point.truncate().distance(across);
        let nearest = found.iter().copied().reduce(|a, b| if away(&b) < away(&a) { b } else { a });
        let nearest = nearest.expect("the piece of the nearest sample");
        // Where two pieces meet, both say on which side the place is.
        let tied = found.iter().filter(|found| away(found) <= away(&nearest) + SAME_MM);
        let beyond: f64 = tied.map(|found| found.beyond).sum();
        (nearest.point, away(&nearest).copysign(beyond))
    }

    /// The place of a piece that is nearest, from a place near to it.
    fn refined(&self, piece: usize, mut at: f64, across: DVec2) -> Found {
        let plan = |at: f64| self.point(piece, at).truncate();
        let way = |at: f64| {
            let [from, to] = [(at - STEP).max(0.0), (at + STEP).min(1.0)];
            (plan(to) - plan(from)) / (to - from)
        };
        for _ in 0..STEPS {
            let along = way(at);
            let next = at + (across - plan(at)).dot(along) / along.length_squared();
            at = next.clamp(0.0, 1.0);
        }
        let point = self.point(piece, at);
        // The pieces go round anticlockwise.
        Found { point, beyond: (across - point.truncate()).perp_dot(way(at).normalize()) }
    }

    /// The point of the edge at a share of a piece.
    fn point(&self, piece: usize, at: f64) -> DVec3 {
        let [(panel, from), (other, to)] = self.pieces[piece].ends;
        let on = |panel: usize, q: DVec2| {
            let mirror = &self.panels[panel];
            mirror.position(q, &mirror.row(q.y).at(q.x))
        };
        if panel == other {
            on(panel, from.lerp(to, at))
        } else {
            on(panel, from).lerp(on(other, to), at)
        }
    }
}

/// The rims of the panels along a side of the outline `rect`, anticlockwise: 0 the lower one.
fn rims(panels: &[Mirror], rect: Rect, side: usize) -> Vec<EdgePiece> {
    let corners = |Rect { min, max }: Rect| {
        let all = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
        [all[side], all[(side + 1) % SIDES]]
    };
    let [first, last] = corners(rect);
    let (way, across) = ((last - first).normalize(), side % 2);
    let mut rims: Vec<EdgePiece> = panels
        .iter()
        .enumerate()
        .map(|(k, panel)| EdgePiece { ends: corners(panel.outline.bounds()).map(|q| (k, q)) })
        .filter(|piece| piece.ends[0].1[1 - across] == first[1 - across])
        .collect();
    let along = |piece: &EdgePiece| (piece.ends[0].1 - first).dot(way);
    rims.sort_by(|a, b| along(a).total_cmp(&along(b)));
    rims
}

/// A place of the edge.
#[derive(Clone, Copy)]
struct Found {
    point: DVec3,
    /// How far the place lies beyond the tangent there, mm.
    beyond: f64,
}

/// Share of a piece at a sample.
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
            .map(|k| edge.point(k / MANY, (k % MANY) as f64 / MANY as f64).truncate())
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
            let place = edge.point(k / 64, (k % 64) as f64 / 64.0);
            let (point, beyond) = edge.nearest(place.truncate());
            assert!(point.distance(place) < 1e-9 && beyond.abs() < 1e-9, "{place} {point}");
        }
    }
}
