//! What a face as cut has that its facets have not: slopes, and a rim of its own.

use super::cut_slopes::CutSlopes;
use crate::geom::TriMesh;
use crate::mirror::Mirror;
use crate::solid::likely_open_edges;

/// A face as cut, beside its facets.
pub(crate) struct AsCutFace {
    /// Its slopes, where they are not those of its facets.
    pub slopes: Option<CutSlopes>,
    /// The largest height of its rim over the mirror or below it, mm: in the plan the rim is the mirror's own.
    pub rim_mm: f64,
}

impl AsCutFace {
    /// Of these facets, cut of `mirror`.
    #[must_use]
    pub(crate) fn new(mirror: &Mirror, facets: &TriMesh, slopes: Option<CutSlopes>) -> Self {
        let height = |(from, _): (u32, u32)| {
            let at = facets.vertices[from as usize];
            // (Rounding may leave a vertex of the rim beyond it.)
            let place = mirror.local_surface_over(at.truncate(), at.z)?;
            Some((at.z - place.at.z).abs())
        };
        let rim_mm = likely_open_edges(facets).into_iter().filter_map(height).fold(0.0, f64::max);
        Self { slopes, rim_mm }
    }
}
