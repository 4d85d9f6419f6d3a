//! The coarse mesh: nodes on the boundary, points placed inside, their triangulation, and the choice of its size.
//!
//! `boundary_nodes` and `point_placement` put the vertices, `delaunay` triangulates and smooths, `coarse_mesh` holds
//! the result with an estimate of the facets that come of it, and `candidate` chooses among sizes.

pub(super) mod boundary_nodes;
pub(super) mod candidate;
pub(super) mod coarse_mesh;
pub(super) mod delaunay;
pub(super) mod point_placement;
pub(super) mod spatial_grid;
pub(super) mod tuning;
