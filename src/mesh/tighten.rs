//! The bound of a whole mesh, near the largest errors that its facets have.

use super::Limits;
use super::proof::{Bound, Prover, Vertex};
use super::tight::{Found, Kind, LOOSE, NOTHING};
use rayon::prelude::*;

/// Facets a thread looks at at a time; fixed, so that results do not depend on the thread count.
const CHUNK: usize = 512;
/// From so many facets on one in so many tells whether bounds are loose.
const MANY: usize = 32_768;
const SAMPLE: usize = 8;
/// Facets that are taken apart before what they reach decides about the others.
const BATCH: usize = 64;
/// Batches after which the bound is left as it is where taking facets apart takes long.
const SLOW_BATCHES: usize = 32;

/// What quick bounds say of some facets: of each error the largest bound, and what is reached.
#[derive(Debug, Clone, Copy, Default)]
struct Quick {
    bound: Bound,
    reached: [f64; 2],
}

/// The same of a chunk, and the bounds of every facet's chord and facet error.
struct Chunk {
    all: Quick,
    each: Vec<[f64; 2]>,
}

impl Quick {
    fn max(self, other: Self) -> Self {
        let reached = [0, 1].map(|k| self.reached[k].max(other.reached[k]));
        Self { bound: self.bound.max(other.bound), reached }
    }
}

impl Prover<'_> {
    /// Bounds over all `facets` (numbers of `vertices`), each of which keeps `limits` and, as is
    /// known already, `known`: within some per cent of errors that are reached, as far as facets
    /// can be taken apart for it.
    #[must_use]
    pub fn tighten(
        &self,
        vertices: &[Vertex],
        facets: &[[u32; 3]],
        limits: &Limits,
        known: Bound,
    ) -> Bound {
        let mesh = Mesh { prover: self, vertices, facets };
        if facets.len() > MANY {
            // Fine meshes: what is known is near what some of them reach.
            let some = |k: usize| mesh.quick(&facets[SAMPLE * k]);
            let some = (0..facets.len() / SAMPLE).into_par_iter().with_min_len(CHUNK).map(some);
            let reached = some.reduce(Quick::default, Quick::max).reached;
            let near = |kind: Kind| {
                let (bound, reached) = (kind.of(&known), kind.of_both(reached));
                self.is_near(&Found { bound, reached })
            };
            if near(Kind::Chord) && near(Kind::Facet) {
                return known;
            }
        }
        let chunks: Vec<Chunk> = facets.par_chunks(CHUNK).map(|chunk| mesh.chunk(chunk)).collect();
        let all = chunks.iter().map(|chunk| chunk.all).fold(Quick::default(), Quick::max);
        let mut bound = all.bound;
        for kind in [Kind::Chord, Kind::Facet] {
            let (quick, reached) =
                (kind.of(&bound).min(kind.of(&known)), kind.of_both(all.reached));
            let ceiling = kind.limit(limits).unwrap_or(f64::INFINITY);
            let near = self.is_near(&Found { bound: quick, reached });
            let found = if near { quick } else { mesh.largest(kind, &chunks, reached, ceiling) };
            kind.set(&mut bound, found);
        }
        bound
    }
}

struct Mesh<'a> {
    prover: &'a Prover<'a>,
    vertices: &'a [Vertex],
    facets: &'a [[u32; 3]],
}

impl<'a> Mesh<'a> {
    fn corners(&self, facet: &[u32; 3]) -> [&'a Vertex; 3] {
        facet.map(|v| &self.vertices[v as usize])
    }

    fn quick(&self, facet: &[u32; 3]) -> Quick {
        let (bound, reached) = self.prover.estimate(self.corners(facet));
        Quick { bound, reached }
    }

    fn chunk(&self, facets: &[[u32; 3]]) -> Chunk {
        let mut all = Quick::default();
        let one = |facet| {
            let quick = self.quick(facet);
            all = all.max(quick);
            [quick.bound.chord_mm, quick.bound.facet_mm]
        };
        let each = facets.iter().map(one).collect();
        Chunk { all, each }
    }

    /// A bound of one error, of which `reached` is reached: the facets whose quick bounds are well
    /// over that are taken apart, the largest first.
    fn largest(&self, kind: Kind, chunks: &[Chunk], mut reached: f64, ceiling: f64) -> f64 {
        let least = NOTHING * self.prover.mirror().outline.bounds().size().max_element();
        let enough = |reached: f64| ((1.0 + LOOSE) * reached).max(least).min(ceiling);
        let is_loose = |bound: f64| !(bound <= enough(reached));
        let mut rest = 0.0f64;
        let mut loose: Vec<(f64, usize)> = Vec::new();
        for (k, Chunk { all, each }) in chunks.iter().enumerate() {
            if !is_loose(kind.of(&all.bound)) {
                rest = rest.max(kind.of(&all.bound));
                continue;
            }
            for (i, &both) in each.iter().enumerate() {
                let bound = kind.of_both(both);
                if is_loose(bound) {
                    let bound = if bound.is_nan() { f64::INFINITY } else { bound };
                    loose.push((bound, k * CHUNK + i));
                } else {
                    rest = rest.max(bound);
                }
            }
        }
        loose.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let slow = kind == Kind::Facet && !self.prover.plain;
        let most = if slow { SLOW_BATCHES } else { usize::MAX };
        for (k, batch) in loose.chunks(BATCH).enumerate() {
            let goal = enough(reached).max(rest);
            if batch[0].0 <= goal || k == most {
                return rest.max(batch[0].0).min(ceiling);
            }
            let look = |&(quick, t): &(f64, usize)| {
                let near = |found: &Found| {
                    found.bound <= goal || (self.prover.is_near(found) && found.bound <= ceiling)
                };
                self.prover.search(self.corners(&self.facets[t]), kind, quick, near)
            };
            let found: Vec<Found> = batch.par_iter().map(look).collect();
            for one in found {
                (rest, reached) = (rest.max(one.bound), reached.max(one.reached));
            }
        }
        rest
    }
}
