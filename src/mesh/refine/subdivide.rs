//! The fine mesh: every coarse triangle cut into equal parts, along the arcs where it has a side
//! on one.

use super::triangulation::EditableTriangulation;
use crate::geom::DVec2;
use crate::mesh::coarse::boundary_nodes::{Arc, BoundaryNodes};
use crate::mesh::coarse::coarse_mesh::CoarseMesh;
use crate::parallel;

/// A triangulation of points, neighbours near each other in both lists.
pub struct FineMesh {
    /// Corners.
    pub points: Vec<DVec2>,
    /// Counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
}

const NONE: u32 = u32::MAX;

/// Coarse triangles that a thread cuts at a time.
const CHUNK: usize = 256;

/// Cuts the sides of every triangle of `draft` into its number of parts.
pub fn subdivide(draft: &CoarseMesh) -> FineMesh {
    let (plane, parts) = (&draft.net, draft.cells.parts);
    let cutter = Subdivider { plane, rim: &draft.rim, parts, beyond: neighbours(plane) };
    let pieces = cutter.number();
    let cut = |pieces: &[CoarsePatch]| {
        let mut fine = FineMesh { points: Vec::new(), triangles: Vec::new() };
        pieces.iter().for_each(|piece| cutter.cut(piece, &mut fine));
        fine
    };
    let cut = parallel::map_chunks(&pieces, CHUNK, cut);
    let (points, triangles): (Vec<_>, Vec<_>) =
        cut.into_iter().map(|fine| (fine.points, fine.triangles)).unzip();
    FineMesh { points: points.concat(), triangles: triangles.concat() }
}

/// Triangles in bands of their height, each from left to right.
fn in_rows(plane: &EditableTriangulation) -> Vec<usize> {
    let centre =
        |t: usize| plane.triangles[t].map(|v| plane.points[v as usize]).iter().sum::<DVec2>();
    let centres: Vec<DVec2> = (0..plane.triangles.len()).map(centre).collect();
    let lo = centres.iter().fold(DVec2::INFINITY, |lo, &c| lo.min(c));
    let hi = centres.iter().fold(DVec2::NEG_INFINITY, |hi, &c| hi.max(c));
    let bands = (0.5 * (centres.len() as f64).sqrt()).ceil();
    let band = |c: DVec2| ((c.y - lo.y) / (hi.y - lo.y).max(f64::MIN_POSITIVE) * bands) as u32;
    let mut order: Vec<(u32, f64, usize)> =
        centres.iter().enumerate().map(|(t, &c)| (band(c), c.x, t)).collect();
    parallel::sort_unstable_by(&mut order, |a, b| {
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2))
    });
    order.into_iter().map(|(_, _, t)| t).collect()
}

/// A coarse triangle, and which fine points are its.
struct CoarsePatch {
    triangle: usize,
    /// At its corners.
    corners: [u32; 3],
    /// The first inside each side; they run from the side's lesser corner.
    sides: [u32; 3],
    /// The first inside it.
    inner: u32,
    /// Which of these come with it, and not with a piece before it.
    new_corners: [bool; 3],
    new_sides: [bool; 3],
}

struct Subdivider<'a> {
    plane: &'a EditableTriangulation<'a>,
    rim: &'a BoundaryNodes,
    parts: usize,
    /// For every coarse triangle those beyond its sides.
    beyond: Vec<[u32; 3]>,
}

impl Subdivider<'_> {
    /// Numbers the fine points.
    fn number(&self) -> Vec<CoarsePatch> {
        let (plane, m) = (self.plane, self.parts as u32);
        let mut corners = vec![NONE; plane.points.len()];
        let mut sides = vec![[NONE; 3]; plane.triangles.len()];
        let mut count = 0;
        let mut take = |known: &mut u32, many: u32| {
            let is_new = *known == NONE;
            if is_new {
                *known = count;
                count += many;
            }
            is_new
        };
        let mut number = |t: usize| {
            let triangle = plane.triangles[t];
            let new_corners = triangle.map(|v| take(&mut corners[v as usize], 1));
            let new_sides = [0, 1, 2].map(|e| {
                let is_new = take(&mut sides[t][e], m - 1);
                let u = self.beyond[t][e] as usize;
                if is_new && u != NONE as usize {
                    let back = (0..3).find(|&g| self.beyond[u][g] == t as u32).expect("neighbour");
                    sides[u][back] = sides[t][e];
                }
                is_new
            });
            let mut inner = NONE;
            take(&mut inner, (m - 1) * m.saturating_sub(2) / 2);
            let corners = triangle.map(|v| corners[v as usize]);
            CoarsePatch { triangle: t, corners, sides: sides[t], inner, new_corners, new_sides }
        };
        in_rows(plane).into_iter().map(&mut number).collect()
    }

    /// Adds what a piece is cut into.
    fn cut(&self, piece: &CoarsePatch, fine: &mut FineMesh) {
        let (m, corners) = (self.parts, self.plane.triangles[piece.triangle]);
        let (own, starts, inner) = (piece.corners, piece.sides, piece.inner);
        let at = corners.map(|v| self.plane.points[v as usize]);
        let arcs = [0, 1, 2].map(|e| self.arc(piece.triangle, e));
        fine.points.extend((0..3).filter(|&k| piece.new_corners[k]).map(|k| at[k]));
        for e in (0..3).filter(|&e| piece.new_sides[e]) {
            let next = (e + 1) % 3;
            let (p, q) =
                if corners[e] < corners[next] { (at[e], at[next]) } else { (at[next], at[e]) };
            for k in 1..m {
                let place = p + (q - p) * (k as f64 / m as f64);
                fine.points.push(arcs[e].map_or(place, |arc| arc.onto(place)));
            }
        }
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
                fine.points.push(p);
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
                fine.triangles.push([a, b, c]);
                if i + j + 1 < m {
                    fine.triangles.push([b, index(i + 1, j + 1), c]);
                }
            }
        }
    }

    fn arc(&self, t: usize, e: usize) -> Option<Arc> {
        let [a, b] = [e, (e + 1) % 3].map(|k| self.plane.triangles[t][k] as usize);
        let is_rim = self.beyond[t][e] == NONE;
        is_rim.then(|| self.rim.arc(a, b).copied()).flatten()
    }
}

/// For every triangle those beyond its sides.
fn neighbours(plane: &EditableTriangulation) -> Vec<[u32; 3]> {
    let beyond = |t: usize| {
        let [a, b, c] = plane.triangles[t];
        [[a, b], [b, c], [c, a]].map(|side| {
            plane.beside(side).into_iter().flatten().find(|&u| u as usize != t).unwrap_or(NONE)
        })
    };
    parallel::map(plane.triangles.len(), CHUNK, beyond)
}
