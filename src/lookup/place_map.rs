//! The way back: the place of a frame that shows each pixel of a plan of the floor or of a panorama.

use super::cell_search::{CellSearch, PlaceOnCell};
use super::{BilinearField, FloorPlane, Pole};
use crate::geom::{DVec2, DVec3, Ray};
use crate::num::{cos, radians, sin};
use crate::raster::npy;

/// Steps that are gone to every place: from a quarter of a pixel to some thousandths, where the picture changes most over a cell.
const LEAST_STEPS: usize = 3;
/// A place is found after a step from one that was off by so little, px: it is off by less by an order at least.
const CONVERGED_PX: f64 = 2e-3;
/// Most that the place before the last step may have been off by, px: more is left beside a ridge, where steps go back and forth.
const LAST_OFF_PX: f64 = 2e-2;

/// A picture that shows the world without the mirror.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MapFrame {
    /// A plan of the floor, X to the right, with the axis in its middle.
    Floor {
        /// The floor.
        plane: FloorPlane,
        /// Millimetres to a pixel.
        mm_per_px: f64,
        /// Which way its rows go.
        rows: PlanRows,
    },
    /// Azimuth across, from -180 degrees on the left, and elevation up, both in equal steps.
    Panorama {
        /// Elevation of the upper edge, degrees.
        top_deg: f64,
        /// Elevation of the lower edge, degrees.
        bottom_deg: f64,
        /// Degrees to a pixel; a whole number of them is a full turn.
        deg_per_px: f64,
    },
}

/// Ways of a plan's rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlanRows {
    /// Y up: a floor as seen from larger Z.
    AgainstY,
    /// Y down: a floor as seen from smaller Z.
    AlongY,
}

impl PlanRows {
    /// Y of a row less that of the row above it, of rows that are `mm_per_px` high, mm.
    #[must_use]
    pub fn step_mm(self, mm_per_px: f64) -> f64 {
        match self {
            Self::AgainstY => -mm_per_px,
            Self::AlongY => mm_per_px,
        }
    }
}

impl MapFrame {
    /// Pixels across and down.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        match *self {
            Self::Floor { plane, mm_per_px, .. } => {
                [2 * (plane.range_mm / mm_per_px).round() as usize; 2]
            }
            Self::Panorama { top_deg, bottom_deg, deg_per_px } => [
                (360.0 / deg_per_px).round() as usize,
                ((top_deg - bottom_deg) / deg_per_px).round() as usize,
            ],
        }
    }

    /// What is at its upper left corner: azimuth and elevation, degrees, or X and Y, mm.
    #[must_use]
    pub fn corner(&self) -> [f64; 2] {
        match *self {
            Self::Floor { mm_per_px, rows, .. } => {
                let [width, height] = self.size().map(|pixels| 0.5 * pixels as f64);
                [-width * mm_per_px, -height * rows.step_mm(mm_per_px)]
            }
            Self::Panorama { top_deg, .. } => [-180.0, top_deg],
        }
    }

    /// What the middle of pixel `k`, row by row, shows: X and Y of a floor within its range, or a direction projected from a pole.
    #[must_use]
    pub fn wanted(&self, k: usize, pole: Pole) -> Option<[f64; 2]> {
        let [width, _] = self.size();
        let [right, down] = [k % width, k / width].map(|index| index as f64 + 0.5);
        let [left, top] = self.corner();
        match *self {
            Self::Floor { plane, mm_per_px, rows } => {
                let at = DVec2::new(left + right * mm_per_px, top + down * rows.step_mm(mm_per_px));
                (at.length() <= plane.range_mm).then(|| at.to_array())
            }
            Self::Panorama { deg_per_px, .. } => {
                let azimuth = radians(left + right * deg_per_px);
                let elevation = radians(top - down * deg_per_px);
                let level = cos(elevation);
                let direction =
                    DVec3::new(level * sin(azimuth), level * cos(azimuth), sin(elevation));
                Some(pole.project(&Ray { origin: DVec3::ZERO, direction }))
            }
        }
    }
}

/// Places of a frame for the pixels of a picture, first by the cells of a field, then nearer.
#[derive(Debug, Clone)]
pub struct PlaceMapDraft {
    /// Pixels of the picture.
    count: usize,
    /// Steps that were gone.
    steps: usize,
    /// Of each pixel that is shown: its number, what it shows, and the place of the frame.
    shown: Vec<(usize, DVec2, PlaceOnCell)>,
}

/// A place of a frame for each pixel of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceMap {
    /// The picture.
    pub frame: MapFrame,
    /// Row by row from the top left: px from the upper left corner of the camera's frame; none where nothing is shown.
    pub places: Vec<Option<[f64; 2]>>,
}

impl PlaceMapDraft {
    /// The first places for `count` pixels, each of which shows what is `wanted` of it, in the values of `field`: linear within each half
    /// of its cells, and on from there for as many cells as `beyond` says.
    #[must_use]
    pub fn new(
        count: usize,
        wanted: impl Fn(usize) -> Option<[f64; 2]>,
        (field, beyond): (&BilinearField, f64),
    ) -> Self {
        let search = CellSearch::new(field, beyond);
        let place = |k: usize| {
            let wanted = DVec2::from_array(wanted(k)?);
            Some((k, wanted, search.find(wanted)?))
        };
        Self { count, steps: 0, shown: (0..count).filter_map(place).collect() }
    }

    /// The places of the frame that are not yet found.
    #[must_use]
    pub fn open(&self) -> Vec<DVec2> {
        self.shown.iter().filter(|shown| self.is_open(shown)).map(|(.., at)| at.place).collect()
    }

    /// All places of the frame, as far as they are known.
    #[must_use]
    pub fn places(&self) -> Vec<DVec2> {
        self.shown.iter().map(|(.., at)| at.place).collect()
    }

    fn is_open(&self, (.., at): &(usize, DVec2, PlaceOnCell)) -> bool {
        self.steps < LEAST_STEPS || !(at.off_px() <= CONVERGED_PX)
    }

    /// One step nearer: `found` is what the open places show, as the field has it. What shows nothing is left out.
    pub fn step(&mut self, found: impl IntoIterator<Item = Option<[f64; 2]>>) {
        let mut found = found.into_iter();
        let mut shown = std::mem::take(&mut self.shown);
        shown.retain_mut(|shown| {
            if !self.is_open(shown) {
                return true;
            }
            let Some(found) = found.next().flatten() else { return false };
            let (_, wanted, at) = shown;
            at.go(*wanted - DVec2::from_array(found));
            true
        });
        self.shown = shown;
        self.steps += 1;
    }

    /// The place of each pixel, px from the upper left corner of the frame; none where nothing is shown, where `is_shown` of
    /// [`PlaceMapDraft::places`] is false, and where steps led to no place.
    #[must_use]
    pub fn finish(self, is_shown: &[bool]) -> Vec<Option<[f64; 2]>> {
        let mut places = vec![None; self.count];
        for (shown, is_shown) in self.shown.iter().zip(is_shown) {
            let (k, _, at) = shown;
            let is_found = *is_shown && at.off_px() <= LAST_OFF_PX;
            places[*k] = is_found.then(|| at.place.to_array());
        }
        places
    }
}

impl PlaceMap {
    /// Share of the picture's pixels that the frame shows.
    #[must_use]
    pub fn seen(&self) -> f64 {
        self.places.iter().flatten().count() as f64 / self.places.len().max(1) as f64
    }

    /// A NumPy array of shape (rows, columns, 2) in single precision for OpenCV's `remap`: the first pixel's middle is (0, 0); -1 where
    /// nothing is shown.
    #[must_use]
    pub fn npy(&self) -> Vec<u8> {
        let [width, height] = self.frame.size();
        let entry = |place: &Option<[f64; 2]>| {
            place.map_or([-1.0; 2], |place| place.map(|x| (x - 0.5) as f32))
        };
        npy(&[height, width, 2], self.places.iter().flat_map(entry))
    }

    /// Two pictures, PGM of 16 bits, for ffmpeg's `remap`: the column and the row of the pixel that is shown; 65535 where nothing is.
    #[must_use]
    pub fn pgm(&self) -> [Vec<u8>; 2] {
        let [width, height] = self.frame.size();
        [0, 1].map(|axis| {
            let mut bytes = format!("P5\n{width} {height}\n65535\n").into_bytes();
            let pixel = |place: &Option<[f64; 2]>| {
                place.map_or(u16::MAX, |place| place[axis].floor().clamp(0.0, 65534.0) as u16)
            };
            bytes.extend(self.places.iter().flat_map(|place| pixel(place).to_be_bytes()));
            bytes
        })
    }
}
