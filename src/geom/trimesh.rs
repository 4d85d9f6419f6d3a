//! Triangle meshes: vertices and triangles, no promises.

use super::{DVec2, DVec3};
use crate::parallel;
use hashbrown::hash_table::{Entry, HashTable};
use std::collections::HashSet;

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
    /// All facets of several meshes, which share no vertices.
    #[must_use]
    pub fn side_by_side(meshes: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::default();
        for mesh in meshes {
            let first = all.vertices.len() as u32;
            all.vertices.extend(mesh.vertices);
            all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
        }
        all
    }

    /// The edges that one facet alone has, from vertex to vertex with the facet on their left, in no order.
    #[must_use]
    pub fn open_edges(&self) -> HashSet<(u32, u32)> {
        let mut open = HashSet::new();
        for &[a, b, c] in &self.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if !open.remove(&(to, from)) {
                    open.insert((from, to));
                }
            }
        }
        open
    }

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

    /// The mesh that a [`Welder`] makes of its facets, if all vertices are finite and no two at the same place:
    /// then only their numbers change.
    #[must_use]
    pub fn as_welded(&self) -> Option<Self> {
        let (distinct, welded) = parallel::join(|| self.is_distinct(), || self.renumbered());
        distinct.then_some(welded)
    }

    /// Whether all vertices are finite and no two at the same place.
    fn is_distinct(&self) -> bool {
        // Threads among which the vertices are shared out by their hashes.
        const SHARES: usize = 2;
        let distinct = |share: usize| {
            let (all, places) = (&self.vertices, self.vertices.len());
            let mut seen: HashTable<u32> = HashTable::with_capacity(places / SHARES + places / 64);
            let hash_of = |&index: &u32| hash(all[index as usize] + DVec3::ZERO);
            let hashed = all.iter().map(|v| hash(*v + DVec3::ZERO));
            let mine = |hash: &u64| (hash >> 32) as usize % SHARES == share;
            (0..).zip(hashed).filter(|(_, hash)| mine(hash)).all(|(k, hash)| {
                let v = all[k as usize];
                match seen.entry(hash, |&other| all[other as usize] == v, hash_of) {
                    Entry::Occupied(_) => false,
                    Entry::Vacant(new) => {
                        new.insert(k);
                        v.is_finite()
                    }
                }
            })
        };
        parallel::map(SHARES, 1, distinct).into_iter().all(|distinct| distinct)
    }

    /// The mesh with vertices numbered in the order of their first appearance in a facet.
    fn renumbered(&self) -> Self {
        const NONE: u32 = u32::MAX;
        let mut number = vec![NONE; self.vertices.len()];
        let mut vertices = Vec::with_capacity(self.vertices.len());
        let mut triangles = Vec::with_capacity(self.triangles.len());
        triangles.extend(self.triangles.iter().map(|t| {
            t.map(|v| {
                let known = &mut number[v as usize];
                if *known == NONE {
                    *known = vertices.len() as u32;
                    vertices.push(self.vertices[v as usize] + DVec3::ZERO);
                }
                *known
            })
        }));
        Self { vertices, triangles }
    }

    /// The mesh with its mirror image across the plane where coordinate `axis` (0 = X, 1 = Y)
    /// vanishes. Vertices in that plane are shared by both halves; images follow the originals in
    /// their order, with the facets turned so that they stay oriented.
    #[must_use]
    pub fn with_reflection(mut self, axis: usize) -> Self {
        let mut image = Vec::with_capacity(self.vertices.len());
        self.vertices.reserve_exact(self.vertices.len());
        self.triangles.reserve_exact(self.triangles.len());
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
    /// Indices of the vertices, hashed by their bits.
    seen: HashTable<u32>,
    /// The last vertex met for each residue of the hash. Files list neighbours near each other, so
    /// most corners are found here, without a jump into the large table.
    recent: Vec<u32>,
}

impl Welder {
    const RECENT_BITS: u32 = 13;

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
            seen: HashTable::with_capacity(vertices),
            recent: vec![u32::MAX; 1 << Self::RECENT_BITS],
        }
    }

    /// A welder for at most `vertices` vertices and `facets` facets; none when memory does not hold them.
    #[must_use]
    pub fn reserved(vertices: usize, facets: usize) -> Option<Self> {
        let mut welder = Self::new(0);
        welder.mesh.vertices.try_reserve_exact(vertices).ok()?;
        welder.mesh.triangles.try_reserve_exact(facets).ok()?;
        welder.seen.try_reserve(vertices, |_| unreachable!("an empty table")).ok()?;
        Some(welder)
    }

    /// Adds a facet.
    #[inline]
    pub fn add(&mut self, corners: [DVec3; 3]) {
        let triangle = corners.map(|corner| self.vertex(corner + DVec3::ZERO));
        self.mesh.triangles.push(triangle);
    }

    #[inline]
    fn vertex(&mut self, corner: DVec3) -> u32 {
        let hash = hash(corner);
        let vertices = &mut self.mesh.vertices;
        let recent = &mut self.recent[(hash >> (64 - Self::RECENT_BITS)) as usize];
        if vertices.get(*recent as usize) == Some(&corner) {
            return *recent;
        }
        let same = |&index: &u32| vertices[index as usize] == corner;
        let hash_of = |&index: &u32| self::hash(vertices[index as usize]);
        *recent = match self.seen.entry(hash, same, hash_of) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                let index = vertices.len() as u32;
                new.insert(index);
                vertices.push(corner);
                index
            }
        };
        *recent
    }

    /// One mesh of many that were welded apart, the same as if one welder had been given all their
    /// facets.
    #[must_use]
    pub fn join(parts: Vec<TriMesh>) -> TriMesh {
        let facets = parts.iter().map(|part| part.triangles.len()).sum();
        let mut welder = Self::new(facets);
        for TriMesh { vertices, triangles } in parts {
            let known: Vec<u32> = vertices.into_iter().map(|v| welder.vertex(v)).collect();
            let renamed = triangles.iter().map(|t| t.map(|v| known[v as usize]));
            welder.mesh.triangles.extend(renamed);
        }
        welder.mesh
    }

    /// The mesh of all facets added.
    #[must_use]
    pub fn finish(self) -> TriMesh {
        self.mesh
    }
}

/// A hash of the coordinates' bits whose top and bottom bits are both well mixed (single-precision
/// numbers leave the lower half of their doubles empty).
#[inline]
fn hash(v: DVec3) -> u64 {
    let fold = |a: u64, b: u64| {
        let wide = u128::from(a) * u128::from(b);
        (wide >> 64) as u64 ^ wide as u64
    };
    let [x, y, z] = v.to_array().map(f64::to_bits);
    fold(fold(x ^ 0x9e37_79b9_7f4a_7c15, y ^ 0xbf58_476d_1ce4_e5b9) ^ z, 0x94d0_49bb_1331_11eb)
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
    fn a_mesh_of_distinct_vertices_is_welded_by_numbering_them() {
        let mesh = TriMesh {
            vertices: (0..9).map(|k| DVec3::new(f64::from(k % 3), f64::from(k / 3), 1.0)).collect(),
            triangles: vec![[4, 5, 8], [4, 8, 7], [0, 1, 4], [3, 0, 4]],
        };
        let weld = |mesh: &TriMesh| {
            let mut welder = Welder::new(0);
            (0..mesh.triangles.len()).for_each(|t| welder.add(mesh.corners(t)));
            welder.finish()
        };
        assert_eq!(mesh.as_welded(), Some(weld(&mesh)));
        for place in [mesh.vertices[8], -DVec3::ZERO.with_x(0.0), DVec3::splat(f64::INFINITY)] {
            let mut other = mesh.clone();
            other.vertices[0] = DVec3::ZERO;
            other.vertices[4] = place;
            assert_eq!(other.as_welded(), None, "{place}");
        }
    }

    #[test]
    fn what_was_welded_apart_joins_to_the_same() {
        // A strip of facets whose corners come back later, in uneven parts.
        let at = |k: usize| DVec3::new((k / 2) as f64, (k % 2) as f64, (k % 7) as f64);
        let corners: Vec<[DVec3; 3]> =
            (0..50).map(|k| [at(k * 13 % 50), at(k * 13 % 50 + 1), at(k * 13 % 50 + 2)]).collect();
        let weld = |corners: &[[DVec3; 3]]| {
            let mut welder = Welder::new(0);
            corners.iter().for_each(|&facet| welder.add(facet));
            welder.finish()
        };
        for size in [1, 7, 20, 50] {
            assert_eq!(Welder::join(corners.chunks(size).map(weld).collect()), weld(&corners));
        }
    }

    #[test]
    fn weld_takes_both_zeros_for_one_place() {
        let mut welder = Welder::new(2);
        welder.add([DVec3::ZERO, DVec3::X, DVec3::Y]);
        welder.add([-DVec3::ZERO, DVec3::Y, -DVec3::X]);
        assert_eq!(welder.finish().vertices.len(), 4);
    }
}
