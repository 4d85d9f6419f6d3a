//! A mesh with the search structures for rays against it.

use super::obstacles::Obstacles;
use super::occlusion::OcclusionProof;
use crate::geom::sheared_ray::ShearedRay;
use crate::geom::{DVec3, Hit, MeshSearch, Ray, TriMesh};
use crate::parallel;
use std::sync::{Arc, OnceLock};

/// Facets whose box is held against rays at once: neighbours in a file are near each other.
const PIECE: usize = 256;

/// A reflected ray that may be blocked.
#[derive(Debug, Clone, Copy)]
pub(super) struct LeavingRay {
    /// The ray.
    pub ray: Ray,
    /// The facet that it leaves.
    pub from: u32,
    /// Distance from its origin within which nothing counts, mm.
    pub clear: f64,
}

/// Whether a ray may enter a box: NaN says that it may.
fn may_enter(ray: &Ray, [lo, hi]: [DVec3; 2]) -> bool {
    let (mut first, mut last) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (from, along) = (ray.origin[axis], ray.direction[axis]);
        if along == 0.0 {
            if from < lo[axis] || from > hi[axis] {
                return false;
            }
            continue;
        }
        let (a, b) = ((lo[axis] - from) / along, (hi[axis] - from) / along);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    !(first > last)
}

/// A triangle mesh with the grid that finds the facets a ray meets.
#[derive(Debug, Clone)]
pub struct Scene {
    search: MeshSearch,
    bounds: Option<(DVec3, DVec3)>,
    /// Whether the mesh is known to be closed, as `is_closed` has it; no: not yet looked at.
    closed: bool,
    /// Made when it is first needed: never from within a trace, whose threads would wait for it
    /// while it waits for them.
    occlusion_proof: OnceLock<Option<OcclusionProof>>,
    /// Bodies beside the mesh that hide what rays would show; none where nothing is there.
    obstacles: Option<Arc<Obstacles>>,
}

impl Scene {
    /// A scene of `mesh`, which need be neither closed nor consistent.
    #[must_use]
    pub fn new(mesh: TriMesh) -> Self {
        let scene = Self::for_cameras(mesh, false);
        scene.prepare_search();
        scene
    }

    /// A scene of `mesh`, which is known to be `closed` or not known to be, for [`CameraTrace`]: the grid is
    /// made when more than a few rays have to be searched for. Call [`Self::prepare_search`] before any single
    /// ray.
    ///
    /// [`CameraTrace`]: super::CameraTrace
    #[must_use]
    pub fn for_cameras(mesh: TriMesh, closed: bool) -> Self {
        let bounds = mesh.bounds();
        let (search, occlusion_proof) = (MeshSearch::new(mesh), OnceLock::new());
        Self { search, bounds, closed, occlusion_proof, obstacles: None }
    }

    /// The same scene among `obstacles`. What rays meet of the mesh before an obstacle is searched for in the grid.
    #[must_use]
    pub fn among(self, obstacles: Option<Arc<Obstacles>>) -> Self {
        if obstacles.is_some() {
            self.prepare_search();
        }
        Self { obstacles, ..self }
    }

    /// The bodies beside the mesh, if there are any.
    #[must_use]
    pub fn obstacles(&self) -> Option<&Obstacles> {
        self.obstacles.as_deref()
    }

    /// Makes the grid that searches for single rays, unless it is there. It must not be called from work that
    /// is shared out among threads.
    pub fn prepare_search(&self) {
        self.search.prepare();
    }

    /// Whether single rays are searched for in the grid.
    pub(super) fn has_search(&self) -> bool {
        self.search.is_prepared()
    }

    /// The triangles.
    #[must_use]
    pub fn mesh(&self) -> &TriMesh {
        self.search.mesh()
    }

    /// Smallest and largest coordinates; `None` without vertices.
    #[must_use]
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        self.bounds
    }

    /// A height above everything in it, mm, for camera rays to start from.
    #[must_use]
    pub fn above_mm(&self) -> f64 {
        let above = self.bounds.map_or(0.0, |(lo, hi)| hi.z + (hi - lo).max_element());
        self.obstacles().map_or(above, |obstacles| above.max(obstacles.above_mm()))
    }

    /// Proof that reflected rays are unoccluded; `None` for a mesh that is not closed.
    pub(super) fn occlusion_proof(&self) -> Option<&OcclusionProof> {
        self.occlusion_proof.get_or_init(|| OcclusionProof::new(self.mesh(), self.closed)).as_ref()
    }

    /// Nearest intersection ahead of the ray's origin; of two at the same distance (a ray through an
    /// edge) that with the lower facet number.
    #[must_use]
    pub fn nearest_hit(&self, ray: &Ray) -> Option<Hit> {
        self.search.nearest_hit(ray, 0.0)
    }

    /// A facet other than `from` that the ray meets further than `clear` mm from its origin; the
    /// first one found.
    #[must_use]
    pub fn occluder(&self, ray: &Ray, from: u32, clear: f64) -> Option<u32> {
        self.occluder_before(ray, from, [clear, f64::INFINITY])
    }

    /// The same between two distances from its origin, mm.
    pub(super) fn occluder_before(&self, ray: &Ray, from: u32, between: [f64; 2]) -> Option<u32> {
        self.search.occluder(ray, from, between)
    }

    /// Whether a facet other than the ray's own blocks any of `rays` further than `clear` mm from its origin:
    /// each facet near a ray is tried, without the grid.
    pub(super) fn blocks_any(&self, rays: &[LeavingRay]) -> bool {
        let margin =
            self.bounds.map_or(0.0, |(lo, hi)| 1e-9 * lo.abs().max(hi.abs()).max_element());
        let blocks = |first: usize, facets: &[[u32; 3]]| {
            let corners = facets.iter().flatten().map(|&v| self.mesh().vertices[v as usize]);
            let none = [DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY)];
            let [lo, hi] = corners.fold(none, |[lo, hi], v| [lo.min(v), hi.max(v)]);
            let [lo, hi] = [lo - DVec3::splat(margin), hi + DVec3::splat(margin)];
            rays.iter().filter(|leaving| may_enter(&leaving.ray, [lo, hi])).any(|leaving| {
                let line = ShearedRay::new(&leaving.ray);
                (first as u32..).take(facets.len()).any(|facet| {
                    facet != leaving.from
                        && self.search.intersect(&line, facet).is_some_and(|t| t > leaving.clear)
                })
            })
        };
        let pieces = self.mesh().triangles.len().div_ceil(PIECE);
        let piece = |k: usize| {
            let first = k * PIECE;
            let end = self.mesh().triangles.len().min(first + PIECE);
            blocks(first, &self.mesh().triangles[first..end])
        };
        parallel::map(pieces, 64, piece).contains(&true)
    }

    /// Barycentric coordinates in `facet` where the ray's line meets its plane.
    pub(super) fn barycentric(&self, ray: &Ray, facet: u32) -> [f64; 3] {
        self.search.barycentric(ray, facet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec2, DVec3};
    use crate::num::{cos, sin};

    /// Random numbers in [0, 1) from a counter (splitmix64).
    fn random(k: u64) -> f64 {
        let mut z = k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A bumpy grid of n x n quads over [0, n]^2, with long thin facets of a base below it.
    fn terrain(n: u32) -> TriMesh {
        let side = n + 1;
        let mut vertices: Vec<DVec3> = (0..side * side)
            .map(|k| {
                let (x, y) = (f64::from(k % side), f64::from(k / side));
                DVec3::new(x, y, 2.0 + sin(0.7 * x) * cos(0.9 * y) + 0.3 * random(u64::from(k)))
            })
            .collect();
        let quad = |k: u32| {
            let a = k / n * side + k % n;
            [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
        };
        let mut triangles: Vec<[u32; 3]> = (0..n * n).flat_map(quad).collect();
        let foot = vertices.len() as u32;
        let far = f64::from(n);
        vertices.extend(
            [(0.0, 0.0), (far, 0.0), (far, far), (0.0, far)].map(|(x, y)| DVec3::new(x, y, 0.0)),
        );
        triangles.extend([[foot, foot + 2, foot + 1], [foot, foot + 3, foot + 2]]);
        TriMesh { vertices, triangles }
    }

    fn brute_force(scene: &Scene, ray: &Ray) -> Option<Hit> {
        let facets = 0..scene.mesh().triangles.len() as u32;
        let hits = facets.filter_map(|facet| {
            let t = scene.search.intersect(&ShearedRay::new(ray), facet)?;
            Some(Hit { t, facet, barycentric: scene.barycentric(ray, facet) })
        });
        hits.filter(|h| h.t > 0.0).min_by(|a, b| a.t.total_cmp(&b.t).then(a.facet.cmp(&b.facet)))
    }

    #[test]
    fn the_grid_finds_what_brute_force_finds() {
        let scene = Scene::new(terrain(24));
        let mut hits = 0;
        for k in 0..20_000u64 {
            let r = |j: u64| random(1000 + 8 * k + j);
            let origin = DVec3::new(30.0 * r(0) - 3.0, 30.0 * r(1) - 3.0, 8.0 * r(2) - 2.0);
            let mut direction = DVec3::new(r(3) - 0.5, r(4) - 0.5, r(5) - 0.5);
            match k % 8 {
                0 => direction = DVec3::NEG_Z,
                1 => direction.x = 0.0,
                2 => direction.y = 0.0,
                3 => direction.z *= 1e-3,
                _ => {}
            }
            let ray = Ray { origin, direction: direction.normalize() };
            let expected = brute_force(&scene, &ray);
            assert_eq!(scene.nearest_hit(&ray), expected, "ray {k} {ray:?}");
            let clear = 1e-6;
            let blocked = (0..scene.mesh().triangles.len() as u32).any(|t| {
                t != 7
                    && scene.search.intersect(&ShearedRay::new(&ray), t).is_some_and(|t| t > clear)
            });
            assert_eq!(scene.occluder(&ray, 7, clear).is_some(), blocked, "ray {k} {ray:?}");
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 4000, "{hits}");
    }

    #[test]
    fn rays_through_vertices_and_edges_never_slip_between() {
        let scene = Scene::new(terrain(24));
        let nudge = |x: f64, ulps: i64| f64::from_bits((x.to_bits() as i64 + ulps) as u64);
        for k in 0..30_000u64 {
            let r = |j: u64| random(77 + 8 * k + j);
            let (x, y) = (6.0 + (12.0 * r(0)).floor(), 6.0 + (12.0 * r(1)).floor());
            // Through a vertex, or anywhere on an edge or diagonal, and one ulp beside it.
            let along = if k % 3 == 0 { 0.0 } else { r(2) };
            let ulps = (k % 5) as i64 - 2;
            let foot = [
                DVec2::new(nudge(x, ulps), y + along),
                DVec2::new(x + along, nudge(y, ulps)),
                DVec2::new(x + along, nudge(y + along, ulps)),
            ][(k % 3) as usize];
            let tilt =
                if k % 2 == 0 { DVec3::ZERO } else { DVec3::new(r(3) - 0.5, r(4) - 0.5, 0.0) };
            let direction = (DVec3::NEG_Z + 0.3 * tilt).normalize();
            let ray = Ray { origin: foot.extend(9.0), direction };
            let hit =
                scene.nearest_hit(&ray).unwrap_or_else(|| panic!("ray {k} fell through: {ray:?}"));
            assert!(hit.facet < 2 * 24 * 24, "ray {k} reached the base: {ray:?}");
        }
    }

    #[test]
    fn rays_one_ulp_beside_a_cell_border_are_not_lost() {
        let nudge = |x: f64, ulps: i64| f64::from_bits((x.to_bits() as i64 + ulps) as u64);
        let mut tried = 0;
        for width in [0.77, 1.0, 1.371, 3.3, 9.1] {
            let mut mesh = terrain(24);
            mesh.vertices.iter_mut().for_each(|v| *v *= width);
            let scene = Scene::new(mesh);
            let inside = |x: &f64| (0.5 * width..23.5 * width).contains(x);
            for border in scene.search.grid.get().unwrap().borders().into_iter().filter(inside) {
                for (ulps, other) in (-6..=6).flat_map(|u| [3.3, 20.1].map(|o| (u, o * width))) {
                    let x = nudge(border, ulps);
                    for direction in [DVec3::NEG_Z, DVec3::new(1e-17, -1e-17, -1.0)] {
                        let ray = Ray { origin: DVec3::new(x, other, 9.0 * width), direction };
                        assert!(scene.nearest_hit(&ray).is_some(), "lost: {ray:?}");
                        tried += 1;
                    }
                }
            }
        }
        assert!(tried > 2000, "{tried}");
    }

    #[test]
    fn barycentric_coordinates_give_the_point() {
        let scene = Scene::new(terrain(5));
        let ray = Ray {
            origin: DVec3::new(2.3, 3.4, 9.0),
            direction: DVec3::new(0.1, -0.2, -1.0).normalize(),
        };
        let hit = scene.nearest_hit(&ray).unwrap();
        let corners = scene.mesh().corners(hit.facet as usize);
        let point: DVec3 = corners.iter().zip(hit.barycentric).map(|(c, w)| *c * w).sum();
        assert!((point - ray.at(hit.t)).length() < 1e-13);
    }

    #[test]
    fn an_empty_mesh_meets_nothing() {
        let ray = Ray { origin: DVec3::Z, direction: DVec3::NEG_Z };
        assert_eq!(Scene::new(TriMesh::default()).nearest_hit(&ray), None);
    }
}
