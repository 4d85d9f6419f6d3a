//! Panels cropped from the photo and laid side by side: unwrapping without resampling.

use super::{ImagingSystem, Panorama, UnwrapError};
use crate::geom::{DVec2, Outline};
use crate::optics::Projection;
use crate::raster::Raster;
use std::ops::Range;

/// Columns and rows of a photo that show one panel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PanelCrop {
    /// Columns.
    pub columns: Range<usize>,
    /// Rows.
    pub rows: Range<usize>,
}

impl PanelCrop {
    /// These pixels of `photo`.
    pub(super) fn crop(&self, photo: &Raster) -> Raster {
        photo.crop(self.columns.clone(), self.rows.clone())
    }
}

/// The whole pixels nearest to each panel, the designed one's first.
///
/// # Errors
/// [`UnwrapError`]: a round mirror has no straight panels.
pub(super) fn panel_crops(
    optics: &ImagingSystem,
    photo: [usize; 2],
) -> Result<Vec<PanelCrop>, UnwrapError> {
    let scale = optics.scale(photo)?;
    let mirror = optics.mirror;
    let Outline::Rect(panel) = mirror.outline else { return Err(UnwrapError::NotStrip) };
    let corner = |q: DVec2| {
        let at = mirror.position(q, &mirror.surface.at(q));
        let pixel = optics.pixel(optics.camera.image_at(at));
        [pixel[0] * scale[0], pixel[1] * scale[1]]
    };
    let ([left, lower], [right, upper]) = (corner(panel.min), corner(panel.max));
    let (columns, rows) = (whole(left, right, photo[0]), whole(upper, lower, photo[1]));
    if columns.is_empty() || rows.is_empty() {
        return Err(UnwrapError::Nothing);
    }
    let reflected = photo[1] - rows.end..photo[1] - rows.start;
    let mut pieces = vec![PanelCrop { columns: columns.clone(), rows }];
    if mirror.folded {
        pieces.push(PanelCrop { columns, rows: reflected });
    }
    Ok(pieces)
}

/// The crops of `photo` that show the panels, side by side in the order of azimuth, and what they
/// are meant to show. The reflected panel's is turned by half a turn: it sees the world reflected in the
/// ridge, azimuth 180 - a in the place of a, which read backwards goes on where the designed panel
/// ends.
///
/// # Errors
/// [`UnwrapError`]: a round mirror has no straight panels.
pub fn crop_panels(
    optics: &ImagingSystem,
    photo: &Raster,
) -> Result<(Raster, Panorama), UnwrapError> {
    let size = [photo.width, photo.height];
    let scale = optics.scale(size)?;
    let pieces = panel_crops(optics, size)?;
    let Projection::Strip(strip) = &optics.view.projection else {
        return Err(UnwrapError::NotStrip);
    };
    let PanelCrop { columns, rows } = &pieces[0];
    let per_mm = scale.map(|scale| scale / optics.camera.pixel_mm);
    let unit = strip.scale_mm * per_mm[0];
    let shows = Panorama {
        law: strip.law.clone(),
        left: strip.azimuth + (columns.start as f64 - 0.5 * size[0] as f64) / unit,
        top: strip.z + (0.5 * size[1] as f64 - rows.start as f64) / (strip.scale_mm * per_mm[1]),
        per_px: 1.0 / unit,
        size: [columns.len(), rows.len()],
    };
    let piece = pieces[0].crop(photo);
    let Some(reflected) = pieces.get(1) else { return Ok((piece, shows)) };
    let mut other = reflected.crop(photo);
    other.rgb.reverse();
    let lines = piece.rgb.chunks(piece.width).zip(other.rgb.chunks(piece.width));
    let rgb = lines.flat_map(|(a, b)| [a, b]).flatten().copied().collect();
    let width = 2 * piece.width;
    let shows = Panorama { size: [width, piece.height], ..shows };
    Ok((Raster { width, height: piece.height, rgb }, shows))
}

/// The whole pixels nearest to a range, of `count`.
fn whole(from: f64, to: f64, count: usize) -> Range<usize> {
    let [from, to] = [from, to].map(|edge| edge.round().clamp(0.0, count as f64) as usize);
    from..to
}
