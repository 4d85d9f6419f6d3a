//! Triangles with the grid that finds those which a ray meets.

mod hierarchical_grid;
pub(crate) mod sheared_ray;
mod uniform_grid;

use crate::geom::{Ray, TriMesh};
use hierarchical_grid::HierarchicalGrid;
use sheared_ray::{Shear, ShearedRay, ShearedVertex, barycentric, intersect};
use std::sync::OnceLock;

/// Intersection of a ray with a facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the ray, mm.
    pub t: f64,
    /// The facet.
    pub facet: u32,
    /// Barycentric coordinates in the facet.
    pub barycentric: [f64; 3],
}

/// A triangle mesh with the grid that finds the facets a ray meets.
#[derive(Debug, Clone)]
pub(crate) struct MeshSearch {
    mesh: TriMesh,
    /// Made when it is first needed: never from within a trace, whose threads would wait for it
    /// while it waits for them. Without it rays are held against every facet.
    pub(crate) grid: OnceLock<HierarchicalGrid>,
}

impl MeshSearch {
    /// A search without a grid yet.
    pub(crate) fn new(mesh: TriMesh) -> Self {
        Self { mesh, grid: OnceLock::new() }
    }

    /// Makes the grid, unless it is there. It must not be called from work that is shared out among threads.
    pub(crate) fn prepare(&self) {
        self.grid.get_or_init(|| HierarchicalGrid::new(&self.mesh));
    }

    /// Whether the grid is there.
    pub(crate) fn is_prepared(&self) -> bool {
        self.grid.get().is_some()
    }

    /// The triangles.
    #[inline]
    pub(crate) fn mesh(&self) -> &TriMesh {
        &self.mesh
    }

    /// Nearest intersection further than `after` mm from the ray's origin; of two at the same distance (a ray
    /// through an edge) that with the lower facet number.
    pub(crate) fn nearest_hit(&self, ray: &Ray, after: f64) -> Option<Hit> {
        let line = ShearedRay::new(ray);
        let mut nearest: Option<(f64, u32)> = None;
        self.walk(ray, |facets| {
            for &facet in facets {
                if let Some(t) = self.intersect(&line, facet) {
                    let nearer = nearest.is_none_or(|nearest| (t, facet) < nearest);
                    if t > after && nearer {
                        nearest = Some((t, facet));
                    }
                }
            }
            nearest.map_or(f64::INFINITY, |(t, _)| t)
        });
        nearest.map(|(t, facet)| Hit { t, facet, barycentric: self.barycentric(ray, facet) })
    }

    /// A facet other than `from` that the ray meets between two distances from its origin, mm; the first one
    /// found.
    pub(crate) fn occluder(&self, ray: &Ray, from: u32, [clear, end]: [f64; 2]) -> Option<u32> {
        let line = ShearedRay::new(ray);
        let mut found = None;
        self.walk(ray, |facets| {
            let blocks = |&&facet: &&u32| {
                let between = |t: f64| t > clear && t < end;
                facet != from && self.intersect(&line, facet).is_some_and(between)
            };
            found = found.or(facets.iter().find(blocks).copied());
            if found.is_some() { 0.0 } else { end }
        });
        found
    }

    /// Visits the facets that a ray may meet, as [`HierarchicalGrid::walk`] does.
    #[inline]
    fn walk(&self, ray: &Ray, mut visit: impl FnMut(&[u32]) -> f64) {
        if let Some(grid) = self.grid.get() {
            grid.walk(ray, visit);
        } else {
            (0..self.mesh.triangles.len() as u32).for_each(|facet| {
                visit(&[facet]);
            });
        }
    }

    /// Barycentric coordinates in `facet` where the ray's line meets its plane.
    pub(crate) fn barycentric(&self, ray: &Ray, facet: u32) -> [f64; 3] {
        let [a, b, c] = self.sheared(&ShearedRay::new(ray), facet);
        barycentric(a, b, c)
    }

    #[inline]
    pub(crate) fn intersect(&self, line: &ShearedRay, facet: u32) -> Option<f64> {
        let [a, b, c] = self.sheared(line, facet);
        let (met, t) = intersect(a, b, c);
        met.then_some(t)
    }

    #[inline]
    fn sheared(&self, line: &ShearedRay, facet: u32) -> [ShearedVertex; 3] {
        self.mesh.corners(facet as usize).map(|v| line.project(v))
    }
}
