//! Facets on the faces of a body.

use super::face::TrimmedFace;
use crate::geom::{DVec3, TriMesh};

/// Facets of a body, about.
const FACETS: f64 = 20_000.0;
/// Facets along each side of a patch or a plane, at the least and at most.
const SIDE: [f64; 2] = [2.0, 48.0];

/// Facets on `faces` whose corners belong to them.
pub(super) fn of_faces(faces: &[TrimmedFace]) -> TriMesh {
    let patches: usize = faces.iter().map(|face| face.patches.len().max(1)).sum();
    let side = (FACETS / (2.0 * patches as f64)).sqrt().clamp(SIDE[0], SIDE[1]) as usize;
    let mut mesh = TriMesh::default();
    for face in faces {
        for patch in 0..face.patches.len().max(1) {
            add(&mut mesh, face, patch, side);
        }
    }
    mesh
}

/// Adds `side` x `side` pairs of facets on a patch of a face, or on all of a plane one.
fn add(mesh: &mut TriMesh, face: &TrimmedFace, patch: usize, side: usize) {
    let share = |k: usize| k as f64 / side as f64;
    let across = side + 1;
    let places: Vec<Option<DVec3>> = (0..across * across)
        .map(|k| face.place(patch, [share(k / across), share(k % across)]))
        .collect();
    let first = mesh.vertices.len() as u32;
    // (Places beyond the face are vertices of no facet.)
    mesh.vertices.extend(places.iter().map(|place| place.unwrap_or(DVec3::ZERO)));
    for k in (0..side * across).filter(|k| k % across < side) {
        let corners = [k, k + across, k + across + 1, k + 1];
        if corners.iter().all(|&corner| places[corner].is_some()) {
            let [a, b, c, d] = corners.map(|corner| first + corner as u32);
            let pair = if face.same { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
            mesh.triangles.extend(pair);
        }
    }
}
