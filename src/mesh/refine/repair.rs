//! Repair of the fine mesh: around facets that fail, vertices are moved and edges flipped, and, where that does not do,
//! facets are split or collapsed, until none fails.

use super::boundary_arcs::BoundaryArcs;
use super::facet_check::{CheckedFacets, FacetCheck};
use super::independent_sets::{IndependentSets, flip_all};
use super::probe::RefinementProbe;
use super::repair_progress::{FailureSpread, RepairProgress};
use super::subdivide::FineMesh;
use super::triangulation::EditableTriangulation;
use super::tuning::TUNING;
use crate::geom::{DVec2, TriMesh};
use crate::mesh::bound::error_bound::ErrorBound;
use crate::mesh::bound::mesh_bound::MeshBound;
use crate::mesh::bound::vertex::SurfaceVertex;
use crate::mesh::error::MeshError;
use crate::mesh::sizing::frame_field::FrameField;
use crate::parallel;
use glam::DMat2;
use std::collections::HashSet;

/// Vertices that a thread makes at a time; fixed, so that results do not depend on the number of threads.
const CHUNK: usize = 256;
/// Facets whose oversize a thread takes at a time, at least: some microseconds of work.
const OVERSIZE_CHUNK: usize = 64;

/// Refines `fine` until every facet keeps the limits of `check`; the mesh, and its bound, or none where failures spread
/// farther than `spread`. The face holds `copies` of it.
///
/// # Errors
/// [`MeshError`] where refinement does not help, or needs too many facets.
pub(crate) fn refine(
    check: &FacetCheck,
    frames: &FrameField,
    arcs: &BoundaryArcs,
    fine: FineMesh,
    copies: usize,
    spread: FailureSpread,
) -> Result<Option<(TriMesh, ErrorBound)>, MeshError> {
    let vertex = |&q: &DVec2| check.bounder.snapped_vertex(q);
    let vertices: Vec<SurfaceVertex> = parallel::map_slice(&fine.points, CHUNK, vertex);
    let all: Vec<u32> = (0..fine.triangles.len() as u32).collect();
    let mut checked = check.check(&all, &vertices, &fine.triangles);
    let mut repair = Repair {
        check,
        frames,
        arcs,
        net: EditableTriangulation::new(&frames.sizing, 1.0, vertices, fine.triangles),
        changed: Vec::new(),
        sets: IndependentSets::default(),
        collapsed: HashSet::new(),
        mended: HashSet::new(),
    };
    if !repair.run(&mut checked, copies, spread)? {
        return Ok(None);
    }
    let EditableTriangulation { vertices, triangles, .. } = &repair.net;
    let mesh = MeshBound { bounder: check.bounder, vertices, facets: triangles };
    let bound = mesh.bound(&checked.bounds, &checked.largest, &check.limits);
    let (vertices, triangles) = repair.net.into_parts();
    let vertices = vertices.into_iter().map(|v| v.at).collect();
    Ok(Some((TriMesh { vertices, triangles }, bound)))
}

/// A fine mesh under repair.
struct Repair<'a> {
    check: &'a FacetCheck<'a>,
    frames: &'a FrameField,
    arcs: &'a BoundaryArcs,
    net: EditableTriangulation<SurfaceVertex>,
    /// Facets that have changed since they were checked.
    changed: Vec<u32>,
    sets: IndependentSets,
    /// Facets around vertices that were removed by a collapse in this round.
    collapsed: HashSet<u32>,
    /// Facets that failed in the last round and were foreseen to hold as they had been changed in it.
    mended: HashSet<u32>,
}

impl Repair<'_> {
    /// Repairs round after round until no facet fails; whether failures spread no farther than `spread`.
    fn run(
        &mut self,
        checked: &mut CheckedFacets,
        copies: usize,
        spread: FailureSpread,
    ) -> Result<bool, MeshError> {
        let mut progress = RepairProgress::new(self.net.triangles.len());
        while !checked.failed.is_empty() {
            MeshError::check_facets((self.net.triangles.len() * copies) as f64)?;
            progress.begin_round(checked.failed.len(), self.net.triangles.len());
            if progress.is_diverging() {
                return Err(self.not_refinable(checked.failed[0]));
            }
            if spread == FailureSpread::Local && progress.is_spreading() {
                return Ok(false);
            }
            let failed = std::mem::take(&mut checked.failed);
            self.round(&failed, &checked.bounds, progress.is_optimising())?;
            self.changed.extend(&failed);
            self.check_changed(checked);
        }
        checked.largest.retain(|t| !self.net.is_removed(*t));
        Ok(true)
    }

    /// Checks the facets that have changed; those that were removed have no errors.
    fn check_changed(&mut self, checked: &mut CheckedFacets) {
        let mut changed = sorted_set(std::mem::take(&mut self.changed));
        checked.bounds.resize(self.net.triangles.len(), ErrorBound::INFINITE);
        changed.retain(|&t| {
            let is_removed = self.net.is_removed(t);
            if is_removed {
                checked.bounds[t as usize] = ErrorBound::default();
            }
            !is_removed
        });
        let found = self.check.check(&changed, &self.net.vertices, &self.net.triangles);
        for (t, bound) in changed.into_iter().zip(found.bounds) {
            checked.bounds[t as usize] = bound;
        }
        checked.largest.extend(found.largest);
        checked.failed = found.failed;
    }

    /// Changes the facets that failed, of all facets with these bounds; by `optimising` shapes, or by bisection alone.
    fn round(
        &mut self,
        failed: &[u32],
        bounds: &[ErrorBound],
        optimising: bool,
    ) -> Result<(), MeshError> {
        self.check_axis(failed)?;
        let old = self.net.vertices.len() as u32;
        if optimising {
            self.smooth_until_stable(self.corners(failed));
        }
        let mut changed = std::mem::take(&mut self.changed);
        changed.sort_unstable();
        self.collapsed.clear();
        let mut mended = HashSet::new();
        for &t in failed {
            if self.net.is_removed(t) {
                continue;
            }
            let corners = self.net.triangles[t as usize];
            // A facet that is new in this round has not been proven to fail.
            let is_changed = (changed.binary_search(&t).is_ok() && !self.mended.contains(&t))
                || self.collapsed.contains(&t);
            let is_mended = is_changed && self.net.oversize(t) < TUNING.mended_oversize;
            if is_mended {
                mended.insert(t);
            }
            if is_mended || corners.iter().any(|&v| v >= old) {
                continue;
            }
            let is_collapsed = optimising
                && self.is_tilted(&bounds[t as usize])
                && self.collapse(t, TUNING.mended_oversize);
            if !is_collapsed {
                self.split_facet(t, optimising)?;
            }
        }
        self.mended = mended;
        self.changed.extend(changed);
        if optimising {
            let mut near = self.corners(failed);
            near.extend(old..self.net.vertices.len() as u32);
            self.smooth_until_stable(near);
        }
        Ok(())
    }

    /// Checks that no failed facet lies where the mirror may look along its axis, if the image counts.
    fn check_axis(&self, failed: &[u32]) -> Result<(), MeshError> {
        if self.check.limits.facet_mm.is_none() {
            return Ok(());
        }
        for &t in failed {
            let facet = self.net.triangles[t as usize].map(|v| self.net.vertices[v as usize]);
            if self.check.bounder.may_be_on_axis(&facet) {
                return Err(MeshError::OnAxis { at: facet[0].q });
            }
        }
        Ok(())
    }

    /// Whether rounding has a large share in the error of a facet.
    fn is_tilted(&self, bound: &ErrorBound) -> bool {
        let limit = self.check.limits.facet_mm;
        limit.is_some_and(|limit| bound.rounding_mm > TUNING.tilted_share * limit)
    }

    /// Collapses an edge of facet `t`, if the oversize that is foreseen around it is then under `most`, and smaller.
    fn collapse(&mut self, t: u32, most: f64) -> bool {
        let Some(collapse) = self.net.best_collapse(t, most) else { return false };
        let around = self.net.collapse(collapse);
        self.collapsed.extend(&around);
        self.changed.extend(around);
        true
    }

    /// Splits an edge of facet `t`: the best one while `optimising`, else the longest by Rivara's rule.
    fn split_facet(&mut self, t: u32, optimising: bool) -> Result<(), MeshError> {
        if !optimising {
            let [a, b, c] = self.net.triangles[t as usize].map(|v| self.net.q(v));
            let metric = self.frames.at((a + b + c) / 3.0).inverse();
            return self.bisect(t, t, &metric);
        }
        let (edge, middle) = self.net.best_split(t, |edge| self.midpoint(edge));
        if !is_splittable(edge.map(|v| self.net.q(v))) && self.collapse(t, f64::INFINITY) {
            return Ok(());
        }
        self.split(edge, middle, t)
    }

    /// The vertices of the given facets that are left.
    fn corners(&self, facets: &[u32]) -> Vec<u32> {
        let left = facets.iter().filter(|t| !self.net.is_removed(**t));
        left.flat_map(|&t| self.net.triangles[t as usize]).collect()
    }

    /// Smooths around the given vertices, and again around those facets that changed and are still too large.
    fn smooth_until_stable(&mut self, mut vertices: Vec<u32>) {
        for _ in 0..TUNING.smoothing_passes {
            vertices.sort_unstable();
            vertices.dedup();
            let before = self.changed.len();
            self.smooth(&vertices);
            let changed = sorted_set(self.changed.split_off(before));
            let net = &self.net;
            let is_large = |t: &u32| net.oversize(*t) > TUNING.mended_oversize;
            let large = parallel::gather(changed.len(), OVERSIZE_CHUNK, |part| {
                changed[part].iter().copied().filter(is_large).collect()
            });
            vertices.clear();
            vertices.extend(large.into_iter().flat_map(|t| net.triangles[t as usize]));
            self.changed.extend(changed);
        }
    }

    /// Moves the given vertices, and flips the edges around them.
    fn smooth(&mut self, vertices: &[u32]) {
        let Self { check, frames, net, changed, sets, .. } = self;
        let fine = |q: DVec2| frames.at(q) * (1.0 / frames.parts as f64);
        let better = |net: &EditableTriangulation<SurfaceVertex>, v: u32| {
            let vertex = |q| check.bounder.snapped_vertex(q);
            net.better_position(v, TUNING.movable_oversize, fine, vertex)
        };
        sets.move_all(net, vertices.to_vec(), better, |net, v| changed.extend(net.around(v)));
        let near = sorted_set(vertices.iter().flat_map(|&v| net.around(v)).collect());
        let sides = |t: u32| {
            let [a, b, c] = net.triangles[t as usize];
            [sorted(a, b), sorted(b, c), sorted(c, a)]
        };
        let mut edges: Vec<[u32; 2]> = near.into_iter().flat_map(sides).collect();
        edges.sort_unstable();
        edges.dedup();
        flip_all(net, edges, |t| changed.push(t));
    }

    /// Splits the longest edge of facet `t`, for the sake of facet `of`, by Rivara's rule: an edge is only split when
    /// it is the longest of both its facets, so that shapes stay what they were. Lengths are counted in one metric, or
    /// the rule might not end.
    fn bisect(&mut self, t: u32, of: u32, metric: &DMat2) -> Result<(), MeshError> {
        let edge = self.longest_edge(t, metric);
        loop {
            let beyond = self.net.beside(edge).into_iter().flatten().find(|&u| u != t);
            match beyond {
                Some(u) if self.longest_edge(u, metric) != edge => self.bisect(u, of, metric)?,
                _ => return self.split(edge, self.midpoint(edge), of),
            }
        }
    }

    /// The vertex in the middle of an edge; on the arc of an edge that is on one.
    fn midpoint(&self, edge: [u32; 2]) -> SurfaceVertex {
        let [p, q] = edge.map(|v| self.net.q(v));
        let is_boundary = self.net.beside(edge)[1].is_none();
        let arc = if is_boundary { self.arcs.through(p, q) } else { None };
        let middle = (p + q) * 0.5;
        self.check.bounder.snapped_vertex(arc.map_or(middle, |arc| arc.project(middle)))
    }

    /// Splits an edge at `middle`, for the sake of facet `of`.
    fn split(&mut self, edge: [u32; 2], middle: SurfaceVertex, of: u32) -> Result<(), MeshError> {
        if !is_splittable(edge.map(|v| self.net.q(v))) {
            return Err(self.not_refinable(of));
        }
        let v = self.net.split(edge, middle);
        self.changed.extend(self.net.around(v));
        Ok(())
    }

    /// The longest edge of a facet in a metric; of equally long ones, that of the largest numbers.
    fn longest_edge(&self, t: u32, metric: &DMat2) -> [u32; 2] {
        let [a, b, c] = self.net.triangles[t as usize];
        let length = |edge: [u32; 2]| {
            let [p, q] = edge.map(|v| self.net.q(v));
            ((*metric * (q - p)).length_squared(), edge)
        };
        let longer = |x: (f64, [u32; 2]), y: (f64, [u32; 2])| {
            if y.0.total_cmp(&x.0).then(y.1.cmp(&x.1)).is_gt() { y } else { x }
        };
        let edges = [sorted(a, b), sorted(b, c), sorted(c, a)].map(length);
        edges.into_iter().reduce(longer).expect("three edges").1
    }

    /// The error that says why facet `t` is not refined.
    fn not_refinable(&self, t: u32) -> MeshError {
        let FacetCheck { bounder, limits } = self.check;
        let facet = self.net.triangles[t as usize].map(|v| self.net.q(v));
        RefinementProbe::new(bounder, *limits).not_refinable(facet)
    }
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The numbers in order, each once.
fn sorted_set(mut numbers: Vec<u32>) -> Vec<u32> {
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// Whether an edge is so long that its halves would keep their shape under rounding.
fn is_splittable([a, b]: [DVec2; 2]) -> bool {
    let step = ((a + b) * 0.5).abs().max_element() * f64::from(f32::EPSILON);
    a.distance(b) > TUNING.shortest_edge_steps * step
}
