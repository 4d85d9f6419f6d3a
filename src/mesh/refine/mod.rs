//! The fine mesh: subdivision of a coarse triangulation, proof of its facets, and repair of those that fail.

pub mod independent_sets;
pub mod probe;
pub mod repair;
pub mod repair_progress;
pub mod subdivide;
pub mod triangulation;
pub mod vertex_model;
