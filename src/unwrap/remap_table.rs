//! The remap table of a panorama, a view or a plan: for each of its pixels the position in the photo; and its use.

use super::panel_crop::{PanelCrop, panel_crops};
use super::row::locate_row;
use super::{DirectionPicture, ImageLocation, ImagingSystem, InverseMap, UnwrapError};
use crate::num::stats::Summary;
use crate::parallel;
use crate::raster::Raster;
use std::ops::Range;

/// Most samples of the photo along each side of a pixel of the picture.
const MOST_SAMPLES: usize = 16;
/// Neighbours further apart, as a share of the photo's width, lie at both ends of a turn.
const JUMP: f32 = 0.05;

/// Positions in a photo of the content of each pixel of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct RemapTable {
    /// Pixels of the picture across and down.
    pub size: [usize; 2],
    /// Pixels of the photo across and down.
    pub photo: [usize; 2],
    /// Row by row from the top left: x to the right from the photo's left edge and y down from its
    /// top edge, pixels; the first pixel's centre is (0.5, 0.5). NaN where nothing is seen.
    pub places: Vec<[f32; 2]>,
    /// Distance on the sensor, in its pixels, between where the mirror shows what belongs to a
    /// pixel and where it was meant to; none when nothing is seen, and of places that are known from elsewhere.
    pub distortion_px: Option<Summary>,
    /// Crops of the photo that are sampled: each panel by itself, lest light of another or from beside the
    /// mirror bleeds in; the designed one first.
    panels: Vec<PanelCrop>,
}

impl RemapTable {
    /// The table of `picture` for photos of `photo` pixels through the designed mirror. Every row is found by itself, so that
    /// its bits do not depend on the number of threads.
    ///
    /// # Errors
    /// [`UnwrapError::Aspect`].
    pub fn new(
        optics: &ImagingSystem,
        picture: &dyn DirectionPicture,
        photo: [usize; 2],
    ) -> Result<Self, UnwrapError> {
        let scale = optics.scale(photo)?;
        let map = InverseMap::new(*optics);
        let size @ [width, height] = picture.size();
        let row = |y: usize| {
            let sigma = |x: usize| picture.sigma(x as f64 + 0.5, y as f64 + 0.5);
            let found = locate_row(&mut map.search(), width, optics.camera.pixel_mm, sigma);
            let place = |found: Option<ImageLocation>| {
                let Some(found) = found else { return ([f32::NAN; 2], None) };
                let pixel = optics.pixel(found.image);
                let off = (found.image - found.intended).length() / optics.camera.pixel_mm;
                ([0, 1].map(|k| (pixel[k] * scale[k]) as f32), Some(off))
            };
            found.into_iter().map(place).collect()
        };
        let rows: Vec<Vec<_>> = parallel::map(height, 1, row);
        let (places, off): (Vec<_>, Vec<_>) = rows.into_iter().flatten().unzip();
        let distortion_px = Summary::of(off.into_iter().flatten().collect());
        let panels = sampled_crops(optics, photo);
        Ok(Self { size, photo, places, distortion_px, panels })
    }

    /// The table of `places` of the sensor, row by row from the top left of a picture of `size` pixels, for photos of `photo` pixels: each
    /// in px from the sensor's upper left corner, none where nothing is seen.
    ///
    /// # Errors
    /// [`UnwrapError::Aspect`].
    pub fn of_places(
        optics: &ImagingSystem,
        (size, places): ([usize; 2], &[Option<[f64; 2]>]),
        photo: [usize; 2],
    ) -> Result<Self, UnwrapError> {
        let scale = optics.scale(photo)?;
        let place = |place: &Option<[f64; 2]>| {
            place.map_or([f32::NAN; 2], |at| [0, 1].map(|k| (at[k] * scale[k]) as f32))
        };
        let places = places.iter().map(place).collect();
        Ok(Self { size, photo, places, distortion_px: None, panels: sampled_crops(optics, photo) })
    }

    /// Share of the picture's pixels that the photo shows.
    #[must_use]
    pub fn seen(&self) -> f64 {
        let seen = self.places.iter().filter(|place| !place[0].is_nan()).count();
        seen as f64 / self.places.len() as f64
    }

    /// The picture of `photo`, black where nothing is seen. Where it has fewer pixels than the
    /// photo, each is the mean of several places.
    ///
    /// # Panics
    /// When the photo has another size than the map is for.
    #[must_use]
    pub fn paint(&self, photo: &Raster) -> Raster {
        assert_eq!([photo.width, photo.height], self.photo, "the size that the map is for");
        let panels: Vec<Raster> = self.panels.iter().map(|panel| panel.crop(photo)).collect();
        let light = |[x, y]: [f32; 2], panel: usize| {
            let PanelCrop { columns, rows } = &self.panels[panel];
            let (x, y) = (f64::from(x) - columns.start as f64, f64::from(y) - rows.start as f64);
            panels[panel].sample(x, y, false)
        };
        let [width, height] = self.size;
        let pixel = |k: usize| {
            let place = self.places[k];
            if place[0].is_nan() {
                return [0.0; 3];
            }
            let panel = self.panel(place);
            let [right, down] = [self.step(k, 1, width), self.step(k, width, height)];
            let longest = right.into_iter().chain(down).fold(0.0, |a: f32, b| a.max(b.abs()));
            let count = ((longest + 0.5) as usize).clamp(1, MOST_SAMPLES);
            let share = |i: usize| (i as f32 + 0.5) / count as f32 - 0.5;
            let mut sum = [0.0; 3];
            for i in 0..count * count {
                let (a, b) = (share(i % count), share(i / count));
                let at = [0, 1].map(|k| place[k] + a * right[k] + b * down[k]);
                let light = light(at, panel);
                sum = std::array::from_fn(|c| sum[c] + light[c]);
            }
            sum.map(|sum| sum / (count * count) as f32)
        };
        let rgb = parallel::map(width * height, 1, pixel);
        Raster { width, height, rgb }
    }

    /// Number of panels that are sampled each by itself.
    pub(super) fn panels(&self) -> usize {
        self.panels.len()
    }

    /// Columns and rows of the photo that show a panel.
    pub(super) fn panel_pixels(&self, panel: usize) -> [Range<usize>; 2] {
        let PanelCrop { columns, rows } = &self.panels[panel];
        [columns.clone(), rows.clone()]
    }

    /// Whether two positions that belong next to each other in the picture are so in the photo.
    pub(super) fn are_neighbours(&self, a: [f32; 2], b: [f32; 2]) -> bool {
        let near = (0..2).all(|k| (a[k] - b[k]).abs() <= JUMP * self.photo[0] as f32);
        near && self.panel(a) == self.panel(b)
    }

    /// Number of the panel that shows a position.
    pub(super) fn panel(&self, place: [f32; 2]) -> usize {
        let rows = &self.panels[0].rows;
        let first_above = rows.start < self.photo[1] - rows.end;
        let above = place[1] < 0.5 * self.photo[1] as f32;
        usize::from(self.panels.len() > 1 && above != first_above)
    }

    /// How far the photo's place moves from pixel `k` to the next one, `stride` further among `count`
    /// of a line; nothing where that is not known.
    fn step(&self, k: usize, stride: usize, count: usize) -> [f32; 2] {
        let index = k / stride % count;
        let (from, to) = match index {
            _ if index + 1 < count => (k, k + stride),
            0 => (k, k),
            _ => (k - stride, k),
        };
        let (from, to) = (self.places[from], self.places[to]);
        let step = [0, 1].map(|c| to[c] - from[c]);
        if self.are_neighbours(from, to) { step } else { [0.0; 2] }
    }
}

/// The crops of a photo that are sampled: the panels, or all where there are none.
fn sampled_crops(optics: &ImagingSystem, photo: [usize; 2]) -> Vec<PanelCrop> {
    // A given mirror's sides may be curved in the picture.
    let straight = optics.mirror.chart == optics.camera.chart;
    let panels = straight.then(|| panel_crops(optics, photo).ok()).flatten();
    panels.unwrap_or_else(|| vec![PanelCrop { columns: 0..photo[0], rows: 0..photo[1] }])
}
