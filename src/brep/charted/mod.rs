//! A body as a camera's chart shows it: all rays of some rows are met with its faces at once.
//!
//! Faces are cut into pieces whose picture in the chart is proven one to one; along a row the place where one ray
//! meets such a piece foretells that of the next, so that a step or two of Newton's method are enough. What cannot be
//! proven is left to the general search, ray by ray: pieces on edge, at poles, of a high degree. Pieces that show the
//! camera their back are hidden: it is outside the closed body (docs/theory.md, T121).

mod block;
mod newton;
mod tile;

use super::Body;
use super::bicubic::{Net, Powers, ROWS};
use super::face::{Share, TrimmedFace};
use super::patch::halves_of;
use crate::geom::{Chart, DVec2, DVec3, Ray};
use crate::num::sort_by_number;
use crate::parallel;
use block::{Block, COLUMNS, Found};
use tile::{ChartBox, Tile, TileForm, proven_side};

/// Halvings of a patch at most.
const MOST_DEPTH: usize = 16;
/// Share of a pixel at which a piece that is on edge is not halved any more.
const THIN: f64 = 0.5;
/// Height by which a ray may meet a piece above its highest control point, mm: rounding is far below it.
const ABOVE_MM: f64 = 1e-9;

/// A plane face, or a piece of any that is left to the search.
#[derive(Debug, Clone)]
struct Region {
    face: u32,
    bounds: ChartBox,
}

/// The pieces of one face.
#[derive(Debug, Clone, Default)]
struct Pieces {
    tiles: Vec<Tile>,
    planes: Vec<Region>,
    unproven: Vec<Region>,
}

/// Where a ray of a camera meets a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChartedHit {
    /// Distance along the ray, mm.
    pub t: f64,
    /// Number of the face.
    pub face: u32,
    /// Normal there, out of the body, of any length.
    pub normal: DVec3,
}

/// A body with its pieces, as a camera outside it sees them.
#[derive(Debug)]
pub struct ChartedBody<'a> {
    body: &'a Body,
    chart: Chart,
    /// Z where parallel rays start, mm.
    top_mm: f64,
    pieces: Pieces,
}

impl<'a> ChartedBody<'a> {
    /// The pieces of `body` as seen by the rays of `chart`, whose pixels are `pixel_mm` wide on its reference plane;
    /// parallel rays start from height `top_mm`. The rays must start outside the body. `None` where some of it is
    /// behind the pinhole or near it.
    #[must_use]
    pub fn new(body: &'a Body, chart: &Chart, top_mm: f64, pixel_mm: f64) -> Option<Self> {
        let numbers: Vec<u32> = (0..body.faces.len() as u32).collect();
        let of_face = |&number: &u32| {
            let face = &body.faces[number as usize];
            Cutter { chart, face, number, thin: THIN * pixel_mm, pieces: Pieces::default() }
                .cut_face()
        };
        let mut pieces = Pieces::default();
        for of_face in parallel::map_slice(&numbers, 1, of_face) {
            let Pieces { tiles, planes, unproven } = of_face?;
            pieces.tiles.extend(tiles);
            pieces.planes.extend(planes);
            pieces.unproven.extend(unproven);
        }
        Some(Self { body, chart: *chart, top_mm, pieces })
    }

    /// Meets the rays of some rows, given by their chart coordinates, with the body, and calls `each` with the row and
    /// the column of every ray that meets it, the ray and the hit.
    pub fn meet(&self, rows: &[&[DVec2]], mut each: impl FnMut([usize; 2], &Ray, ChartedHit)) {
        let near = self.pieces.near(&ChartBox::of_rays(rows));
        let mut block = Block::empty();
        for (number, rows) in rows.chunks(ROWS).enumerate() {
            let near = near.near(&ChartBox::of_rays(rows));
            for first in (0..rows[0].len()).step_by(COLUMNS) {
                block.begin(rows, first);
                self.meet_block(&near, &mut block);
                let [lo, hi] = block.bounds;
                let unproven = near.unproven.iter().filter(|region| region.bounds.meets(lo, hi));
                let unproven: Vec<&Region> = unproven.copied().collect();
                for column in 0..block.columns {
                    for row in 0..rows.len() {
                        let found = block.found(column, row);
                        let hit = self.hit(&unproven, block.ray(column, row), found);
                        let Some((ray, hit)) = hit else { continue };
                        each([number * ROWS + row, first + column], &ray, hit);
                    }
                }
            }
        }
    }

    /// Adds to a block what its rays meet of tiles and planes.
    fn meet_block(&self, near: &Near, block: &mut Block) {
        let [lo, hi] = block.bounds;
        let mut lowest = f64::NEG_INFINITY;
        for tile in near.tiles.iter().filter(|tile| tile.bounds.meets(lo, hi)) {
            // (Tiles come by their height.)
            if tile.bounds.top + ABOVE_MM < lowest {
                break;
            }
            let face = &self.body.faces[tile.face as usize];
            block.meet(tile, &self.chart, &mut |q, at| face.holds(tile.patch as usize, q, at));
            lowest = block.lowest();
        }
        for plane in near.planes.iter().filter(|plane| plane.bounds.meets(lo, hi)) {
            if plane.bounds.top + ABOVE_MM >= lowest {
                self.meet_plane(plane, block);
                lowest = block.lowest();
            }
        }
    }

    fn meet_plane(&self, plane: &Region, block: &mut Block) {
        let face = &self.body.faces[plane.face as usize];
        let Some((at, normal)) = face.plane() else { return };
        for column in 0..block.columns {
            for row in 0..ROWS {
                let q = block.ray(column, row);
                if !plane.bounds.holds(q) {
                    continue;
                }
                let ray = self.chart.ray(q, self.top_mm);
                let place = ray.at((at - ray.origin).dot(normal) / ray.direction.dot(normal));
                let up = place.z - self.chart.plane_mm;
                let before = block.found(column, row).map_or(f64::NEG_INFINITY, |found| found.up);
                if up > before && face.holds(0, [0.0; 2], place) {
                    block.set(column, row, &Found { up, face: plane.face, normal });
                }
            }
        }
    }

    /// The ray at chart coordinates, and what it meets: of tiles and planes what was found.
    #[inline]
    fn hit(
        &self,
        unproven: &[&Region],
        q: DVec2,
        found: Option<Found>,
    ) -> Option<(Ray, ChartedHit)> {
        let up = found.map_or(f64::NEG_INFINITY, |found| found.up);
        let may_be_met =
            |region: &&Region| region.bounds.holds(q) && region.bounds.top + ABOVE_MM >= up;
        let is_searched = unproven.iter().any(may_be_met);
        if !is_searched && found.is_none() {
            return None;
        }
        let ray = self.chart.ray(q, self.top_mm);
        if is_searched {
            let hit = self.body.nearest_hit(&ray, 0.0, f64::INFINITY)?;
            return Some((ray, ChartedHit { t: hit.t, face: hit.face, normal: hit.normal }));
        }
        let found = found?;
        let t = (found.up + self.chart.plane_mm - ray.origin.z) / ray.direction.z;
        Some((ray, ChartedHit { t, face: found.face, normal: found.normal }))
    }
}

/// The pieces in a part of the chart, the highest tiles first.
struct Near<'a> {
    tiles: Vec<&'a Tile>,
    planes: Vec<&'a Region>,
    unproven: Vec<&'a Region>,
}

impl Pieces {
    fn near(&self, [lo, hi]: &[DVec2; 2]) -> Near<'_> {
        let near = |region: &&Region| region.bounds.meets(*lo, *hi);
        let mut tiles: Vec<&Tile> =
            self.tiles.iter().filter(|tile| tile.bounds.meets(*lo, *hi)).collect();
        // (Those of equal height stay in the order of the file.)
        sort_by_number(&mut tiles, |tile| -tile.bounds.top);
        Near {
            tiles,
            planes: self.planes.iter().filter(near).collect(),
            unproven: self.unproven.iter().filter(near).collect(),
        }
    }
}

impl<'a> Near<'a> {
    fn near(&self, [lo, hi]: &[DVec2; 2]) -> Near<'a> {
        let near = |region: &&&Region| region.bounds.meets(*lo, *hi);
        Near {
            tiles: self.tiles.iter().filter(|tile| tile.bounds.meets(*lo, *hi)).copied().collect(),
            planes: self.planes.iter().filter(near).copied().collect(),
            unproven: self.unproven.iter().filter(near).copied().collect(),
        }
    }
}

impl ChartBox {
    /// Least and largest chart coordinates of rays.
    fn of_rays(rows: &[&[DVec2]]) -> [DVec2; 2] {
        let none = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        // (NaN stays out.)
        rows.iter().flat_map(|row| row.iter()).fold(none, |[lo, hi], q| [q.min(lo), q.max(hi)])
    }
}

/// A face that is cut into pieces.
struct Cutter<'a> {
    chart: &'a Chart,
    face: &'a TrimmedFace,
    number: u32,
    /// Width, mm, of a piece that is not halved any more.
    thin: f64,
    pieces: Pieces,
}

impl Cutter<'_> {
    fn cut_face(mut self) -> Option<Pieces> {
        let whole = self.box_of(self.face.bounds)?;
        let region = Region { face: self.number, bounds: whole };
        if let Some((at, normal)) = self.face.plane() {
            let towards = match self.chart.pupil() {
                Some(pupil) => (pupil - at).dot(normal),
                None => normal.z + normal.truncate().dot(self.chart.lean),
            };
            if towards > 0.0 {
                self.pieces.planes.push(region);
            }
            return Some(self.pieces);
        }
        for (patch, of_patch) in (0..).zip(&self.face.patches) {
            match Net::of(of_patch, self.chart) {
                Some(net) => self.cut(&net, patch, [[0.0, 1.0]; 2], 0)?,
                None => {
                    let bounds = self.box_of(of_patch.bounds)?;
                    self.pieces.unproven.push(Region { face: self.number, bounds });
                }
            }
        }
        Some(self.pieces)
    }

    /// The box in the chart around a box in space.
    fn box_of(&self, [lo, hi]: [DVec3; 2]) -> Option<ChartBox> {
        let corner = |k: usize| {
            let pick = |axis: usize| if k >> axis & 1 == 0 { lo[axis] } else { hi[axis] };
            let up = pick(2) - self.chart.plane_mm;
            let upright = DVec2::new(pick(0), pick(1)) - self.chart.lean * up;
            [upright.x, upright.y, up, 1.0]
        };
        let corners: Vec<_> = (0..8).map(corner).collect();
        ChartBox::around(corners.iter(), self.chart)
    }

    /// Adds a part of a patch, or its halves; `None` where it comes near the pinhole.
    fn cut(&mut self, whole: &Net, patch: u32, part: [[f64; 2]; 2], depth: usize) -> Option<()> {
        let net = whole.over(part);
        let bounds = ChartBox::around(net.controls(), self.chart)?;
        let side = proven_side(&net, &bounds, self.chart);
        let share = self.face.share(patch as usize, part);
        if share == Share::None || side.is_some_and(|side| side != self.face.same) {
            return Some(());
        }
        if side.is_some() {
            let powers = Powers::of(&net);
            self.pieces.tiles.push(Tile {
                face: self.number,
                patch,
                part,
                bounds,
                trimmed: share == Share::Some,
                same: self.face.same,
                form: TileForm::of(&net, &powers),
                powers,
            });
        } else if depth == MOST_DEPTH || bounds.size().min_element() <= self.thin {
            self.pieces.unproven.push(Region { face: self.number, bounds });
        } else {
            for half in halves_of(part, net.longer_axis()) {
                self.cut(whole, patch, half, depth + 1)?;
            }
        }
        Some(())
    }
}
