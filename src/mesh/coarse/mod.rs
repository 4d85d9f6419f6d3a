//! The coarse mesh: boundary nodes, point placement, Delaunay triangulation, and the choice of its size.

pub mod boundary_nodes;
pub mod coarse_mesh;
pub mod delaunay;
pub mod point_placement;
