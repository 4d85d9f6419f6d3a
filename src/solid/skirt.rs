//! The skirt: from the rim of a face along the face's rays down to the base or to a border's flat top.

use super::sides;
use crate::geom::{DVec3, FaceMesh, TriMesh};

/// A rim in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rim {
    /// Edges around the face.
    pub edges: usize,
    /// Those among them that are edges of walls between panels, along a ray.
    pub steps: usize,
    /// Edges around the face's hole: 0 if it has none.
    pub hole_edges: usize,
}

/// The feet of a skirt: one for each ray of the rim.
pub(super) struct Feet {
    /// Their places, anticlockwise from above, mm.
    places: Vec<DVec3>,
    /// The foot below each vertex of the rim.
    under: Vec<usize>,
    /// The lowest vertex of the rim over each foot.
    lowest: Vec<u32>,
}

impl Feet {
    /// Those of the rim `outer` of `face`, at the height `top_mm`.
    pub(super) fn of(face: &FaceMesh, outer: &[u32], top_mm: f64) -> Self {
        let walls = face.wall_edges();
        let at = |v: u32| face.vertices[v as usize];
        // Whether a vertex stands on the ray of the one before.
        let steps: Vec<bool> = sides(outer).map(|[from, to]| walls.contains(&(from, to))).collect();
        let mut feet = Self { places: Vec::new(), under: Vec::new(), lowest: Vec::new() };
        let mut add = |v: u32, new: bool| {
            if new {
                feet.places.push(face.foot(v, top_mm));
                feet.lowest.push(v);
            }
            let foot = feet.places.len() - 1;
            if at(v).z < at(feet.lowest[foot]).z {
                feet.lowest[foot] = v;
            }
            feet.under.push(foot);
        };
        for (k, &v) in outer.iter().enumerate() {
            add(v, k == 0 || !steps[k - 1]);
        }
        // The rim may begin within a step.
        if let [first, .., last] = feet.lowest[..]
            && steps[outer.len() - 1]
        {
            feet.lowest[0] = if at(last).z < at(first).z { last } else { first };
            feet.places.pop();
            let gone = feet.lowest.len() - 1;
            feet.lowest.pop();
            feet.under.iter_mut().filter(|foot| **foot == gone).for_each(|foot| *foot = 0);
        }
        feet
    }

    /// Adds the feet and the skirt down to them from the rim `outer`; the feet's numbers.
    pub(super) fn skirt(self, mesh: &mut TriMesh, outer: &[u32]) -> Vec<u32> {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(&self.places);
        let next = self.under.iter().cycle().skip(1);
        for ([top, top_next], (&foot, &foot_next)) in sides(outer).zip(self.under.iter().zip(next))
        {
            if foot == foot_next {
                continue;
            }
            let [lowest, lowest_next] = [foot, foot_next].map(|foot| self.lowest[foot]);
            let [low, low_next] = [foot, foot_next].map(|foot| first + foot as u32);
            // What other panels leave of the ray below a vertex is an edge of its own.
            if lowest != top {
                mesh.triangles.push([top_next, top, lowest]);
            }
            if lowest_next != top_next {
                mesh.triangles.push([top_next, lowest, lowest_next]);
            }
            mesh.triangles.push([lowest_next, lowest, low]);
            mesh.triangles.push([lowest_next, low, low_next]);
        }
        (first..mesh.vertices.len() as u32).collect()
    }
}
