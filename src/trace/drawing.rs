//! Facets drawn over the pixel centres of a camera.

use super::Glimpse;
use super::line::{Line, Plumb, Shear, crossing};
use super::rays::Rays;
use super::scene::Scene;
use super::spot::{Span, Spot};
use crate::geom::{DVec2, DVec3, TriMesh};
use crate::optics::Camera;
use crate::parallel::{self, Scratch};

/// Rows that are drawn together.
pub const ROWS: usize = 32;
/// Facets are drawn in parts of this size, whatever the number of threads.
const PART: usize = 1 << 14;
/// Facets over more pixels than this are large: they are drawn last, where nothing is nearer.
const LARGE: usize = 64;
/// Facets whose pixels are listed together.
const BLOCK: usize = 256;
/// Pixels by which a facet's picture is taken to be larger than it is: rounding is far below it.
const MARGIN: f64 = 1e-6;
/// Columns or rows of a camera at most.
const MOST_PIXELS: u32 = i16::MAX as u32;
/// Part of the way from the pinhole to the reference plane that facets must keep from it.
const LEAST_WAY: f64 = 1e-3;

/// A facet that the ray of a pixel meets.
#[derive(Debug, Clone, Copy, Default)]
struct Met {
    t: f64,
    spot: Spot,
    /// Of the facet, as long as twice its area.
    normal: DVec3,
}

/// A large facet, its corners' places in the picture and the rows, from the first up to the last, whose centres it may
/// cover.
#[derive(Debug, Clone, Copy)]
struct Large {
    facet: u32,
    at: [DVec2; 3],
    rows: [usize; 2],
    /// The least distance of a ray to a plane above it, mm.
    least: f64,
}

/// A facet that a pixel shows, as long as nothing nearer is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Shown {
    pub column: usize,
    pub row: usize,
    /// Distance along the pixel's ray, mm.
    pub t: f64,
    pub facet: u32,
    /// Of the facet, as long as twice its area.
    pub normal: DVec3,
}

/// What some of the facets show.
#[derive(Debug, Clone)]
struct Part {
    /// Where small ones are met, a band of rows after the other.
    met: Vec<Met>,
    /// Where each band's begin, and the end.
    start: Vec<usize>,
    large: Vec<Large>,
}

impl Part {
    /// Where small ones are met in a band.
    #[inline]
    fn of(&self, band: usize) -> &[Met] {
        &self.met[self.start[band]..self.start[band + 1]]
    }
}

/// Where facets lie in the picture.
#[derive(Debug)]
pub struct Drawing<'a> {
    mesh: &'a TriMesh,
    rays: &'a Rays,
    /// Pixels per mm on the reference plane.
    per_mm: f64,
    /// Z where the rays start.
    start: f64,
    /// Rounding of places in the picture, pixels, and of distances, mm.
    margins: [f64; 2],
    /// Of each vertex.
    spans: Vec<Span>,
    parts: Vec<Part>,
}

/// Shows a facet where nothing nearer is shown.
#[inline(always)]
fn add(
    &Met { t, spot, normal }: &Met,
    columns: usize,
    found: &mut [Glimpse],
    show: &impl Fn(Shown) -> Glimpse,
) {
    let (facet, column, row) = spot.parts();
    let [column, row] = [column, row].map(usize::from);
    let seen = &mut found[row % ROWS * columns + column];
    if t < seen.t || (t == seen.t && facet < seen.facet) {
        *seen = show(Shown { column, row, t, facet, normal });
    }
}

impl<'a> Drawing<'a> {
    /// The picture that `rays` give of `scene`. None where they start beside or below facets: those
    /// cannot be drawn.
    pub fn new(scene: &'a Scene, rays: &'a Rays) -> Option<Self> {
        let (lo, hi) = scene.bounds()?;
        let Rays { camera, top_mm, .. } = *rays;
        let chart = camera.chart;
        let start =
            if chart.vergence == 0.0 { top_mm } else { chart.plane_mm + 1.0 / chart.vergence };
        let way = chart.view_scale(hi.z);
        let extent = lo.abs().max(hi.abs()).max_element().max(start.abs());
        let margin = MARGIN + 64.0 * f64::EPSILON * extent / camera.pixel_mm;
        // (What is no number fails.)
        if !(start > hi.z
            && way >= LEAST_WAY
            && margin < 0.25
            && camera.pixels.iter().all(|&n| n <= MOST_PIXELS))
        {
            return None;
        }
        let mesh = scene.mesh();
        let mut drawing = Self {
            mesh,
            rays,
            per_mm: 1.0 / camera.pixel_mm,
            start,
            margins: [margin, 1e-9 * extent],
            spans: vec![],
            parts: vec![],
        };
        drawing.spans = parallel::map_slice(&mesh.vertices, PART, |&v| drawing.span(v));
        let parts: Vec<_> = mesh.triangles.chunks(PART).enumerate().collect();
        let part = |room: &mut (Vec<Spot>, Vec<(f64, Spot)>),
                    &(number, part): &(usize, &[[u32; 3]])| {
            let first = (number * PART) as u32;
            // Nothing is left of the shear of parallel rays.
            if chart.vergence == 0.0 {
                drawing.part(room, first, part, |x, y| Plumb { origin: DVec3::new(x, y, top_mm) })
            } else {
                let ray = |x, y| Line::new(&camera.ray(DVec2::new(x, y), top_mm));
                drawing.part(room, first, part, ray)
            }
        };
        let scratch = Scratch::default();
        drawing.parts = parallel::map_slice(&parts, 1, |one| scratch.with(|room| part(room, one)));
        Some(drawing)
    }

    /// The place of a point in the picture, pixels from the upper left corner.
    #[inline]
    fn place(&self, v: DVec3) -> DVec2 {
        let Camera { pixels: [columns, rows], chart, .. } = self.rays.camera;
        let scale = self.per_mm / chart.view_scale(v.z);
        DVec2::new(0.5 * f64::from(columns) + v.x * scale, 0.5 * f64::from(rows) - v.y * scale)
    }

    /// The first pixel of a line of `count` whose centre lies between `lo` and `hi`, and the one after
    /// the last.
    #[inline]
    fn between(&self, lo: f64, hi: f64, count: u32) -> [u32; 2] {
        // Numbers around 2^52 have no digits after the point: their lowest ones are the rounded rest.
        const WHOLE: f64 = (1u64 << 52) as f64;
        let within = |x: f64| (lesser(greater(0.0, x), f64::from(count)) + WHOLE).to_bits() as u32;
        [within(lo - self.margins[0]), within(hi + self.margins[0])]
    }

    /// The pixels whose centres the picture of a point may reach.
    #[inline]
    fn span(&self, v: DVec3) -> Span {
        let [width, height] = self.rays.camera.pixels;
        let at = self.place(v);
        let [left, right] = self.between(at.x, at.x, width).map(|k| k as i16);
        let [upper, lower] = self.between(at.y, at.y, height).map(|k| k as i16);
        [left, upper, -right, -lower]
    }

    /// Draws the small ones of the facets numbered from `first` on; `line` gives the ray of a place on
    /// the reference plane.
    fn part<S: Shear>(
        &self,
        (spots, met): &mut (Vec<Spot>, Vec<(f64, Spot)>),
        first: u32,
        triangles: &[[u32; 3]],
        line: impl Fn(f64, f64) -> S,
    ) -> Part {
        let [xs, ys] = &self.rays.centres;
        let height = self.rays.camera.pixels[1];
        let mut large = Vec::new();
        let mut count = 0;
        spots.resize(BLOCK * LARGE, Spot::default());
        for (first, triangles) in (first..).step_by(BLOCK).zip(triangles.chunks(BLOCK)) {
            let tries = self.spots(spots, &mut large, first, triangles);
            if met.len() < count + tries {
                met.resize(2 * count + spots.len(), Default::default());
            }
            for &spot in &spots[..tries] {
                let (facet, column, row) = spot.parts();
                let triangle = triangles[(facet - first) as usize];
                let line = line(xs[usize::from(column)], ys[usize::from(row)]);
                let [a, b, c] = triangle.map(|v| line.project(self.mesh.vertices[v as usize]));
                let (meets, t) = crossing(a, b, c);
                // Half of them meet: a branch would be foretold wrongly as often.
                met[count] = (t, spot);
                count += usize::from(meets);
            }
        }
        let band = |spot: Spot| usize::from(spot.parts().2) / ROWS;
        let mut start = vec![0; (height as usize).div_ceil(ROWS) + 2];
        for &(_, spot) in &met[..count] {
            start[band(spot) + 2] += 1;
        }
        for k in 2..start.len() {
            start[k] += start[k - 1];
        }
        let mut sorted = vec![Met::default(); count];
        for &(t, spot) in &met[..count] {
            let place = &mut start[band(spot) + 1];
            let normal = self.mesh.area_vector(spot.parts().0 as usize);
            sorted[*place] = Met { t, spot, normal };
            *place += 1;
        }
        Part { met: sorted, start, large }
    }

    /// The spots of some facets from `first` on into `spots`, and how many; large ones apart.
    #[inline]
    fn spots(
        &self,
        spots: &mut [Spot],
        large: &mut Vec<Large>,
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
        let mut count = 0;
        for (facet, &[left, upper, right, lower]) in (first..).zip(&of_a[..triangles.len()]) {
            let [wide, high] = [-(left + right), -(upper + lower)].map(|n| n.max(0) as usize);
            let first = Spot::new(facet, left as u16, upper as u16);
            if wide <= 2 && high <= 2 {
                spots[count..count + 4].copy_from_slice(&first.four(wide));
                count += wide * high;
            } else if wide * high > LARGE {
                large.push(self.large(facet, [upper, -lower].map(|row| row as usize)));
            } else {
                for at in (0..high).flat_map(|y| (0..wide).map(move |x| [x, y])) {
                    spots[count] = first.next(at);
                    count += 1;
                }
            }
        }
        count
    }

    fn large(&self, facet: u32, rows: [usize; 2]) -> Large {
        let corners = self.mesh.corners(facet as usize);
        let [a, b, c] = corners.map(|v| v.z);
        let least = self.start - a.max(b).max(c) - self.margins[1];
        Large { facet, at: corners.map(|v| self.place(v)), rows, least }
    }

    /// Draws a band from row `first` on over `found`, one entry a pixel, by what `show` makes of a
    /// facet that is nearest so far.
    pub fn draw(&self, first: usize, found: &mut [Glimpse], show: impl Fn(Shown) -> Glimpse) {
        let columns = self.rays.camera.pixels[0] as usize;
        let rows = found.len() / columns;
        found.fill(Glimpse::NOTHING);
        for part in &self.parts {
            part.of(first / ROWS).iter().for_each(|met| add(met, columns, found, &show));
        }
        let mut deepest = vec![f64::NEG_INFINITY; columns.div_ceil(ROWS)];
        for line in found.chunks(columns) {
            for (deepest, part) in deepest.iter_mut().zip(line.chunks(ROWS)) {
                *deepest = part.iter().map(|seen| seen.t).fold(*deepest, greater);
            }
        }
        let all = deepest.iter().copied().fold(f64::NEG_INFINITY, greater);
        for large in self.parts.iter().flat_map(|part| &part.large) {
            let [upper, lower] = [large.rows[0].max(first), large.rows[1].min(first + rows)];
            if upper >= lower || all < large.least {
                continue;
            }
            let shows = |&[left, right]: &[usize; 2]| {
                left < right
                    && deepest[left / ROWS..=(right - 1) / ROWS].iter().any(|&d| d >= large.least)
            };
            if !shows(&self.slice(large, [upper, lower])) {
                continue;
            }
            let corners = self.mesh.corners(large.facet as usize);
            for row in upper..lower {
                let pixels @ [left, right] = self.slice(large, [row, row + 1]);
                if !shows(&pixels) {
                    continue;
                }
                for column in left..right {
                    let line = Line::new(&self.rays.at(column, row));
                    let [a, b, c] = corners.map(|v| line.project(v));
                    let (meets, t) = crossing(a, b, c);
                    if meets {
                        let spot = Spot::new(large.facet, column as u16, row as u16);
                        let normal = self.mesh.area_vector(large.facet as usize);
                        add(&Met { t, spot, normal }, columns, found, &show);
                    }
                }
            }
        }
    }

    /// The columns, from the first up to the last, where a facet may cover centres in some rows.
    fn slice(&self, Large { at, .. }: &Large, rows: [usize; 2]) -> [usize; 2] {
        let margin = self.margins[0];
        let (upper, lower) = (rows[0] as f64 + 0.5 - margin, rows[1] as f64 - 0.5 + margin);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (a, b) = (at[k], at[(k + 1) % 3]);
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

#[inline]
fn greater(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
