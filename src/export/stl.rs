//! Binary STL.

use super::Label;
use crate::geom::TriMesh;
use crate::parallel;
use crate::solid::Solid;
use std::io::{self, Write};

/// Length of the free text that begins a binary STL.
const HEADER: usize = 80;

/// Bytes of a triangle: its normal, its corners, and an attribute that nothing uses.
const TRIANGLE: u64 = 50;

/// The length of what [`write_stl`] writes of so many triangles.
#[must_use]
pub fn stl_bytes(triangles: usize) -> u64 {
    HEADER as u64 + 4 + TRIANGLE * triangles as u64
}

/// Triangles that a thread encodes at a time, and those that are encoded before any is written.
const CHUNK: usize = 1 << 14;
const GROUP: usize = 8 * CHUNK;

/// Writes `solid`, whose coordinates should be single-precision numbers, as binary STL with facet
/// normals. The header names the program, the profile, the unit, the camera's place and the tolerances, as
/// far as they fit, and never begins with "solid", by which readers know the text form.
///
/// # Errors
/// Whatever `out` returns, flushing included.
pub fn write_stl(out: &mut impl Write, solid: &Solid, label: &Label) -> io::Result<()> {
    let mesh = solid.mesh();
    let count = u32::try_from(mesh.triangles.len()).map_err(io::Error::other)?;
    out.write_all(&header(label))?;
    out.write_all(&count.to_le_bytes())?;
    // (`stl_io` writes one number after another.)
    let mut bytes = Vec::new();
    for first in (0..mesh.triangles.len()).step_by(GROUP) {
        let group = first..mesh.triangles.len().min(first + GROUP);
        bytes.resize(TRIANGLE as usize * group.len(), 0);
        parallel::map_chunks_mut(&mut bytes, TRIANGLE as usize * CHUNK, |k, bytes| {
            for (t, bytes) in (first + k * CHUNK..).zip(bytes.chunks_exact_mut(TRIANGLE as usize)) {
                encode(mesh, t, bytes);
            }
        });
        out.write_all(&bytes)?;
    }
    out.flush()
}

/// The bytes of a triangle: its normal and its corners as single-precision numbers, and two of zero.
fn encode(mesh: &TriMesh, t: usize, bytes: &mut [u8]) {
    let corners = mesh.corners(t);
    let normal = mesh.area_vector(t).normalize().as_vec3() + 0.0;
    let all = [normal, corners[0].as_vec3(), corners[1].as_vec3(), corners[2].as_vec3()];
    for (bytes, number) in bytes.chunks_exact_mut(4).zip(all.iter().flat_map(|v| v.to_array())) {
        bytes.copy_from_slice(&number.to_le_bytes());
    }
}

fn header(label: &Label) -> [u8; HEADER] {
    let hash = &label.sha256[..label.sha256.len().min(8)];
    let camera = label.mounting.first().map_or(String::new(), |camera| format!("{camera}; "));
    let text = format!("Morion {} {hash} mm {camera}{}", label.profile, label.tolerances);
    let mut header = [b' '; HEADER];
    for (to, from) in header.iter_mut().zip(Label::plain(&text).bytes()) {
        *to = from;
    }
    header
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec3, PartFeatures, Precision};
    use stl_io::{Normal, Triangle, Vertex};

    #[test]
    fn the_bytes_are_those_of_stl_io_but_for_the_header() {
        let side = 300u32;
        let vertex = |k: u32| {
            let (x, y) = (f64::from(k % side), f64::from(k / side));
            DVec3::new(0.1 * x - 15.0, 0.1 * y - 15.0, 2.0 + 0.003 * x * y)
        };
        let quad = |k: u32| {
            let a = k / (side - 1) * side + k % (side - 1);
            [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
        };
        let vertices = (0..side * side).map(vertex).collect();
        let triangles = (0..(side - 1) * (side - 1)).flat_map(quad).collect();
        let solid = Solid::from_face(
            &TriMesh { vertices, triangles }.into(),
            PartFeatures::NONE,
            Precision::Single,
        )
        .unwrap();
        let mesh = solid.mesh();
        assert!(mesh.triangles.len() > GROUP);
        let label = Label {
            profile: "part".into(),
            sha256: "0123456789abcdef".into(),
            tolerances: "chord 2 um".into(),
            mounting: vec![],
        };
        let (mut found, mut expected) = (Vec::new(), Vec::new());
        write_stl(&mut found, &solid, &label).unwrap();
        let facets: Vec<Triangle> = (0..mesh.triangles.len())
            .map(|t| Triangle {
                normal: Normal::new((mesh.area_vector(t).normalize().as_vec3() + 0.0).to_array()),
                vertices: mesh.corners(t).map(|v| Vertex::new(v.as_vec3().to_array())),
            })
            .collect();
        stl_io::write_stl(&mut expected, facets.iter()).unwrap();
        assert_eq!(found.len() as u64, stl_bytes(mesh.triangles.len()));
        assert!(found[..HEADER] == header(&label) && found[HEADER..] == expected[HEADER..]);
    }
}
