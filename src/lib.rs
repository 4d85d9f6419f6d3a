//! Morion designs freeform catadioptric mirrors, meshes them, writes solids that a machine shop
//! can cut, and proves the written file by tracing rays against it.

pub mod num;
pub mod render;
