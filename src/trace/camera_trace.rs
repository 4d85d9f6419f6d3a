//! All rays of a camera at once: the facets they meet are rasterized instead of searched for, and
//! reflected rays that provably leave are not followed.
//!
//! The rasterizer intersects a facet with the rays of the pixel centres near its picture by the same
//! arithmetic, to the last bit, as the general search; so both answer alike.

use super::band_depths::BAND_ROWS;
use super::camera_rays::CameraRays;
use super::occlusion::{OcclusionProof, RayPacket};
use super::rasterizer::{PixelHit, Rasterizer};
use super::ray_end::{Outcome, RayEnd, reflect_at_facet};
use super::scene::{LeavingRay, Scene};
use crate::geom::Ray;
use crate::optics::Camera;
use crate::parallel::{self, ScratchPool};
use std::ops::{Add, Range};
use std::sync::Arc;

/// Side of the smallest squares of pixels whose reflected rays are proven unoccluded together; the
/// largest are as high as a band.
const SMALLEST_SQUARE: usize = 2;

/// Numbers of rays by how they were traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TraceCounts {
    /// Camera rays whose facet was found by the rasterizer.
    pub rasterized: usize,
    /// Camera rays whose facet was searched for in the grid.
    pub searched: usize,
    /// Reflected rays that were proven unoccluded.
    pub proven: usize,
    /// Reflected rays that were followed through the grid.
    pub followed: usize,
}

impl Add for TraceCounts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rasterized: self.rasterized + other.rasterized,
            searched: self.searched + other.searched,
            proven: self.proven + other.proven,
            followed: self.followed + other.followed,
        }
    }
}

/// Trace of the rays through all pixel centres of a camera in a scene.
#[derive(Debug, Clone)]
pub struct CameraTrace<'a> {
    scene: &'a Scene,
    rays: Arc<CameraRays>,
    shortcuts: bool,
    /// Most pixels of a strip, unless two bands have more.
    strip_pixels: usize,
}

impl<'a> CameraTrace<'a> {
    /// Trace of the rays of `camera`, where they are parallel from height `top_mm`, in `scene`.
    #[must_use]
    pub fn new(scene: &'a Scene, camera: &Camera, top_mm: f64) -> Self {
        let rays = Arc::new(CameraRays::new(camera, top_mm));
        Self { scene, rays, shortcuts: true, strip_pixels: Self::STRIP_PIXELS }
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

    /// The scene that is traced.
    #[must_use]
    pub fn scene(&self) -> &'a Scene {
        self.scene
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
        let tracer = Tracer::new(self, rows);
        let found = parallel::map_chunks_mut(ends, self.band_pixels(), |number, ends| {
            tracer.trace_band(first + number * BAND_ROWS, ends)
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
        let bands = (self.strip_pixels / (columns * BAND_ROWS)).max(Self::LEAST_BANDS);
        let step = if columns * rows <= self.strip_pixels { rows } else { bands * BAND_ROWS };
        (0..rows).step_by(step.max(1)).map(|first| first..(first + step).min(rows)).collect()
    }

    /// Most pixels of a strip: what is kept of them takes some 100 MB.
    pub const STRIP_PIXELS: usize = 1 << 19;
    /// Bands of a strip at the least: each is a thread's.
    const LEAST_BANDS: usize = 2;

    /// The rows of a strip in slices, each of whole bands, that are traced one after the other: what is kept
    /// of a slice's pixels stays in the processor's cache and its memory is used again.
    pub(super) fn slices(&self, rows: Range<usize>) -> Vec<Range<usize>> {
        let bands = Self::SLICE_PIXELS / self.band_pixels();
        let step = bands.max(Self::LEAST_SLICE).max(2 * parallel::threads()) * BAND_ROWS;
        rows.clone().step_by(step).map(|first| first..(first + step).min(rows.end)).collect()
    }

    /// Most pixels of a slice, unless its least number of bands has more: what is kept of them takes 10 MB.
    const SLICE_PIXELS: usize = 1 << 16;
    const LEAST_SLICE: usize = 4;

    /// What is needed to trace the rows of a strip.
    pub(super) fn tracer(&self, rows: Range<usize>) -> Tracer<'_> {
        Tracer::new(self, rows)
    }

    /// Traces the bands of `rows`, a slice of the strip of `tracer`, side by side. `each` gets the number of the
    /// first row, the ends of the band's rays, and its share of `out`, which has one entry a pixel; what it
    /// returns is returned in the order of the bands, with the pixels, counted from the slice's first, whose
    /// reflected rays are occluded although their ends said that they were not.
    pub(super) fn bands<T: Send, U: Send>(
        &self,
        tracer: &Tracer,
        rows: Range<usize>,
        out: &mut [T],
        each: impl Fn(usize, &[RayEnd], &mut [T]) -> U + Sync,
    ) -> (TraceCounts, Vec<U>, Vec<(usize, Outcome)>) {
        let first_row = rows.start;
        let scratch = ScratchPool::default();
        let band = |number: usize, out: &mut [T], ends: &mut Vec<RayEnd>| {
            ends.resize(out.len(), RayEnd::MISSED);
            let first = first_row + number * BAND_ROWS;
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
            if !self.scene.blocks_any(&leaving) {
                return Vec::new();
            }
        }
        self.scene.prepare_search();
        let follow = |(pixel, end): &Undecided| (*pixel, self.scene.occlusion(&ray(*pixel), end));
        let outcomes = parallel::map_slice(undecided, 64, follow);
        outcomes.into_iter().filter(|(_, outcome)| *outcome != Outcome::Hit).collect()
    }

    /// Pixels of a band of rows.
    fn band_pixels(&self) -> usize {
        self.pixels()[0] as usize * BAND_ROWS
    }

    /// Whether the camera's rays start outside the mesh.
    fn starts_outside(&self) -> bool {
        let chart = &self.rays.camera.chart;
        let start = chart.pupil().map_or(self.rays.top_mm, |pupil| pupil.z);
        self.scene.bounds().is_some_and(|(_, hi)| start > hi.z)
    }
}

/// A pixel, counted from the first of some rows, and the end of its ray, whose reflected ray has still to be
/// followed.
type Undecided = (usize, RayEnd);

/// The counts of bands, one after the other, and their undecided pixels, counted from the first of the first.
fn gathered(bands: Vec<BandTrace>) -> (TraceCounts, Vec<Undecided>) {
    let (mut counts, mut undecided, mut pixels) = (TraceCounts::default(), Vec::new(), 0);
    for band in bands {
        counts = counts + band.counts;
        undecided.extend(band.undecided.into_iter().map(|(pixel, end)| (pixels + pixel, end)));
        pixels += band.pixels;
    }
    (counts, undecided)
}

/// What is told of the trace of a band.
#[derive(Default)]
pub(super) struct BandTrace {
    counts: TraceCounts,
    pixels: usize,
    undecided: Vec<Undecided>,
}

/// Rays, scene and the shortcuts that may be taken.
pub(super) struct Tracer<'a> {
    scene: &'a Scene,
    rays: Arc<CameraRays>,
    /// Without one, every facet is searched for.
    rasterizer: Option<Rasterizer<'a>>,
    /// Without one, every reflected ray is followed.
    proof: Option<&'a OcclusionProof>,
}

impl<'a> Tracer<'a> {
    fn new(trace: &'a CameraTrace, rows: Range<usize>) -> Self {
        let CameraTrace { scene, ref rays, shortcuts, .. } = *trace;
        if !shortcuts {
            scene.prepare_search();
            return Self { scene, rays: Arc::clone(rays), rasterizer: None, proof: None };
        }
        let proof = if trace.starts_outside() { scene.occlusion_proof() } else { None };
        let rasterizer = Rasterizer::new(scene, rays, rows, None);
        // Without the one all camera rays are searched for, without the other all reflected ones.
        if rasterizer.is_none() || proof.is_none() {
            scene.prepare_search();
        }
        let rays = Arc::clone(rasterizer.as_ref().map_or(rays, Rasterizer::rays));
        Self { scene, rays, rasterizer, proof }
    }

    /// The rays, those of the tracer's rows at hand.
    pub(super) fn rays(&self) -> &CameraRays {
        &self.rays
    }

    /// Traces the rays of the band from row `first` on. Where the scene has no grid, reflected rays that are
    /// not proven unoccluded are told of and not followed.
    fn trace_band(&self, first: usize, ends: &mut [RayEnd]) -> BandTrace {
        let columns = self.rays.camera.pixels[0] as usize;
        let mut band = BandTrace { pixels: ends.len(), ..BandTrace::default() };
        let counts = &mut band.counts;
        if let Some(rasterizer) = &self.rasterizer {
            counts.rasterized = ends.len();
            rasterizer.draw(first, ends, |PixelHit { column, row, t, facet, normal }| {
                let along = self.rays.at(column, row).direction;
                let (outcome, direction) = reflect_at_facet(along, normal);
                RayEnd { outcome, facet, t, direction }
            });
        } else {
            counts.searched = ends.len();
            for (k, end) in ends.iter_mut().enumerate() {
                let ray = self.rays.at(k % columns, first + k / columns);
                *end = self.scene.trace_primary(&ray);
            }
        }
        self.obstruct(first, ends);
        OcclusionPass { tracer: self, columns, first, ends, band: &mut band }.run();
        band
    }

    /// Finds the obstructed ones among the rays of the band from row `first` on. (What is proven of the others,
    /// that the mesh is in no reflected ray's way, holds with obstacles as without.)
    fn obstruct(&self, first: usize, ends: &mut [RayEnd]) {
        if self.scene.obstacles().is_none() {
            return;
        }
        let columns = self.rays.camera.pixels[0] as usize;
        for (k, end) in ends.iter_mut().enumerate() {
            let ray = self.rays.at(k % columns, first + k / columns);
            end.outcome = self.scene.obstructed(&ray, end);
        }
    }
}

/// Search for the occluded ones among a band's reflected rays, square by square of pixels.
struct OcclusionPass<'a, 'b> {
    tracer: &'a Tracer<'a>,
    columns: usize,
    /// The band's first row.
    first: usize,
    ends: &'b mut [RayEnd],
    band: &'b mut BandTrace,
}

impl OcclusionPass<'_, '_> {
    fn run(&mut self) {
        let columns = self.columns;
        let rows = self.ends.len() / columns;
        for left in (0..columns).step_by(BAND_ROWS) {
            self.square([left, 0], [(left + BAND_ROWS).min(columns), rows]);
        }
    }

    /// Decides the pixels from the upper left corner up to, not including, the lower right one: all
    /// together if the proof holds, else quarter by quarter, the smallest squares ray by ray.
    fn square(&mut self, from @ [left, upper]: [usize; 2], to @ [right, lower]: [usize; 2]) {
        let (packet, reflected) = self.packet(from, to);
        if reflected == 0 {
            return;
        }
        let proof = self.tracer.proof;
        if proof.is_some_and(|proof| proof.is_unoccluded(&packet)) {
            self.band.counts.proven += reflected;
            return;
        }
        let side = (right - left).max(lower - upper);
        if side > SMALLEST_SQUARE && proof.is_some() {
            let middle = [0, 1].map(|axis| from[axis] + side / 2);
            for [x, y] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let half = |k: usize, axis: usize| {
                    let cut = middle[axis].min(to[axis]);
                    if k == 0 { [from[axis], cut] } else { [cut, to[axis]] }
                };
                let ([left, right], [upper, lower]) = (half(x, 0), half(y, 1));
                self.square([left, upper], [right, lower]);
            }
            return;
        }
        self.follow(from, to);
    }

    /// The reflected rays of a square of pixels, and their number.
    #[inline]
    fn packet(&self, [left, upper]: [usize; 2], [right, lower]: [usize; 2]) -> (RayPacket, usize) {
        let mut packet = RayPacket::EMPTY;
        let mut reflected = 0;
        for row in upper..lower {
            for column in left..right {
                let RayEnd { outcome, t, direction, .. } = self.ends[row * self.columns + column];
                if outcome == Outcome::Hit {
                    let origin = self.tracer.rays.point(column, self.first + row, t);
                    packet.add(origin, direction);
                    reflected += 1;
                }
            }
        }
        (packet, reflected)
    }

    /// Follows the reflected rays of a square of pixels one by one.
    fn follow(&mut self, [left, upper]: [usize; 2], [right, lower]: [usize; 2]) {
        let (Tracer { scene, rays, .. }, columns) = (self.tracer, self.columns);
        let search = scene.has_search();
        for k in (upper..lower).flat_map(|row| row * columns + left..row * columns + right) {
            let end = &mut self.ends[k];
            if end.outcome == Outcome::Hit {
                self.band.counts.followed += 1;
                if search {
                    let ray = rays.at(k % columns, self.first + k / columns);
                    end.outcome = scene.occlusion(&ray, end);
                } else {
                    self.band.undecided.push((k, *end));
                }
            }
        }
    }
}
