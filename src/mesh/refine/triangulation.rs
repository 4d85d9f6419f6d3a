//! An editable triangulation: edges are flipped or split, vertices moved or collapsed, wherever that makes the largest
//! oversize smaller.
//!
//! Oversizes follow from what is known of the vertices (`vertex_model`): in the coarse mesh from the quadratic model,
//! in the fine mesh from the mirror's values at the vertices.

mod collapse;
mod moves;

use super::tuning::TUNING;
use super::vertex_model::VertexModel;
use crate::geom::{DVec2, turn};
use crate::mesh::sizing::field::SizingField;
use crate::mesh::sizing::local_model::LocalModel;

/// The number of no vertex and no place.
const NONE: u32 = u32::MAX;
/// Triangles around a vertex that is moved or collapsed, at most.
const MOST_AROUND: usize = 16;

/// The triangles (a, b, c) and (b, a, d).
struct TrianglePair {
    triangles: [u32; 2],
    corners: [u32; 4],
}

/// The link of an inner vertex: the edges opposite it.
struct VertexLink {
    edges: [[u32; 2]; MOST_AROUND],
    count: usize,
}

impl VertexLink {
    fn edges(&self) -> &[[u32; 2]] {
        &self.edges[..self.count]
    }
}

/// Triangles in the plane of the chart, with the triangles around each vertex.
pub(crate) struct EditableTriangulation<C = DVec2> {
    sizing: SizingField,
    /// Factor on the oversize of triangles.
    scale: f64,
    /// Vertices.
    pub vertices: Vec<C>,
    /// Triangles, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// The first place (three to a triangle) that names each vertex, and for each place the next that names the same.
    first: Vec<u32>,
    next: Vec<u32>,
}

impl<C: VertexModel> EditableTriangulation<C> {
    /// A triangulation whose triangles count as `scale` times smaller, in length, than they are.
    pub(crate) fn new(
        sizing: &SizingField,
        scale: f64,
        vertices: Vec<C>,
        triangles: Vec<[u32; 3]>,
    ) -> Self {
        let (first, next) = (vec![NONE; vertices.len()], vec![NONE; 3 * triangles.len()]);
        let scale = 1.0 / (scale * scale);
        let mut net = Self { sizing: sizing.clone(), scale, vertices, triangles, first, next };
        for t in 0..net.triangles.len() {
            net.attach(t);
        }
        net
    }

    /// Oversize of a triangle where `model` holds; infinite for one that is turned over.
    fn oversize_of(&self, model: &LocalModel, triangle: [&C; 3]) -> f64 {
        let [a, b, c] = triangle.map(C::q);
        if !(turn(a, b, c) > 0.0) {
            return f64::INFINITY;
        }
        C::oversize(&self.sizing, model, triangle) * self.scale
    }

    /// Oversize of a triangle by the model at its centroid.
    fn oversize_at_centroid(&self, triangle: [&C; 3]) -> f64 {
        let [a, b, c] = triangle.map(C::q);
        self.oversize_of(&self.sizing.at((a + b + c) / 3.0), triangle)
    }

    /// Oversize of triangle `t` by the model at its centroid.
    pub(crate) fn oversize(&self, t: u32) -> f64 {
        self.oversize_at_centroid(self.triangles[t as usize].map(|v| &self.vertices[v as usize]))
    }

    /// Position of vertex `v` in the chart, mm.
    pub(crate) fn q(&self, v: u32) -> DVec2 {
        self.vertices[v as usize].q()
    }

    /// The triangles around a vertex.
    pub(crate) fn around(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let mut at = self.first[v as usize];
        std::iter::from_fn(move || {
            let here = (at != NONE).then_some(at / 3);
            if at != NONE {
                at = self.next[at as usize];
            }
            here
        })
    }

    /// The triangles beside an edge: none, one, or two.
    pub(crate) fn beside(&self, [a, b]: [u32; 2]) -> [Option<u32>; 2] {
        let mut beside = [None; 2];
        for t in self.around(a).filter(|&t| self.triangles[t as usize].contains(&b)) {
            let free = usize::from(beside[0].is_some());
            beside[free] = Some(t);
        }
        beside
    }

    /// The ends of the edges that have a triangle on one side only, mm.
    pub(crate) fn boundary_edges(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let edges = self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let single = edges.filter(|&edge| self.beside(edge)[1].is_none());
        single.map(|edge| edge.map(|v| self.q(v)))
    }

    /// Whether flipping an edge makes the worse of its two triangles better.
    pub(crate) fn gains_by_flipping(&self, edge: [u32; 2]) -> bool {
        self.better_flipped(edge).is_some()
    }

    /// The triangles beside an edge, if flipping it makes the worse one better.
    fn better_flipped(&self, edge: [u32; 2]) -> Option<TrianglePair> {
        let pair = self.pair(edge)?;
        let [a, b, c, d] = pair.corners.map(|v| &self.vertices[v as usize]);
        let [pa, pb, pc, pd] = [a, b, c, d].map(C::q);
        let smallest = turn(pa, pd, pc).min(turn(pd, pb, pc));
        let [abc, bad] = [turn(pa, pb, pc), turn(pb, pa, pd)];
        if smallest < TUNING.sliver_area * (abc + bad) && smallest < abc.min(bad) {
            return None;
        }
        let model = self.sizing.at(0.25 * (pa + pb + pc + pd));
        let oversize = |t| {
            if C::MODEL_AT_CENTROID {
                self.oversize_at_centroid(t)
            } else {
                self.oversize_of(&model, t)
            }
        };
        let before = oversize([a, b, c]).max(oversize([b, a, d]));
        let most = TUNING.flip_gain * before;
        let first = oversize([a, d, c]);
        // The other triangle cannot make up for this one.
        if first >= most {
            return None;
        }
        (first.max(oversize([d, b, c])) < most).then_some(pair)
    }

    /// The two triangles beside an edge, if there are two and they make a convex quadrilateral.
    fn pair(&self, [a, b]: [u32; 2]) -> Option<TrianglePair> {
        let [Some(t), Some(u)] = self.beside([a, b]) else { return None };
        let triangles = if self.runs(t, a, b) { [t, u] } else { [u, t] };
        let [c, d] = triangles.map(|t| self.third(t, a, b));
        let [pa, pb, pc, pd] = [a, b, c, d].map(|v| self.q(v));
        let convex = turn(pa, pd, pc) > 0.0 && turn(pd, pb, pc) > 0.0;
        convex.then_some(TrianglePair { triangles, corners: [a, b, c, d] })
    }

    /// Flips the edge between a pair; its triangles.
    fn flip(
        &mut self,
        TrianglePair { triangles: [t, u], corners: [a, b, c, d] }: TrianglePair,
    ) -> [u32; 2] {
        self.detach(t as usize);
        self.detach(u as usize);
        self.triangles[t as usize] = [a, d, c];
        self.triangles[u as usize] = [d, b, c];
        self.attach(t as usize);
        self.attach(u as usize);
        [t, u]
    }

    /// Flips the given edges, and those around the ones that were flipped, until none gains; reports the triangles that
    /// changed.
    pub(crate) fn flip_from(&mut self, mut edges: Vec<[u32; 2]>, mut changed: impl FnMut(u32)) {
        let most = TUNING.edges_per_flip * edges.len() + 100;
        let mut seen = 0;
        while let Some(edge) = edges.pop() {
            seen += 1;
            if seen > most {
                break;
            }
            let Some(pair) = self.better_flipped(edge) else { continue };
            let [t, u] = self.flip(pair);
            changed(t);
            changed(u);
            let ([a, d, c], [_, b, _]) = (self.triangles[t as usize], self.triangles[u as usize]);
            edges.extend([[a, d], [d, b], [b, c], [c, a]]);
        }
    }

    /// The link of an inner vertex, if it has not too many edges.
    fn link(&self, v: u32) -> Option<VertexLink> {
        let mut link = VertexLink { edges: [[0; 2]; MOST_AROUND], count: 0 };
        let mut balance = 0i64;
        for t in self.around(v) {
            let triangle = self.triangles[t as usize];
            let k = triangle.iter().position(|&w| w == v).expect("a corner");
            let (b, c) = (triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
            *link.edges.get_mut(link.count)? = [b, c];
            link.count += 1;
            // Around an inner vertex every neighbour is once the next and once the last.
            balance +=
                (i64::from(b) + 1) * (i64::from(b) + 7) - (i64::from(c) + 1) * (i64::from(c) + 7);
        }
        (balance == 0).then_some(link)
    }

    /// The edge of triangle `t` whose split leaves the smallest oversize in the halves of the triangles beside it, and
    /// the new vertex, which `midpoint` makes of the edge.
    pub(crate) fn best_split(&self, t: u32, midpoint: impl Fn([u32; 2]) -> C) -> ([u32; 2], C) {
        let [a, b, c] = self.triangles[t as usize];
        let length = |[a, b]: [u32; 2]| self.q(a).distance(self.q(b));
        let edges = [[a, b], [b, c], [c, a]];
        let longest = edges.map(length).into_iter().fold(0.0, f64::max);
        let edges = edges.map(|edge| {
            let middle = midpoint(edge);
            let is_long = length(edge) > TUNING.short_edge * longest;
            let worst = if is_long { self.worst_half(edge, &middle) } else { f64::INFINITY };
            (worst, edge, middle)
        });
        let better = |x: (f64, [u32; 2], C), y: (f64, [u32; 2], C)| if y.0 < x.0 { y } else { x };
        let (_, edge, middle) = edges.into_iter().reduce(better).expect("three edges");
        (edge, middle)
    }

    /// The largest oversize of the halves into which the vertex `middle` splits the triangles beside an edge.
    fn worst_half(&self, [a, b]: [u32; 2], middle: &C) -> f64 {
        let model = self.sizing.at(middle.q());
        let halves = |u: u32| {
            let c = &self.vertices[self.third(u, a, b) as usize];
            let (a, b) = if self.runs(u, a, b) { (a, b) } else { (b, a) };
            let [a, b] = [a, b].map(|v| &self.vertices[v as usize]);
            self.oversize_of(&model, [a, middle, c]).max(self.oversize_of(&model, [middle, b, c]))
        };
        self.beside([a, b]).into_iter().flatten().map(halves).fold(0.0, f64::max)
    }

    /// Splits an edge at a new vertex; the number of the vertex.
    pub(crate) fn split(&mut self, [a, b]: [u32; 2], at: C) -> u32 {
        let m = self.vertices.len() as u32;
        self.vertices.push(at);
        self.first.push(NONE);
        for t in self.beside([a, b]).into_iter().flatten() {
            let (a, b) = if self.runs(t, a, b) { (a, b) } else { (b, a) };
            let c = self.third(t, a, b);
            self.detach(t as usize);
            self.triangles[t as usize] = [a, m, c];
            self.attach(t as usize);
            self.triangles.push([m, b, c]);
            self.next.extend([NONE; 3]);
            self.attach(self.triangles.len() - 1);
        }
        m
    }

    /// Whether triangle `t` runs from `a` to `b`.
    fn runs(&self, t: u32, a: u32, b: u32) -> bool {
        let triangle = self.triangles[t as usize];
        (0..3).any(|k| triangle[k] == a && triangle[(k + 1) % 3] == b)
    }

    /// The corner of triangle `t` that is neither `a` nor `b`.
    fn third(&self, t: u32, a: u32, b: u32) -> u32 {
        let [p, q, r] = self.triangles[t as usize];
        if p != a && p != b {
            p
        } else if q != a && q != b {
            q
        } else {
            r
        }
    }

    /// Enters triangle `t` in the lists of its vertices.
    fn attach(&mut self, t: usize) {
        for k in 0..3 {
            let v = self.triangles[t][k] as usize;
            self.next[3 * t + k] = self.first[v];
            self.first[v] = (3 * t + k) as u32;
        }
    }

    /// Takes triangle `t` out of the lists of its vertices.
    fn detach(&mut self, t: usize) {
        for k in 0..3 {
            let (v, place) = (self.triangles[t][k] as usize, (3 * t + k) as u32);
            let after = self.next[3 * t + k];
            if self.first[v] == place {
                self.first[v] = after;
                continue;
            }
            let mut at = self.first[v];
            while self.next[at as usize] != place {
                at = self.next[at as usize];
            }
            self.next[at as usize] = after;
        }
    }
}
