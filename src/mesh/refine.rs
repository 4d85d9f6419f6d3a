//! Triangulation and repair: spade joins the points, the proof is asked of every facet, and the
//! facets that fail get a point on their longest edge until none fails.

use super::lattice::Proposal;
use super::proof::{Bound, Prover, Vertex};
use super::rim::Rims;
use super::{Limits, MOST_FACETS, MeshError};
use crate::geom::{DVec2, TriMesh};
use rayon::prelude::*;
use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, Point2, Triangulation};
use std::collections::HashSet;

type Plane = DelaunayTriangulation<Point2<f64>>;

/// Facets a thread proves at a time; fixed, so that results do not depend on the thread count.
const CHUNK: usize = 4096;

/// Most points for every proposed one, and some for small proposals: past these, splitting does not
/// bring the bounds down. Proposals that suit their mirror need a few in a hundred more.
const MOST_GROWTH: usize = 2;
const FEW: usize = 100_000;

/// The Delaunay triangulation of a proposal, refined until every facet keeps `limits`, with the
/// bound reached.
///
/// Inserting a point into a Delaunay triangulation only makes facets that have it as a corner, so
/// each round proves just those, and any that failed and are still there. The face holds `copies`
/// of this mesh.
pub fn triangulate(
    prover: &Prover,
    proposal: Proposal,
    copies: usize,
    limits: Limits,
) -> Result<(TriMesh, Bound), MeshError> {
    let points = proposal.points;
    let (plane, mut vertices) = rayon::join(|| delaunay(&points), || on_rows(prover, &points));
    let mut plane = plane?;
    let mut rims = Rims::new(&proposal.rims, &points);
    let (mut bound, mut proven) = (Bound::default(), 0);
    let mut failing = HashSet::new();
    let most = MOST_GROWTH * points.len() + FEW;
    loop {
        close_hole(prover, &mut plane, &mut vertices, &mut rims)?;
        let triangles: Vec<[u32; 3]> = plane
            .inner_faces()
            .map(|f| f.vertices().map(|v| v.index() as u32))
            .filter(|facet| rims.keeps(facet, |v| vertices[v as usize].q))
            .collect();
        let facets = (triangles.len() * copies) as f64;
        if facets > MOST_FACETS {
            return Err(MeshError::TooMany { facets, most: MOST_FACETS });
        }
        let is_new = |t: &[u32; 3]| {
            t.iter().any(|&v| v as usize >= proven) || failing.contains(&least_first(*t))
        };
        let (worst, failed) = prove(prover, &vertices, &triangles, is_new, limits);
        bound = bound.max(worst);
        if failed.is_empty() {
            let bound = prover.tighten(&vertices, &triangles, &limits, bound);
            let vertices = vertices.into_iter().map(|v| v.at).collect();
            return Ok((TriMesh { vertices, triangles: in_rows(triangles) }, bound));
        }
        let stays = failed.iter().find(|&&t| failing.contains(&least_first(triangles[t])));
        let grown = failed.first().filter(|_| vertices.len() > most);
        if let Some(&t) = stays.or(grown) {
            // Splitting does not help, and will not.
            return Err(floor(prover, &triangles[t].map(|v| vertices[v as usize])));
        }
        failing = failed.iter().map(|&t| least_first(triangles[t])).collect();
        proven = vertices.len();
        for t in failed {
            let corners = triangles[t];
            let facet = corners.map(|v| vertices[v as usize]);
            if limits.facet_mm.is_some() && prover.sees_the_pole(&facet) {
                return Err(MeshError::Pole { at: facet[0].q });
            }
            let [i, j] = longest_edge(&facet);
            let (a, b) = (facet[i].q, facet[j].q);
            let rim = rims.joining(corners[i], corners[j]);
            let point = match rim {
                Some(rim) => splits(a, b).then(|| rims.arc(rim).between(a, b)),
                None => middle(prover, a, b),
            };
            let Some(point) = point else { return Err(floor(prover, &facet)) };
            let near = FixedVertexHandle::from_index(corners[0] as usize);
            if insert(&mut plane, point, near)? == vertices.len() {
                vertices.push(prover.vertex(point, prover.mirror().surface.at(point)));
                rims.push(point, rim);
            }
        }
        rims.settle();
    }
}

/// Joins the neighbours on the rim of a hole by edges: where the triangulation does without one,
/// a point half-way between the two brings it back.
fn close_hole(
    prover: &Prover,
    plane: &mut Plane,
    vertices: &mut Vec<Vertex>,
    rims: &mut Rims,
) -> Result<(), MeshError> {
    loop {
        let handle = |v: u32| FixedVertexHandle::from_index(v as usize);
        let is_lost =
            |&[a, b]: &[u32; 2]| plane.get_edge_from_neighbors(handle(a), handle(b)).is_none();
        let lost: Vec<[u32; 2]> = rims.hole().filter(is_lost).collect();
        if lost.is_empty() {
            return Ok(());
        }
        for [a, b] in lost {
            let (p, q) = (vertices[a as usize], vertices[b as usize]);
            if !splits(p.q, q.q) {
                return Err(floor(prover, &[p, q, q]));
            }
            let rim = rims.joining(a, b);
            let point = rims.arc(rim.expect("neighbours")).between(p.q, q.q);
            if insert(plane, point, handle(a))? == vertices.len() {
                vertices.push(prover.vertex(point, prover.mirror().surface.at(point)));
                rims.push(point, rim);
            }
        }
        rims.settle();
    }
}

/// The facets in the order of their first vertices. spade's order jumps about the plane; every
/// later stage, and every reader of the file, is faster when neighbours are stored near each other.
fn in_rows(triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    let mut triangles: Vec<_> = triangles.into_iter().map(least_first).collect();
    triangles.par_sort_unstable();
    triangles
}

/// The same facet, beginning with its least vertex.
fn least_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Evaluates the mirror at points that come in rows of equal Y.
fn on_rows(prover: &Prover, points: &[DVec2]) -> Vec<Vertex> {
    let rows: Vec<&[DVec2]> = points.chunk_by(|a, b| a.y == b.y).collect();
    let evaluate = |row: &&[DVec2]| {
        let surface = prover.mirror().surface.row(row[0].y);
        row.iter().map(|&q| prover.vertex(q, surface.at(q.x))).collect::<Vec<_>>()
    };
    rows.par_iter().map(evaluate).collect::<Vec<_>>().concat()
}

fn delaunay(points: &[DVec2]) -> Result<Plane, MeshError> {
    let points = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    DelaunayTriangulation::bulk_load_stable(points).map_err(|reason| MeshError::Point {
        x: f64::NAN,
        y: f64::NAN,
        reason: reason.to_string(),
    })
}

fn insert(plane: &mut Plane, p: DVec2, near: FixedVertexHandle) -> Result<usize, MeshError> {
    match plane.insert_with_hint(Point2::new(p.x, p.y), near) {
        Ok(vertex) => Ok(vertex.index()),
        Err(reason) => Err(MeshError::Point { x: p.x, y: p.y, reason: reason.to_string() }),
    }
}

/// Of the facets that `is_new` picks: the worst bound of those that keep the limits, and the
/// others in ascending order.
fn prove(
    prover: &Prover,
    vertices: &[Vertex],
    triangles: &[[u32; 3]],
    is_new: impl Fn(&[u32; 3]) -> bool + Sync,
    limits: Limits,
) -> (Bound, Vec<usize>) {
    let chunk = |(chunk, facets): (usize, &[[u32; 3]])| {
        let (mut worst, mut failed) = (Bound::default(), Vec::new());
        for (k, facet) in facets.iter().enumerate().filter(|(_, facet)| is_new(facet)) {
            let corners = facet.map(|v| &vertices[v as usize]);
            let mut bound = prover.bound(corners);
            if !limits.hold(&bound) {
                bound = prover.settle(corners, &limits);
            }
            if limits.hold(&bound) {
                worst = worst.max(bound);
            } else {
                failed.push(chunk * CHUNK + k);
            }
        }
        (worst, failed)
    };
    let chunks: Vec<_> = triangles.par_chunks(CHUNK).enumerate().map(chunk).collect();
    chunks.into_iter().fold((Bound::default(), Vec::new()), |(worst, mut all), (bound, failed)| {
        all.extend(failed);
        (worst.max(bound), all)
    })
}

/// Whether an edge is so long that its halves would keep their shape under rounding.
fn splits(a: DVec2, b: DVec2) -> bool {
    const STEPS: f64 = 64.0;
    let step = ((a + b) * 0.5).abs().max_element() * f64::from(f32::EPSILON);
    a.distance(b) > STEPS * step
}

/// The middle of an edge; under parallel rays on the grid of single precision (so that a point on
/// a straight rim stays on it).
fn middle(prover: &Prover, a: DVec2, b: DVec2) -> Option<DVec2> {
    let middle = (a + b) * 0.5;
    let parallel = prover.mirror().chart.vergence == 0.0;
    splits(a, b).then(|| if parallel { middle.as_vec2().as_dvec2() } else { middle })
}

/// Which two corners are farthest apart.
fn longest_edge(facet: &[Vertex; 3]) -> [usize; 2] {
    let length = |[i, j]: [usize; 2]| facet[i].q.distance(facet[j].q);
    let longer = |a: [usize; 2], b: [usize; 2]| if length(b) > length(a) { b } else { a };
    longer(longer([0, 1], [1, 2]), [2, 0])
}

/// No facet as small as this one can do better.
fn floor(prover: &Prover, facet: &[Vertex; 3]) -> MeshError {
    let [a, b] = longest_edge(facet).map(|k| facet[k].q);
    MeshError::Floor {
        at: (a + b) * 0.5,
        size_mm: a.distance(b),
        bound: prover.bound(facet.each_ref()),
    }
}
