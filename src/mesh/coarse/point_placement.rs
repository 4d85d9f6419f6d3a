//! Packing: a lattice of varying cells grown over a panel from its rim and from seeds.
//!
//! Every point proposes its neighbours one step of its own cell away; a proposal is taken unless a
//! point is near. Where cells turn or change in size the lattice gets dislocations, rows that
//! begin or end: no lattice without them follows all cells.

use super::boundary_nodes::BoundaryNodes;
use crate::geom::DVec2;
use crate::mesh::CROWDED;
use crate::mesh::sizing::frame_field::FrameField;
use glam::DMat2;
use std::collections::VecDeque;

/// A proposal this near to a point (in cells) is that point. Rows spread from so much to one and
/// so much, for a step each side of their right distance.
const NEAR: f64 = 0.7;
/// The same for points of the rim.
const NEAR_RIM: f64 = 0.35;
/// A point this near to where it was proposed continues the lattice.
const SAME: f64 = 0.35;
const SAME_ON_RIM: f64 = 0.12;
/// Distance of the lattice from the rim, in cells.
const CLEARANCE: f64 = 0.25;
/// Farther than this from every point a place has been left out.
const COVERED: f64 = 1.3;
const NONE: u32 = u32::MAX;
/// Rounds of relaxation, and how far beyond the mean of its neighbours a point goes.
const ROUNDS: usize = 25;
const BEYOND: f64 = 1.5;
/// Steps in cells that no longer matter.
const SETTLED: f64 = 2e-3;

/// A packed panel; the first points are the rim's.
pub struct PointPlacement {
    /// Where they are.
    pub points: Vec<DVec2>,
    /// The map from unit steps to steps of the lattice at each.
    pub cells: Vec<DMat2>,
    /// The points that each found where it proposed its neighbours.
    links: Vec<[u32; 6]>,
    active: Vec<bool>,
    /// How many are the rim's.
    fixed: usize,
    /// Where the others were before they were moved.
    proposed: Vec<DVec2>,
}

impl PointPlacement {
    /// Packs the inside of `rim`; or else a place where cells shrink so that there is no end.
    pub fn new(cells: &FrameField, rim: &BoundaryNodes) -> Result<Self, DVec2> {
        let mut packing = Self {
            proposed: Vec::new(),
            points: Vec::new(),
            cells: Vec::new(),
            links: Vec::new(),
            active: Vec::new(),
            fixed: rim.points.len(),
        };
        let mut bins = SpatialGrid::new(cells);
        for &q in &rim.points {
            packing.push(q, cells.at(q), &mut bins);
        }
        let mut queue = VecDeque::new();
        let corner = cells.needs.domain().min;
        if rim.points.first() == Some(&corner) {
            packing.active[0] = true;
            queue.push_back(0);
        }
        packing.grow(cells, rim, &mut queue, &mut bins)?;
        for q in cells.needs.centres() {
            let cell = cells.at(q);
            if rim.is_clear(q, &cell, CLEARANCE)
                && packing.nearest(q, &cell, COVERED, &bins).is_none()
            {
                queue.push_back(packing.push(q, cell, &mut bins));
                packing.active[queue[0]] = true;
                packing.grow(cells, rim, &mut queue, &mut bins)?;
            }
        }
        packing.proposed = packing.points[packing.fixed..].to_vec();
        packing.relax(cells, rim);
        Ok(packing)
    }

    fn push(&mut self, q: DVec2, cell: DMat2, bins: &mut SpatialGrid) -> usize {
        let index = self.points.len();
        self.points.push(q);
        self.cells.push(cell);
        self.links.push([NONE; 6]);
        self.active.push(false);
        bins.add(q, index as u32);
        index
    }

    /// Takes up what the points of `queue` propose, and what these propose, until all is full.
    fn grow(
        &mut self,
        cells: &FrameField,
        rim: &BoundaryNodes,
        queue: &mut VecDeque<usize>,
        bins: &mut SpatialGrid,
    ) -> Result<(), DVec2> {
        let (ways, turns) = (cells.kind.ways(), cells.kind.turns());
        while let Some(i) = queue.pop_front() {
            let (from, own) = (self.points[i], self.cells[i]);
            if self.points.len() > CROWDED {
                return Err(from);
            }
            for (k, &way) in ways.iter().enumerate() {
                if self.links[i][k] != NONE {
                    continue;
                }
                let back = (k + ways.len() / 2) % ways.len();
                // Where cells turn, the one half-way leads nearer to the neighbour.
                let cell = if turns { cells.following(from + own * way * 0.5, &own) } else { own };
                let q = from + cell * way;
                match self.nearest(q, &cell, NEAR, bins) {
                    Some((j, distance)) => {
                        let same = if j < self.fixed { SAME_ON_RIM } else { SAME };
                        if distance < same && j != i {
                            self.links[i][k] = j as u32;
                            if !self.active[j] {
                                self.active[j] = true;
                                self.cells[j] = cells.following(self.points[j], &own);
                                queue.push_back(j);
                            }
                            let same_back = if i < self.fixed { SAME_ON_RIM } else { SAME };
                            if distance < same_back && is_alike(&own, &self.cells[j]) {
                                self.links[j][back] = i as u32;
                            }
                        }
                    }
                    None if rim.is_clear(q, &cell, CLEARANCE) => {
                        let j = self.push(q, cells.following(q, &own), bins);
                        self.active[j] = true;
                        self.links[i][k] = j as u32;
                        self.links[j][back] = i as u32;
                        queue.push_back(j);
                    }
                    None => {}
                }
            }
        }
        Ok(())
    }

    /// The nearest point within `reach` cells of `q`, and how near.
    fn nearest(
        &self,
        q: DVec2,
        cell: &DMat2,
        reach: f64,
        bins: &SpatialGrid,
    ) -> Option<(usize, f64)> {
        let (half, inverse) = (extent(cell) * reach, cell.inverse());
        let mut found = None;
        let mut best = reach * reach;
        bins.each(q - half, q + half, |j| {
            let d = (inverse * (self.points[j as usize] - q)).length_squared();
            // Lattice and rim need not fit each other.
            let beside = (j as usize) < self.fixed && reach == NEAR;
            if d < best && (!beside || d < NEAR_RIM * NEAR_RIM) {
                best = d;
                found = Some(j as usize);
            }
        });
        found.map(|j| (j, best.sqrt()))
    }

    /// Spreads the strain between dislocations: every inner point goes to where its neighbours
    /// would have it. The rim's stay.
    fn relax(&mut self, cells: &FrameField, rim: &BoundaryNodes) {
        let ways = cells.kind.ways();
        // From each point that it found a point's way, as that point's neighbour would have it.
        let mut starts = Vec::with_capacity(self.points.len() + 1);
        let mut pulls: Vec<(u32, DVec2)> = Vec::with_capacity(ways.len() * self.points.len());
        for i in self.fixed..self.points.len() {
            starts.push(pulls.len());
            for (k, &way) in ways.iter().enumerate() {
                let j = self.links[i][k];
                if j != NONE {
                    pulls.push((j, self.between(i, j as usize) * way));
                }
            }
        }
        starts.push(pulls.len());
        for _ in 0..ROUNDS {
            let mut largest = 0.0f64;
            for (k, range) in starts.windows(2).enumerate() {
                let pulls = &pulls[range[0]..range[1]];
                if pulls.len() < 2 {
                    continue;
                }
                let i = self.fixed + k;
                let to = pulls.iter().map(|&(j, way)| self.points[j as usize] - way).sum::<DVec2>();
                let step = (to / pulls.len() as f64 - self.points[i]) * BEYOND;
                self.points[i] += step;
                let size = self.cells[i].x_axis.length_squared();
                largest = largest.max(step.length_squared() / size);
            }
            if largest < SETTLED * SETTLED {
                break;
            }
        }
        // What has come too near to the rim goes back a little.
        for i in self.fixed..self.points.len() {
            let depth = rim.depth(self.points[i], &self.cells[i]);
            if depth < 0.5 * CLEARANCE {
                self.points[i] = self.proposed[i - self.fixed];
            }
        }
    }

    fn between(&self, i: usize, j: usize) -> DMat2 {
        let (a, b) = (self.cells[i], self.cells[j]);
        let turned = a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis);
        let size = a.x_axis.length_squared() + a.y_axis.length_squared();
        if turned > 0.5 * size { (a + b) * 0.5 } else { a }
    }
}

/// Whether two cells are turned the same way about, so that a way back is the way.
fn is_alike(a: &DMat2, b: &DMat2) -> bool {
    let size = |m: &DMat2| m.x_axis.length_squared() + m.y_axis.length_squared();
    let same = a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis);
    same > 0.0 && same * same > 0.75 * size(a) * size(b)
}

/// Half-sizes of the box around the image of the unit circle.
pub fn extent(cell: &DMat2) -> DVec2 {
    let (a, b) = (cell.x_axis, cell.y_axis);
    DVec2::new(DVec2::new(a.x, b.x).length(), DVec2::new(a.y, b.y).length())
}

/// Points by place.
struct SpatialGrid {
    min: DVec2,
    scale: DVec2,
    width: usize,
    height: usize,
    first: Vec<u32>,
    next: Vec<u32>,
}

impl SpatialGrid {
    fn new(cells: &FrameField) -> Self {
        let domain = cells.needs.domain();
        // Large cells that few points share cost little; the other way round costs time squared.
        let size = cells
            .needs
            .centres()
            .map(|q| extent(&cells.at(q)))
            .fold(DVec2::splat(0.0), |sum, e| sum + e.recip());
        let count = cells.needs.centres().count() as f64;
        let bins = (domain.size() * size / count).ceil().clamp(DVec2::ONE, DVec2::splat(2000.0));
        let (width, height) = (bins.x as usize, bins.y as usize);
        Self {
            min: domain.min,
            scale: bins / domain.size(),
            width,
            height,
            first: vec![NONE; width * height],
            next: Vec::new(),
        }
    }

    fn bin(&self, q: DVec2) -> [usize; 2] {
        let place = (q - self.min) * self.scale;
        [
            (place.x.max(0.0) as usize).min(self.width - 1),
            (place.y.max(0.0) as usize).min(self.height - 1),
        ]
    }

    fn add(&mut self, q: DVec2, index: u32) {
        let [i, j] = self.bin(q);
        let slot = j * self.width + i;
        self.next.push(self.first[slot]);
        self.first[slot] = index;
    }

    fn each(&self, lo: DVec2, hi: DVec2, mut visit: impl FnMut(u32)) {
        let ([i0, j0], [i1, j1]) = (self.bin(lo), self.bin(hi));
        for j in j0..=j1 {
            for i in i0..=i1 {
                let mut at = self.first[j * self.width + i];
                while at != NONE {
                    visit(at);
                    at = self.next[at as usize];
                }
            }
        }
    }
}
