//! Comparison of traced rays with expected ones, run by run of neighbouring pixels, so that what belongs to a pixel is
//! still near the processor when the next step asks for it.

use super::camera_rays::{CameraRays, PixelRay};
use super::camera_trace::CameraTrace;
use super::digest::Digest;
use super::expected_ray::ExpectedRay;
use super::face_slopes::reflected;
use super::filled_range::FilledRange;
use super::pixel_trace::{PixelTrace, RayErrors};
use super::ray_end::{Outcome, RayEnd};
use super::scene::Scene;
use super::trace_counts::TraceCounts;
use super::traced_part::TracedPart;
use super::tracer::Tracer;
use crate::geom::{DVec3, angle};
use crate::optics::{ImagingTask, ReflectedRay, ShownContent, reflect};
use crate::parallel::ScratchPool;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Neighbours of a row that are compared together.
const RUN_OF_PIXELS: usize = 256;

/// Comparison of traced rays with expected ones.
pub(super) struct Comparison<'a, 'b, T> {
    trace: &'a CameraTrace<'b>,
    /// A mesh with normals at the corners of its facets.
    smoothed: Option<(&'a Scene, &'a [[DVec3; 3]])>,
    task: Option<&'a ImagingTask>,
    /// Image error up to which a pixel shows its content, mm.
    tolerance_mm: f64,
    /// By column, what its image points share.
    turns: Vec<[f64; 2]>,
    /// The expected rays of neighbours in a row.
    table: T,
    /// What the pixels show that are known to be filled.
    filled: FilledRange,
    /// Ends of the rays of bands at work.
    ends: ScratchPool<Vec<RayEnd>>,
    /// Digests whose memory is used again.
    spare: Mutex<Vec<Digest>>,
}

impl<'a, 'b, T: Fn([u32; 2], &[PixelRay]) -> Vec<ExpectedRay> + Sync> Comparison<'a, 'b, T> {
    pub(super) fn new(
        trace: &'a CameraTrace<'b>,
        normals: Option<&'a [[DVec3; 3]]>,
        (task, tolerance_mm): (Option<&'a ImagingTask>, f64),
        table: T,
    ) -> Self {
        let turn = |task: &ImagingTask| {
            let columns = 0..trace.pixels()[0] as usize;
            columns.map(|column| task.turn(trace.rays().image_point(column, 0).x)).collect()
        };
        let smoothed = match trace.part() {
            TracedPart::Mesh(scene) => normals.map(|normals| (scene, normals)),
            TracedPart::Body(_) => None,
        };
        let turns = task.map_or(Vec::new(), turn);
        let filled = FilledRange::default();
        let (ends, spare) = (ScratchPool::default(), Mutex::default());
        Self { trace, smoothed, task, tolerance_mm, turns, table, filled, ends, spare }
    }

    /// Traces the pixels of some rows into `pixels`, whatever is in there.
    pub(super) fn trace(
        &self,
        tracer: &Tracer,
        rows: Range<usize>,
        pixels: &mut Vec<PixelTrace>,
    ) -> (TraceCounts, Vec<Digest>) {
        let first_row = rows.start;
        pixels.resize(self.columns() * rows.len(), PixelTrace::MISSED);
        let band = |first: usize, ends: &[RayEnd], pixels: &mut [PixelTrace]| {
            self.band(tracer.rays(), first, ends, pixels)
        };
        let (counts, mut digests, occluded) =
            self.trace.bands((tracer, &self.ends), rows, pixels, band);
        let size = self.trace.band_pixels();
        for of_band in occluded.chunk_by(|(a, _), (b, _)| a / size == b / size) {
            let number = of_band[0].0 / size;
            let (start, digest) = (number * size, &mut digests[number]);
            for &(pixel, outcome) in of_band {
                pixels[pixel] = PixelTrace { outcome, errors: None, ..pixels[pixel] };
                digest.forget_smooth(pixel - start);
            }
            let band = &pixels[start..pixels.len().min(start + size)];
            let first = first_row + start / self.columns();
            digest.empty(self.filled);
            for (at, run) in self.runs(first, band.len()) {
                let (_, expected) = self.expected(tracer.rays(), at, run.len());
                digest.add(&band[run], &expected, self.tolerance_mm);
            }
        }
        (counts, digests)
    }

    /// Takes digests back that are done with: what the filled pixels show is kept, and the memory is used again.
    pub(super) fn take_back(&mut self, digests: Vec<Digest>) {
        digests.iter().for_each(|digest| self.filled.join(digest.filled));
        self.spare.get_mut().unwrap_or_else(PoisonError::into_inner).extend(digests);
    }

    /// A digest of nothing yet.
    fn digest(&self) -> Digest {
        let spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut digest = spare.unwrap_or_default();
        digest.empty(self.filled);
        digest.smooth.clear();
        digest
    }

    /// Whether the pixels of a row are aimed.
    pub(super) fn aimed(&self, row: usize) -> Vec<bool> {
        let rays = self.trace.rays();
        let runs = self.runs(row, self.columns());
        runs.flat_map(|(at, run)| self.expected(rays, at, run.len()).1)
            .map(|expected| expected.aimed)
            .collect()
    }

    fn columns(&self) -> usize {
        self.trace.pixels()[0] as usize
    }

    /// The runs of so many pixels, whole rows from row `first` on: column and row of the first of each, and their
    /// places among those pixels.
    fn runs(
        &self,
        first: usize,
        pixels: usize,
    ) -> impl Iterator<Item = ([usize; 2], Range<usize>)> + use<'a, 'b, T> {
        let columns = self.columns();
        (0..pixels).step_by(columns).flat_map(move |start| {
            let row = first + start / columns;
            (0..columns).step_by(RUN_OF_PIXELS).map(move |column| {
                ([column, row], start + column..start + columns.min(column + RUN_OF_PIXELS))
            })
        })
    }

    /// The camera rays of so many neighbours, and the expected ones.
    fn expected(
        &self,
        rays: &CameraRays,
        at: [usize; 2],
        count: usize,
    ) -> (Vec<PixelRay>, Vec<ExpectedRay>) {
        let rays = rays.of_neighbours(at, count);
        let expected = (self.table)(at.map(|k| k as u32), &rays);
        (rays, expected)
    }

    /// Compares the pixels of a band, whose first row is `first` and whose rays end as `ends`.
    fn band(
        &self,
        rays: &CameraRays,
        first: usize,
        ends: &[RayEnd],
        pixels: &mut [PixelTrace],
    ) -> Digest {
        let mut digest = self.digest();
        for (at, run) in self.runs(first, ends.len()) {
            let (of_camera, expected) = self.expected(rays, at, run.len());
            let (pixels, ends) = (&mut pixels[run.clone()], &ends[run]);
            for (k, pixel) in pixels.iter_mut().enumerate() {
                let ray = &of_camera[k].ray;
                *pixel = PixelTrace {
                    outcome: ends[k].outcome,
                    aimed: expected[k].aimed,
                    direction: reflected(self.trace.slopes(), ray, &ends[k]),
                    hit_point: ends[k].hit_point(ray),
                    errors: None,
                };
            }
            let run = RunOfPixels { rays, at, of_camera: &of_camera, expected: &expected, ends };
            self.judge(&run, pixels, &mut digest);
            digest.add(pixels, &expected, self.tolerance_mm);
        }
        digest
    }

    /// Finds the errors of a run of pixels, those by the file's normals for the digest.
    fn judge(&self, run: &RunOfPixels, pixels: &mut [PixelTrace], digest: &mut Digest) {
        let first = digest.smooth.len();
        if self.smoothed.is_some() {
            digest.smooth.resize(first + pixels.len(), None);
        }
        let Some(task) = self.task else { return };
        let is_hit = |k: &usize| pixels[*k].aimed && pixels[*k].outcome == Outcome::Hit;
        let hits: Vec<usize> = (0..pixels.len()).filter(is_hit).collect();
        let ([column, row], at) = (run.at, |k: usize| pixels[k].hit_point);
        let leaving = |k: usize, direction: DVec3| {
            let near = run.rays.image_point(column + k, row);
            let turn = self.turns[column + k];
            (ReflectedRay { at: at(k), direction, near, turn }, run.expected[k].designed)
        };
        if let Some((scene, normals)) = self.smoothed {
            let by_normals = |&k: &usize| {
                let (ray, facet) = (&run.of_camera[k].ray, run.ends[k].facet);
                let corners = normals[facet as usize].iter().zip(scene.barycentric(ray, facet));
                leaving(k, reflect(ray.direction, corners.map(|(n, w)| *n * w).sum()))
            };
            let rays: Vec<_> = hits.iter().map(by_normals).collect();
            for (k, errors) in hits.iter().zip(run.errors(task, &hits, &rays)) {
                digest.smooth[first + k] = Some(errors);
            }
        }
        let rays: Vec<_> = hits.iter().map(|&k| leaving(k, pixels[k].direction)).collect();
        for (k, errors) in hits.iter().zip(run.errors(task, &hits, &rays)) {
            pixels[*k].errors = Some(errors);
        }
    }
}

/// Neighbours in a row, with all that they are compared by.
struct RunOfPixels<'a> {
    rays: &'a CameraRays,
    /// Column and row of the first.
    at: [usize; 2],
    of_camera: &'a [PixelRay],
    expected: &'a [ExpectedRay],
    ends: &'a [RayEnd],
}

impl RunOfPixels<'_> {
    /// Errors of the rays of the pixels `hits`, which come with what the designed mirror shows.
    fn errors(
        &self,
        task: &ImagingTask,
        hits: &[usize],
        rays: &[(ReflectedRay, ShownContent)],
    ) -> Vec<RayErrors> {
        let shown = task.shown_beside(rays);
        let errors = |k: usize| {
            let (ReflectedRay { direction, near, .. }, designed) = rays[k];
            let image = shown[k].image;
            RayErrors {
                angle_rad: angle(direction, self.expected[hits[k]].direction),
                image_mm: (image - near).length(),
                facet_mm: task.projection.image_distance(image, designed.image),
            }
        };
        (0..rays.len()).map(errors).collect()
    }
}
