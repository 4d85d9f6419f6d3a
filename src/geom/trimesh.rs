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
        Some(self.vertices.iter().fold((first, first), |(lo, hi), &v| (lo.min(v), hi.max(v))))
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
}

/// Joins corners that have the same bits: how a file without shared vertices becomes a mesh.
/// Vertices are numbered in order of first appearance. Zeros of either sign are the same.
#[derive(Debug)]
pub struct Welder {
    mesh: TriMesh,
    seen: FxHashMap<[u64; 3], u32>,
    /// The last vertex met for each residue of the hash. Files list neighbours near each other, so
    /// most corners are found here, without a jump into the large table.
    recent: Vec<([u64; 3], u32)>,
}

impl Welder {
    const RECENT: usize = 1 << 13;
    /// No finite vertex has these bits.
    const NOWHERE: [u64; 3] = [u64::MAX; 3];

    /// A welder for about `facets` facets.
    #[must_use]
    pub fn new(facets: usize) -> Self {
        // Closed triangle meshes have half as many vertices as facets.
        let vertices = facets / 2 + 16;
        Self {
            mesh: TriMesh {
                vertices: Vec::with_capacity(vertices),
                triangles: Vec::with_capacity(facets),
            },
            seen: FxHashMap::with_capacity_and_hasher(vertices, Default::default()),
            recent: vec![(Self::NOWHERE, 0); Self::RECENT],
        }
    }

    /// Adds a facet.
    #[inline]
    pub fn add(&mut self, corners: [DVec3; 3]) {
        let triangle = corners.map(|corner| self.vertex(corner));
        self.mesh.triangles.push(triangle);
    }

    #[inline]
    fn vertex(&mut self, corner: DVec3) -> u32 {
        let key = (corner + DVec3::ZERO).to_array().map(f64::to_bits);
        // Fibonacci hashing of the mixed coordinates.
        let mixed = key[0].rotate_left(21) ^ key[1].rotate_left(42) ^ key[2];
        let slot = (mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 51) as usize;
        let recent = &mut self.recent[slot];
        if recent.0 == key {
            return recent.1;
        }
        let index = match self.seen.entry(key) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                self.mesh.vertices.push(corner);
                *new.insert(self.mesh.vertices.len() as u32 - 1)
            }
        };
        *recent = (key, index);
        index
    }

    /// The mesh of all facets added.
    #[must_use]
    pub fn finish(self) -> TriMesh {
        self.mesh
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
        let mut welder = Welder::new(2);
        (0..2).for_each(|t| welder.add(mesh.corners(t)));
        assert_eq!(welder.finish(), mesh);
    }

    #[test]
    fn weld_takes_both_zeros_for_one_place() {
        let mut welder = Welder::new(2);
        welder.add([DVec3::ZERO, DVec3::X, DVec3::Y]);
        welder.add([-DVec3::ZERO, DVec3::Y, -DVec3::X]);
        assert_eq!(welder.finish().vertices.len(), 4);
    }
}
