//! Form error: departures of a part from its design along the normal, pixel by pixel.

use super::OUTLIER;
use crate::geom::{DVec2, DVec3};
use crate::mirror::Mirror;
use crate::optics::{Camera, ThinnedFrame};
use crate::parallel;
use serde::Serialize;
use std::ops::Range;

/// Departures from the design along its normal, one a sensor pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct FormMap {
    /// Columns and rows.
    pub pixels: [u32; 2],
    /// Departures, mm, row by row from the upper left: positive towards the camera, no number where
    /// there is no mirror or no mesh.
    pub mm: Vec<f64>,
}

/// Statistics of the departures: peak to valley, RMS and extremes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FormStatistics {
    /// Highest less lowest.
    pub pv: f64,
    /// Root of the mean square: over equal areas of the picture.
    pub rms: f64,
    /// The lowest place; negative where material is missing.
    pub lowest: f64,
    /// The highest place.
    pub highest: f64,
}

/// Form error of a part, um, with and without outliers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct FormError {
    /// Over all pixels.
    #[serde(flatten)]
    pub all: FormStatistics,
    /// Over what is within 4.685 standard deviations, estimated by the median.
    pub without_outliers: FormStatistics,
    /// Share of the pixels that are not.
    pub outliers: f64,
    /// Pixels that show a place of the mesh on the mirror.
    pub pixels: usize,
}

/// Map of the form error of which rows after rows of the frame are added.
#[derive(Debug)]
pub struct FormMapBuilder<'a> {
    mirror: &'a Mirror,
    camera: &'a Camera,
    thinned: ThinnedFrame,
    map: FormMap,
}

impl<'a> FormMapBuilder<'a> {
    /// A map of the pixels of `camera`, without a row.
    #[must_use]
    pub fn new(mirror: &'a Mirror, camera: &'a Camera) -> Self {
        let thinned = ThinnedFrame::new(camera.pixels);
        let map = FormMap { pixels: thinned.pixels(), mm: Vec::new() };
        Self { mirror, camera, thinned, map }
    }

    /// Adds the rows of a mesh that the ray of each pixel meets `at` some place or none.
    pub fn add(&mut self, rows: Range<usize>, at: impl Fn([usize; 2]) -> Option<DVec3> + Sync) {
        let Self { mirror, camera, thinned, .. } = *self;
        let outline = mirror.full_outline();
        let columns: Vec<usize> = thinned.columns().collect();
        let rows: Vec<usize> = thinned.rows(rows).collect();
        let mut mm = vec![f64::NAN; columns.len() * rows.len()];
        parallel::map_chunks_mut(&mut mm, columns.len().max(1), |k, line| {
            let row = rows[k];
            let place = |x: &usize| {
                let q = camera.image_point(*x as f64 + 0.5, row as f64 + 0.5);
                mirror
                    .intersect_camera_ray(&camera.chart, camera.picture.chart_point(q))
                    .filter(|q| outline.aims(*q))
            };
            let places = columns.iter().map(place).enumerate();
            let (known, places): (Vec<usize>, Vec<DVec2>) =
                places.filter_map(|(column, q)| Some((column, q?))).unzip();
            for ((column, q), point) in
                known.into_iter().zip(&places).zip(mirror.eval_many(&places))
            {
                if let Some(at) = at([columns[column], row]) {
                    let normal = mirror.normal(*q, &point).normalize();
                    line[column] = normal.dot(at - mirror.position(*q, &point));
                }
            }
        });
        self.map.mm.extend(mm);
    }

    /// The map of all rows.
    #[must_use]
    pub fn finish(self) -> FormMap {
        self.map
    }
}

impl FormMap {
    /// Its figures; none without a single pixel.
    #[must_use]
    pub fn error(&self) -> Option<FormError> {
        let um: Vec<f64> = self.mm.iter().filter(|mm| !mm.is_nan()).map(|mm| 1e3 * mm).collect();
        let all = spread(&um)?;
        let mut distances: Vec<f64> = um.iter().map(|um| um.abs()).collect();
        let median = *distances.select_nth_unstable_by(um.len() / 2, f64::total_cmp).1;
        let reach = OUTLIER * 1.4826 * median;
        let inner: Vec<f64> = um.iter().copied().filter(|um| um.abs() <= reach).collect();
        Some(FormError {
            all,
            without_outliers: spread(&inner)?,
            outliers: (um.len() - inner.len()) as f64 / um.len() as f64,
            pixels: um.len(),
        })
    }
}

fn spread(values: &[f64]) -> Option<FormStatistics> {
    let first = *values.first()?;
    let ends = |(lo, hi): (f64, f64), x: &f64| (lo.min(*x), hi.max(*x));
    let (lo, hi) = values.iter().fold((first, first), ends);
    let rms = (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt();
    Some(FormStatistics { pv: hi - lo, rms, lowest: lo, highest: hi })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_a_sine_and_outliers_are_told_apart() {
        // Whole periods of 0.4 um amplitude, one pixel in a hundred 50 um off, and some unknown.
        let n = 40_000;
        let at = |k: usize| match k {
            _ if k % 100 == 7 => -0.05,
            _ if k % 100 == 8 => f64::NAN,
            _ => 4e-4 * crate::num::sin(0.1 * k as f64),
        };
        let map = FormMap { pixels: [200, 200], mm: (0..n).map(at).collect() };
        let error = map.error().unwrap();
        assert_eq!(error.pixels, 39_600);
        assert!((error.outliers - 400.0 / 39_600.0).abs() < 1e-12);
        let FormStatistics { pv, rms, .. } = error.without_outliers;
        assert!((pv - 0.8).abs() < 1e-3 && (rms - 0.4 / f64::sqrt(2.0)).abs() < 1e-3, "{pv} {rms}");
        assert!((error.all.lowest + 50.0).abs() < 1e-9 && (error.all.highest - 0.4).abs() < 1e-3);
        assert!((error.all.pv - 50.4).abs() < 1e-3);
        let square = (2500.0 * 400.0 + 0.08 * 39_200.0) / 39_600.0;
        assert!((error.all.rms - f64::sqrt(square)).abs() < 1e-3);
        assert_eq!(FormMap { pixels: [1, 1], mm: vec![f64::NAN] }.error(), None);
    }
}
