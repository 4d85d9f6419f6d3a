//! The fine mesh: subdivision of a coarse triangulation, proof of its facets, and repair of those that fail.
//!
//! `vertex_model`, `triangulation` and `independent_sets` edit a triangulation by the errors that its vertices foresee;
//! the coarse mesh is smoothed by them, too. `boundary_arcs` keeps the round parts of the boundary, `subdivide` cuts
//! coarse triangles, `facet_check` bounds the facets, `repair` mends those that fail for as long as `repair_progress`
//! sees a point in it, and `probe` tells beforehand whether refinement of a facet helps.

pub(super) mod boundary_arcs;
pub(super) mod facet_check;
pub(super) mod independent_sets;
pub(super) mod probe;
pub(super) mod repair;
pub(super) mod repair_progress;
pub(super) mod subdivide;
pub(super) mod triangulation;
pub(super) mod tuning;
pub(super) mod vertex_model;
