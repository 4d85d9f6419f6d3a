//! Look-up tables of a mirror as a camera sees it: from pixels to directions and places of a floor, and back.
//!
//! - A **node** of a [`PixelGrid`] is the middle of a block of pixels; between nodes tables are read by bilinear interpolation.
//! - A **field** is what a table holds at the nodes: two numbers. [`BilinearField`] measures what interpolation is off by, in pixels of the
//!   frame, and leaves cells out where that is more than a quarter: across ridges, and beside what nobody sees.
//! - **Directions** are held as stereographic coordinates, which are smooth where azimuths are not: about the axis.
//! - A [`PlaceMap`] is the way back: for each pixel of a plan of the floor, or of a panorama, the place of the frame that shows it.
//!
//! Rays come from elsewhere: the room knows no mirror.

mod bilinear_field;
mod c_header;
mod camera_info;
mod cell_search;
mod node_table;
mod pixel_grid;
mod place_map;
mod sight;

pub use bilinear_field::{BilinearField, FieldErrors, MOST_OFF_PX};
pub use c_header::{MOST_STEPS, c_header};
pub use camera_info::{CameraInfo, camera_info};
pub use cell_search::CellSearch;
pub use node_table::{NodeSight, NodeTable};
pub use pixel_grid::PixelGrid;
pub use place_map::{MapFrame, PlaceMap, PlaceMapDraft, PlanRows};
pub use sight::{Direction, FloorPlane, Pole};
