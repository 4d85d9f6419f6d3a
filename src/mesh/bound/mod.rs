//! Proven upper bounds of the errors of facets: tables of derivative bounds, the error bounder, branch and bound.

pub mod bound_table;
pub mod branch_and_bound;
pub mod deviation;
pub mod error_bounder;
pub mod mesh_bound;
pub mod region;
pub mod vertex_snapping;
