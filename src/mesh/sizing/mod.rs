//! Size, shape and direction of facets at every place of a panel, from a local model of mirror and image.
//!
//! `local_model` is the model at one place, `field` the table of such models over the panel, `lattice` the kinds of
//! cells, `frame_field` the graded cells over the panel, and `precision_limit` refuses limits that rounding alone
//! exceeds. `optimum` stands beside these: lower bounds on the number of triangles.

pub(super) mod field;
pub(super) mod frame_field;
pub(super) mod lattice;
pub(super) mod local_model;
pub(super) mod optimum;
pub(super) mod precision_limit;
pub(super) mod tuning;
