//! The rays of bands of rows, traced with the shortcuts that a part allows.

use super::band_depths::RUN;
use super::camera_rays::CameraRays;
use super::occlusion::{OcclusionProof, RayPacket};
use super::rasterizer::{PixelHit, Rasterizer};
use super::ray_end::{Outcome, RayEnd, reflect_at_facet};
use super::trace_counts::TraceCounts;
use super::traced_part::TracedPart;
use crate::brep::ChartedBody;
use crate::geom::DVec2;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// Side of the smallest squares of pixels whose reflected rays are proven unoccluded together; the
/// largest are as wide as a run.
const SMALLEST_SQUARE: usize = 2;

/// A pixel, counted from the first of some rows, and the end of its ray, whose reflected ray has still to be
/// followed.
pub(super) type Undecided = (usize, RayEnd);

/// The counts of bands, one after the other, and their undecided pixels, counted from the first of the first.
pub(super) fn gathered(bands: Vec<BandTrace>) -> (TraceCounts, Vec<Undecided>) {
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

/// How the first places that rays meet are found.
enum FirstHits<'a> {
    /// Facets are rasterized.
    Drawn(Box<Rasterizer<'a>>),
    /// Curved faces are met in the camera's chart.
    Charted(&'a ChartedBody<'a>),
    /// Each is searched for.
    Searched,
}

/// Rays, part and the shortcuts that may be taken.
pub(super) struct Tracer<'a> {
    part: TracedPart<'a>,
    rays: Arc<CameraRays>,
    first_hits: FirstHits<'a>,
    /// Without one, every reflected ray is followed.
    proof: Option<&'a OcclusionProof>,
}

impl<'a> Tracer<'a> {
    /// A tracer that searches for what every ray meets, and follows every reflected ray.
    pub(super) fn searching(part: TracedPart<'a>, rays: &Arc<CameraRays>) -> Self {
        part.prepare_search();
        Self { part, rays: Arc::clone(rays), first_hits: FirstHits::Searched, proof: None }
    }

    /// A tracer of the rays of `rows` with all shortcuts that hold for them: `outside` tells whether they start outside
    /// the part, and `charted` has the curved faces as the camera sees them.
    pub(super) fn new(
        part: TracedPart<'a>,
        rays: &Arc<CameraRays>,
        rows: Range<usize>,
        (outside, charted): (bool, Option<&'a ChartedBody<'a>>),
    ) -> Self {
        let proof = if outside { part.occlusion_proof() } else { None };
        let first_hits = match (part, charted) {
            (TracedPart::Mesh(scene), _) => Rasterizer::new(scene, rays, rows.clone(), None)
                .map(|drawn| FirstHits::Drawn(Box::new(drawn))),
            (TracedPart::Body(_), charted) => charted.map(FirstHits::Charted),
        };
        let rays = match &first_hits {
            Some(FirstHits::Drawn(rasterizer)) => Arc::clone(rasterizer.rays()),
            Some(FirstHits::Charted(_)) => rays.of_rows(rows, None),
            _ => Arc::clone(rays),
        };
        // Without the one all camera rays are searched for, without the other all reflected ones.
        if first_hits.is_none() || proof.is_none() {
            part.prepare_search();
        }
        Self { part, rays, first_hits: first_hits.unwrap_or(FirstHits::Searched), proof }
    }

    /// The rays, those of the tracer's rows at hand.
    pub(super) fn rays(&self) -> &CameraRays {
        &self.rays
    }

    /// Traces the rays of the band from row `first` on. Where the scene has no grid, reflected rays that are
    /// not proven unoccluded are told of and not followed.
    pub(super) fn trace_band(&self, first: usize, ends: &mut [RayEnd]) -> BandTrace {
        let columns = self.rays.camera.pixels[0] as usize;
        let mut band = BandTrace { pixels: ends.len(), ..BandTrace::default() };
        let counts = &mut band.counts;
        match &self.first_hits {
            FirstHits::Drawn(rasterizer) => {
                counts.rasterized = ends.len();
                rasterizer.draw(first, ends, |PixelHit { column, row, t, facet, normal }| {
                    let along = self.rays.at(column, row).direction;
                    let (outcome, direction) = reflect_at_facet(along, normal);
                    RayEnd { outcome, facet, t, direction }
                });
            }
            FirstHits::Charted(charted) => {
                counts.rasterized = ends.len();
                self.meet(charted, first, ends);
            }
            FirstHits::Searched => {
                counts.searched = ends.len();
                for (k, end) in ends.iter_mut().enumerate() {
                    let ray = self.rays.at(k % columns, first + k / columns);
                    *end = self.part.trace_primary(&ray);
                }
            }
        }
        self.obstruct(first, ends);
        OcclusionPass { tracer: self, columns, first, ends, band: &mut band }.run();
        band
    }

    /// Ends of the rays of the band from row `first` on by their first reflection at curved faces.
    fn meet(&self, charted: &ChartedBody, first: usize, ends: &mut [RayEnd]) {
        let columns = self.rays.camera.pixels[0] as usize;
        ends.fill(RayEnd::MISSED);
        let rows = first..first + ends.len() / columns;
        let rows: Vec<Cow<[DVec2]>> = rows.map(|row| self.rays.charted_row(row)).collect();
        let rows: Vec<&[DVec2]> = rows.iter().map(|row| &**row).collect();
        charted.meet(&rows, |[row, column], ray, hit| {
            let (outcome, direction) = reflect_at_facet(ray.direction, hit.normal);
            ends[row * columns + column] = RayEnd { outcome, facet: hit.face, t: hit.t, direction };
        });
    }

    /// Finds the obstructed ones among the rays of the band from row `first` on. (What is proven of the others,
    /// that the mesh is in no reflected ray's way, holds with obstacles as without.)
    fn obstruct(&self, first: usize, ends: &mut [RayEnd]) {
        if self.part.obstacles().is_none() {
            return;
        }
        let columns = self.rays.camera.pixels[0] as usize;
        for (k, end) in ends.iter_mut().enumerate() {
            let ray = self.rays.at(k % columns, first + k / columns);
            end.outcome = self.part.obstructed(&ray, end);
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
        for left in (0..columns).step_by(RUN) {
            self.square([left, 0], [(left + RUN).min(columns), rows]);
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
        let (Tracer { part, rays, .. }, columns) = (self.tracer, self.columns);
        let search = part.has_search();
        for k in (upper..lower).flat_map(|row| row * columns + left..row * columns + right) {
            let end = &mut self.ends[k];
            if end.outcome == Outcome::Hit {
                self.band.counts.followed += 1;
                if search {
                    let ray = rays.at(k % columns, self.first + k / columns);
                    end.outcome = part.occlusion(&ray, end);
                } else {
                    self.band.undecided.push((k, *end));
                }
            }
        }
    }
}
