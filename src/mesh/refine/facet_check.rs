//! The check of facets against limits: their bounds, and the facets that fail.

use crate::mesh::bound::error_bound::{ErrorBound, Limits};
use crate::mesh::bound::error_bounder::ErrorBounder;
use crate::mesh::bound::vertex::SurfaceVertex;
use crate::parallel;

/// Facets that a thread checks at a time; fixed, so that results do not depend on the number of threads.
const CHUNK: usize = 256;

/// A bounder, and the limits that facets are held to.
pub(crate) struct FacetCheck<'a> {
    /// The bounder.
    pub bounder: &'a ErrorBounder<'a>,
    /// The limits.
    pub limits: Limits,
}

/// The outcome of a check of some facets.
#[derive(Default)]
pub(crate) struct CheckedFacets {
    /// The bounds of each.
    pub bounds: Vec<ErrorBound>,
    /// The facets that attain the largest chord and facet error in their chunk, among those that keep the limits.
    pub largest: Vec<u32>,
    /// The facets that fail.
    pub failed: Vec<u32>,
}

impl FacetCheck<'_> {
    /// Checks the given facets.
    pub(crate) fn check(
        &self,
        facets: &[u32],
        vertices: &[SurfaceVertex],
        triangles: &[[u32; 3]],
    ) -> CheckedFacets {
        let chunk = |facets: &[u32]| self.check_chunk(facets, vertices, triangles);
        let chunks = parallel::map_chunks(facets, CHUNK, chunk);
        chunks.into_iter().fold(CheckedFacets::default(), |mut all, chunk| {
            all.bounds.extend(chunk.bounds);
            all.largest.extend(chunk.largest);
            all.failed.extend(chunk.failed);
            all
        })
    }

    fn check_chunk(
        &self,
        facets: &[u32],
        vertices: &[SurfaceVertex],
        triangles: &[[u32; 3]],
    ) -> CheckedFacets {
        let mut checked = CheckedFacets::default();
        let mut largest = [(0.0, None); 2];
        for &t in facets {
            let facet = triangles[t as usize].map(|v| &vertices[v as usize]);
            let (mut bound, attained) = self.bounder.enclose(facet);
            if !self.limits.hold(&bound) && self.limits.may_hold(attained) {
                bound = self.bounder.bound_until_decided(facet, bound, &self.limits);
            }
            checked.bounds.push(bound);
            if self.limits.hold(&bound) {
                for (largest, attained) in largest.iter_mut().zip(attained) {
                    if attained > largest.0 {
                        *largest = (attained, Some(t));
                    }
                }
            } else {
                checked.failed.push(t);
            }
        }
        checked.largest.extend(largest.into_iter().filter_map(|(_, t)| t));
        checked
    }
}
