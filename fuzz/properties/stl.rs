//! STL bytes, binary or text.

use super::mesh;
use morion::internals::export::read_stl;
use morion::internals::geom::TriMesh;

/// `lot` 0 asks for all that can be asked, other ones for less.
pub fn holds(bytes: &[u8], lot: u8) {
    let Ok(read) = read_stl(bytes) else { return };
    mesh::is_sound(&read);
    let again = read_stl(&binary(&read.mesh)).expect("a mesh that was read can be read again");
    assert_eq!(again.mesh, read.mesh);
    mesh::verified(bytes, "stl", &read, lot);
}

/// The mesh as binary STL: its coordinates are single-precision numbers, as they come from one.
fn binary(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        for corner in mesh.corners(t) {
            bytes.extend(corner.as_vec3().to_array().iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}
