//! A triangulation that can be improved in places: edges flipped or split, corners moved, all by
//! the errors that follow from what is known of the corners (`corner`): of the coarse mesh those
//! of the quadratic model, of facets what the mirror does there.

mod collapse;

use super::vertex_model::VertexModel;
use crate::geom::{DVec2, turn};
use crate::mesh::sizing::field::{LocalModel, SizingField};
use glam::DMat2;

const NONE: u32 = u32::MAX;
/// What a flip must leave of the worse excess, and a move of the sum of powers.
const GAIN: f64 = 0.996;
const GAIN_BY_MOVING: f64 = 0.97;
/// Share of that gain from which on, when it is foreseen, a move is tried.
const HOPE: f64 = 0.5;
/// Trial steps of moves, in cells.
const STEP: f64 = 0.06;

/// Share of the area of two triangles, or of three around a corner, under which one of them is a
/// sliver: what is foreseen does not mind slivers that lie right, but rounding does.
const SLIGHT: f64 = 0.12;
/// Share of a triangle's longest edge under which an edge is not split.
const SHORT: f64 = 0.55;

/// Triangles (a, b, c) and (b, a, d).
struct TrianglePair {
    triangles: [u32; 2],
    corners: [u32; 4],
}

/// Triangles around a corner that is moved, at most.
const MOST_AROUND: usize = 16;

/// The edges opposite a corner.
struct VertexLink {
    edges: [[u32; 2]; MOST_AROUND],
    count: usize,
}

impl VertexLink {
    fn edges(&self) -> &[[u32; 2]] {
        &self.edges[..self.count]
    }
}

/// Triangles in the plane of the chart, and around each corner those that share it.
pub struct EditableTriangulation<'a, C = DVec2> {
    needs: &'a SizingField,
    /// What the excess of triangles is multiplied by.
    scale: f64,
    /// Corners.
    pub points: Vec<C>,
    /// Counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// The first place (three to a triangle) where each corner is named, and what follows each.
    first: Vec<u32>,
    next: Vec<u32>,
}

impl<'a, C: VertexModel> EditableTriangulation<'a, C> {
    /// A net of triangles that are `scale` times as large as their errors count.
    pub fn new(
        needs: &'a SizingField,
        scale: f64,
        points: Vec<C>,
        triangles: Vec<[u32; 3]>,
    ) -> Self {
        let (first, next) = (vec![NONE; points.len()], vec![NONE; 3 * triangles.len()]);
        let scale = 1.0 / (scale * scale);
        let mut net = Self { needs, scale, points, triangles, first, next };
        for t in 0..net.triangles.len() {
            net.link(t);
        }
        net
    }

    /// By how much a triangle exceeds what it may be, in areas.
    fn excess_of(&self, place: &LocalModel, triangle: [&C; 3]) -> f64 {
        let [a, b, c] = triangle.map(C::q);
        if !(turn(a, b, c) > 0.0) {
            return f64::INFINITY;
        }
        C::excess(self.needs, place, triangle) * self.scale
    }

    /// The same at its own place.
    fn own_excess(&self, triangle: [&C; 3]) -> f64 {
        let [a, b, c] = triangle.map(C::q);
        self.excess_of(&self.needs.at((a + b + c) / 3.0), triangle)
    }

    /// The same of triangle `t`.
    pub fn excess(&self, t: u32) -> f64 {
        self.own_excess(self.triangles[t as usize].map(|v| &self.points[v as usize]))
    }

    /// Where corner `v` is.
    pub fn q(&self, v: u32) -> DVec2 {
        self.points[v as usize].q()
    }

    /// The triangles around a corner.
    pub fn around(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
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
    pub fn beside(&self, [a, b]: [u32; 2]) -> [Option<u32>; 2] {
        let mut beside = [None; 2];
        for t in self.around(a).filter(|&t| self.triangles[t as usize].contains(&b)) {
            let free = usize::from(beside[0].is_some());
            beside[free] = Some(t);
        }
        beside
    }

    /// Whether flipping an edge makes the worse of its two triangles better.
    pub fn gains_by_flipping(&self, edge: [u32; 2]) -> bool {
        self.better_flipped(edge).is_some()
    }

    /// The triangles beside an edge, if flipping it makes the worse one better.
    fn better_flipped(&self, edge: [u32; 2]) -> Option<TrianglePair> {
        let pair = self.pair(edge)?;
        let [a, b, c, d] = pair.corners.map(|v| &self.points[v as usize]);
        let [pa, pb, pc, pd] = [a, b, c, d].map(C::q);
        let slightest = turn(pa, pd, pc).min(turn(pd, pb, pc));
        let [abc, bad] = [turn(pa, pb, pc), turn(pb, pa, pd)];
        if slightest < SLIGHT * (abc + bad) && slightest < abc.min(bad) {
            return None;
        }
        let place = self.needs.at(0.25 * (pa + pb + pc + pd));
        let excess = |t| if C::EACH { self.own_excess(t) } else { self.excess_of(&place, t) };
        let before = excess([a, b, c]).max(excess([b, a, d]));
        let after = excess([a, d, c]).max(excess([d, b, c]));
        (after < GAIN * before).then_some(pair)
    }

    /// The ends of the edges that have a triangle on one side only.
    pub fn sides(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let edges = self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let single = edges.filter(|&edge| self.beside(edge)[1].is_none());
        single.map(|edge| edge.map(|v| self.q(v)))
    }

    /// The two triangles beside an edge, if there are two and they make a convex quadrangle.
    fn pair(&self, [a, b]: [u32; 2]) -> Option<TrianglePair> {
        let [Some(t), Some(u)] = self.beside([a, b]) else { return None };
        let triangles = if self.runs(t, a, b) { [t, u] } else { [u, t] };
        let [c, d] = triangles.map(|t| self.third(t, a, b));
        let [pa, pb, pc, pd] = [a, b, c, d].map(|v| self.q(v));
        let convex = turn(pa, pd, pc) > 0.0 && turn(pd, pb, pc) > 0.0;
        convex.then_some(TrianglePair { triangles, corners: [a, b, c, d] })
    }

    /// Flips the edge between a pair.
    fn turn(
        &mut self,
        TrianglePair { triangles: [t, u], corners: [a, b, c, d] }: TrianglePair,
    ) -> [u32; 2] {
        self.unlink(t as usize);
        self.unlink(u as usize);
        self.triangles[t as usize] = [a, d, c];
        self.triangles[u as usize] = [d, b, c];
        self.link(t as usize);
        self.link(u as usize);
        [t, u]
    }

    /// Flips the given edges, and those around the ones that were, until none gains; the triangles
    /// that changed are reported.
    pub fn flip_all(&mut self, mut edges: Vec<[u32; 2]>, mut changed: impl FnMut(u32)) {
        // Every flip gains, but by how much depends on the place that is asked.
        let most = 20 * edges.len() + 100;
        let mut seen = 0;
        while let Some(edge) = edges.pop() {
            seen += 1;
            if seen > most {
                break;
            }
            let Some(pair) = self.better_flipped(edge) else { continue };
            let [t, u] = self.turn(pair);
            changed(t);
            changed(u);
            let ([a, d, c], [_, b, _]) = (self.triangles[t as usize], self.triangles[u as usize]);
            edges.extend([[a, d], [d, b], [b, c], [c, a]]);
        }
    }

    /// The edges opposite an inner corner, if there are not too many.
    fn ring(&self, v: u32) -> Option<VertexLink> {
        let mut ring = VertexLink { edges: [[0; 2]; MOST_AROUND], count: 0 };
        let mut balance = 0i64;
        for t in self.around(v) {
            let triangle = self.triangles[t as usize];
            let k = triangle.iter().position(|&w| w == v).expect("a corner");
            let (b, c) = (triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
            *ring.edges.get_mut(ring.count)? = [b, c];
            ring.count += 1;
            // Around an inner corner every neighbour is once the next and once the last.
            balance +=
                (i64::from(b) + 1) * (i64::from(b) + 7) - (i64::from(c) + 1) * (i64::from(c) + 7);
        }
        (balance == 0).then_some(ring)
    }

    /// Where an inner corner has smaller errors around it, if one of these is over `easy`. Steps are
    /// measured in `cell`s; `corner` tells what is known of a place.
    pub fn better_place(
        &self,
        v: u32,
        easy: f64,
        cell: impl FnOnce(DVec2) -> DMat2,
        corner: impl Fn(DVec2) -> C,
    ) -> Option<C> {
        let ring = self.ring(v)?;
        let ring = ring.edges();
        let own = &self.points[v as usize];
        let q = own.q();
        let place = self.needs.at(q);
        let each = |p: &C, edge: [u32; 2]| {
            let [b, c] = edge.map(|w| &self.points[w as usize]);
            self.excess_of(&place, [p, b, c])
        };
        let sees = self.needs.sees();
        // Nearly the largest, and smooth. In the image, errors of neighbours differ more.
        let squared = |x: f64| x * x;
        let sharp = |x: f64| if sees { squared(x) } else { x };
        let power = |e: f64| sharp(squared(squared(e)));
        let sum_of = |p: &C| ring.iter().map(|&edge| power(each(p, edge))).sum::<f64>();
        let near = own.beside(ring.iter().map(|&[b, _]| &self.points[b as usize]));
        let sum = |p: DVec2| sum_of(&near(p));
        let (mut worst, mut here) = (0.0, 0.0);
        for &edge in ring {
            let excess = each(own, edge);
            worst = f64::max(worst, excess);
            here += power(excess);
        }
        if !(worst > easy) {
            return None;
        }
        let cell = cell(q);
        let mut way = DVec2::ZERO;
        // What a quadratic model of the sum gains by the way.
        let mut gain = 0.0;
        for axis in [cell.x_axis, cell.y_axis] {
            let (up, down) = (sum(q + axis * STEP), sum(q - axis * STEP));
            let bend = up + down - 2.0 * here;
            let step = if bend > 0.0 { 0.5 * (down - up) / bend } else { (down - up).signum() };
            if step.is_finite() {
                way += axis * (STEP * step.clamp(-2.5, 2.5));
                gain += if bend > 0.0 { 0.25 * step * (down - up) } else { f64::INFINITY };
            }
        }
        if gain < HOPE * (1.0 - GAIN_BY_MOVING) * here {
            return None;
        }
        let areas = |p: DVec2| ring.iter().map(move |&[b, c]| turn(p, self.q(b), self.q(c)));
        let slightest = |p: DVec2| areas(p).fold(f64::INFINITY, f64::min);
        let least = (SLIGHT * areas(q).sum::<f64>() / 3.0).min(slightest(q));
        let to = [1.0, 0.5, 0.2].into_iter().map(|share| corner(q + way * share));
        let gains = |to: &C| sum_of(to) < GAIN_BY_MOVING * here && slightest(to.q()) >= least;
        { to }.find(gains)
    }

    /// The edge of a triangle whose split in the middle leaves the smallest excess in both halves and
    /// those of the triangle beyond, and the new corner.
    pub fn best_split(&self, t: u32, middle: impl Fn([u32; 2]) -> C) -> ([u32; 2], C) {
        let [a, b, c] = self.triangles[t as usize];
        let worst = |[a, b]: [u32; 2], middle: &C| {
            let place = self.needs.at(middle.q());
            let halves = |u: u32| {
                let c = &self.points[self.third(u, a, b) as usize];
                let (a, b) = if self.runs(u, a, b) { (a, b) } else { (b, a) };
                let [a, b] = [a, b].map(|v| &self.points[v as usize]);
                self.excess_of(&place, [a, middle, c]).max(self.excess_of(&place, [middle, b, c]))
            };
            self.beside([a, b]).into_iter().flatten().map(halves).fold(0.0, f64::max)
        };
        let length = |[a, b]: [u32; 2]| self.q(a).distance(self.q(b));
        let edges = [[a, b], [b, c], [c, a]];
        let longest = edges.map(length).into_iter().fold(0.0, f64::max);
        let edges = edges.map(|edge| {
            let middle = middle(edge);
            let long = length(edge) > SHORT * longest;
            (if long { worst(edge, &middle) } else { f64::INFINITY }, edge, middle)
        });
        let better = |x: (f64, [u32; 2], C), y: (f64, [u32; 2], C)| if y.0 < x.0 { y } else { x };
        let (_, edge, middle) = edges.into_iter().reduce(better).expect("three edges");
        (edge, middle)
    }

    /// Splits an edge at a new corner; the corner.
    pub fn split(&mut self, [a, b]: [u32; 2], at: C) -> u32 {
        let m = self.points.len() as u32;
        self.points.push(at);
        self.first.push(NONE);
        for t in self.beside([a, b]).into_iter().flatten() {
            let (a, b) = if self.runs(t, a, b) { (a, b) } else { (b, a) };
            let c = self.third(t, a, b);
            self.unlink(t as usize);
            self.triangles[t as usize] = [a, m, c];
            self.link(t as usize);
            self.triangles.push([m, b, c]);
            self.next.extend([NONE; 3]);
            self.link(self.triangles.len() - 1);
        }
        m
    }

    /// Whether triangle `t` runs from `a` to `b`.
    fn runs(&self, t: u32, a: u32, b: u32) -> bool {
        let triangle = self.triangles[t as usize];
        (0..3).any(|k| triangle[k] == a && triangle[(k + 1) % 3] == b)
    }

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

    fn link(&mut self, t: usize) {
        for k in 0..3 {
            let v = self.triangles[t][k] as usize;
            self.next[3 * t + k] = self.first[v];
            self.first[v] = (3 * t + k) as u32;
        }
    }

    fn unlink(&mut self, t: usize) {
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
