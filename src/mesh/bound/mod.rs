//! Proven upper bounds of the errors of facets.
//!
//! The arrows between the files of this room: `deviation`, `error_bound`, `vertex`, `content_bounds` and `region` stand
//! alone; `flat_facet` rounds the vertices of a facet, `imaging_problem` makes regions, `bound_table` keeps them,
//! `error_bounder` bounds a facet by them, `facet_parts` and `branch_and_bound` divide a facet for closer bounds,
//! `mesh_bound` does so for a whole mesh, and `vertex_snapping` puts vertices where rounding hardly moves them off the
//! mirror.

pub(super) mod bound_table;
pub(super) mod branch_and_bound;
pub(super) mod content_bounds;
pub(super) mod deviation;
pub(super) mod error_bound;
pub(super) mod error_bounder;
pub(super) mod facet_parts;
pub(super) mod flat_facet;
pub(super) mod imaging_problem;
pub(super) mod mesh_bound;
pub(super) mod region;
pub(super) mod tuning;
pub(super) mod vertex;
pub(super) mod vertex_snapping;
