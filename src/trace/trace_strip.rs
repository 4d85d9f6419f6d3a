//! A frame traced strip by strip, so that memory does not grow with it.

use super::camera_rays::PixelRay;
use super::camera_trace::CameraTrace;
use super::comparison::Comparison;
use super::digest::Digest;
use super::expected_ray::ExpectedRay;
use super::pixel_class::PixelClass;
use super::pixel_trace::PixelTrace;
use super::ray_end::Outcome;
use super::trace_counts::TraceCounts;
use crate::geom::DVec3;
use crate::optics::ImagingTask;
use crate::parallel;
use std::ops::Range;

/// Picture that the traced pixels are held against.
#[derive(Debug, Clone, Copy)]
pub struct WantedPicture<'a> {
    /// What it shows.
    pub task: &'a ImagingTask,
    /// Image error up to which a pixel counts as filled, mm.
    pub tolerance_mm: f64,
}

/// Traces of the rows of a strip of the frame.
#[derive(Debug, Clone)]
pub struct TraceStrip {
    /// Columns and rows of the frame.
    pub frame: [usize; 2],
    /// The rows.
    pub rows: Range<usize>,
    /// One entry a pixel of them.
    pub pixels: Vec<PixelTrace>,
    /// Class of each of the pixels; none without a picture.
    pub classes: Vec<PixelClass>,
    /// Numbers and errors of the pixels, piece after piece.
    pub(super) digests: Vec<Digest>,
}

impl TraceStrip {
    /// Traces the frame of `trace` as [`TraceResult::new`] does, strip by strip, with each of which `each` is
    /// called.
    ///
    /// [`TraceResult::new`]: super::TraceResult::new
    pub fn each(
        trace: &CameraTrace,
        normals: Option<&[[DVec3; 3]]>,
        picture: Option<WantedPicture>,
        table: impl Fn([u32; 2], &[PixelRay]) -> Vec<ExpectedRay> + Sync,
        mut each: impl FnMut(&Self),
    ) -> TraceCounts {
        let task = picture.map(|picture| picture.task);
        let tolerance_mm = picture.map_or(0.0, |picture| picture.tolerance_mm);
        let mut comparison = Comparison::new(trace, normals, (task, tolerance_mm), table);
        let frame = trace.pixels().map(|n| n as usize);
        let (mut counts, mut pixels) = (TraceCounts::default(), Vec::new());
        let mut above = Vec::new();
        for rows in trace.strips() {
            let tracer = trace.tracer(rows.clone());
            for rows in trace.slices(rows) {
                let (found, digests) = comparison.trace(&tracer, rows.clone(), &mut pixels);
                counts = counts + found;
                let mut strip = Self { frame, rows, pixels, classes: Vec::new(), digests };
                if let Some(task) = task {
                    let is_last = strip.rows.end == frame[1];
                    let below = if is_last { Vec::new() } else { comparison.aimed(strip.rows.end) };
                    strip.classify([above, below], task.fold.is_some());
                }
                each(&strip);
                pixels = strip.pixels;
                comparison.take_back(strip.digests);
                above = pixels[pixels.len() - frame[0]..].iter().map(|pixel| pixel.aimed).collect();
            }
        }
        counts
    }

    /// The facet or face that shadows the pixel, of each aimed one that is shadowed.
    pub fn shadowing(&self) -> impl Iterator<Item = u32> {
        let is_any = self.digests.iter().any(|digest| digest.counts.shadowed > 0);
        let pixels = if is_any { &self.pixels[..] } else { &[] };
        pixels.iter().filter(|pixel| pixel.aimed).filter_map(|pixel| match pixel.outcome {
            Outcome::Shadowed(facet) => Some(facet),
            _ => None,
        })
    }

    /// Finds the class of each pixel; `aimed_beside` tells which pixels of the rows above and below are aimed, and
    /// none is beyond the frame. `is_folded`: a ridge runs across the middle of the picture.
    pub(super) fn classify(&mut self, aimed_beside: [Vec<bool>; 2], is_folded: bool) {
        let [columns, height] = self.frame;
        let own: Vec<Option<PixelClass>> =
            self.digests.iter().flat_map(|digest| digest.classes.iter().copied()).collect();
        let (rows, pixels) = (&self.rows, &self.pixels);
        let is_aimed = |column: Option<usize>, row: Option<usize>| {
            let (Some(column), Some(row)) = (column.filter(|k| *k < columns), row) else {
                return false;
            };
            if rows.contains(&row) {
                return pixels[(row - rows.start) * columns + column].aimed;
            }
            let beside = &aimed_beside[usize::from(row >= rows.end)];
            beside.get(column).copied().unwrap_or(false)
        };
        let around = |k: usize| [k.checked_sub(1), Some(k), Some(k + 1)];
        let at_rim = |column: usize, row: usize| {
            around(row)
                .iter()
                .any(|&row| around(column).iter().any(|&column| !is_aimed(column, row)))
        };
        let at_ridge = |row: usize| is_folded && (2 * row + 1).abs_diff(height) <= 2;
        let by_neighbours = |k: usize| {
            let (column, row) = (k % columns, rows.start + k / columns);
            match pixels[k].outcome {
                _ if at_rim(column, row) => PixelClass::Rim,
                Outcome::Hit if at_ridge(row) => PixelClass::Ridge,
                Outcome::Hit => PixelClass::Content,
                _ => PixelClass::Missed,
            }
        };
        self.classes =
            parallel::map(own.len(), 1 << 12, |k| own[k].unwrap_or_else(|| by_neighbours(k)));
    }
}
