//! Worlds, and pictures of them through any map from pixels to rays.
//!
//! Words: a **world** says what light comes along a ray. A **direction** is a unit vector (X, Y, Z)
//! of the part frame, written as **azimuth** a and **elevation** e by (cos e sin a, cos e cos a, sin e).
//! **Footprint** is the angle, in radians, that one sample of the picture covers. **Linear** colour is
//! light; sRGB is its 8-bit code.

mod angle_tables;
mod camera_view;
mod chess_pieces;
mod chessboard;
mod coarse_mesh;
mod graticule;
mod material;
mod model;
mod panorama;
pub mod picture;
mod pixel_errors;
mod samples;
mod section;
mod setup_diagram;
mod shaded_views;
mod side_view;
mod smooth_sight;
mod solid_of_revolution;
pub mod test_world;
mod text_distance_field;
mod unwanted_views;

pub use crate::raster::EncodingError;
pub(crate) use camera_view::{CameraPicture, CameraView, Distance, ReflectedCentres, TracedMesh};
pub use chessboard::Chessboard;
pub use coarse_mesh::coarse_mesh;
pub use model::{Model, ModelError};
pub use panorama::PanoramaWorld;
pub use picture::{Picture, StripPainter};
pub use pixel_errors::pixel_errors;
#[cfg(feature = "studio")]
pub(crate) use pixel_errors::pixel_errors_of;
pub use samples::{EdgePixels, LineByLine, OneByOne, PictureRay, SampleGrid, SampleSight, Sight};
pub use section::{AxialPlane, PartSection};
pub use setup_diagram::SetupDiagram;
pub(crate) use shaded_views::optical_normal;
pub use shaded_views::{shaded_view, shaded_views};
pub use side_view::{SideView, ViewRay};
pub(crate) use smooth_sight::{SmoothSight, reflected, reflected_on_chart};
pub use test_world::TestWorld;
pub use unwanted_views::{OwnCamera, UnwantedViews};

use crate::geom::Ray;

/// Radiance along every ray: a scene that pictures are made of.
pub trait World: Sync {
    /// Linear red, green and blue of the light that comes against `ray` (part frame, mm; unit
    /// direction) to where it starts, seen by a sample that covers `footprint_rad` radians. Worlds far
    /// away look at the direction alone.
    fn light(&self, ray: &Ray, footprint_rad: f64) -> [f32; 3];
}
