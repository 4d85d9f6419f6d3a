//! All rays of a camera at once: the facets they meet are rasterized instead of searched for, and
//! reflected rays that provably leave are not followed.
//!
//! The rasterizer intersects a facet with the rays of the pixel centres near its picture by the same
//! arithmetic, to the last bit, as the general search; so both answer alike.

use super::camera_rays::CameraRays;
use super::face_slopes::FaceSlopes;
use super::ray_end::{Outcome, RayEnd};
use super::scene::LeavingRay;
use super::trace_counts::TraceCounts;
use super::traced_part::TracedPart;
use super::tracer::{Tracer, Undecided, gathered};
use crate::brep::ChartedBody;
use crate::geom::Ray;
use crate::optics::Camera;
use crate::parallel::{self, ScratchPool};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

/// Trace of the rays through all pixel centres of a camera in a scene.
#[derive(Debug, Clone)]
pub struct CameraTrace<'a> {
    part: TracedPart<'a>,
    rays: Arc<CameraRays>,
    /// The curved faces as the camera sees them, if all are before its pinhole; made when they are first needed.
    charted: Arc<OnceLock<Option<ChartedBody<'a>>>>,
    shortcuts: bool,
    /// Slopes of the face; none where they are those of its facets.
    slopes: Option<&'a dyn FaceSlopes>,
    /// Most pixels of a strip, unless two bands have more.
    strip_pixels: usize,
}

impl<'a> CameraTrace<'a> {
    /// Trace of the rays of `camera`, where they are parallel from height `top_mm`, at a part: a [`Scene`] of a mesh, or
    /// a [`BodyScene`].
    ///
    /// [`Scene`]: super::Scene
    /// [`BodyScene`]: super::BodyScene
    #[must_use]
    pub fn new(part: impl Into<TracedPart<'a>>, camera: &Camera, top_mm: f64) -> Self {
        let rays = Arc::new(CameraRays::new(camera, top_mm));
        let part = part.into();
        let charted = Arc::default();
        let strip_pixels = Self::STRIP_PIXELS;
        Self { part, rays, charted, shortcuts: true, slopes: None, strip_pixels }
    }

    /// The same trace of a face with these slopes, if there are any.
    #[must_use]
    pub fn with_slopes(self, slopes: Option<&'a dyn FaceSlopes>) -> Self {
        Self { slopes, ..self }
    }

    /// The same trace without rasterizer and proofs: every ray is searched for and followed. It must
    /// change no answer.
    #[must_use]
    pub fn without_shortcuts(self) -> Self {
        Self { shortcuts: false, ..self }
    }

    /// The same trace in strips of so many pixels, or of two bands if these have more. It changes no answer.
    #[must_use]
    pub fn in_strips_of(self, strip_pixels: usize) -> Self {
        Self { strip_pixels, ..self }
    }

    /// The part that is traced.
    pub(super) fn part(&self) -> TracedPart<'a> {
        self.part
    }

    /// Slopes of the face, if they are not those of its facets.
    pub(super) fn slopes(&self) -> Option<&'a dyn FaceSlopes> {
        self.slopes
    }

    /// Columns and rows.
    #[must_use]
    pub fn pixels(&self) -> [u32; 2] {
        self.rays.camera.pixels
    }

    /// Ray through a pixel's centre.
    #[inline]
    #[must_use]
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        self.rays.at(column as usize, row as usize)
    }

    pub(super) fn rays(&self) -> &CameraRays {
        &self.rays
    }

    /// Ends of all rays, row by row, with the counts of how they were traced.
    #[must_use]
    pub fn run(&self) -> (Vec<RayEnd>, TraceCounts) {
        let [columns, rows] = self.pixels().map(|n| n as usize);
        let mut ends = vec![RayEnd::MISSED; columns * rows];
        let counts = self.run_into(&mut ends);
        (ends, counts)
    }

    /// Ends of all rays into `ends`, row by row: one entry a pixel.
    pub fn run_into(&self, ends: &mut [RayEnd]) -> TraceCounts {
        self.run_rows_into(0..self.pixels()[1] as usize, ends)
    }

    /// Ends of the rays of `rows`, one of [`Self::strips`], with the counts of how they were traced.
    #[must_use]
    pub fn run_rows(&self, rows: Range<usize>) -> (Vec<RayEnd>, TraceCounts) {
        let mut ends = vec![RayEnd::MISSED; self.pixels()[0] as usize * rows.len()];
        let counts = self.run_rows_into(rows, &mut ends);
        (ends, counts)
    }

    fn run_rows_into(&self, rows: Range<usize>, ends: &mut [RayEnd]) -> TraceCounts {
        let first = rows.start;
        let tracer = self.tracer(rows);
        let found = parallel::map_chunks_mut(ends, self.band_pixels(), |number, ends| {
            tracer.trace_band(first + number * self.rays.band_rows(), ends)
        });
        let (counts, undecided) = gathered(found);
        for (pixel, outcome) in self.occluded(first, &undecided) {
            ends[pixel].outcome = outcome;
        }
        counts
    }

    /// The rows of the frame in strips, each of whole bands: all in one where they are few pixels. Memory for
    /// a strip does not grow with the frame.
    #[must_use]
    pub fn strips(&self) -> Vec<Range<usize>> {
        let [columns, rows] = self.pixels().map(|n| n as usize);
        let bands = (self.strip_pixels / self.band_pixels()).max(Self::LEAST_BANDS);
        let whole = columns * rows <= self.strip_pixels;
        let step = if whole { rows } else { bands * self.rays.band_rows() };
        (0..rows).step_by(step.max(1)).map(|first| first..(first + step).min(rows)).collect()
    }

    /// Most pixels of a strip: what is kept of them takes some 70 MB.
    pub const STRIP_PIXELS: usize = 1 << 19;
    /// Bands of a strip at the least: each is a thread's.
    const LEAST_BANDS: usize = 2;

    /// The rows of a strip in slices, each of whole bands, that are traced one after the other: what is kept
    /// of a slice's pixels is memory that is used again.
    pub(super) fn slices(&self, rows: Range<usize>) -> Vec<Range<usize>> {
        let bands = Self::SLICE_PIXELS / self.band_pixels();
        let step = bands.max(Self::BANDS_PER_THREAD * parallel::threads()) * self.rays.band_rows();
        rows.clone().step_by(step).map(|first| first..(first + step).min(rows.end)).collect()
    }

    /// Most pixels of a slice, unless its threads' bands have more: what is kept of them takes 10 MB.
    const SLICE_PIXELS: usize = 1 << 16;
    /// Bands of a slice for each thread, where the strip has so many: enough for threads to finish at about the same time.
    const BANDS_PER_THREAD: usize = 4;

    /// What is needed to trace the rows of a strip.
    pub(super) fn tracer(&self, rows: Range<usize>) -> Tracer<'_> {
        if !self.shortcuts {
            return Tracer::searching(self.part, &self.rays);
        }
        let outside = self.starts_outside();
        let charted = if outside { self.charted() } else { None };
        Tracer::new(self.part, &self.rays, rows, (outside, charted))
    }

    /// The curved faces as the camera sees them.
    fn charted(&self) -> Option<&ChartedBody<'a>> {
        let TracedPart::Body(scene) = self.part else { return None };
        let charted = || {
            let CameraRays { camera, top_mm, .. } = *self.rays;
            let [columns, rows] = camera.pixels.map(|n| n as usize);
            let row = self.rays.charted_row(rows / 2);
            let pixel_mm = (row[columns - 1] - row[0]).length() / columns as f64;
            let pixel_mm = if pixel_mm.is_finite() { pixel_mm } else { 0.0 };
            ChartedBody::new(scene.body(), &camera.chart, top_mm, pixel_mm)
        };
        self.charted.get_or_init(charted).as_ref()
    }

    /// Traces the bands of `rows`, a slice of the strip of `tracer`, side by side; the ends of a band's rays are kept in
    /// `scratch` while it is at work. `each` gets the number of the
    /// first row, the ends of the band's rays, and its share of `out`, which has one entry a pixel; what it
    /// returns is returned in the order of the bands, with the pixels, counted from the slice's first, whose
    /// reflected rays are occluded although their ends said that they were not.
    pub(super) fn bands<T: Send, U: Send>(
        &self,
        (tracer, scratch): (&Tracer, &ScratchPool<Vec<RayEnd>>),
        rows: Range<usize>,
        out: &mut [T],
        each: impl Fn(usize, &[RayEnd], &mut [T]) -> U + Sync,
    ) -> (TraceCounts, Vec<U>, Vec<(usize, Outcome)>) {
        let first_row = rows.start;
        let band = |number: usize, out: &mut [T], ends: &mut Vec<RayEnd>| {
            ends.resize(out.len(), RayEnd::MISSED);
            let first = first_row + number * self.rays.band_rows();
            let found = tracer.trace_band(first, ends);
            (found, each(first, ends, out))
        };
        let made = parallel::map_chunks_mut(out, self.band_pixels(), |number, out| {
            scratch.with(|ends| band(number, out, ends))
        });
        let (found, made): (Vec<_>, Vec<U>) = made.into_iter().unzip();
        let (counts, undecided) = gathered(found);
        (counts, made, self.occluded(first_row, &undecided))
    }

    /// The occluded ones of reflected rays that were neither proven unoccluded nor followed, as the scene has
    /// no grid yet: it is made where there are more than a few, or one is occluded.
    fn occluded(&self, first_row: usize, undecided: &[Undecided]) -> Vec<(usize, Outcome)> {
        /// Rays up to which holding each against the facets is faster than making the grid.
        const FEW: usize = 256;
        if undecided.is_empty() {
            return Vec::new();
        }
        let columns = self.pixels()[0] as usize;
        let ray = |pixel: usize| self.rays.at(pixel % columns, first_row + pixel / columns);
        if undecided.len() <= FEW {
            let leave = |(pixel, end): &Undecided| LeavingRay::new(&ray(*pixel), end);
            let leaving: Vec<LeavingRay> = undecided.iter().map(leave).collect();
            if !self.part.blocks_any(&leaving) {
                return Vec::new();
            }
        }
        self.part.prepare_search();
        let follow = |(pixel, end): &Undecided| (*pixel, self.part.occlusion(&ray(*pixel), end));
        let outcomes = parallel::map_slice(undecided, 64, follow);
        outcomes.into_iter().filter(|(_, outcome)| *outcome != Outcome::Hit).collect()
    }

    /// Pixels of a band of rows.
    pub(super) fn band_pixels(&self) -> usize {
        self.pixels()[0] as usize * self.rays.band_rows()
    }

    /// Whether the camera's rays start outside the part.
    fn starts_outside(&self) -> bool {
        let chart = &self.rays.camera.chart;
        let start = chart.pupil().map_or(self.rays.top_mm, |pupil| pupil.z);
        self.part.bounds().is_some_and(|(_, hi)| start > hi.z)
    }
}
