//! GLB bytes.

use super::mesh;
use morion::internals::export::read_glb;
use morion::internals::geom::TriMesh;

/// `lot` 0 asks for all that can be asked, other ones for less.
pub fn holds(bytes: &[u8], lot: u8) {
    let Ok(read) = read_glb(bytes) else { return };
    mesh::is_sound(&read);
    // Placed by a matrix, coordinates have more digits than a file holds.
    if read.mesh.vertices.iter().all(|v| v.as_vec3().as_dvec3() == *v) {
        let again = read_glb(&bare(&read.mesh)).expect("a mesh that was read can be read again");
        assert_eq!(again.mesh, read.mesh);
    }
    mesh::verified(bytes, "glb", &read, lot);
}

/// The mesh as a GLB of one node, in millimetres.
fn bare(mesh: &TriMesh) -> Vec<u8> {
    let places = mesh.vertices.iter().flat_map(|v| v.as_vec3().to_array());
    let mut bin: Vec<u8> = places.flat_map(f32::to_le_bytes).collect();
    let split = bin.len();
    bin.extend(mesh.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"matrix":[0.001,0,0,0,0,0,-0.001,0,0,0.001,0,0,0,0,0,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3"}},
        {{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":{split}}},
        {{"buffer":0,"byteOffset":{split},"byteLength":{}}}],"buffers":[{{"byteLength":{}}}]}}"#,
        mesh.vertices.len(),
        3 * mesh.triangles.len(),
        bin.len() - split,
        bin.len()
    );
    file(&json, &bin)
}

/// A GLB of these chunks, with the padding that they need.
pub fn file(json: &str, bin: &[u8]) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (kind, bytes, padding) in [(b"JSON", json.as_bytes(), b' '), (b"BIN\0", bin, 0)] {
        let length = bytes.len().next_multiple_of(4);
        chunks.extend((length as u32).to_le_bytes());
        chunks.extend(kind);
        chunks.extend(bytes);
        chunks.resize(chunks.len() + length - bytes.len(), padding);
    }
    let mut file = b"glTF".to_vec();
    file.extend(2_u32.to_le_bytes());
    file.extend((12 + chunks.len() as u32).to_le_bytes());
    file.extend(chunks);
    file
}
