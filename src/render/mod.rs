//! What the camera sees: a test world at infinity, painted through any map from pixels to directions.
//!
//! Words: a **direction** is a unit vector (X, Y, Z) of the part frame, written as **azimuth** a and
//! **elevation** e by (cos e sin a, cos e cos a, sin e). **Footprint** is the angle, in radians, that
//! one sample of the picture covers. **Linear** colour is light; sRGB is its 8-bit code.

mod angles;
mod graticule;
mod label;
pub mod picture;
pub mod world;

pub use crate::raster::EncodingError;
pub use picture::{Canvas, Picture, Seen};
pub use world::TestWorld;
