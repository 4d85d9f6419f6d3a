//! The meshing stage: mirror and limits to an optical face with proven bounds.
//!
//! Four rooms, each of which uses only those to its left:
//!
//! ```text
//! bound    <-   sizing   <-   refine          <-   coarse          <-   mesher   <-   budget
//! proven        size and      subdivision,         boundary nodes,      the whole     limits for a
//! bounds of     shape of      check and repair     placed points,       way, once     number of
//! facets        cells         of facets            choice of size       or often      triangles
//! ```
//!
//! A value goes its way through them in this order:
//!
//! 1. `sizing`: a local model of mirror and image at every place says which lattice cell suits it.
//! 2. `coarse`: a lattice of such cells is placed inside the boundary, triangulated and smoothed; of some sizes the one
//!    of the fewest facets is chosen, and limits that refinement cannot meet are refused.
//! 3. `refine`: each triangle of that coarse mesh is cut into equal facets. Every facet is bounded over its whole area
//!    (`bound`); around those that fail vertices are moved, edges flipped, and facets split or collapsed.
//! 4. `bound`: at last the largest of the bounds are brought near the errors that facets attain.
//!
//! All of that happens in the mirror's chart, where facets are flat too (`geom::Chart`). A symmetric panel is meshed on
//! one half or quarter, a folded mirror on one panel: displacements of the image are the same in all of them.

mod bound;
mod budget;
mod coarse;
mod error;
mod face;
mod mesher;
mod panel_mesher;
mod refine;
mod sizing;
#[cfg(test)]
mod tests;

pub use bound::error_bound::{ErrorBound, Limits};
pub use bound::error_bounder::ErrorBounder;
pub use bound::vertex::SurfaceVertex;
pub use budget::{Budget, ClosureCount, LEAST_USED, MeshPlan};
pub use error::{ImageSingularity, MeshError};
pub use face::{Face, FaceForecast};
pub use sizing::optimum::Optimum;

use crate::geom::Chart;
use crate::mirror::Mirror;
use crate::optics::ImagingTask;
use mesher::{Mesher, SmoothPanels};

/// The optical face of `mirror` with facets that keep `limits` as the camera of chart `camera` sees them.
///
/// The image must show `view`; without one `facet_mm` of the face's bound is 0. The camera's chart is the mirror's own,
/// or any where the mirror's is that of parallel rays (a given mirror under a pinhole).
///
/// # Errors
/// [`MeshError`] when there is no such mesh in the precision of `limits`, or none that fits in memory.
///
/// # Panics
/// When `limits` ask for a facet error without a view.
pub fn mesh(
    mirror: &Mirror,
    camera: &Chart,
    view: Option<&ImagingTask>,
    limits: Limits,
) -> Result<Face, MeshError> {
    Mesher::new(&SmoothPanels::new(mirror, view), camera).mesh(limits)
}

/// Forecast of the size of the mesh that [`mesh`] makes of the same arguments, mostly without making it.
///
/// # Errors
/// [`MeshError`] as far as it can be foreseen.
///
/// # Panics
/// When `limits` ask for a facet error without a view.
pub fn forecast(
    mirror: &Mirror,
    camera: &Chart,
    view: Option<&ImagingTask>,
    limits: Limits,
) -> Result<FaceForecast, MeshError> {
    Mesher::new(&SmoothPanels::new(mirror, view), camera).forecast(limits)
}
