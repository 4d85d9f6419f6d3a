//! Uniform subdivision: every coarse triangle is cut into equal facets, along an arc where it has a side on one.

use super::boundary_arcs::{BoundaryArc, BoundaryArcs};
use super::triangulation::EditableTriangulation;
use crate::geom::DVec2;
use crate::parallel;

/// The fine mesh: facets before any of them is proven, with neighbours near each other in both lists.
pub(crate) struct FineMesh {
    /// Positions of its vertices in the chart, mm.
    pub points: Vec<DVec2>,
    /// Its facets, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
}

/// The number of no point and no triangle.
const NONE: u32 = u32::MAX;

/// Coarse triangles that a thread cuts at a time; fixed, so that results do not depend on the number of threads.
const CHUNK: usize = 256;

/// Cuts the sides of every coarse triangle into `parts`.
pub(crate) fn subdivide(
    coarse: &EditableTriangulation,
    arcs: &BoundaryArcs,
    parts: usize,
) -> FineMesh {
    let subdivider = Subdivider { coarse, arcs, parts, beyond: neighbours(coarse) };
    let patches = subdivider.number();
    let cut = |patches: &[CoarsePatch]| {
        let mut fine = FineMesh { points: Vec::new(), triangles: Vec::new() };
        patches.iter().for_each(|patch| subdivider.cut(patch, &mut fine));
        fine
    };
    let cut = parallel::map_chunks(&patches, CHUNK, cut);
    let (points, triangles): (Vec<_>, Vec<_>) =
        cut.into_iter().map(|fine| (fine.points, fine.triangles)).unzip();
    FineMesh { points: points.concat(), triangles: triangles.concat() }
}

/// The coarse triangles in bands of equal height, each from left to right.
fn in_rows(coarse: &EditableTriangulation) -> Vec<usize> {
    let centre =
        |t: usize| coarse.triangles[t].map(|v| coarse.vertices[v as usize]).iter().sum::<DVec2>();
    let centres: Vec<DVec2> = (0..coarse.triangles.len()).map(centre).collect();
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

/// A coarse triangle, and the numbers of the fine points in it.
struct CoarsePatch {
    /// Number of the coarse triangle.
    triangle: usize,
    /// Numbers of the points at its corners.
    corners: [u32; 3],
    /// Number of the first point inside each side; numbers run from the corner of the lesser number.
    sides: [u32; 3],
    /// Number of the first point inside it.
    inner: u32,
    /// Whether each corner is its own, and not one of a patch before it.
    new_corners: [bool; 3],
    /// Whether the points inside each side are its own.
    new_sides: [bool; 3],
}

/// A coarse triangulation that is cut.
struct Subdivider<'a> {
    coarse: &'a EditableTriangulation,
    arcs: &'a BoundaryArcs,
    parts: usize,
    /// For every coarse triangle the triangles beyond its sides.
    beyond: Vec<[u32; 3]>,
}

impl Subdivider<'_> {
    /// Numbers the fine points.
    fn number(&self) -> Vec<CoarsePatch> {
        let (coarse, m) = (self.coarse, self.parts as u32);
        let mut corners = vec![NONE; coarse.vertices.len()];
        let mut sides = vec![[NONE; 3]; coarse.triangles.len()];
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
            let triangle = coarse.triangles[t];
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
        in_rows(coarse).into_iter().map(&mut number).collect()
    }

    /// Adds the points and facets into which a patch is cut.
    fn cut(&self, patch: &CoarsePatch, fine: &mut FineMesh) {
        self.add_points(patch, &mut fine.points);
        self.add_facets(patch, &mut fine.triangles);
    }

    /// Adds the points of a patch that are not those of a patch before it.
    fn add_points(&self, patch: &CoarsePatch, points: &mut Vec<DVec2>) {
        let (m, corners) = (self.parts, self.coarse.triangles[patch.triangle]);
        let at = corners.map(|v| self.coarse.vertices[v as usize]);
        let arcs = [0, 1, 2].map(|e| self.arc(patch.triangle, e));
        points.extend((0..3).filter(|&k| patch.new_corners[k]).map(|k| at[k]));
        for e in (0..3).filter(|&e| patch.new_sides[e]) {
            let next = (e + 1) % 3;
            let (p, q) =
                if corners[e] < corners[next] { (at[e], at[next]) } else { (at[next], at[e]) };
            for k in 1..m {
                let place = p + (q - p) * (k as f64 / m as f64);
                points.push(arcs[e].map_or(place, |arc| arc.project(place)));
            }
        }
        let step = 1.0 / m as f64;
        for j in 1..m {
            for i in 1..m - j {
                points.push(inner_point(at, arcs, [i as f64 * step, j as f64 * step]));
            }
        }
    }

    /// Adds the facets of a patch.
    fn add_facets(&self, patch: &CoarsePatch, triangles: &mut Vec<[u32; 3]>) {
        let (m, corners) = (self.parts, self.coarse.triangles[patch.triangle]);
        let (own, starts, inner) = (patch.corners, patch.sides, patch.inner);
        // The k-th point inside the side from corner e, counted from that corner.
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
                triangles.push([a, b, c]);
                if i + j + 1 < m {
                    triangles.push([b, index(i + 1, j + 1), c]);
                }
            }
        }
    }

    /// The arc on which side `e` of triangle `t` lies, if it is on the boundary.
    fn arc(&self, t: usize, e: usize) -> Option<BoundaryArc> {
        let [a, b] = [e, (e + 1) % 3].map(|k| self.coarse.triangles[t][k] as usize);
        let is_boundary = self.beyond[t][e] == NONE;
        is_boundary.then(|| self.arcs.between(a, b).copied()).flatten()
    }
}

/// The point inside a triangle with corners `at` at the shares `u` and `v` of the ways to its second and third corner,
/// displaced as the sides on arcs are.
fn inner_point(at: [DVec2; 3], arcs: [Option<BoundaryArc>; 3], [u, v]: [f64; 2]) -> DVec2 {
    let mut p = at[0] + (at[1] - at[0]) * u + (at[2] - at[0]) * v;
    let shares = [1.0 - u - v, u, v];
    for (e, arc) in arcs.iter().enumerate() {
        if let Some(arc) = arc {
            let (from, to, off) = (e, (e + 1) % 3, shares[(e + 2) % 3]);
            let along = shares[to] / (shares[from] + shares[to]);
            let chord = at[from] + (at[to] - at[from]) * along;
            p += (arc.project(chord) - chord) * (1.0 - off) * (1.0 - off);
        }
    }
    p
}

/// For every triangle the triangles beyond its sides.
fn neighbours(coarse: &EditableTriangulation) -> Vec<[u32; 3]> {
    let beyond = |t: usize| {
        let [a, b, c] = coarse.triangles[t];
        [[a, b], [b, c], [c, a]].map(|side| {
            coarse.beside(side).into_iter().flatten().find(|&u| u as usize != t).unwrap_or(NONE)
        })
    };
    parallel::map(coarse.triangles.len(), CHUNK, beyond)
}
