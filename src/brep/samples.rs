//! Facets on the faces of a body.

use super::face::TrimmedFace;
use crate::geom::TriMesh;

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
    // Numbers of the vertices; none where the place does not belong to the face.
    let place = |k: usize| face.place(patch, [share(k / across), share(k % across)]);
    let vertices: Vec<Option<u32>> = (0..across * across)
        .map(|k| {
            mesh.vertices.push(place(k)?);
            Some(mesh.vertices.len() as u32 - 1)
        })
        .collect();
    for k in (0..side * across).filter(|k| k % across < side) {
        let corners = [k, k + across, k + across + 1, k + 1].map(|corner| vertices[corner]);
        if let [Some(a), Some(b), Some(c), Some(d)] = corners {
            let pair = if face.same { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
            mesh.triangles.extend(pair);
        }
    }
}
