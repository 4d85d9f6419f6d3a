//! The optical face, and the forecast of one.

use super::bound::error_bound::ErrorBound;
use super::sizing::optimum::Optimum;
use crate::geom::{FaceMesh, Precision};

/// The optical face: all panels of the meshed mirror, and the walls between them, without skirt and base.
#[derive(Debug, Clone)]
pub struct Face {
    /// Facets in the part frame, mm. In the chart of parallel rays X and Y are single-precision numbers.
    pub mesh: FaceMesh,
    /// Number of facets of the designed panels, which come first; what follows is the reflection of a folded mirror's,
    /// or walls.
    pub designed: usize,
    /// Bounds that hold on every facet, for the mesh as it is and rounded to single precision.
    pub bound: ErrorBound,
    /// Lower bounds on the number of triangles.
    pub optimum: Optimum,
    /// Digits for which the limits were kept.
    pub precision: Precision,
    /// Number of triangles, closed, of the mesh within the next finer limit that was tried for a budget and did not
    /// fit it; none where no such mesh was made.
    pub next_finer: Option<usize>,
}

/// Forecast of the size of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceForecast {
    /// Facets of the optical face.
    pub facets: f64,
    /// Edges around it, and around its hole if there is one.
    pub rim: f64,
}
