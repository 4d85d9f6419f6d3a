//! What the limits ask for at every place of a panel: sizing field, frame field of lattice cells, and the lower bounds
//! on the number of triangles.

pub mod field;
pub mod frame_field;
pub mod optimum;
