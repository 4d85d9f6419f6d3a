//! Proven upper bounds of the errors of facets.
//!
//! The arrows between the files of this room: `deviation`, `error_bound`, `vertex`, `content_bounds` and `region` stand
//! alone; `flat_facet` rounds the vertices of a facet, `imaging_problem` makes regions, `bound_table` keeps them,
//! `error_bounder` bounds a facet by them, `facet_parts` and `branch_and_bound` divide a facet for closer bounds,
//! `mesh_bound` does so for a whole mesh, and `vertex_snapping` puts vertices where rounding hardly moves them off the
//! mirror.

pub mod bound_table;
pub mod branch_and_bound;
pub mod content_bounds;
pub mod deviation;
pub mod error_bound;
pub mod error_bounder;
pub mod facet_parts;
pub mod flat_facet;
pub mod imaging_problem;
pub mod mesh_bound;
pub mod region;
pub mod tuning;
pub mod vertex;
pub mod vertex_snapping;
