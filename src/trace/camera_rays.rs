//! The rays through the pixel centres of a camera.

use super::band_depths::band_rows;
use crate::geom::{DVec2, DVec3, Ray};
use crate::optics::{Camera, ChartedFrame};
use crate::parallel;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// Camera ray of a pixel, for which the table of expected rays is asked.
#[derive(Debug, Clone, Copy)]
pub struct PixelRay {
    /// Its chart coordinates, mm.
    pub charted: DVec2,
    /// The ray.
    pub ray: Ray,
}

/// Rays through the pixel centres of a camera, with the centres' image coordinates tabulated.
#[derive(Debug, Clone)]
pub(super) struct CameraRays {
    /// The camera.
    pub camera: Camera,
    /// Z where parallel rays start, mm.
    pub top_mm: f64,
    /// X of the pixel centres by column, and Y by row, image coordinates, mm.
    pub centres: [Vec<f64>; 2],
    /// Where image points are on the reference plane.
    frame: Arc<ChartedFrame>,
    /// The pixels of some rows on the reference plane, where that takes long to find out: behind a lens.
    pub charted: Option<ChartedRows>,
}

/// Chart coordinates of the rays through the pixel centres of some rows.
#[derive(Debug, Clone)]
pub(super) struct ChartedRows {
    /// The first of the rows.
    pub first: usize,
    /// Row by row, mm; not finite where they were not asked for.
    pub points: Vec<DVec2>,
}

impl CameraRays {
    /// Rays of `camera`, where they are parallel from height `top_mm`.
    pub(super) fn new(camera: &Camera, top_mm: f64) -> Self {
        let [columns, rows] = camera.pixels.map(|n| (0..n).map(|k| f64::from(k) + 0.5));
        let centres = [
            columns.map(|x| camera.image_point(x, 0.0).x).collect(),
            rows.map(|y| camera.image_point(0.0, y).y).collect(),
        ];
        let frame = Arc::new(ChartedFrame::new(camera));
        Self { camera: *camera, top_mm, centres, frame, charted: None }
    }

    /// Rays through `side` x `side` samples of each pixel of `camera`, those of a camera with so many times as
    /// many pixels to rounding.
    pub(super) fn through_samples(camera: &Camera, top_mm: f64, side: u32) -> Self {
        let place = |k: u32| f64::from(k / side) + (f64::from(k % side) + 0.5) / f64::from(side);
        let [columns, rows] = camera.pixels.map(|n| (0..n * side).map(place));
        let centres = [
            columns.map(|x| camera.image_point(x, 0.0).x).collect(),
            rows.map(|y| camera.image_point(0.0, y).y).collect(),
        ];
        let frame = Arc::new(ChartedFrame::new(camera));
        let camera = camera.with_pixels(camera.pixels.map(|n| n * side));
        Self { camera, top_mm, centres, frame, charted: None }
    }

    /// The same rays with what helps to make those of `rows`, or of the `wanted` ones of their pixels, again and
    /// again.
    pub(super) fn of_rows(
        self: &Arc<Self>,
        rows: Range<usize>,
        wanted: Option<&[bool]>,
    ) -> Arc<Self> {
        if self.camera.picture.keeps_lines() {
            return Arc::clone(self);
        }
        let (first, columns) = (rows.start, self.camera.pixels[0] as usize);
        let mut points = vec![DVec2::NAN; rows.len() * columns];
        parallel::map_chunks_mut(&mut points, columns, |row, points| {
            for (column, point) in points.iter_mut().enumerate() {
                if wanted.is_none_or(|wanted| wanted[row * columns + column]) {
                    *point = self.charted(column, first + row);
                }
            }
        });
        Arc::new(Self { charted: Some(ChartedRows { first, points }), ..Self::clone(self) })
    }

    /// Rows of a band.
    pub(super) fn band_rows(&self) -> usize {
        band_rows(self.camera.pixels[0] as usize)
    }

    /// Image point of a pixel's centre, mm.
    #[inline]
    pub(super) fn image_point(&self, column: usize, row: usize) -> DVec2 {
        let [xs, ys] = &self.centres;
        DVec2::new(xs[column], ys[row])
    }

    /// Ray through a pixel's centre; of rows that are charted.
    #[inline]
    pub(super) fn at(&self, column: usize, row: usize) -> Ray {
        let q = self.known(row).map_or_else(|| self.charted(column, row), |known| known[column]);
        self.camera.chart.ray(q, self.top_mm)
    }

    /// Chart coordinates of the rays through the pixel centres of a row, mm.
    pub(super) fn charted_row(&self, row: usize) -> Cow<'_, [DVec2]> {
        let columns = 0..self.camera.pixels[0] as usize;
        self.known(row)
            .map_or_else(|| columns.map(|column| self.charted(column, row)).collect(), Into::into)
    }

    /// Rays through the centres of so many neighbours in a row, from the pixel of a column and a row on.
    pub(super) fn of_neighbours(&self, [column, row]: [usize; 2], count: usize) -> Vec<PixelRay> {
        let (chart, columns) = (&self.camera.chart, column..column + count);
        let ray = |charted: DVec2| PixelRay { charted, ray: chart.ray(charted, self.top_mm) };
        match self.known(row) {
            None => columns.map(|column| ray(self.charted(column, row))).collect(),
            Some(known) => known[columns].iter().map(|charted| ray(*charted)).collect(),
        }
    }

    /// The chart coordinates of a row, if they are known.
    #[inline]
    fn known(&self, row: usize) -> Option<&[DVec2]> {
        let columns = self.camera.pixels[0] as usize;
        let ChartedRows { first, points } = self.charted.as_ref()?;
        points.get(row.checked_sub(*first)? * columns..)?.get(..columns)
    }

    /// Chart coordinates of the ray through a pixel's centre, mm.
    #[inline]
    fn charted(&self, column: usize, row: usize) -> DVec2 {
        let image = self.image_point(column, row);
        if self.camera.picture.is_identity() { image } else { self.frame.chart_point(image) }
    }

    /// Point at distance `t` on the ray of a pixel, mm.
    #[inline]
    pub(super) fn point(&self, column: usize, row: usize, t: f64) -> DVec3 {
        // (Nothing is left of the product of vertical rays.)
        if self.camera.chart.is_plan() && self.camera.picture.is_identity() {
            return self.image_point(column, row).extend(self.top_mm - t);
        }
        self.at(column, row).at(t)
    }
}
