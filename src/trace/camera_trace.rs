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
use super::scene::Scene;
use crate::geom::Ray;
use crate::optics::Camera;
use crate::parallel::{self, ScratchPool};
use std::ops::{Add, Range};

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
    rays: CameraRays,
    shortcuts: bool,
    /// Most pixels of a strip, unless two bands have more.
    strip_pixels: usize,
}

impl<'a> CameraTrace<'a> {
    /// Trace of the rays of `camera`, where they are parallel from height `top_mm`, in `scene`.
    #[must_use]
    pub fn new(scene: &'a Scene, camera: &Camera, top_mm: f64) -> Self {
        let rays = CameraRays::new(camera, top_mm);
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
        let tracer = Tracer::new(self, 0..self.pixels()[1] as usize);
        let band = self.band_pixels();
        let counts = parallel::map_chunks_mut(ends, band, |number, ends| {
            tracer.trace_band(number * BAND_ROWS, ends)
        });
        counts.into_iter().fold(TraceCounts::default(), Add::add)
    }

    /// Ends of the rays of `rows`, one of [`Self::strips`], with the counts of how they were traced.
    #[must_use]
    pub fn run_rows(&self, rows: Range<usize>) -> (Vec<RayEnd>, TraceCounts) {
        let mut ends = vec![RayEnd::MISSED; self.pixels()[0] as usize * rows.len()];
        let (counts, _) = self.bands(rows, &mut ends, |_, found, ends| ends.copy_from_slice(found));
        (ends, counts)
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

    /// Traces the bands of `rows`, a strip of the frame, side by side. `each` gets the number of the first
    /// row, the ends of the band's rays, and its share of `out`, which has one entry a pixel; what it returns
    /// is returned in the order of the bands.
    pub(super) fn bands<T: Send, U: Send>(
        &self,
        rows: Range<usize>,
        out: &mut [T],
        each: impl Fn(usize, &[RayEnd], &mut [T]) -> U + Sync,
    ) -> (TraceCounts, Vec<U>) {
        let first_row = rows.start;
        let tracer = Tracer::new(self, rows);
        let scratch = ScratchPool::default();
        let band = |number: usize, out: &mut [T], ends: &mut Vec<RayEnd>| {
            ends.resize(out.len(), RayEnd::MISSED);
            let first = first_row + number * BAND_ROWS;
            let counts = tracer.trace_band(first, ends);
            (counts, each(first, ends, out))
        };
        let made = parallel::map_chunks_mut(out, self.band_pixels(), |number, out| {
            scratch.with(|ends| band(number, out, ends))
        });
        let (counts, made): (Vec<TraceCounts>, Vec<U>) = made.into_iter().unzip();
        (counts.into_iter().fold(TraceCounts::default(), Add::add), made)
    }

    /// Pixels of a band of rows.
    fn band_pixels(&self) -> usize {
        self.pixels()[0] as usize * BAND_ROWS
    }

    /// Whether the camera's rays start outside the mesh.
    fn starts_outside(&self) -> bool {
        let chart = &self.rays.camera.chart;
        let start = if chart.vergence == 0.0 {
            self.rays.top_mm
        } else {
            chart.ray(Default::default(), 0.0).origin.z
        };
        self.scene.bounds().is_some_and(|(_, hi)| start > hi.z)
    }
}

/// Rays, scene and the shortcuts that may be taken.
struct Tracer<'a> {
    scene: &'a Scene,
    rays: &'a CameraRays,
    /// Without one, every facet is searched for.
    rasterizer: Option<Rasterizer<'a>>,
    /// Without one, every reflected ray is followed.
    proof: Option<&'a OcclusionProof>,
}

impl<'a> Tracer<'a> {
    fn new(trace: &'a CameraTrace, rows: Range<usize>) -> Self {
        let CameraTrace { scene, ref rays, shortcuts, .. } = *trace;
        if !shortcuts {
            return Self { scene, rays, rasterizer: None, proof: None };
        }
        let proof = if trace.starts_outside() { scene.occlusion_proof() } else { None };
        Self { scene, rays, rasterizer: Rasterizer::new(scene, rays, rows), proof }
    }

    /// Traces the rays of the band from row `first` on.
    fn trace_band(&self, first: usize, ends: &mut [RayEnd]) -> TraceCounts {
        let columns = self.rays.camera.pixels[0] as usize;
        let mut counts = TraceCounts::default();
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
        OcclusionPass { tracer: self, columns, first, ends, counts: &mut counts }.run();
        counts
    }
}

/// Search for the occluded ones among a band's reflected rays, square by square of pixels.
struct OcclusionPass<'a, 'b> {
    tracer: &'a Tracer<'a>,
    columns: usize,
    /// The band's first row.
    first: usize,
    ends: &'b mut [RayEnd],
    counts: &'b mut TraceCounts,
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
            self.counts.proven += reflected;
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
        for k in (upper..lower).flat_map(|row| row * columns + left..row * columns + right) {
            let end = &mut self.ends[k];
            if end.outcome == Outcome::Hit {
                let ray = rays.at(k % columns, self.first + k / columns);
                end.outcome = scene.occlusion(&ray, end);
                self.counts.followed += 1;
            }
        }
    }
}
