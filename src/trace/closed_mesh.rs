//! The closedness of a mesh.

use crate::geom::TriMesh;

/// Whether every edge is run through as often in one direction as in the other: then every point off
/// the facets has a winding number, and a line that comes from outside and goes back there crosses
/// as many facets inwards as outwards. Facets may meet or cut each other in any way.
pub(super) fn is_closed(mesh: &TriMesh) -> bool {
    // Edges by their lower vertex: the other one, and the direction in the last bit.
    let edges = || {
        let edges = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        edges.filter(|[u, v]| u != v).map(
            |[u, v]| {
                if u < v { (u, v << 1) } else { (v, (u << 1) | 1) }
            },
        )
    };
    if mesh.vertices.len() > (u32::MAX >> 1) as usize {
        return false;
    }
    let mut start = vec![0u32; mesh.vertices.len() + 2];
    for (u, _) in edges() {
        start[u as usize + 2] += 1;
    }
    for k in 2..start.len() {
        start[k] += start[k - 1];
    }
    let mut others = vec![0u32; 3 * mesh.triangles.len()];
    for (u, other) in edges() {
        let next = &mut start[u as usize + 1];
        others[*next as usize] = other;
        *next += 1;
    }
    start.windows(2).take(mesh.vertices.len()).all(|range| {
        let others = &mut others[range[0] as usize..range[1] as usize];
        others.sort_unstable();
        others.chunk_by(|a, b| a >> 1 == b >> 1).all(|same| {
            let back = same.iter().filter(|&&other| other & 1 == 1).count();
            2 * back == same.len()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::DVec3;

    #[test]
    fn a_tetrahedron_is_closed_until_a_facet_is_lost_or_turned() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let body = TriMesh { vertices, triangles };
        assert!(is_closed(&body));
        for k in 0..4 {
            let mut lost = body.clone();
            lost.triangles.remove(k);
            assert!(!is_closed(&lost));
            let mut turned = body.clone();
            turned.triangles[k].swap(0, 1);
            assert!(!is_closed(&turned));
        }
        // Twice the same body; a facet and its back; nothing at all.
        let mut twice = body.clone();
        twice.triangles.extend(body.triangles.clone());
        assert!(is_closed(&twice));
        twice.triangles.extend([[0, 1, 2], [0, 2, 1], [1, 1, 3], [1, 3, 1]]);
        assert!(is_closed(&twice));
        assert!(is_closed(&TriMesh::default()));
    }
}
