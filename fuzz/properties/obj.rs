//! OBJ text.

use super::mesh;
use morion::internals::export::read_obj;
use morion::internals::geom::TriMesh;

/// `lot` 0 asks for all that can be asked, other ones for less.
pub fn holds(bytes: &[u8], lot: u8) {
    let Ok(read) = read_obj(bytes) else { return };
    mesh::is_sound(&read);
    let again = read_obj(text(&read.mesh).as_bytes());
    assert_eq!(again.expect("a mesh that was read can be read again").mesh, read.mesh);
    mesh::verified(bytes, "obj", &read, lot);
}

fn text(mesh: &TriMesh) -> String {
    let vertices = mesh.vertices.iter().map(|v| format!("v {} {} {}\n", v.x, v.y, v.z));
    let facets = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| v + 1);
        format!("f {a} {b} {c}\n")
    });
    vertices.chain(facets).collect()
}
