//! Point placement: a lattice of varying cells grown over a panel from its boundary and from seeds.
//!
//! Every point proposes its neighbours one step of its own cell away; a proposal is taken unless a point is near. Where
//! cells turn or change in size the lattice gets dislocations, rows that begin or end: no lattice without them follows
//! all cells.

use super::boundary_nodes::BoundaryNodes;
use super::spatial_grid::SpatialGrid;
use super::tuning::TUNING;
use crate::geom::DVec2;
use crate::mesh::sizing::frame_field::{FrameField, cell_extent};
use glam::DMat2;
use std::collections::VecDeque;

/// The number of no point.
const NONE: u32 = u32::MAX;

/// The points of a panel; the first ones are the boundary nodes.
pub(crate) struct PointPlacement {
    /// Positions in the chart, mm.
    pub points: Vec<DVec2>,
    /// The map from unit steps to steps of the lattice at each point.
    pub cells: Vec<DMat2>,
    /// For each point the points that it found where it proposed its neighbours.
    links: Vec<[u32; 6]>,
    /// Whether each point has proposed its neighbours, or is going to.
    active: Vec<bool>,
    /// Number of the boundary nodes.
    fixed: usize,
    /// Positions of the other points before relaxation.
    proposed: Vec<DVec2>,
}

/// A placement while it grows.
struct Growth<'a> {
    frames: &'a FrameField,
    boundary: &'a BoundaryNodes,
    grid: SpatialGrid,
    /// Points that have yet to propose their neighbours.
    queue: VecDeque<usize>,
    placed: PointPlacement,
}

impl PointPlacement {
    /// Places points inside of `boundary`.
    ///
    /// # Errors
    /// A place where cells shrink so that there is no end of points.
    pub(crate) fn new(frames: &FrameField, boundary: &BoundaryNodes) -> Result<Self, DVec2> {
        let mut growth = Growth::new(frames, boundary);
        growth.fill()?;
        let mut placed = growth.placed;
        placed.proposed = placed.points[placed.fixed..].to_vec();
        placed.relax(frames, boundary);
        Ok(placed)
    }

    /// Spreads the strain between dislocations: every inner point goes to where its neighbours would have it. The
    /// boundary nodes stay.
    fn relax(&mut self, frames: &FrameField, boundary: &BoundaryNodes) {
        let (starts, pulls) = self.pulls(frames);
        for _ in 0..TUNING.relaxation_rounds {
            let mut largest = 0.0f64;
            for (k, range) in starts.windows(2).enumerate() {
                let pulls = &pulls[range[0]..range[1]];
                if pulls.len() < 2 {
                    continue;
                }
                let i = self.fixed + k;
                let to = pulls.iter().map(|&(j, way)| self.points[j as usize] - way).sum::<DVec2>();
                let step = (to / pulls.len() as f64 - self.points[i]) * TUNING.overrelaxation;
                self.points[i] += step;
                let size = self.cells[i].x_axis.length_squared();
                largest = largest.max(step.length_squared() / size);
            }
            if largest < TUNING.relaxed_step * TUNING.relaxed_step {
                break;
            }
        }
        // A point that has come too near to the boundary goes back.
        for i in self.fixed..self.points.len() {
            let depth = boundary.depth(self.points[i], &self.cells[i]);
            if depth < 0.5 * TUNING.clearance {
                self.points[i] = self.proposed[i - self.fixed];
            }
        }
    }

    /// For every inner point the points that it found, and the steps to these as the lattice would have them; where the
    /// list of each inner point begins, and the lists one after the other.
    fn pulls(&self, frames: &FrameField) -> (Vec<usize>, Vec<(u32, DVec2)>) {
        let steps = frames.kind.steps();
        let mut starts = Vec::with_capacity(self.points.len() + 1);
        let mut pulls: Vec<(u32, DVec2)> = Vec::with_capacity(steps.len() * self.points.len());
        for i in self.fixed..self.points.len() {
            starts.push(pulls.len());
            for (k, &step) in steps.iter().enumerate() {
                let j = self.links[i][k];
                if j != NONE {
                    pulls.push((j, self.mean_cell(i, j as usize) * step));
                }
            }
        }
        starts.push(pulls.len());
        (starts, pulls)
    }

    /// The mean of the cells of two points, or that of the first if they are turned by more than 60 degrees.
    fn mean_cell(&self, i: usize, j: usize) -> DMat2 {
        let (a, b) = (self.cells[i], self.cells[j]);
        let turned = a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis);
        let size = a.x_axis.length_squared() + a.y_axis.length_squared();
        if turned > 0.5 * size { (a + b) * 0.5 } else { a }
    }
}

impl<'a> Growth<'a> {
    /// A placement of the boundary nodes alone.
    fn new(frames: &'a FrameField, boundary: &'a BoundaryNodes) -> Self {
        let placed = PointPlacement {
            proposed: Vec::new(),
            points: Vec::new(),
            cells: Vec::new(),
            links: Vec::new(),
            active: Vec::new(),
            fixed: boundary.points.len(),
        };
        let grid = SpatialGrid::new(frames);
        let mut growth = Self { frames, boundary, grid, queue: VecDeque::new(), placed };
        for &q in &boundary.points {
            growth.push(q, frames.at(q));
        }
        growth
    }

    /// Grows the lattice from the domain's corner, and then from seeds wherever a place has been left out.
    fn fill(&mut self) -> Result<(), DVec2> {
        let corner = self.frames.sizing.domain().min;
        if self.boundary.points.first() == Some(&corner) {
            self.placed.active[0] = true;
            self.queue.push_back(0);
        }
        self.grow()?;
        for q in self.frames.sizing.cell_centres() {
            let cell = self.frames.at(q);
            if self.boundary.is_clear(q, &cell)
                && self.nearest(q, &cell, TUNING.uncovered).is_none()
            {
                let seed = self.push(q, cell);
                self.queue.push_back(seed);
                self.placed.active[seed] = true;
                self.grow()?;
            }
        }
        Ok(())
    }

    fn push(&mut self, q: DVec2, cell: DMat2) -> usize {
        let index = self.placed.points.len();
        self.placed.points.push(q);
        self.placed.cells.push(cell);
        self.placed.links.push([NONE; 6]);
        self.placed.active.push(false);
        self.grid.add(q, index as u32);
        index
    }

    /// Takes up what the points of the queue propose, and what these propose, until all is full.
    fn grow(&mut self) -> Result<(), DVec2> {
        while let Some(i) = self.queue.pop_front() {
            if self.placed.points.len() > TUNING.most_points {
                return Err(self.placed.points[i]);
            }
            for k in 0..self.frames.kind.steps().len() {
                if self.placed.links[i][k] == NONE {
                    self.propose(i, k);
                }
            }
        }
        Ok(())
    }

    /// Proposes the neighbour of point `i` at step `k` of its cell.
    fn propose(&mut self, i: usize, k: usize) {
        let frames = self.frames;
        let (from, own) = (self.placed.points[i], self.placed.cells[i]);
        let steps = frames.kind.steps();
        let (step, back) = (steps[k], (k + steps.len() / 2) % steps.len());
        // Where cells turn, the one half-way leads nearer to the neighbour.
        let turns = frames.kind.turns();
        let cell = if turns { frames.continued(from + own * step * 0.5, &own) } else { own };
        let q = from + cell * step;
        match self.nearest(q, &cell, TUNING.occupied) {
            Some((j, distance)) => self.join(i, k, (j, back), distance),
            None if self.boundary.is_clear(q, &cell) => {
                let j = self.push(q, frames.continued(q, &own));
                self.placed.active[j] = true;
                self.placed.links[i][k] = j as u32;
                self.placed.links[j][back] = i as u32;
                self.queue.push_back(j);
            }
            None => {}
        }
    }

    /// Links point `i` at its step `k` to the point `j`, and back, if it is so near (in cells) to the proposal that it
    /// continues the lattice.
    fn join(&mut self, i: usize, k: usize, (j, back): (usize, usize), distance: f64) {
        let same = |point: usize| {
            let is_fixed = point < self.placed.fixed;
            if is_fixed { TUNING.continues_at_boundary } else { TUNING.continues }
        };
        let (same, same_back) = (same(j), same(i));
        if !(distance < same && j != i) {
            return;
        }
        let own = self.placed.cells[i];
        self.placed.links[i][k] = j as u32;
        if !self.placed.active[j] {
            self.placed.active[j] = true;
            self.placed.cells[j] = self.frames.continued(self.placed.points[j], &own);
            self.queue.push_back(j);
        }
        if distance < same_back && is_aligned(&own, &self.placed.cells[j]) {
            self.placed.links[j][back] = i as u32;
        }
    }

    /// The nearest point within `reach` cells of `q`, and its distance in cells.
    fn nearest(&self, q: DVec2, cell: &DMat2, reach: f64) -> Option<(usize, f64)> {
        let (half, inverse) = (cell_extent(cell) * reach, cell.inverse());
        let mut found = None;
        let mut best = reach * reach;
        let by_boundary = TUNING.occupied_by_boundary * TUNING.occupied_by_boundary;
        self.grid.each(q - half, q + half, |j| {
            let d = (inverse * (self.placed.points[j as usize] - q)).length_squared();
            // Lattice and boundary need not fit each other.
            let beside = (j as usize) < self.placed.fixed && reach == TUNING.occupied;
            if d < best && (!beside || d < by_boundary) {
                best = d;
                found = Some(j as usize);
            }
        });
        found.map(|j| (j, best.sqrt()))
    }
}

/// Whether two cells are turned by less than 30 degrees (cos^2 = 0.75, less where they differ in shape), so that a step
/// back is the step's opposite.
fn is_aligned(a: &DMat2, b: &DMat2) -> bool {
    let size = |m: &DMat2| m.x_axis.length_squared() + m.y_axis.length_squared();
    let same = a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis);
    same > 0.0 && same * same > 0.75 * size(a) * size(b)
}
