//! What of a mesh is fitted: its vertices, each with its share of the facets around it.

use super::Pose;
use crate::geom::{DVec3, TriMesh};
use std::cmp::Ordering;

/// A vertex and a third of the area vectors of the facets around it, mm^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VertexPatch {
    /// Where it is, mm.
    pub at: DVec3,
    /// The area vector, outwards.
    pub area: DVec3,
}

impl VertexPatch {
    /// The same after a motion.
    pub fn moved(&self, pose: &Pose) -> Self {
        Self { at: pose.apply(self.at), area: pose.rotation * self.area }
    }
}

/// The vertices of `mesh`.
pub(super) fn patches(mesh: &TriMesh) -> Vec<VertexPatch> {
    let mut patches: Vec<VertexPatch> =
        mesh.vertices.iter().map(|&at| VertexPatch { at, area: DVec3::ZERO }).collect();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let third = mesh.area_vector(t) / 6.0;
        triangle.iter().for_each(|&v| patches[v as usize].area += third);
    }
    patches
}

/// Cells along each side of the grid that [`is_upside_down`] looks down on.
const CELLS: usize = 48;

/// Whether what one sees of `mesh` from above is the back of most facets.
///
/// Only the highest facet over each cell of a grid counts, so that the base of a solid does not.
pub(super) fn is_upside_down(mesh: &TriMesh) -> bool {
    let Some((lo, hi)) = mesh.bounds() else { return false };
    let step = (hi - lo).truncate() / CELLS as f64;
    let mut top = vec![(f64::NEG_INFINITY, 0.0); CELLS * CELLS];
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t);
        let centre = (a + b + c) / 3.0;
        let cell = ((centre - lo).truncate() / step).floor();
        // A cell that is no number counts as the first.
        let [x, y] = cell.to_array().map(|k| (k.max(0.0) as usize).min(CELLS - 1));
        let highest = &mut top[y * CELLS + x];
        if highest.0.partial_cmp(&centre.z) == Some(Ordering::Less) {
            *highest = (centre.z, (b - a).cross(c - a).normalize_or_zero().z);
        }
    }
    top.iter().map(|cell| cell.1).sum::<f64>() < 0.0
}

/// About `count` of `patches` that look up, chosen evenly by area.
pub(super) fn thinned(patches: &[VertexPatch], count: usize) -> Vec<VertexPatch> {
    let up = |patch: &&VertexPatch| patch.area.z > 0.1 * patch.area.length();
    let total: f64 = patches.iter().filter(up).map(|patch| patch.area.length()).sum();
    let step = total / count as f64;
    let (mut sum, mut next) = (0.0, 0.5 * step);
    let mut chosen = Vec::with_capacity(count);
    for patch in patches.iter().filter(up) {
        sum += patch.area.length();
        let mut times = 0.0;
        while next < sum {
            times += 1.0;
            next += step;
        }
        if times > 0.0 {
            chosen.push(VertexPatch { at: patch.at, area: patch.area.normalize() * times });
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square sheet of 20 x 20 steps, bent up or down at its sides, and its bottom below if it is
    /// a tray.
    fn tray(bend: f64, bottom: bool) -> TriMesh {
        let n = 20u32;
        let mut mesh = TriMesh::default();
        for k in 0..(n + 1) * (n + 1) {
            let (x, y) = (f64::from(k % (n + 1)) - 10.0, f64::from(k / (n + 1)) - 10.0);
            mesh.vertices.push(DVec3::new(x, y, bend * x * x));
        }
        for k in 0..n * n {
            let a = k / n * (n + 1) + k % n;
            mesh.triangles.extend([[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]);
        }
        if bottom {
            let below: Vec<DVec3> = mesh.vertices.iter().map(|v| *v - 5.0 * DVec3::Z).collect();
            let count = mesh.vertices.len() as u32;
            let facets: Vec<[u32; 3]> =
                mesh.triangles.iter().map(|&[a, b, c]| [a + count, c + count, b + count]).collect();
            mesh.vertices.extend(below);
            mesh.triangles.extend(facets);
        }
        mesh
    }

    #[test]
    fn a_sheet_on_its_back_is_noticed_with_and_without_a_base() {
        for (bend, bottom) in [(0.01, false), (-0.02, false), (0.01, true), (-0.02, true)] {
            let mesh = tray(bend, bottom);
            assert!(!is_upside_down(&mesh), "{bend} {bottom}");
            let mut turned = mesh.clone();
            turned.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            assert!(is_upside_down(&turned), "{bend} {bottom}");
        }
        assert!(!is_upside_down(&TriMesh::default()));
    }

    #[test]
    fn vertices_share_the_area_and_thinning_keeps_it_even() {
        let flat = patches(&tray(0.0, false));
        let sum: DVec3 = flat.iter().map(|patch| patch.area).sum();
        assert!((sum - 400.0 * DVec3::Z).length() < 1e-9);
        let few = thinned(&flat, 100);
        let weight: f64 = few.iter().map(|patch| patch.area.length()).sum();
        assert!((weight - 100.0).abs() < 1.5 && few.len() > 90, "{weight} {}", few.len());
        let right = few.iter().filter(|patch| patch.at.y > 0.0).count();
        assert!((40..60).contains(&right), "{right}");
    }
}
