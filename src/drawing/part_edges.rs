//! Edges of a part as a view shows them: those that nothing hides.

use super::lines::Segment;
use crate::geom::{DVec2, DVec3, Ray};
use crate::num::cos;
use crate::solid::Solid;
use crate::trace::Scene;
use std::collections::BTreeMap;

/// A direction in which a part is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ViewFrame {
    /// Unit vector to the right.
    pub right: DVec3,
    /// Unit vector upwards.
    pub up: DVec3,
    /// Whether the half of the part before the plane through the origin is taken away.
    pub is_cut: bool,
}

impl ViewFrame {
    /// Unit vector towards the viewer.
    pub(super) fn toward(&self) -> DVec3 {
        self.right.cross(self.up)
    }

    /// A place in the view, mm.
    pub(super) fn project(&self, at: DVec3) -> DVec2 {
        DVec2::new(at.dot(self.right), at.dot(self.up))
    }
}

/// An edge between two facets.
struct PartEdge {
    ends: [DVec3; 2],
    facets: [usize; 2],
    /// Whether it is an edge of the part, not of its mesh alone.
    is_sharp: bool,
}

/// The edges of a meshed part.
pub(super) struct PartEdges {
    scene: Scene,
    normals: Vec<DVec3>,
    edges: Vec<PartEdge>,
    optical: usize,
    size_mm: f64,
}

/// Largest angles between neighbouring facets of a smooth mirror, and of other faces, whose circles have chords.
const SMOOTH_DEG: f64 = 6.0;
const ROUND_DEG: f64 = 30.0;
/// Pieces to the part's size in which edges are hidden or seen.
const PIECES: f64 = 80.0;
/// Share of the part's size by which sight begins beside an edge.
const BESIDE: f64 = 1e-5;

impl PartEdges {
    /// The edges of a part.
    pub(super) fn new(part: &Solid) -> Self {
        let (mesh, optical) = (part.mesh(), part.optical());
        let normals: Vec<DVec3> =
            (0..mesh.triangles.len()).map(|t| mesh.area_vector(t).normalize_or_zero()).collect();
        let radians = |degrees: f64| degrees.to_radians();
        let [smooth, round] = [SMOOTH_DEG, ROUND_DEG].map(|limit| cos(radians(limit)));
        let is_sharp = |[a, b]: [usize; 2]| {
            let turned = normals[a].dot(normals[b]);
            (a < optical) != (b < optical) || turned < if a < optical { smooth } else { round }
        };
        let (mut open, mut edges) = (BTreeMap::new(), Vec::new());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                let Some(other) = open.remove(&(a.min(b), a.max(b))) else {
                    open.insert((a.min(b), a.max(b)), t);
                    continue;
                };
                let ends = [a, b].map(|v| mesh.vertices[v as usize]);
                let facets = [other, t];
                edges.push(PartEdge { ends, facets, is_sharp: is_sharp(facets) });
            }
        }
        let size_mm = mesh.bounds().map_or(0.0, |(low, high)| (high - low).max_element());
        let scene = Scene::new(mesh.clone());
        scene.prepare_search();
        Self { scene, normals, edges, optical, size_mm }
    }

    /// The pieces of edges, and of the outlines of curved faces, that a view shows.
    pub(super) fn seen(&self, view: &ViewFrame) -> Vec<Segment> {
        let toward = view.toward();
        let is_front = |facet: usize| self.normals[facet].dot(toward) > 1e-9;
        let mut seen = Vec::new();
        for edge in &self.edges {
            let [a, b] = edge.facets;
            if edge.is_sharp || is_front(a) != is_front(b) {
                let beside = (self.normals[a] + self.normals[b]).normalize_or_zero();
                self.add_seen(view, edge.ends, beside, &mut seen);
            }
        }
        seen
    }

    /// Lines over the mirror where a coordinate has one of these values, as far as a view shows them.
    pub(super) fn mirror_lines(
        &self,
        view: &ViewFrame,
        axis: usize,
        values: &[f64],
    ) -> Vec<Segment> {
        let (mesh, mut seen) = (self.scene.mesh(), Vec::new());
        for facet in 0..self.optical {
            let corners = mesh.corners(facet);
            for &value in values {
                let crossing = |k: usize| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    let [from, to] = [a, b].map(|p| p[axis] - value);
                    ((from < 0.0) != (to < 0.0)).then(|| a.lerp(b, from / (from - to)))
                };
                let mut ends = (0..3).filter_map(crossing);
                if let (Some(a), Some(b)) = (ends.next(), ends.next()) {
                    self.add_seen(view, [a, b], self.normals[facet], &mut seen);
                }
            }
        }
        seen
    }

    /// Adds the pieces of a line of the part that nothing hides; `beside` leads out of the part.
    fn add_seen(&self, view: &ViewFrame, ends: [DVec3; 2], beside: DVec3, seen: &mut Vec<Segment>) {
        let Some([from, to]) = self.behind(view, ends) else { return };
        let pieces = (from.distance(to) * PIECES / self.size_mm).ceil().max(1.0) as usize;
        let at = |k: usize| from.lerp(to, k as f64 / pieces as f64);
        let is_seen = |k: &usize| self.is_seen(view, at(*k).midpoint(at(k + 1)), beside);
        let mut first = None;
        for k in 0..=pieces {
            match (first, k < pieces && is_seen(&k)) {
                (None, true) => first = Some(k),
                (Some(begin), false) => {
                    seen.push([at(begin), at(k)].map(|p| view.project(p)));
                    first = None;
                }
                _ => {}
            }
        }
    }

    /// What of a line is left by the cut.
    fn behind(&self, view: &ViewFrame, [a, b]: [DVec3; 2]) -> Option<[DVec3; 2]> {
        if !view.is_cut {
            return Some([a, b]);
        }
        let [from, to] = [a, b].map(|p| p.dot(view.toward()));
        let crossing = || a.lerp(b, from / (from - to));
        match (from <= 0.0, to <= 0.0) {
            (true, true) => Some([a, b]),
            (true, false) => Some([a, crossing()]),
            (false, true) => Some([crossing(), b]),
            (false, false) => None,
        }
    }

    /// Whether nothing of what is left by the cut hides a place beside the part.
    fn is_seen(&self, view: &ViewFrame, at: DVec3, beside: DVec3) -> bool {
        let direction = view.toward();
        let origin = at + (beside + direction) * (BESIDE * self.size_mm);
        let hit = self.scene.nearest_hit(&Ray { origin, direction });
        hit.is_none_or(|hit| {
            let is_entry = self.normals[hit.facet as usize].dot(direction) < 0.0;
            let is_cut_away = view.is_cut && origin.dot(direction) + hit.t >= 0.0;
            is_entry && is_cut_away
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::lines::joined;
    use crate::geom::{Border, Contour, FaceMesh, Hole, PartFeatures, Precision, TriMesh};

    /// A plateau of 4 x 4 mm, 3 mm high, on a flat rim of 10 x 8 mm that is 1 mm high and has a hole.
    fn part(edge_chamfer_mm: f64) -> Solid {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 3.0);
        let vertices =
            vec![corner(-2.0, -2.0), corner(2.0, -2.0), corner(2.0, 2.0), corner(-2.0, 2.0)];
        let face: FaceMesh = TriMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] }.into();
        let border = Border {
            contour: Contour::Rect { half: DVec2::new(5.0, 4.0), corner_mm: 0.0 },
            top_mm: 1.0,
            edge_chamfer_mm,
            holes: vec![Hole::plain(DVec2::new(3.5, 3.0), 1.0)],
            marks: Vec::new(),
            land: None,
        };
        Solid::from_face(&face, PartFeatures::bordered(Some(&border)), Precision::Double).unwrap()
    }

    fn lines(view: &ViewFrame) -> Vec<Vec<DVec2>> {
        joined(&PartEdges::new(&part(0.0)).seen(view), 1e-6)
    }

    fn length(lines: &[Vec<DVec2>]) -> f64 {
        lines.iter().flat_map(|line| line.windows(2)).map(|w| w[0].distance(w[1])).sum()
    }

    #[test]
    fn the_plan_has_contour_plateau_and_hole() {
        let found = lines(&ViewFrame { right: DVec3::X, up: DVec3::Y, is_cut: false });
        let around = length(&found) - 2.0 * (10.0 + 8.0) - 16.0;
        assert!((around / std::f64::consts::PI - 1.0).abs() < 0.01, "{around}");
    }

    #[test]
    fn the_plan_has_both_edges_of_a_chamfer_and_its_mitres() {
        let plan = ViewFrame { right: DVec3::X, up: DVec3::Y, is_cut: false };
        let found = joined(&PartEdges::new(&part(0.25)).seen(&plan), 1e-6);
        let mitres = 4.0 * 0.25 * f64::sqrt(2.0);
        let around = length(&found) - 2.0 * (10.0 + 8.0) - 2.0 * (9.5 + 7.5) - mitres - 16.0;
        assert!((around / std::f64::consts::PI - 1.0).abs() < 0.01, "{around}");
    }

    #[test]
    fn a_cut_part_shows_what_stands_behind_the_cut_and_hides_the_rest() {
        // From -Y, without the half before Y = 0: the plateau's rear corners, upright, are behind what is cut.
        let cut = ViewFrame { right: DVec3::X, up: DVec3::Z, is_cut: true };
        let found = lines(&cut);
        let inside = |p: &DVec2| p.x.abs() < 4.9 && p.x.abs() > 2.1 && p.y > 0.1 && p.y < 0.9;
        assert!(!found.iter().flatten().any(inside), "{found:?}");
        let high = found.iter().flatten().map(|p| p.y).fold(0.0, f64::max);
        assert_eq!(high, 3.0);
        // The whole part from the same side shows its front.
        let whole = lines(&ViewFrame { is_cut: false, ..cut });
        assert!(length(&whole) >= 2.0 * (10.0 + 1.0) + 2.0 * 2.0 + 4.0 - 1e-9, "{whole:?}");
    }
}
