//! What a perspective view shows: the picture of an ideal camera that looks in any direction.

use super::{DirectionPicture, ImagingSystem, UnwrapError, checked_size};
use crate::geom::DVec3;
use crate::num::{cos, radians, sin, tan};
use crate::optics::stereographic;

/// Height over width of a view of which only the width is given.
const SHAPE: f64 = 0.75;

/// Direction and field of a perspective view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewAngles {
    /// Azimuth of its middle, degrees from Y towards X.
    pub azimuth_deg: f64,
    /// Elevation of its middle, degrees towards Z.
    pub elevation_deg: f64,
    /// Angle from its left to its right edge, degrees.
    pub field_deg: f64,
}

/// A picture in perspective, with Z upright in it: straight lines of the world are straight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PerspectiveView {
    /// Unit vectors to the right, downwards, and to its middle.
    axes: [DVec3; 3],
    /// Tangents to a pixel.
    per_px: f64,
    /// Pixels across and down.
    size: [usize; 2],
}

impl PerspectiveView {
    /// The view in `angles`. Without `width` its middle has the scale of a photo of `photo` pixels as the projection has it in the mean;
    /// without `height` it is three quarters as high as wide.
    ///
    /// # Errors
    /// [`UnwrapError`].
    pub fn new(
        optics: &ImagingSystem,
        photo: [usize; 2],
        angles: ViewAngles,
        [width, height]: [Option<usize>; 2],
    ) -> Result<Self, UnwrapError> {
        let [across, _] = optics.scale(photo)?;
        let ViewAngles { azimuth_deg, elevation_deg, field_deg } = angles;
        let half = tan(radians(0.5 * field_deg));
        let own = || {
            let radians_per_px =
                optics.view.projection.radians_per_mm().abs() * optics.camera.pixel_mm / across;
            2.0 * half / radians_per_px
        };
        let columns = width.map_or_else(own, |width| width as f64).round();
        let rows = height.map_or(SHAPE * columns, |height| height as f64).round();
        let size = checked_size([columns, rows])?;
        let [azimuth, elevation] = [azimuth_deg, elevation_deg].map(radians);
        let [(sa, ca), (se, ce)] = [azimuth, elevation].map(|x| (sin(x), cos(x)));
        // (Upwards: how the middle changes with the elevation, which is so at the poles too.)
        let axes = [
            DVec3::new(ca, -sa, 0.0),
            DVec3::new(se * sa, se * ca, -ce),
            DVec3::new(ce * sa, ce * ca, se),
        ];
        Ok(Self { axes, per_px: 2.0 * half / columns, size })
    }

    /// The direction, of any length, of a place in pixels from the upper left corner.
    #[must_use]
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        let [right, down, middle] = self.axes;
        let [x, y] = [(x, self.size[0]), (y, self.size[1])]
            .map(|(at, pixels)| self.per_px * (at - 0.5 * pixels as f64));
        middle + x * right + y * down
    }
}

impl DirectionPicture for PerspectiveView {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn sigma(&self, x: f64, y: f64) -> [f64; 2] {
        stereographic::sigma(self.direction(x, y).to_array())
    }
}
