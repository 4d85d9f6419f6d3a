//! The rim of a face as cut: in the plan the mirror's own, which the camera sees elsewhere as far as the face is above or below the mirror.

use crate::geom::TriMesh;
use crate::mirror::Mirror;
use crate::solid::likely_open_edges;

/// The largest height by which the rim of `face` is above or below `mirror`, mm.
#[must_use]
pub(crate) fn rim_height_mm(mirror: &Mirror, face: &TriMesh) -> f64 {
    let edges = likely_open_edges(face);
    let height = |(from, _): &(u32, u32)| {
        let at = face.vertices[*from as usize];
        // (Rounding may leave a vertex of the rim beyond it.)
        let place = mirror.local_surface_over(at.truncate(), at.z)?;
        Some((at.z - place.at.z).abs())
    };
    edges.iter().filter_map(height).fold(0.0, f64::max)
}
