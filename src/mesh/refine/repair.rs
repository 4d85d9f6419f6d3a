//! Proof and repair: every facet is asked for its bounds; around those that fail corners are moved
//! and edges flipped, and, where that does not do, split, until none fails.

use super::independent_sets::{IndependentSets, flip_all};
use super::probe::RefinementProbe;
use super::repair_progress::RepairProgress;
use super::subdivide::FineMesh;
use super::triangulation::EditableTriangulation;
use crate::geom::{DVec2, TriMesh};
use crate::mesh::bound::error_bounder::{ErrorBound, ErrorBounder, SurfaceVertex};
use crate::mesh::bound::mesh_bound::MeshBound;
use crate::mesh::coarse::coarse_mesh::CoarseMesh;
use crate::mesh::{Limits, MOST_FACETS, MeshError};
use crate::parallel;
use glam::DMat2;
use std::collections::HashSet;

/// Facets a thread proves at a time; fixed, so that results do not depend on the thread count.
const CHUNK: usize = 256;
/// How often what changes in a round is gone over.
const PASSES: usize = 4;
/// Excess foreseen by what the mirror does at the corners, over which one of a failed facet is moved.
const UNEASY: f64 = 0.81;
/// Facets a thread looks at at a time in a repair, at least.
const FEW: usize = 64;
/// Excess under which a facet that was changed is left to the proof before it is split.
const MENDED: f64 = 0.96;
/// Share of the image's limit that rounding takes up by tilting a facet, over which the facet is not made
/// smaller before there is no other way: rounding tilts it the more.
const TILTED: f64 = 0.3;

/// `fine` refined until every facet keeps `limits`, and the bound reached. The face holds `copies`
/// of it.
pub fn refine(
    prover: &ErrorBounder,
    draft: &CoarseMesh,
    fine: FineMesh,
    copies: usize,
    limits: Limits,
) -> Result<(TriMesh, ErrorBound), MeshError> {
    let corner = |&q: &DVec2| prover.corner(q);
    let vertices: Vec<SurfaceVertex> = parallel::map_slice(&fine.points, CHUNK, corner);
    let all: Vec<u32> = (0..fine.triangles.len() as u32).collect();
    let proof = FacetCheck { prover, limits };
    let mut proven = proof.of(&all, &vertices, &fine.triangles);
    let net = EditableTriangulation::new(draft.cells.needs, 1.0, vertices, fine.triangles);
    let (changed, crowd) = (Vec::new(), IndependentSets::default());
    let (drawn, mended) = (HashSet::new(), HashSet::new());
    let mut repair = Repair { proof: &proof, draft, net, changed, crowd, drawn, mended };
    repair.mend(&mut proven, copies)?;
    let EditableTriangulation { points, triangles, .. } = &repair.net;
    let mesh = MeshBound { prover, vertices: points, facets: triangles };
    let bound = mesh.bound(&proven.bounds, &proven.largest, &limits);
    let (vertices, triangles) = repair.net.into_parts();
    let vertices = vertices.into_iter().map(|v| v.at).collect();
    Ok((TriMesh { vertices, triangles }, bound))
}

struct FacetCheck<'a> {
    prover: &'a ErrorBounder<'a>,
    limits: Limits,
}

/// What the proof of some facets tells.
#[derive(Default)]
struct CheckedFacets {
    /// Of each.
    bounds: Vec<ErrorBound>,
    /// Of each chunk of those that keep the limits, the ones with the largest errors at corners and
    /// edges.
    largest: Vec<u32>,
    /// The others.
    failed: Vec<u32>,
}

impl FacetCheck<'_> {
    /// Proves the given facets.
    fn of(
        &self,
        facets: &[u32],
        vertices: &[SurfaceVertex],
        triangles: &[[u32; 3]],
    ) -> CheckedFacets {
        let chunk = |facets: &[u32]| {
            let mut proven = CheckedFacets::default();
            let mut largest = [(0.0, None); 2];
            for &t in facets {
                let facet = triangles[t as usize].map(|v| &vertices[v as usize]);
                let (mut bound, reached) = self.prover.estimate(facet);
                if !self.limits.hold(&bound) && self.limits.allow(reached) {
                    bound = self.prover.settle(facet, bound, &self.limits);
                }
                proven.bounds.push(bound);
                if self.limits.hold(&bound) {
                    for (largest, reached) in largest.iter_mut().zip(reached) {
                        if reached > largest.0 {
                            *largest = (reached, Some(t));
                        }
                    }
                } else {
                    proven.failed.push(t);
                }
            }
            proven.largest.extend(largest.into_iter().filter_map(|(_, t)| t));
            proven
        };
        let chunks = parallel::map_chunks(facets, CHUNK, chunk);
        chunks.into_iter().fold(CheckedFacets::default(), |mut all, chunk| {
            all.bounds.extend(chunk.bounds);
            all.largest.extend(chunk.largest);
            all.failed.extend(chunk.failed);
            all
        })
    }
}

struct Repair<'a> {
    proof: &'a FacetCheck<'a>,
    draft: &'a CoarseMesh<'a>,
    net: EditableTriangulation<'a, SurfaceVertex>,
    /// Facets that are no longer what was proven.
    changed: Vec<u32>,
    crowd: IndependentSets,
    /// Facets around corners that were drawn into others in this round.
    drawn: HashSet<u32>,
    /// Facets that failed in the last round, and were foreseen to hold as they had been changed in it.
    mended: HashSet<u32>,
}

impl Repair<'_> {
    /// Repairs round after round until no facet fails.
    fn mend(&mut self, proven: &mut CheckedFacets, copies: usize) -> Result<(), MeshError> {
        let mut course = RepairProgress::new(self.net.triangles.len());
        while !proven.failed.is_empty() {
            let facets = (self.net.triangles.len() * copies) as f64;
            if facets > MOST_FACETS {
                return Err(MeshError::TooMany { facets, most: MOST_FACETS });
            }
            course.note(proven.failed.len(), self.net.triangles.len());
            if course.is_hopeless() {
                return Err(self.floor(proven.failed[0]));
            }
            let failed = std::mem::take(&mut proven.failed);
            self.round(&failed, &proven.bounds, course.is_eager())?;
            self.changed.extend(&failed);
            self.prove(proven);
        }
        proven.largest.retain(|t| !self.net.is_gone(*t));
        Ok(())
    }

    /// Proves the facets that have changed; of those that have gone nothing is left.
    fn prove(&mut self, proven: &mut CheckedFacets) {
        let mut changed = std::mem::take(&mut self.changed);
        changed.sort_unstable();
        changed.dedup();
        proven.bounds.resize(self.net.triangles.len(), ErrorBound::NEVER);
        changed.retain(|&t| {
            let is_gone = self.net.is_gone(t);
            if is_gone {
                proven.bounds[t as usize] = ErrorBound::default();
            }
            !is_gone
        });
        let found = self.proof.of(&changed, &self.net.points, &self.net.triangles);
        for (t, bound) in changed.into_iter().zip(found.bounds) {
            proven.bounds[t as usize] = bound;
        }
        proven.largest.extend(found.largest);
        proven.failed = found.failed;
    }

    /// Changes the facets that failed, of all those with these bounds.
    fn round(
        &mut self,
        failed: &[u32],
        bounds: &[ErrorBound],
        eager: bool,
    ) -> Result<(), MeshError> {
        for &t in failed {
            let facet = self.net.triangles[t as usize].map(|v| self.net.points[v as usize]);
            if self.proof.limits.facet_mm.is_some() && self.proof.prover.sees_the_pole(&facet) {
                return Err(MeshError::OnAxis { at: facet[0].q });
            }
        }
        let old = self.net.points.len() as u32;
        if eager {
            self.settle(self.corners(failed));
        }
        let mut changed = std::mem::take(&mut self.changed);
        changed.sort_unstable();
        self.drawn.clear();
        let mut mended = HashSet::new();
        for &t in failed {
            if self.net.is_gone(t) {
                continue;
            }
            let corners = self.net.triangles[t as usize];
            // What is new in this round has not been proven to fail.
            let is_changed = (changed.binary_search(&t).is_ok() && !self.mended.contains(&t))
                || self.drawn.contains(&t);
            let is_mended = is_changed && self.net.excess(t) < MENDED;
            if is_mended {
                mended.insert(t);
            }
            if is_mended || corners.iter().any(|&v| v >= old) {
                continue;
            }
            let is_drawn = eager && self.is_tilted(&bounds[t as usize]) && self.draw(t, MENDED);
            if !is_drawn {
                self.cut(t, eager)?;
            }
        }
        self.mended = mended;
        self.changed.extend(changed);
        if eager {
            let mut near = self.corners(failed);
            near.extend(old..self.net.points.len() as u32);
            self.settle(near);
        }
        Ok(())
    }

    /// Whether rounding has a large share in a facet's error.
    fn is_tilted(&self, bound: &ErrorBound) -> bool {
        let limit = self.proof.limits.facet_mm;
        limit.is_some_and(|limit| bound.rounding_mm > TILTED * limit)
    }

    /// Draws a corner of facet `t` into another, if the excess that is foreseen around it is then under
    /// `most`, and smaller.
    fn draw(&mut self, t: u32, most: f64) -> bool {
        let Some(collapse) = self.net.best_collapse(t, most) else { return false };
        let around = self.net.collapse(collapse);
        self.drawn.extend(&around);
        self.changed.extend(around);
        true
    }

    /// Splits an edge of facet `t`.
    fn cut(&mut self, t: u32, eager: bool) -> Result<(), MeshError> {
        if !eager {
            let [a, b, c] = self.net.triangles[t as usize].map(|v| self.net.q(v));
            let metric = self.draft.cells.at((a + b + c) / 3.0).inverse();
            return self.bisect(t, t, &metric);
        }
        let (edge, middle) = self.net.best_split(t, |edge| self.middle(edge));
        if !splits(edge.map(|v| self.net.q(v))) && self.draw(t, f64::INFINITY) {
            return Ok(());
        }
        self.split(edge, middle, t)
    }

    /// The corners of those of the given facets that are left.
    fn corners(&self, facets: &[u32]) -> Vec<u32> {
        let left = facets.iter().filter(|t| !self.net.is_gone(**t));
        left.flat_map(|&t| self.net.triangles[t as usize]).collect()
    }

    /// Moves corners and flips the edges around them; and again at those facets that changed and
    /// are still too large.
    fn settle(&mut self, mut corners: Vec<u32>) {
        for _ in 0..PASSES {
            corners.sort_unstable();
            corners.dedup();
            let before = self.changed.len();
            self.ease(&corners);
            let mut changed = self.changed.split_off(before);
            changed.sort_unstable();
            changed.dedup();
            let net = &self.net;
            let is_large = |t: &u32| net.excess(*t) > MENDED;
            let large = parallel::gather(changed.len(), FEW, |part| {
                changed[part].iter().copied().filter(is_large).collect()
            });
            corners.clear();
            corners.extend(large.into_iter().flat_map(|t| net.triangles[t as usize]));
            self.changed.extend(changed);
        }
    }

    fn ease(&mut self, corners: &[u32]) {
        let Self { proof, draft, net, changed, crowd, .. } = self;
        let cells = &draft.cells;
        let fine = |q: DVec2| cells.at(q) * (1.0 / cells.parts as f64);
        let better = |net: &EditableTriangulation<SurfaceVertex>, v: u32| {
            net.better_place(v, UNEASY, fine, |q| proof.prover.corner(q))
        };
        crowd.move_all(net, corners.to_vec(), better, |net, v| changed.extend(net.around(v)));
        let mut near: Vec<u32> = corners.iter().flat_map(|&v| net.around(v)).collect();
        near.sort_unstable();
        near.dedup();
        let sides = |t: u32| {
            let [a, b, c] = net.triangles[t as usize];
            [sorted(a, b), sorted(b, c), sorted(c, a)]
        };
        let mut edges: Vec<[u32; 2]> = near.into_iter().flat_map(sides).collect();
        edges.sort_unstable();
        edges.dedup();
        flip_all(net, edges, |t| changed.push(t));
    }

    /// Splits the longest edge of facet `t`, for the sake of facet `of`, by Rivara's rule: an edge
    /// is only split when it is the longest of both its facets, so that shapes stay what they were.
    /// Lengths are counted in one metric, lest the rule goes on for ever.
    fn bisect(&mut self, t: u32, of: u32, metric: &DMat2) -> Result<(), MeshError> {
        let edge = self.longest(t, metric);
        loop {
            let beyond = self.net.beside(edge).into_iter().flatten().find(|&u| u != t);
            match beyond {
                Some(u) if self.longest(u, metric) != edge => self.bisect(u, of, metric)?,
                _ => return self.split(edge, self.middle(edge), of),
            }
        }
    }

    /// The middle of an edge.
    fn middle(&self, edge: [u32; 2]) -> SurfaceVertex {
        let [p, q] = edge.map(|v| self.net.q(v));
        let is_rim = self.net.beside(edge)[1].is_none();
        let arc = if is_rim { self.draft.rim.arc_through(p, q) } else { None };
        let middle = (p + q) * 0.5;
        self.proof.prover.corner(arc.map_or(middle, |arc| arc.onto(middle)))
    }

    /// Splits an edge in its middle, for the sake of facet `of`.
    fn split(&mut self, edge: [u32; 2], middle: SurfaceVertex, of: u32) -> Result<(), MeshError> {
        if !splits(edge.map(|v| self.net.q(v))) {
            return Err(self.floor(of));
        }
        let v = self.net.split(edge, middle);
        self.changed.extend(self.net.around(v));
        Ok(())
    }

    /// The longest edge of a facet; no two edges are equally long.
    fn longest(&self, t: u32, metric: &DMat2) -> [u32; 2] {
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

    /// Facet `t` is not split.
    fn floor(&self, t: u32) -> MeshError {
        let FacetCheck { prover, limits } = self.proof;
        RefinementProbe::new(prover, *limits)
            .floor(self.net.triangles[t as usize].map(|v| self.net.q(v)))
    }
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Whether an edge is so long that its halves would keep their shape under rounding.
fn splits([a, b]: [DVec2; 2]) -> bool {
    const STEPS: f64 = 64.0;
    let step = ((a + b) * 0.5).abs().max_element() * f64::from(f32::EPSILON);
    a.distance(b) > STEPS * step
}
