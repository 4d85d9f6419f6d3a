//! One ray per pixel: its end, its reflected direction, and how far that is from the expected one.

use super::camera_trace::{CameraTrace, TraceCounts};
use super::ray_end::{Outcome, RayEnd};
use super::scene::Scene;
use crate::geom::{DVec2, DVec3, Ray, angle};
use crate::num::stats::Summary;
use crate::optics::{ImagingTask, reflect};

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

/// Errors of one ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayErrors {
    /// Angle between the reflected direction and the expected one, radians.
    pub angle_rad: f64,
    /// Distance in the image between the ray's image point and that where its content belongs, mm.
    pub image_mm: f64,
    /// Distance in the image between the content shown and that of the designed mirror, mm.
    pub facet_mm: f64,
}

/// Trace of the ray of one pixel: outcome, reflected ray and errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelTrace {
    /// Its end.
    pub outcome: Outcome,
    /// Whether the designed mirror is under the ray.
    pub aimed: bool,
    /// Expected unit direction.
    pub expected: DVec3,
    /// Unit direction of the reflected ray; the zero vector for rays that are not reflected.
    pub direction: DVec3,
    /// Point where the ray meets its nearest facet, mm; the zero vector without one.
    pub hit_point: DVec3,
    /// Errors by the facet's own normal, for aimed rays that hit, where a projection is given.
    pub errors: Option<RayErrors>,
    /// Errors by the file's interpolated normals, where it has any.
    pub smooth: Option<RayErrors>,
}

impl PixelTrace {
    const MISSED: Self = Self {
        outcome: Outcome::Missed,
        aimed: false,
        expected: DVec3::ZERO,
        direction: DVec3::ZERO,
        hit_point: DVec3::ZERO,
        errors: None,
        smooth: None,
    };
}

/// Traces of all pixels of a camera, row by row.
#[derive(Debug, Clone)]
pub struct TraceResult {
    /// One entry a pixel.
    pub pixels: Vec<PixelTrace>,
}

impl TraceResult {
    /// Traces all rays of `trace` and compares them with `table`, which gives the expected rays of a
    /// row; with the counts of how they were traced. `task` carries errors back to the image (without
    /// it there are outcomes only); `normals` are the file's own at each facet's corners.
    pub fn new(
        trace: &CameraTrace,
        normals: Option<&[[DVec3; 3]]>,
        task: Option<&ImagingTask>,
        table: impl Fn(u32) -> Vec<ExpectedRay> + Sync,
    ) -> (Self, TraceCounts) {
        let rays = trace.rays();
        let columns = trace.pixels()[0] as usize;
        let comparison = Comparison { scene: trace.scene(), normals, task };
        let mut pixels = vec![PixelTrace::MISSED; columns * trace.pixels()[1] as usize];
        let counts = trace.bands(&mut pixels, |first, ends, pixels| {
            let rows = pixels.chunks_mut(columns).zip(ends.chunks(columns));
            for (row, (pixels, ends)) in (first..).zip(rows) {
                let expected = table(row as u32);
                for (column, (pixel, expected)) in pixels.iter_mut().zip(&expected).enumerate() {
                    let ray = (rays.at(column, row), rays.image_point(column, row));
                    *pixel = comparison.compare(ray, expected, &ends[column]);
                }
            }
        });
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

    /// Summary of an error over the aimed rays that hit; `None` when none did.
    #[must_use]
    pub fn summary(&self, error: impl Fn(&PixelTrace) -> Option<f64>) -> Option<Summary> {
        let hits = self.aimed().filter(|pixel| pixel.outcome == Outcome::Hit);
        Summary::of(hits.filter_map(error).collect())
    }
}

/// Comparison of traced rays with expected ones.
struct Comparison<'a> {
    scene: &'a Scene,
    normals: Option<&'a [[DVec3; 3]]>,
    task: Option<&'a ImagingTask>,
}

impl Comparison<'_> {
    /// Trace of the pixel whose ray, with its image point, ended as `end`.
    fn compare(
        &self,
        (ray, image_point): (Ray, DVec2),
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
            let content = task.image_of(pixel.hit_point, direction, image_point);
            RayErrors {
                angle_rad: angle(direction, expected.direction),
                image_mm: (content - image_point).length(),
                facet_mm: task.projection.image_distance(content, expected.designed),
            }
        };
        let smooth = self.normals.map(|normals| {
            let weights = self.scene.barycentric(&ray, end.facet);
            let corners = normals[end.facet as usize].iter().zip(weights);
            errors(reflect(ray.direction, corners.map(|(n, w)| *n * w).sum()))
        });
        PixelTrace { errors: Some(errors(end.direction)), smooth, ..pixel }
    }
}
