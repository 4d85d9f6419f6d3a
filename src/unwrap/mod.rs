//! Photos through a mirror -> panoramas, perspective views and plans: by plain cuts, or with everything fetched from where the mirror
//! shows it. A [`RemapTable`] says where that is: of directions in the designed mirror by an [`InverseMap`], or by places that are known
//! from elsewhere; a [`FrameTable`] is the same for the frames of a video.
//!
//! Shadows are not looked for: where one panel of a valley hides the other, the photo shows its panel.

mod cubic_kernel;
mod frame_table;
mod inverse_map;
mod map_files;
mod panel_crop;
mod panorama;
mod perspective_view;
mod plane_table;
mod remap_table;
mod row;

pub use frame_table::FrameTable;
pub use inverse_map::{ImageLocation, InverseMap, InverseSearch};
pub use map_files::MapEncodingError;
pub use panel_crop::crop_panels;
pub use panorama::{Panorama, STEEPEST_DEG};
pub use perspective_view::{PerspectiveView, ViewAngles};
pub use remap_table::RemapTable;

use crate::mirror::Mirror;
use crate::optics::{Camera, ImagingTask};
use crate::raster::{MOST_PIXELS, MOST_SIDE};
use thiserror::Error;

/// The catadioptric system that a photo was taken with.
#[derive(Debug, Clone, Copy)]
pub struct ImagingSystem<'a> {
    /// The mirror.
    pub mirror: &'a Mirror,
    /// The camera.
    pub camera: &'a Camera,
    /// What the picture is meant to show.
    pub view: &'a ImagingTask,
}

/// A picture each place of which shows a direction.
pub trait DirectionPicture: Sync {
    /// Pixels across and down.
    fn size(&self) -> [usize; 2];

    /// The direction of a place in pixels from the upper left corner, as a stereographic coordinate.
    fn sigma(&self, x: f64, y: f64) -> [f64; 2];
}

/// Reason why a photo cannot be unwrapped.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnwrapError {
    /// The photo is not a larger or smaller picture of the sensor.
    #[error(
        "the photo has {} x {} pixels, which is not the shape of the sensor's {} x {}; crop it to what \
         the sensor saw, or give the profile the camera's pixels",
        photo[0], photo[1], sensor[0], sensor[1]
    )]
    Aspect {
        /// Pixels of the photo, across and down.
        photo: [usize; 2],
        /// Those of the sensor.
        sensor: [u32; 2],
    },
    /// Round mirrors and views have no panels that are parts of a panorama.
    #[error(
        "only a strip's picture can be cut into a panorama, not a round mirror's or a view; leave --cuts out"
    )]
    NotStrip,
    /// Panels show views of their own.
    #[error(
        "a picture of panels is no panorama: each is a view of its own; cut them out of the photo by their columns \
         and rows"
    )]
    Panels,
    /// No pixel of the photo shows the mirror.
    #[error("the mirror is smaller than a pixel of the photo; take a larger photo")]
    Nothing,
    /// The projection leaves nothing of what the mirror shows.
    #[error(
        "the mirror shows elevations {:.2} to {:.2} degrees, and the panorama would leave off all over \
         {STEEPEST_DEG} degrees from the horizon; choose --projection equirectangular",
        elevation_deg[0], elevation_deg[1]
    )]
    Steep {
        /// Lowest and highest elevation.
        elevation_deg: [f64; 2],
    },
    /// The picture has no pixels, or too many.
    #[error(
        "the picture would have {:.0} x {:.0} pixels; it must have at least one, at most {MOST_SIDE} a \
         side and {MOST_PIXELS} in all: choose another --width or a smaller photo",
        size[0], size[1]
    )]
    Size {
        /// Pixels across and down.
        size: [f64; 2],
    },
}

/// Pixels across and down of a picture that can be made.
///
/// # Errors
/// [`UnwrapError::Size`] for one without pixels, or with too many.
fn checked_size(size: [f64; 2]) -> Result<[usize; 2], UnwrapError> {
    let fits = size.iter().all(|pixels| (1.0..=f64::from(MOST_SIDE)).contains(pixels));
    if !fits || size[0] * size[1] > MOST_PIXELS as f64 {
        return Err(UnwrapError::Size { size });
    }
    Ok(size.map(|pixels| pixels as usize))
}

impl ImagingSystem<'_> {
    /// Pixels of the photo to one of the sensor, across and down.
    ///
    /// # Errors
    /// [`UnwrapError::Aspect`] when the shapes differ by half a pixel of the photo.
    pub fn scale(&self, photo: [usize; 2]) -> Result<[f64; 2], UnwrapError> {
        let sensor = self.camera.pixels;
        let [x, y] = [0, 1].map(|k| photo[k] as f64 / f64::from(sensor[k]));
        let off = |k: usize, scale: f64| (photo[k] as f64 - f64::from(sensor[k]) * scale).abs();
        let similar = off(1, x) <= 0.5 || off(0, y) <= 0.5;
        similar.then_some([x, y]).ok_or(UnwrapError::Aspect { photo, sensor })
    }

    /// Pixels of the sensor, from its upper left corner, of a point (mm) of the image.
    fn pixel(&self, q: crate::geom::DVec2) -> [f64; 2] {
        let [width, height] = self.camera.pixels.map(f64::from);
        let q = q / self.camera.pixel_mm;
        [0.5 * width + q.x, 0.5 * height - q.y]
    }
}
