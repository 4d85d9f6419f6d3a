//! Triangle meshes: vertices and triangles, no promises.

use super::{DVec2, DVec3};
use rustc_hash::FxHashMap;
use std::collections::hash_map::Entry;

/// Vertices (mm) and the triples of vertex indices that are its facets, counter-clockwise seen
/// from outside. Nothing is promised about closedness, orientation or shape.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriMesh {
    /// Positions, mm.
    pub vertices: Vec<DVec3>,
    /// Facets.
    pub triangles: Vec<[u32; 3]>,
}

impl TriMesh {
    /// The three corners of facet `t`.
    #[inline]
    #[must_use]
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.vertices[v as usize])
    }

    /// Facet normal of `t`, twice the facet's area long.
    #[inline]
    #[must_use]
    pub fn area_vector(&self, t: usize) -> DVec3 {
        let [a, b, c] = self.corners(t);
        (b - a).cross(c - a)
    }

    /// Smallest and largest coordinates; `None` without vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.vertices.first()?;
        Some(
            self.vertices
                .iter()
                .fold((first, first), |(lo, hi), &v| (lo.min(v), hi.max(v))),
        )
    }

    /// The mesh with its mirror image across the plane where coordinate `axis` (0 = X, 1 = Y)
    /// vanishes. Vertices in that plane are shared by both halves; images follow the originals in
    /// their order, with the facets turned so that they stay oriented.
    #[must_use]
    pub fn with_reflection(mut self, axis: usize) -> Self {
        let mut image = Vec::with_capacity(self.vertices.len());
        for k in 0..self.vertices.len() {
            let mut v = self.vertices[k];
            if v[axis] == 0.0 {
                image.push(k as u32);
            } else {
                v[axis] = -v[axis];
                image.push(self.vertices.len() as u32);
                self.vertices.push(v);
            }
        }
        for t in 0..self.triangles.len() {
            let [a, b, c] = self.triangles[t].map(|v| image[v as usize]);
            self.triangles.push([a, c, b]);
        }
        self
    }

    /// Joins corners that have the same bits: how a file without shared vertices becomes a mesh.
    /// Vertices are numbered in order of first appearance. Zeros of either sign are the same.
    #[must_use]
    pub fn weld(corners: impl ExactSizeIterator<Item = DVec3>) -> Self {
        let count = corners.len();
        // Closed triangle meshes have half as many vertices as facets.
        let mut seen: FxHashMap<[u64; 3], u32> =
            FxHashMap::with_capacity_and_hasher(count / 6 + 16, Default::default());
        let mut mesh = Self {
            vertices: Vec::with_capacity(count / 6 + 16),
            triangles: Vec::with_capacity(count / 3),
        };
        let mut triangle = [0; 3];
        for (k, corner) in corners.enumerate() {
            let key = (corner + DVec3::ZERO).to_array().map(f64::to_bits);
            triangle[k % 3] = match seen.entry(key) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(new) => {
                    mesh.vertices.push(corner);
                    *new.insert(mesh.vertices.len() as u32 - 1)
                }
            };
            if k % 3 == 2 {
                mesh.triangles.push(triangle);
            }
        }
        mesh
    }
}

/// Twice the signed area of the triangle's shadow on the (X, Y) plane.
#[inline]
#[must_use]
pub fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle() -> TriMesh {
        TriMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::new(0.0, 1.0, 2.0)],
            triangles: vec![[0, 1, 2]],
        }
    }

    #[test]
    fn reflection_shares_the_plane_and_keeps_orientation() {
        let both = triangle().with_reflection(1);
        assert_eq!(both.vertices.len(), 4);
        assert_eq!(both.vertices[3], DVec3::new(0.0, -1.0, 2.0));
        assert_eq!(both.triangles[1], [0, 3, 1]);
        assert!(both.area_vector(0).z > 0.0 && both.area_vector(1).z > 0.0);
    }

    #[test]
    fn weld_undoes_the_unshared_list() {
        let mesh = triangle().with_reflection(1);
        let soup: Vec<_> = (0..2).flat_map(|t| mesh.corners(t)).collect();
        assert_eq!(TriMesh::weld(soup.into_iter()), mesh);
    }

    #[test]
    fn weld_takes_both_zeros_for_one_place() {
        let soup = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::Y,
            -DVec3::ZERO,
            DVec3::Y,
            -DVec3::X,
        ];
        assert_eq!(TriMesh::weld(soup.into_iter()).vertices.len(), 4);
    }
}
