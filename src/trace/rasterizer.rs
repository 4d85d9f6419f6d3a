//! Facets rasterized over the pixel centres of a camera, with a depth test.

use super::band_depths::{BandDepths, greater};
use super::camera_rays::CameraRays;
use super::fragment::{Fragment, PixelSpan};
use super::pixel_table::PixelTable;
use super::ray_end::RayEnd;
use super::scene::Scene;
use crate::geom::sheared_ray::{Shear, ShearedRay, VerticalRay, intersect};
use crate::geom::{DVec2, DVec3, TriMesh};
use crate::optics::Camera;
use crate::parallel::{self, ScratchPool};
use std::ops::Range;
use std::sync::Arc;

/// Facets of a chunk, rasterized by one thread, whatever the number of threads.
const CHUNK: usize = 1 << 14;
/// Facets over more pixels than this are large: they are drawn last, where nothing is nearer.
const LARGE: usize = 64;
/// Facets whose fragments are listed together.
const BLOCK: usize = 256;
/// Pixels by which a facet's picture is enlarged: rounding is far below it.
const MARGIN: f64 = 1e-6;
/// Largest number of columns or rows: a [`PixelSpan`] holds them as 16-bit integers.
const MOST_PIXELS: u32 = i16::MAX as u32;
/// Smallest view scale of a facet: nearer to the pinhole its picture grows without bound.
const LEAST_VIEW_SCALE: f64 = 1e-3;

/// Hit of a pixel's ray on a small facet.
#[derive(Debug, Clone, Copy, Default)]
struct FragmentHit {
    /// Distance along the pixel's ray, mm.
    t: f64,
    fragment: Fragment,
    /// Normal of the facet, as long as twice its area.
    normal: DVec3,
}

/// A facet over many pixels.
#[derive(Debug, Clone, Copy)]
struct LargeFacet {
    facet: u32,
    /// Its corners in the picture, pixels; of a lens that bends its sides in chart coordinates, mm.
    corners: [DVec2; 3],
    /// First column and row whose pixel centres it may cover, and those after the last.
    columns: [usize; 2],
    rows: [usize; 2],
    /// Least distance of a camera ray to the plane above its highest corner, mm.
    nearest: f64,
}

/// The nearest facet of a pixel so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct PixelHit {
    /// Column of the pixel.
    pub column: usize,
    /// Row of the pixel.
    pub row: usize,
    /// Distance along the pixel's ray, mm.
    pub t: f64,
    /// The facet.
    pub facet: u32,
    /// Normal of the facet, as long as twice its area.
    pub normal: DVec3,
}

/// Hits on the facets of one chunk.
#[derive(Debug, Clone)]
struct ChunkHits {
    /// Hits on its small facets, a band of rows after the other.
    hits: Vec<FragmentHit>,
    /// Index of each band's first hit, and the number of all.
    start: Vec<usize>,
    large: Vec<LargeFacet>,
}

impl ChunkHits {
    /// Sorts hits (distance and fragment) by bands of so many of the rows from the first up to the last.
    fn new(
        mesh: &TriMesh,
        ([first, last], band_rows): ([usize; 2], usize),
        found: &[(f64, Fragment)],
        large: Vec<LargeFacet>,
    ) -> Self {
        let band = |fragment: Fragment| (usize::from(fragment.parts().2) - first) / band_rows;
        let mut start = vec![0; (last - first).div_ceil(band_rows) + 2];
        for &(_, fragment) in found {
            start[band(fragment) + 2] += 1;
        }
        for k in 2..start.len() {
            start[k] += start[k - 1];
        }
        let mut hits = vec![FragmentHit::default(); found.len()];
        for &(t, fragment) in found {
            let next = &mut start[band(fragment) + 1];
            let normal = mesh.area_vector(fragment.parts().0 as usize);
            hits[*next] = FragmentHit { t, fragment, normal };
            *next += 1;
        }
        Self { hits, start, large }
    }

    /// Hits on small facets in a band.
    #[inline]
    fn band(&self, band: usize) -> &[FragmentHit] {
        &self.hits[self.start[band]..self.start[band + 1]]
    }
}

/// Buffers of a thread: fragments of a block, and hits with their distances.
type Buffers = (Vec<Fragment>, Vec<(f64, Fragment)>);

/// Hits of the rays through all pixel centres on all facets.
#[derive(Debug)]
pub(super) struct Rasterizer<'a> {
    mesh: &'a TriMesh,
    rays: Arc<CameraRays>,
    /// First row that is drawn, the first of a band, and the one after the last.
    rows: [usize; 2],
    /// Pixels per mm on the reference plane.
    per_mm: f64,
    /// Z where the rays start, mm.
    start: f64,
    /// Rounding of positions in the picture, pixels, and of distances, mm.
    margins: [f64; 2],
    /// The pixels by where their rays cross the reference plane, of a lens that bends the edges of facets.
    table: Option<PixelTable>,
    /// Span of each vertex, in pixels or in the cells of the table.
    spans: Vec<PixelSpan>,
    /// The pixels of the rows that are asked for; all without.
    wanted: Option<Vec<bool>>,
    chunks: Vec<ChunkHits>,
}

/// Shades a pixel of a band, from row `first` on, with a hit if that is nearer than what it has.
#[inline(always)]
fn depth_test(
    &FragmentHit { t, fragment, normal }: &FragmentHit,
    (first, columns): (usize, usize),
    ends: &mut [RayEnd],
    shade: &impl Fn(PixelHit) -> RayEnd,
) {
    let (facet, column, row) = fragment.parts();
    let [column, row] = [column, row].map(usize::from);
    let end = &mut ends[(row - first) * columns + column];
    if t < end.t || (t == end.t && facet < end.facet) {
        *end = shade(PixelHit { column, row, t, facet, normal });
    }
}

impl<'a> Rasterizer<'a> {
    /// Intersects `rays` of the rows of some bands, or of the `wanted` ones of their pixels, with the facets of
    /// `scene`. `None` where they start beside or below facets, which have no picture then.
    pub(super) fn new(
        scene: &'a Scene,
        rays: &Arc<CameraRays>,
        rows: Range<usize>,
        wanted: Option<Vec<bool>>,
    ) -> Option<Self> {
        let (lo, hi) = scene.bounds()?;
        let CameraRays { camera, top_mm, .. } = **rays;
        let chart = camera.chart;
        let start = chart.pupil().map_or(top_mm, |pupil| pupil.z);
        let view_scale = chart.view_scale(hi.z);
        let extent = lo.abs().max(hi.abs()).max_element().max(start.abs());
        let margin = MARGIN + 64.0 * f64::EPSILON * extent / camera.pixel_mm;
        // (NaN fails.)
        if !(start > hi.z
            && view_scale >= LEAST_VIEW_SCALE
            && margin < 0.25
            && camera.pixels.iter().all(|&n| n <= MOST_PIXELS))
        {
            return None;
        }
        let mesh = scene.mesh();
        let rays = rays.of_rows(rows.clone(), wanted.as_deref());
        let table = rays.charted.as_ref().map(|rows| PixelTable::new(&camera, rows));
        let mut rasterizer = Self {
            mesh,
            rays,
            rows: [rows.start, rows.end],
            per_mm: 1.0 / camera.pixel_mm,
            start,
            margins: [margin, 1e-9 * extent],
            table,
            spans: vec![],
            wanted,
            chunks: vec![],
        };
        rasterizer.spans = parallel::map_slice(&mesh.vertices, CHUNK, |&v| rasterizer.span(v));
        rasterizer.chunks = rasterizer.chunks();
        Some(rasterizer)
    }

    /// Hits of all chunks of facets.
    fn chunks(&self) -> Vec<ChunkHits> {
        let CameraRays { ref camera, top_mm, .. } = *self.rays;
        let chunks: Vec<_> = self.mesh.triangles.chunks(CHUNK).enumerate().collect();
        let hits = |buffers: &mut Buffers, &(number, chunk): &(usize, &[[u32; 3]])| {
            let first = (number * CHUNK) as u32;
            // Nothing is left of the shear of vertical rays.
            if camera.chart.is_plan() && camera.picture.is_identity() {
                let [xs, ys] = &self.rays.centres;
                let ray =
                    |column, row| VerticalRay { origin: DVec3::new(xs[column], ys[row], top_mm) };
                self.chunk(buffers, first, chunk, ray)
            } else {
                let ray = |column, row| ShearedRay::new(&self.rays.at(column, row));
                self.chunk(buffers, first, chunk, ray)
            }
        };
        let scratch = ScratchPool::default();
        parallel::map_slice(&chunks, 1, |chunk| scratch.with(|buffers| hits(buffers, chunk)))
    }

    /// The rays, those of the rows that are drawn at hand.
    pub(super) fn rays(&self) -> &Arc<CameraRays> {
        &self.rays
    }

    /// Whether a pixel's ray is asked for.
    #[inline]
    fn wants(&self, fragment: Fragment) -> bool {
        let Some(wanted) = &self.wanted else { return true };
        let (_, column, row) = fragment.parts();
        let columns = self.rays.camera.pixels[0] as usize;
        wanted[(usize::from(row) - self.rows[0]) * columns + usize::from(column)]
    }

    /// Position of a point in the picture, pixels from the upper left corner.
    #[inline]
    fn position(&self, v: DVec3) -> DVec2 {
        let Camera { pixels: [columns, rows], chart, picture, .. } = &self.rays.camera;
        let [width, height] = [columns, rows].map(|&n| f64::from(n));
        if picture.is_identity() && chart.lean == DVec2::ZERO {
            let scale = self.per_mm / chart.view_scale(v.z);
            return DVec2::new(0.5 * width + v.x * scale, 0.5 * height - v.y * scale);
        }
        let image = self.rays.camera.image_at(v) * self.per_mm;
        DVec2::new(0.5 * width + image.x, 0.5 * height - image.y)
    }

    /// First of `count` pixels in a line whose centre lies between `lo` and `hi`, and the one after
    /// the last.
    #[inline]
    fn between(&self, lo: f64, hi: f64, count: u32) -> [u32; 2] {
        // Numbers around 2^52 have no digits after the point: their lowest ones are the rounded rest.
        const WHOLE: f64 = (1u64 << 52) as f64;
        let within = |x: f64| (lesser(greater(0.0, x), f64::from(count)) + WHOLE).to_bits() as u32;
        [within(lo - self.margins[0]), within(hi + self.margins[0])]
    }

    /// Pixels whose centres the picture of a point may reach.
    #[inline]
    fn span(&self, v: DVec3) -> PixelSpan {
        let Camera { pixels: [width, height], chart, pixel_mm, .. } = self.rays.camera;
        if let Some(table) = &self.table {
            return table.span(chart.coordinates(v).0, self.margins[0] * pixel_mm);
        }
        let at = self.position(v);
        let [left, right] = self.between(at.x, at.x, width).map(|k| k as i16);
        let [first, last] = self.rows.map(|row| row as i16);
        let [upper, lower] =
            self.between(at.y, at.y, height).map(|k| (k as i16).clamp(first, last));
        [left, upper, -right, -lower]
    }

    /// Hits on the facets numbered from `first` on; `ray` gives the ray of an image point.
    fn chunk<S: Shear>(
        &self,
        (fragments, hits): &mut Buffers,
        first: u32,
        triangles: &[[u32; 3]],
        ray: impl Fn(usize, usize) -> S,
    ) -> ChunkHits {
        let mut large = Vec::new();
        let mut count = 0;
        fragments.resize(BLOCK * LARGE, Fragment::default());
        for (first, triangles) in (first..).step_by(BLOCK).zip(triangles.chunks(BLOCK)) {
            let tries = self.fragments(fragments, &mut large, first, triangles);
            if hits.len() < count + tries {
                hits.resize(2 * count + fragments.len(), Default::default());
            }
            for &fragment in &fragments[..tries] {
                if !self.wants(fragment) {
                    continue;
                }
                let (facet, column, row) = fragment.parts();
                let triangle = triangles[(facet - first) as usize];
                let ray = ray(usize::from(column), usize::from(row));
                let [a, b, c] = triangle.map(|v| ray.project(self.mesh.vertices[v as usize]));
                let (meets, t) = intersect(a, b, c);
                // Half of them meet: a branch would be predicted wrongly as often.
                hits[count] = (t, fragment);
                count += usize::from(meets);
            }
        }
        ChunkHits::new(self.mesh, (self.rows, self.rays.band_rows()), &hits[..count], large)
    }

    /// Writes the fragments of small facets from `first` on into `fragments`, and returns their number;
    /// large facets go into `large`.
    #[inline]
    fn fragments(
        &self,
        fragments: &mut [Fragment],
        large: &mut Vec<LargeFacet>,
        first: u32,
        triangles: &[[u32; 3]],
    ) -> usize {
        let mut spans = [[[0; 4]; BLOCK]; 3];
        let [of_a, of_b, of_c] = &mut spans;
        for (k, &[a, b, c]) in triangles.iter().enumerate() {
            [of_a[k], of_b[k], of_c[k]] = [a, b, c].map(|v| self.spans[v as usize]);
        }
        // (All at once, in vector registers.)
        let all = of_a.as_flattened_mut().iter_mut();
        for ((a, b), c) in all.zip(of_b.as_flattened()).zip(of_c.as_flattened()) {
            *a = (*a).min(*b).min(*c);
        }
        if let Some(table) = &self.table {
            of_a[..triangles.len()].iter_mut().for_each(|span| *span = table.pixels(*span));
        }
        let mut count = 0;
        for (facet, &[left, upper, right, lower]) in (first..).zip(&of_a[..triangles.len()]) {
            let [wide, high] = [-(left + right), -(upper + lower)].map(|n| n.max(0) as usize);
            let first = Fragment::new(facet, left as u16, upper as u16);
            if wide <= 2 && high <= 2 {
                fragments[count..count + 4].copy_from_slice(&first.four(wide));
                count += wide * high;
            } else if wide * high > LARGE {
                large.push(self.large(facet, [left, upper, -right, -lower].map(|n| n as usize)));
            } else {
                for at in (0..high).flat_map(|y| (0..wide).map(move |x| [x, y])) {
                    fragments[count] = first.next(at);
                    count += 1;
                }
            }
        }
        count
    }

    fn large(&self, facet: u32, [left, upper, right, lower]: [usize; 4]) -> LargeFacet {
        let corners = self.mesh.corners(facet as usize);
        let [a, b, c] = corners.map(|v| v.z);
        let nearest = self.start - a.max(b).max(c) - self.margins[1];
        let corners = corners.map(|v| match self.table {
            Some(_) => self.rays.camera.chart.coordinates(v).0,
            None => self.position(v),
        });
        LargeFacet { facet, corners, columns: [left, right], rows: [upper, lower], nearest }
    }

    /// Resolves a band from row `first` on: `ends`, one entry a pixel, become what `shade` makes of
    /// the nearest hits. Nothing is drawn over pixels that are not asked for.
    pub(super) fn draw(
        &self,
        first: usize,
        ends: &mut [RayEnd],
        shade: impl Fn(PixelHit) -> RayEnd,
    ) {
        let columns = self.rays.camera.pixels[0] as usize;
        ends.fill(RayEnd::MISSED);
        if let Some(wanted) = &self.wanted {
            // (Nothing is nearer.)
            let nearest = RayEnd { t: f64::NEG_INFINITY, ..RayEnd::MISSED };
            let wanted = &wanted[(first - self.rows[0]) * columns..];
            let unwanted = ends.iter_mut().zip(wanted).filter(|(_, wanted)| !**wanted);
            unwanted.for_each(|(end, _)| *end = nearest);
        }
        for chunk in &self.chunks {
            for hit in chunk.band((first - self.rows[0]) / self.rays.band_rows()) {
                depth_test(hit, (first, columns), ends, &shade);
            }
        }
        let depths = BandDepths::new(ends, columns);
        for large in self.chunks.iter().flat_map(|chunk| &chunk.large) {
            self.draw_large(large, &depths, first, ends, &shade);
        }
    }

    /// Draws a large facet over a band, where something farther is shown.
    fn draw_large(
        &self,
        large: &LargeFacet,
        depths: &BandDepths,
        first: usize,
        ends: &mut [RayEnd],
        shade: &impl Fn(PixelHit) -> RayEnd,
    ) {
        let columns = self.rays.camera.pixels[0] as usize;
        let rows = ends.len() / columns;
        let [upper, lower] = [large.rows[0].max(first), large.rows[1].min(first + rows)];
        if upper >= lower
            || depths.whole < large.nearest
            || !depths.reach(self.slice(large, [upper, lower]), large.nearest)
        {
            return;
        }
        let corners = self.mesh.corners(large.facet as usize);
        for row in upper..lower {
            let pixels = self.slice(large, [row, row + 1]);
            if !depths.reach(pixels, large.nearest) {
                continue;
            }
            for column in self.columns(large, row, pixels) {
                let ray = ShearedRay::new(&self.rays.at(column, row));
                let [a, b, c] = corners.map(|v| ray.project(v));
                let (meets, t) = intersect(a, b, c);
                if meets {
                    let fragment = Fragment::new(large.facet, column as u16, row as u16);
                    let normal = self.mesh.area_vector(large.facet as usize);
                    let hit = FragmentHit { t, fragment, normal };
                    depth_test(&hit, (first, columns), ends, shade);
                }
            }
        }
    }

    /// The columns, of these in a row, whose pixel centres a facet may cover.
    fn columns(
        &self,
        large: &LargeFacet,
        row: usize,
        [left, right]: [usize; 2],
    ) -> impl Iterator<Item = usize> {
        let margin_mm = self.margins[0] * self.rays.camera.pixel_mm;
        let bent = self.table.as_ref().map(|table| {
            table.stretches(large.corners, margin_mm, row, [left, right]).flat_map(|[a, b]| a..b)
        });
        let straight = self.table.is_none().then_some(left..right);
        straight.into_iter().flatten().chain(bent.into_iter().flatten())
    }

    /// First column where a facet may cover pixel centres in some rows, and the one after the last.
    fn slice(&self, large: &LargeFacet, rows: [usize; 2]) -> [usize; 2] {
        // Its bent sides are not followed.
        if self.table.is_some() {
            return large.columns;
        }
        let corners = large.corners;
        let margin = self.margins[0];
        let (upper, lower) = (rows[0] as f64 + 0.5 - margin, rows[1] as f64 - 0.5 + margin);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (least, most) = (a.y.min(b.y), a.y.max(b.y));
            if most < upper || least > lower {
                continue;
            }
            let x = |y: f64| a.x + (b.x - a.x) * ((y.clamp(least, most) - a.y) / (b.y - a.y));
            let (x, y) = if a.y == b.y { (a.x, b.x) } else { (x(upper), x(lower)) };
            left = left.min(x).min(y);
            right = right.max(x).max(y);
        }
        self.between(left, right, self.rays.camera.pixels[0]).map(|k| k as usize)
    }
}

#[inline]
fn lesser(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}
