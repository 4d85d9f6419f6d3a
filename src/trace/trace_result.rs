//! One ray per pixel: its end, its reflected direction, and how far that is from the expected one.

use super::camera_rays::PixelRay;
use super::camera_trace::CameraTrace;
use super::comparison::Comparison;
use super::expected_ray::ExpectedRay;
use super::pixel_trace::{PixelTrace, RayErrors};
use super::ray_end::Outcome;
use super::trace_counts::TraceCounts;
use crate::geom::DVec3;
use crate::num::stats::Summary;
use crate::optics::ImagingTask;

/// Traces of pixels of a camera, row by row: of the frame, or of some of its rows.
#[derive(Debug, Clone)]
pub struct TraceResult {
    /// One entry a pixel.
    pub pixels: Vec<PixelTrace>,
    /// Errors by the file's interpolated normals: one entry a pixel, or none where the file has no normals.
    pub smooth: Vec<Option<RayErrors>>,
}

impl TraceResult {
    /// Traces all rays of `trace` and compares them with `table`, which gives the expected rays of neighbours in a
    /// row from the column and the row of the first of them and all their camera rays; with the counts of how they
    /// were traced. `task` carries errors back to the image (without it there are outcomes only); `normals` are the
    /// file's own at each facet's corners.
    pub fn new(
        trace: &CameraTrace,
        normals: Option<&[[DVec3; 3]]>,
        task: Option<&ImagingTask>,
        table: impl Fn([u32; 2], &[PixelRay]) -> Vec<ExpectedRay> + Sync,
    ) -> (Self, TraceCounts) {
        let comparison = Comparison::new(trace, normals, (task, 0.0), table);
        let mut pixels = Vec::new();
        let rows = 0..trace.pixels()[1] as usize;
        let tracer = trace.tracer(rows.clone());
        let (counts, digests) = comparison.trace(&tracer, rows, &mut pixels);
        let smooth = digests.into_iter().flat_map(|digest| digest.smooth).collect();
        (Self { pixels, smooth }, counts)
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
