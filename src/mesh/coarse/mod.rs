//! The coarse mesh: nodes on the boundary, points placed inside, their triangulation, and the choice of its size.
//!
//! `boundary_nodes` and `point_placement` put the vertices, `delaunay` triangulates and smooths, `coarse_mesh` holds
//! the result with an estimate of the facets that come of it, and `candidate` chooses among sizes.

pub mod boundary_nodes;
pub mod candidate;
pub mod coarse_mesh;
pub mod delaunay;
pub mod point_placement;
pub mod spatial_grid;
pub mod tuning;
