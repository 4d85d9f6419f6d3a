//! Morion designs freeform catadioptric mirrors, meshes them, writes solids that a machine shop
//! can cut, and proves the written file by tracing rays against it.

pub mod cli;
pub mod design;
pub mod export;
pub mod geom;
pub mod mesh;
pub mod mirror;
pub mod num;
pub mod optics;
pub mod pipeline;
pub mod profile;
pub mod render;
pub mod report;
pub mod solid;
pub mod trace;
