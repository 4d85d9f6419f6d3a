//! All modules as they are, for the tests, benches, fuzz targets and the program of this package alone:
//! nothing here is promised to stay.

pub mod align {
    pub use crate::align::*;
}
pub mod bench {
    pub use crate::bench::*;
}
pub mod brep {
    pub use crate::brep::*;
}
#[cfg(feature = "cli")]
pub mod cli {
    pub use crate::cli::*;
}
pub mod design {
    pub use crate::design::*;
}
pub mod drawing {
    pub use crate::drawing::*;
}
pub mod export {
    pub use crate::export::*;
}
pub mod forming {
    pub use crate::forming::*;
}
pub mod geom {
    pub use crate::geom::*;
}
pub mod inspection {
    pub use crate::inspection::*;
}
pub mod machining {
    pub use crate::machining::*;
}
pub mod mesh {
    pub use crate::mesh::*;
}
pub mod milling {
    pub use crate::milling::*;
}
pub mod mirror {
    pub use crate::mirror::*;
}
pub mod num {
    pub use crate::num::*;
}
pub mod optics {
    pub use crate::optics::*;
}
pub mod pencil {
    pub use crate::pencil::*;
}
pub mod pipeline {
    pub use crate::pipeline::*;
}
pub mod profile {
    pub use crate::profile::*;
}
pub mod program {
    pub use crate::program::*;
}
pub mod raster {
    pub use crate::raster::*;
}
pub mod render {
    pub use crate::render::*;
}
pub mod report {
    pub use crate::report::*;
}
pub mod results {
    pub use crate::results::*;
}
pub mod sheet {
    pub use crate::sheet::*;
}
pub mod solid {
    pub use crate::solid::*;
}
pub mod sweep {
    pub use crate::sweep::*;
}
pub mod tolerance {
    pub use crate::tolerance::*;
}
pub mod trace {
    pub use crate::trace::*;
}
pub mod turning {
    pub use crate::turning::*;
}
pub mod lookup {
    pub use crate::lookup::*;
}
pub mod unwrap {
    pub use crate::unwrap::*;
}
pub mod publish {
    pub use crate::publish::*;
}
pub mod tolerance_terms {
    pub use crate::tolerance_terms::*;
}
pub mod video {
    pub use crate::video::*;
}
