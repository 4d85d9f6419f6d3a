//! The fine mesh: every coarse triangle cut into equal parts, along the arcs where it has a side
//! on one.

use super::draft::Draft;
use super::net::Net;
use super::rim::{Arc, Rim};
use crate::geom::DVec2;

/// A triangulation of points, neighbours near each other in both lists.
pub struct Fine {
    /// Corners.
    pub points: Vec<DVec2>,
    /// Counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
}

const NONE: u32 = u32::MAX;

/// Cuts the sides of every triangle of `draft` into its number of parts; points are rounded by
/// `round`.
pub fn subdivide(draft: &Draft, round: impl Fn(DVec2) -> DVec2) -> Fine {
    let (plane, parts) = (&draft.net, draft.cells.parts);
    let count = plane.triangles.len();
    let mut cutter = Cutter {
        plane,
        rim: &draft.rim,
        parts,
        corners: vec![NONE; plane.points.len()],
        sides: vec![[NONE; 3]; count],
        beyond: neighbours(&plane.triangles),
        fine: Fine {
            points: Vec::with_capacity(count * parts * parts / 2 + plane.points.len()),
            triangles: Vec::with_capacity(count * parts * parts),
        },
    };
    for t in in_rows(plane) {
        cutter.cut(t);
    }
    for point in &mut cutter.fine.points {
        *point = round(*point);
    }
    cutter.fine
}

/// Triangles in bands of their height, each from left to right.
fn in_rows(plane: &Net) -> Vec<usize> {
    let centre =
        |t: usize| plane.triangles[t].map(|v| plane.points[v as usize]).iter().sum::<DVec2>();
    let centres: Vec<DVec2> = (0..plane.triangles.len()).map(centre).collect();
    let lo = centres.iter().fold(DVec2::INFINITY, |lo, &c| lo.min(c));
    let hi = centres.iter().fold(DVec2::NEG_INFINITY, |hi, &c| hi.max(c));
    let bands = (0.5 * (centres.len() as f64).sqrt()).ceil();
    let band = |c: DVec2| ((c.y - lo.y) / (hi.y - lo.y).max(f64::MIN_POSITIVE) * bands).floor();
    let mut order: Vec<usize> = (0..centres.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (centres[a], centres[b]);
        band(a).total_cmp(&band(b)).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y))
    });
    order
}

struct Cutter<'a> {
    plane: &'a Net<'a>,
    rim: &'a Rim,
    parts: usize,
    /// The fine point at each coarse one.
    corners: Vec<u32>,
    /// The first of the fine points inside each side; they run from the side's lesser corner.
    sides: Vec<[u32; 3]>,
    /// For every coarse triangle those beyond its sides.
    beyond: Vec<[u32; 3]>,
    fine: Fine,
}

impl Cutter<'_> {
    fn cut(&mut self, t: usize) {
        let (m, corners) = (self.parts, self.plane.triangles[t]);
        let at = corners.map(|v| self.plane.points[v as usize]);
        let own = corners.map(|v| self.corner(v as usize));
        let starts = [0, 1, 2].map(|e| self.side(t, e));
        let arcs = [0, 1, 2].map(|e| self.arc(t, e));
        let inner = self.fine.points.len() as u32;
        let step = 1.0 / m as f64;
        for j in 1..m {
            for i in 1..m - j {
                let (u, v) = (i as f64 * step, j as f64 * step);
                let mut p = at[0] + (at[1] - at[0]) * u + (at[2] - at[0]) * v;
                let shares = [1.0 - u - v, u, v];
                for (e, arc) in arcs.iter().enumerate() {
                    if let Some(arc) = arc {
                        let (from, to, off) = (e, (e + 1) % 3, shares[(e + 2) % 3]);
                        let along = shares[to] / (shares[from] + shares[to]);
                        let chord = at[from] + (at[to] - at[from]) * along;
                        p += (arc.onto(chord) - chord) * (1.0 - off) * (1.0 - off);
                    }
                }
                self.push(p);
            }
        }
        // Of the side from corner e the k-th inner point, counted from that corner.
        let side = |e: usize, k: usize| {
            let forward = corners[e] < corners[(e + 1) % 3];
            starts[e] + if forward { k - 1 } else { m - 1 - k } as u32
        };
        let index = |i: usize, j: usize| match (i, j) {
            (0, 0) => own[0],
            (i, 0) if i == m => own[1],
            (0, j) if j == m => own[2],
            (i, 0) => side(0, i),
            (0, j) => side(2, m - j),
            (i, j) if i + j == m => side(1, j),
            // Row j is preceded by rows of m - 2, m - 3, ... points.
            (i, j) => inner + ((j - 1) * (2 * m - 2 - j) / 2 + i - 1) as u32,
        };
        for j in 0..m {
            for i in 0..m - j {
                let (a, b, c) = (index(i, j), index(i + 1, j), index(i, j + 1));
                self.fine.triangles.push([a, b, c]);
                if i + j + 1 < m {
                    self.fine.triangles.push([b, index(i + 1, j + 1), c]);
                }
            }
        }
    }

    fn push(&mut self, p: DVec2) -> u32 {
        self.fine.points.push(p);
        self.fine.points.len() as u32 - 1
    }

    fn corner(&mut self, v: usize) -> u32 {
        if self.corners[v] == NONE {
            self.corners[v] = self.push(self.plane.points[v]);
        }
        self.corners[v]
    }

    fn arc(&self, t: usize, e: usize) -> Option<Arc> {
        let [a, b] = [e, (e + 1) % 3].map(|k| self.plane.triangles[t][k] as usize);
        let is_rim = self.beyond[t][e] == NONE;
        is_rim.then(|| self.rim.arc(a, b).copied()).flatten()
    }

    /// The first inner point of a side, from its lesser corner.
    fn side(&mut self, t: usize, e: usize) -> u32 {
        if self.sides[t][e] == NONE {
            let [a, b] = [e, (e + 1) % 3].map(|k| self.plane.triangles[t][k]);
            let [p, q] = [a.min(b), a.max(b)].map(|v| self.plane.points[v as usize]);
            let arc = self.arc(t, e);
            let first = self.fine.points.len() as u32;
            for k in 1..self.parts {
                let at = p + (q - p) * (k as f64 / self.parts as f64);
                self.push(arc.map_or(at, |arc| arc.onto(at)));
            }
            self.sides[t][e] = first;
            let u = self.beyond[t][e];
            if u != NONE {
                let u = u as usize;
                let back = (0..3).find(|&g| self.beyond[u][g] == t as u32).expect("neighbour");
                self.sides[u][back] = first;
            }
        }
        self.sides[t][e]
    }
}

/// For every triangle those beyond its edges.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (k, t) in triangles.iter().enumerate() {
        for e in 0..3 {
            let (a, b) = (t[e], t[(e + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], k as u32, e as u8));
        }
    }
    edges.sort_unstable();
    let mut beyond = vec![[NONE; 3]; triangles.len()];
    for pair in edges.windows(2) {
        if pair[0].0 == pair[1].0 {
            beyond[pair[0].1 as usize][pair[0].2 as usize] = pair[1].1;
            beyond[pair[1].1 as usize][pair[1].2 as usize] = pair[0].1;
        }
    }
    beyond
}
