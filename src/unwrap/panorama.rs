//! What a panorama shows: which direction each of its pixels looks in.

use super::{DirectionPicture, ImagingSystem, UnwrapError, checked_size};
use crate::geom::DVec2;
use crate::num::{atan, atan2, cos, degrees, sin, wrap_turn};
use crate::optics::{Projection, StripLaw};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Where a cylindrical or mercator panorama of a mirror of another law ends, degrees from the
/// horizon: these laws reach the pole at infinity.
pub const STEEPEST_DEG: f64 = 75.0;

/// A picture with azimuth across and elevation, by a law, up it; pixels are square at the horizon.
#[derive(Debug, Clone, PartialEq)]
pub struct Panorama {
    /// How rows map to elevation.
    pub law: StripLaw,
    /// Azimuth at the left edge, radians.
    pub left: f64,
    /// The law's coordinate at the upper edge.
    pub top: f64,
    /// Radians of azimuth to a pixel.
    pub per_px: f64,
    /// Pixels across and down.
    pub size: [usize; 2],
}

/// Field of view of a mirror and the photo's resolution in it.
struct PanoramaExtent {
    law: StripLaw,
    left: f64,
    span: f64,
    /// Least and largest coordinate of the law.
    z: [f64; 2],
    /// Pixels of the photo across the span.
    width: f64,
}

impl Panorama {
    /// Everything that the mirror is meant to show on the sensor, at the scale of a photo of
    /// `photo` pixels (a round mirror's at its outer rim) or `width` pixels wide, by `law` or the
    /// profile's own (equirectangular for round mirrors).
    ///
    /// # Errors
    /// [`UnwrapError`].
    pub fn new(
        optics: &ImagingSystem,
        photo: [usize; 2],
        law: Option<StripLaw>,
        width: Option<usize>,
    ) -> Result<Self, UnwrapError> {
        let [across, _] = optics.scale(photo)?;
        let range = range(optics, law, across / optics.camera.pixel_mm)?;
        let width = width.map_or(range.width, |width| width as f64);
        let columns = width.round();
        let per_px = range.span / columns;
        let [low, high] = range.z;
        // Never beyond the range, which may end at the pole; a rounding error is no missing row.
        let rows = ((high - low) / per_px + 1e-3).floor();
        let size = checked_size([columns, rows])?;
        let top = 0.5 * (low + high + rows * per_px);
        Ok(Self { law: range.law, left: range.left, top, per_px, size })
    }

    /// Azimuth at the left and at the right edge, degrees.
    #[must_use]
    pub fn azimuth_deg(&self) -> [f64; 2] {
        [0.0, self.size[0] as f64].map(|x| degrees(self.left + x * self.per_px))
    }

    /// Elevation at the lower and at the upper edge, degrees.
    #[must_use]
    pub fn elevation_deg(&self) -> [f64; 2] {
        [self.size[1] as f64, 0.0].map(|y| elevation_deg(&self.law, self.top - y * self.per_px))
    }
}

impl DirectionPicture for Panorama {
    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn sigma(&self, x: f64, y: f64) -> [f64; 2] {
        let azimuth = self.left + x * self.per_px;
        let shrink = self.law.stereographic_radius(self.top - y * self.per_px);
        [shrink * sin(azimuth), shrink * cos(azimuth)]
    }
}

fn elevation_deg(law: &StripLaw, z: f64) -> f64 {
    90.0 - 2.0 * degrees(atan(law.stereographic_radius(z)))
}

/// The azimuths and elevations that a view or a map shows within the frame.
fn view_extent(optics: &ImagingSystem, px_per_mm: f64) -> PanoramaExtent {
    /// Places along each side of the picture that are looked at.
    const SIDE: usize = 64;
    let camera = optics.camera;
    let frame = 0.5 * camera.pixel_mm * DVec2::from(camera.pixels.map(f64::from));
    let panel = optics.mirror.outline.bounds();
    let (lo, hi) = (panel.min.max(-frame), panel.max.min(frame));
    let view = &optics.view.projection;
    let [x, y] = view.direction_of([0.0; 2]);
    let centre = atan2(x, y);
    let (mut azimuth, mut elevation) = ([0.0f64; 2], [FRAC_PI_2, -FRAC_PI_2]);
    for k in 0..=SIDE * SIDE + 2 * SIDE {
        let share = DVec2::new((k % (SIDE + 1)) as f64, (k / (SIDE + 1)) as f64) / SIDE as f64;
        let [x, y] = view.direction_of((lo + share * (hi - lo)).to_array());
        let turned = wrap_turn(atan2(x, y) - centre);
        azimuth = [azimuth[0].min(turned), azimuth[1].max(turned)];
        let above = FRAC_PI_2 - 2.0 * atan((x * x + y * y).sqrt());
        elevation = [elevation[0].min(above), elevation[1].max(above)];
    }
    let zenith = DVec2::from_array(view.image_of([0.0; 2], DVec2::ZERO));
    if zenith.cmpge(lo).all() && zenith.cmple(hi).all() {
        (azimuth, elevation[1]) = ([-PI, PI], FRAC_PI_2);
    }
    let span = azimuth[1] - azimuth[0];
    PanoramaExtent {
        law: StripLaw::Equirectangular,
        left: centre + azimuth[0],
        span,
        z: elevation,
        width: span / view.radians_per_mm() * px_per_mm,
    }
}

fn range(
    optics: &ImagingSystem,
    law: Option<StripLaw>,
    px_per_mm: f64,
) -> Result<PanoramaExtent, UnwrapError> {
    let camera = optics.camera;
    let own = match &optics.view.projection {
        Projection::Strip(strip) => {
            let panel = optics.mirror.outline.bounds();
            // What lies above or below the frame is on no photo.
            let edge = 0.5 * camera.pixel_mm * f64::from(camera.pixels[1]);
            let rows = [panel.min.y.max(-edge), panel.max.y.min(edge)];
            let panels = if optics.mirror.folded { 2.0 } else { 1.0 };
            let across = panels * panel.size().x;
            PanoramaExtent {
                law: strip.law.clone(),
                left: strip.azimuth + panel.min.x / strip.scale_mm,
                span: across / strip.scale_mm,
                z: rows.map(|y| strip.z + y / strip.scale_mm),
                width: across * px_per_mm,
            }
        }
        Projection::Radial { law, radius: [inner, outer] } => {
            // A law may have no value on the axis itself.
            let psi = [*outer, inner.max(1e-9 * outer)].map(|r| law.polar(r));
            PanoramaExtent {
                law: StripLaw::Equirectangular,
                left: -PI,
                span: TAU,
                z: psi.map(|psi| FRAC_PI_2 - psi),
                width: TAU * outer * px_per_mm,
            }
        }
        Projection::Panels(_) => return Err(UnwrapError::Panels),
        Projection::Framed(_) => view_extent(optics, px_per_mm),
    };
    let Some(law) = law.filter(|law| *law != own.law) else { return Ok(own) };
    let elevation_deg = own.z.map(|z| elevation_deg(&own.law, z));
    let most = if law.pole_coordinate().is_some() { 90.0 } else { STEEPEST_DEG };
    let kept = elevation_deg.map(|e| e.clamp(-most, most));
    if !(kept[0] < kept[1]) {
        return Err(UnwrapError::Steep { elevation_deg });
    }
    let z = kept.map(|e| law.image_of_degrees(e));
    Ok(PanoramaExtent { law, z, ..own })
}
