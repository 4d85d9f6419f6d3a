//! Triangles of a plane region between polygons.

use super::DVec2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Why a region has no triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangulationFault {
    /// The corner near which it was found.
    pub near: usize,
    /// What was found.
    pub reason: String,
}

/// The Delaunay triangles, counter-clockwise, of the region within the first loop of corners and outside the others, which
/// lie apart inside it: so many of the `points` belong to each loop, one after the other. Corners are numbers of points.
///
/// # Errors
/// [`TriangulationFault`] when loops touch each other or themselves.
pub fn triangulate_loops(
    points: &[DVec2],
    sizes: &[usize],
) -> Result<Vec<[u32; 3]>, TriangulationFault> {
    let refuse = |near: usize, reason: String| TriangulationFault { near, reason };
    let mut edges: Vec<[usize; 2]> = Vec::with_capacity(points.len());
    for &count in sizes {
        let first = edges.len();
        edges.extend((0..count).map(|k| [first + k, first + (k + 1) % count]));
    }
    let mut crossing = None;
    let cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        points.iter().map(|p| Point2::new(p.x, p.y)).collect(),
        edges,
        |[from, _]| crossing = crossing.or(Some(from)),
    );
    let cdt = cdt.map_err(|error| refuse(0, error.to_string()))?;
    if cdt.num_vertices() < points.len() {
        // The first that is not where it was put is the one after the first left out.
        let moved = cdt.vertices().zip(points).position(|(found, p)| {
            let place = found.position();
            DVec2::new(place.x, place.y) != *p
        });
        let near = moved.unwrap_or(points.len() - 1);
        return Err(refuse(near, "two corners fall together".to_owned()));
    }
    if let Some(from) = crossing {
        return Err(refuse(from, "two edges cross".to_owned()));
    }

    // Outside and inside change at every loop.
    let mut inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    inside[cdt.outer_face().fix().index()] = Some(false);
    let mut next: Vec<_> = cdt.convex_hull().collect();
    while let Some(edge) = next.pop() {
        let (one, other) = (edge.face().fix().index(), edge.rev().face().fix().index());
        let (from, to, beyond) =
            if inside[one].is_some() { (one, other, edge.rev()) } else { (other, one, edge) };
        if inside[to].is_none() {
            inside[to] = inside[from].map(|known| known != edge.is_constraint_edge());
            next.extend([beyond.next().rev(), beyond.prev().rev()]);
        }
    }
    let triangles: Vec<[u32; 3]> = cdt
        .inner_faces()
        .filter(|face| inside[face.fix().index()] == Some(true))
        .map(|face| face.vertices().map(|v| v.fix().index() as u32))
        .collect();
    if triangles.len() + 2 != points.len() + 2 * (sizes.len() - 1) {
        return Err(refuse(0, "a corner lies on another loop".to_owned()));
    }
    Ok(triangles)
}
