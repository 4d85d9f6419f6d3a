//! One ray per pixel: its end, its reflected direction, and how far that is from the expected one.

use super::camera_trace::CameraTrace;
use super::digest::Digest;
use super::pixel_trace::{PixelTrace, RayErrors};
use super::ray_end::{Outcome, RayEnd};
use super::scene::Scene;
use super::trace_counts::TraceCounts;
use super::traced_part::TracedPart;
use super::tracer::Tracer;
use crate::geom::{DVec2, DVec3, Ray, angle};
use crate::num::stats::Summary;
use crate::optics::{ImagingTask, reflect};
use std::borrow::Cow;
use std::ops::Range;

/// Expected reflection of one camera ray: an entry of the table that the witness is handed.
#[derive(Debug, Clone, Copy)]
pub struct ExpectedRay {
    /// Whether the designed mirror is under the ray.
    pub aimed: bool,
    /// Unit direction that the projection wants it to see.
    pub direction: DVec3,
    /// Image point, mm, where the content belongs that the smooth, designed mirror shows.
    pub designed: DVec2,
}

/// Traces of pixels of a camera, row by row: of the frame, or of some of its rows.
#[derive(Debug, Clone)]
pub struct TraceResult {
    /// One entry a pixel.
    pub pixels: Vec<PixelTrace>,
}

impl TraceResult {
    /// Traces all rays of `trace` and compares them with `table`, which gives the expected rays of a
    /// row from the chart coordinates of its rays; with the counts of how they were traced. `task` carries errors back to the image (without
    /// it there are outcomes only); `normals` are the file's own at each facet's corners.
    pub fn new(
        trace: &CameraTrace,
        normals: Option<&[[DVec3; 3]]>,
        task: Option<&ImagingTask>,
        table: impl Fn(u32, &[DVec2]) -> Vec<ExpectedRay> + Sync,
    ) -> (Self, TraceCounts) {
        let comparison = Comparison::new(trace, normals, task);
        let mut pixels = Vec::new();
        let rows = 0..trace.pixels()[1] as usize;
        let tracer = trace.tracer(rows.clone());
        let table = ExpectedRows { table: &table, known: None };
        let (counts, _) = comparison.trace((trace, &tracer), rows, &table, &mut pixels);
        (Self { pixels }, counts)
    }

    /// The rays aimed at the mirror.
    pub fn aimed(&self) -> impl Iterator<Item = &PixelTrace> {
        self.pixels.iter().filter(|pixel| pixel.aimed)
    }

    /// Number of aimed rays with an outcome that `pick` accepts.
    #[must_use]
    pub fn count(&self, pick: impl Fn(Outcome) -> bool) -> usize {
        self.aimed().filter(|pixel| pick(pixel.outcome)).count()
    }

    /// Errors of the aimed rays that hit.
    pub fn errors(&self, error: impl Fn(&PixelTrace) -> Option<f64>) -> impl Iterator<Item = f64> {
        let hits = self.aimed().filter(|pixel| pixel.outcome == Outcome::Hit);
        hits.filter_map(error)
    }

    /// Summary of an error over the aimed rays that hit; `None` when none did.
    #[must_use]
    pub fn summary(&self, error: impl Fn(&PixelTrace) -> Option<f64>) -> Option<Summary> {
        Summary::of(self.errors(error).collect())
    }
}

/// Traces of the rows of a strip of the frame.
#[derive(Debug, Clone)]
pub struct TraceStrip {
    /// Columns and rows of the frame.
    pub frame: [usize; 2],
    /// The rows.
    pub rows: Range<usize>,
    /// One entry a pixel of them.
    pub traced: TraceResult,
    /// Numbers and errors of the pixels, piece after piece.
    pub(super) digests: Vec<Digest>,
    /// Which pixels of the rows above and below are aimed: none beyond the frame.
    aimed_beside: [Vec<bool>; 2],
}

impl TraceStrip {
    /// The strip that is a whole frame of so many columns and rows.
    #[must_use]
    pub fn whole(traced: TraceResult, pixels: [u32; 2]) -> Self {
        let frame = pixels.map(|n| n as usize);
        let digests = vec![Digest::of(&traced.pixels)];
        Self { frame, rows: 0..frame[1], traced, digests, aimed_beside: [vec![], vec![]] }
    }

    /// Traces the frame of `trace` as [`TraceResult::new`] does, strip by strip, with each of which `each` is
    /// called.
    pub fn each(
        trace: &CameraTrace,
        normals: Option<&[[DVec3; 3]]>,
        task: Option<&ImagingTask>,
        table: impl Fn(u32, &[DVec2]) -> Vec<ExpectedRay> + Sync,
        mut each: impl FnMut(&Self),
    ) -> TraceCounts {
        let comparison = Comparison::new(trace, normals, task);
        let frame = trace.pixels().map(|n| n as usize);
        let mut table = ExpectedRows { table: &table, known: None };
        let (mut counts, mut pixels) = (TraceCounts::default(), Vec::new());
        let mut above = Vec::new();
        for rows in trace.strips() {
            let tracer = trace.tracer(rows.clone());
            for rows in trace.slices(rows) {
                let with = (trace, &tracer);
                let (found, digests) = comparison.trace(with, rows.clone(), &table, &mut pixels);
                counts = counts + found;
                let below = (rows.end < frame[1])
                    .then(|| (rows.end, table.row(rows.end, &trace.rays().charted_row(rows.end))));
                let aimed_below = below.iter().flat_map(|(_, row)| row.iter().map(|ray| ray.aimed));
                let aimed_beside = [above, aimed_below.collect()];
                let traced = TraceResult { pixels };
                let strip = Self { frame, rows, traced, digests, aimed_beside };
                each(&strip);
                pixels = strip.traced.pixels;
                above = pixels[pixels.len() - frame[0]..].iter().map(|pixel| pixel.aimed).collect();
                table.known = below.map(|(row, rays)| (row, rays.into_owned()));
            }
        }
        counts
    }

    /// Whether the pixel of a column and a row, of the strip or next to it, is aimed; none beyond the frame
    /// is.
    pub(super) fn is_aimed(&self, column: Option<usize>, row: Option<usize>) -> bool {
        let (Some(column), Some(row)) = (column, row) else { return false };
        let columns = self.frame[0];
        if column >= columns {
            return false;
        }
        if self.rows.contains(&row) {
            return self.traced.pixels[(row - self.rows.start) * columns + column].aimed;
        }
        let beside = &self.aimed_beside[usize::from(row >= self.rows.end)];
        beside.get(column).copied().unwrap_or(false)
    }
}

/// The table of expected rays, row by row, of which one row may be known already.
struct ExpectedRows<'a, T> {
    table: &'a T,
    known: Option<(usize, Vec<ExpectedRay>)>,
}

impl<T: Fn(u32, &[DVec2]) -> Vec<ExpectedRay> + Sync> ExpectedRows<'_, T> {
    /// The expected rays of a row, from the chart coordinates of its camera rays.
    fn row(&self, row: usize, charted: &[DVec2]) -> Cow<'_, [ExpectedRay]> {
        match &self.known {
            Some((known, rays)) if *known == row => rays.into(),
            _ => (self.table)(row as u32, charted).into(),
        }
    }
}

/// Comparison of traced rays with expected ones.
struct Comparison<'a> {
    /// A mesh with normals at the corners of its facets.
    smoothed: Option<(&'a Scene, &'a [[DVec3; 3]])>,
    task: Option<&'a ImagingTask>,
    /// By column, what its image points share.
    turns: Vec<[f64; 2]>,
}

impl<'a> Comparison<'a> {
    fn new<'b: 'a>(
        trace: &CameraTrace<'b>,
        normals: Option<&'a [[DVec3; 3]]>,
        task: Option<&'a ImagingTask>,
    ) -> Self {
        let turn = |task: &ImagingTask| {
            let columns = 0..trace.pixels()[0] as usize;
            columns.map(|column| task.turn(trace.rays().image_point(column, 0).x)).collect()
        };
        let smoothed = match trace.part() {
            TracedPart::Mesh(scene) => normals.map(|normals| (scene, normals)),
            TracedPart::Body(_) => None,
        };
        Self { smoothed, task, turns: task.map_or(Vec::new(), turn) }
    }

    /// Traces the pixels of some rows into `pixels`, whatever is in there.
    fn trace(
        &self,
        (trace, tracer): (&CameraTrace, &Tracer),
        rows: Range<usize>,
        table: &ExpectedRows<impl Fn(u32, &[DVec2]) -> Vec<ExpectedRay> + Sync>,
        pixels: &mut Vec<PixelTrace>,
    ) -> (TraceCounts, Vec<Digest>) {
        let rays = tracer.rays();
        let columns = trace.pixels()[0] as usize;
        pixels.resize(columns * rows.len(), PixelTrace::MISSED);
        let room = |pixels: usize| {
            Digest::with_room_for(pixels, self.task.is_some(), self.smoothed.is_some())
        };
        let band = |first: usize, ends: &[RayEnd], pixels: &mut [PixelTrace]| {
            let rows = pixels.chunks_mut(columns).zip(ends.chunks(columns));
            let mut digest = room(ends.len());
            for (row, (pixels, ends)) in (first..).zip(rows) {
                let expected = table.row(row, &rays.charted_row(row));
                for (column, (pixel, expected)) in pixels.iter_mut().zip(&*expected).enumerate() {
                    let ray = (rays.at(column, row), rays.image_point(column, row));
                    *pixel = self.compare((column, ray), expected, &ends[column]);
                }
                // (While they are near.)
                digest.add(pixels);
            }
            digest
        };
        let (counts, mut digests, occluded) = trace.bands(tracer, rows, pixels, band);
        let size = trace.band_pixels();
        for of_band in occluded.chunk_by(|(a, _), (b, _)| a / size == b / size) {
            for &(pixel, outcome) in of_band {
                let pixel = &mut pixels[pixel];
                *pixel = PixelTrace { outcome, errors: None, smooth: None, ..*pixel };
            }
            let number = of_band[0].0 / size;
            let band = &pixels[number * size..pixels.len().min((number + 1) * size)];
            digests[number] = room(band.len());
            digests[number].add(band);
        }
        (counts, digests)
    }

    /// Trace of the pixel of a column whose ray, with its image point, ended as `end`.
    #[inline(always)]
    fn compare(
        &self,
        (column, (ray, image_point)): (usize, (Ray, DVec2)),
        expected: &ExpectedRay,
        end: &RayEnd,
    ) -> PixelTrace {
        let pixel = PixelTrace {
            outcome: end.outcome,
            aimed: expected.aimed,
            expected: expected.direction,
            direction: end.direction,
            hit_point: end.hit_point(&ray),
            ..PixelTrace::MISSED
        };
        let (Outcome::Hit, true, Some(task)) = (end.outcome, expected.aimed, self.task) else {
            return pixel;
        };
        let errors = |direction: DVec3| {
            let (at, turn) = (pixel.hit_point, self.turns[column]);
            let content = task.image_of_turned(at, direction, image_point, turn);
            RayErrors {
                angle_rad: angle(direction, expected.direction),
                image_mm: (content - image_point).length(),
                facet_mm: task.projection.image_distance(content, expected.designed),
            }
        };
        let smooth = self.smoothed.map(|(scene, normals)| {
            let weights = scene.barycentric(&ray, end.facet);
            let corners = normals[end.facet as usize].iter().zip(weights);
            errors(reflect(ray.direction, corners.map(|(n, w)| *n * w).sum()))
        });
        PixelTrace { errors: Some(errors(end.direction)), smooth, ..pixel }
    }
}
