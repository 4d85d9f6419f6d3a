//! GLB: the solid as binary glTF 2.0 (Khronos Group, glTF 2.0 Specification, 2.0.1).

use super::{Label, MeshCounts};
use crate::geom::TriMesh;
use crate::solid::Solid;
use serde::Serialize;
use std::io::{self, Write};

/// What a GLB begins with, and the types of its chunks (section 4.4).
pub(super) const MAGIC: [u8; 4] = *b"glTF";
pub(super) const VERSION: u32 = 2;
pub(super) const JSON_CHUNK: [u8; 4] = *b"JSON";
pub(super) const BIN_CHUNK: [u8; 4] = *b"BIN\0";
/// Bytes of the file's header, and of each chunk's.
pub(super) const FILE_HEADER: usize = 12;
pub(super) const CHUNK_HEADER: usize = 8;

/// Bytes of a vertex: three single-precision numbers.
const VERTEX: u64 = 12;
/// Most vertices that two bytes number: the largest number of all restarts a primitive.
const MOST_SHORT: usize = 0xffff;
/// Vertices or facets that are encoded before any is written.
const GROUP: usize = 1 << 16;

/// The node's matrix by columns: from millimetres with Z up, the part's frame, to metres with Y up.
const NODE_MATRIX: &str = "[0.001,0,0,0,0,0,-0.001,0,0,0.001,0,0,0,0,0,1]";

/// Materials of the optical face and of the rest.
const MATERIALS: &str = concat!(
    r#"[{"name":"optical face","pbrMetallicRoughness":"#,
    r#"{"baseColorFactor":[0.95,0.95,0.95,1],"metallicFactor":1,"roughnessFactor":0.05}},"#,
    r#"{"name":"skirt and base","pbrMetallicRoughness":"#,
    r#"{"baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":1,"roughnessFactor":0.5}}]"#
);

/// Writes `solid`, whose coordinates should be single-precision numbers, as GLB: one node whose matrix leads
/// from millimetres in the part's frame to glTF's metres with Y up, and one mesh of two primitives, the optical
/// face and the rest, over the same vertices. There are no normals, so that viewers shade it flat. `asset.extras`
/// names profile, tolerances and mounting.
///
/// # Errors
/// Whatever `out` returns, flushing included; an error of its own when the file would have 4 GiB, which its
/// header cannot say.
pub fn write_glb(out: &mut impl Write, solid: &Solid, label: &Label) -> io::Result<()> {
    let mesh = solid.mesh();
    let optical = solid.optical();
    let layout = GlbLayout {
        vertices: mesh.vertices.len(),
        facets: [optical, mesh.triangles.len() - optical],
    };
    let json = layout.json(bounds(mesh), label);
    let length = u32::try_from(layout.bytes(json.len())).map_err(io::Error::other)?;
    out.write_all(&MAGIC)?;
    out.write_all(&VERSION.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(&(json.len() as u32).to_le_bytes())?;
    out.write_all(&JSON_CHUNK)?;
    out.write_all(json.as_bytes())?;
    out.write_all(&(layout.bin() as u32).to_le_bytes())?;
    out.write_all(&BIN_CHUNK)?;
    encoded(out, &mesh.vertices, |bytes, v| {
        bytes.extend(v.as_vec3().to_array().iter().flat_map(|x| x.to_le_bytes()));
    })?;
    encoded(out, &mesh.triangles, |bytes, t| match layout.index() {
        Index::Short => bytes.extend(t.iter().flat_map(|&v| (v as u16).to_le_bytes())),
        Index::Long => bytes.extend(t.iter().flat_map(|&v| v.to_le_bytes())),
    })?;
    out.flush()
}

/// The length of what [`write_glb`] writes of a solid of this size.
#[must_use]
pub fn glb_bytes(size: &MeshCounts, label: &Label) -> u64 {
    let vertices = size.face_vertices + size.more_vertices;
    let layout = GlbLayout { vertices, facets: [size.optical, size.more] };
    layout.bytes(layout.json([[0.0; 3]; 2], label).len())
}

/// Least and greatest coordinates in single precision, mm.
fn bounds(mesh: &TriMesh) -> [[f32; 3]; 2] {
    let (lo, hi) = mesh.bounds().unwrap_or_default();
    [lo, hi].map(|v| v.as_vec3().to_array())
}

/// Writes the items' bytes, group by group.
fn encoded<T>(
    out: &mut impl Write,
    items: &[T],
    encode: impl Fn(&mut Vec<u8>, &T),
) -> io::Result<()> {
    let mut bytes = Vec::new();
    for group in items.chunks(GROUP) {
        bytes.clear();
        group.iter().for_each(|item| encode(&mut bytes, item));
        out.write_all(&bytes)?;
    }
    Ok(())
}

/// Kind of number of the indices.
#[derive(Clone, Copy)]
enum Index {
    /// Two bytes.
    Short,
    /// Four bytes.
    Long,
}

impl Index {
    /// Bytes of a facet, and glTF's code of the kind.
    const fn codes(self) -> (u64, u32) {
        match self {
            Self::Short => (6, 5123),
            Self::Long => (12, 5125),
        }
    }
}

/// Numbers of what is in the binary chunk: the vertices, then the facets of each primitive.
struct GlbLayout {
    vertices: usize,
    /// Facets of the optical face, and the other ones.
    facets: [usize; 2],
}

impl GlbLayout {
    fn index(&self) -> Index {
        if self.vertices <= MOST_SHORT { Index::Short } else { Index::Long }
    }

    /// Bytes of the vertices, and of the facets of each primitive.
    fn lengths(&self) -> [u64; 3] {
        let facets = self.facets.map(|count| self.index().codes().0 * count as u64);
        [VERTEX * self.vertices as u64, facets[0], facets[1]]
    }

    /// Bytes of the buffer: a multiple of four as chunks are, since a closed surface has an even number of facets.
    fn bin(&self) -> u64 {
        self.lengths().iter().sum()
    }

    /// Bytes of the whole file, with a JSON chunk of so many.
    fn bytes(&self, json: usize) -> u64 {
        (FILE_HEADER + 2 * CHUNK_HEADER + json) as u64 + self.bin()
    }

    /// Text of the JSON chunk with the spaces after it. Its length does not depend on `bounds`, the least and
    /// greatest coordinates.
    fn json(&self, bounds: [[f32; 3]; 2], label: &Label) -> String {
        let Self { vertices, facets: [optical, more] } = self;
        let [places, face, rest] = self.lengths();
        let bin = self.bin();
        let kind = self.index().codes().1;
        let [min, max] = bounds.map(|v| v.map(fixed).join(","));
        let name = quoted(&label.profile);
        let extras = quoted(&Extras {
            positions: "millimetres, Z towards the camera",
            profile: &label.profile,
            sha256: &label.sha256,
            tolerances: &label.tolerances,
            mounting: &label.mounting,
        });
        let mut text = format!(
            r#"{{"asset":{{"version":"2.0","generator":"Morion","extras":{extras}}},"scene":0,"#
        );
        text += &format!(r#""scenes":[{{"nodes":[0]}}],"nodes":[{{"name":{name},"mesh":0,"#);
        text += &format!(r#""matrix":{NODE_MATRIX}}}],"materials":{MATERIALS},"#);
        text += &format!(
            r#""meshes":[{{"name":{name},"primitives":[{},{}]}}],"#,
            primitive(1, 0),
            primitive(2, 1)
        );
        text += &format!(
            r#""accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3","#
        );
        text += &format!(r#""min":[{min}],"max":[{max}]}},"#);
        text += &format!(
            r#"{{"bufferView":1,"componentType":{kind},"count":{},"type":"SCALAR"}},"#,
            3 * optical
        );
        text += &format!(
            r#"{{"bufferView":1,"byteOffset":{face},"componentType":{kind},"count":{},"type":"SCALAR"}}],"#,
            3 * more
        );
        text += &format!(
            r#""bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{places},"target":34962}},"#
        );
        text += &format!(
            r#"{{"buffer":0,"byteOffset":{places},"byteLength":{},"target":34963}}],"#,
            face + rest
        );
        text += &format!(r#""buffers":[{{"byteLength":{bin}}}]}}"#);
        let spaces = text.len().next_multiple_of(4) - text.len();
        text + &" ".repeat(spaces)
    }
}

/// What glTF has no words for, as `asset.extras`.
#[derive(Serialize)]
struct Extras<'a> {
    positions: &'a str,
    profile: &'a str,
    sha256: &'a str,
    tolerances: &'a str,
    mounting: &'a [String],
}

/// JSON of text, or of a struct of texts: that cannot fail.
fn quoted(texts: &impl Serialize) -> String {
    serde_json::to_string(texts).unwrap_or_default()
}

/// A primitive with this accessor of its indices and this material.
fn primitive(indices: usize, material: usize) -> String {
    format!(r#"{{"attributes":{{"POSITION":0}},"indices":{indices},"material":{material}}}"#)
}

/// Every digit of a number, after spaces that make all of them equally long.
fn fixed(x: f32) -> String {
    format!("{:>23e}", f64::from(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::{DVec3, PartFeatures, Precision};
    use serde_json::Value;

    /// A dome of `side` by `side` vertices.
    fn dome(side: u32) -> Solid {
        let vertex = |k: u32| {
            let [x, y] =
                [k % side, k / side].map(|k| 0.1 * f64::from(k) - 0.05 * f64::from(side - 1));
            DVec3::new(x, y, 9.1 - 1e-3 * (x * x + y * y))
        };
        let quad = |k: u32| {
            let a = k / (side - 1) * side + k % (side - 1);
            [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]]
        };
        let vertices = (0..side * side).map(vertex).collect();
        let triangles = (0..(side - 1) * (side - 1)).flat_map(quad).collect();
        Solid::from_face(
            &TriMesh { vertices, triangles }.into(),
            PartFeatures::NONE,
            Precision::Single,
        )
        .unwrap()
    }

    fn label() -> Label {
        Label {
            profile: "a \"b\"\n\u{e9}".into(),
            sha256: "0123456789abcdef".into(),
            tolerances: "chord um 2:0.214".into(),
            mounting: vec!["camera far away".into()],
        }
    }

    fn word(bytes: &[u8], at: usize) -> usize {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
    }

    #[test]
    fn the_chunks_are_whole_words_and_as_long_as_foreseen() {
        // Indices of either kind; 65 535 vertices are the most that two bytes number.
        for (side, index) in [(2, 2), (3, 2), (254, 2), (255, 4)] {
            let (solid, mut bytes) = (dome(side), Vec::new());
            write_glb(&mut bytes, &solid, &label()).unwrap();
            let [vertices, facets] = [solid.mesh().vertices.len(), solid.mesh().triangles.len()];
            let face_vertices = (side * side) as usize;
            let size = MeshCounts {
                optical: solid.optical(),
                more: facets - solid.optical(),
                face_vertices,
                more_vertices: vertices - face_vertices,
            };
            assert_eq!(bytes.len() as u64, glb_bytes(&size, &label()));
            assert_eq!(
                (&bytes[..4], word(&bytes, 4), word(&bytes, 8)),
                (&MAGIC[..], 2, bytes.len())
            );
            let json = word(&bytes, 12);
            let text = std::str::from_utf8(&bytes[20..20 + json]).unwrap();
            let value: Value = serde_json::from_str(text).unwrap();
            let bin = word(&bytes, 20 + json);
            assert!(
                json.is_multiple_of(4) && bin.is_multiple_of(4) && bytes.len() == 28 + json + bin
            );
            assert_eq!(bin, 12 * vertices + 3 * index * facets, "{vertices} vertices");
            assert_eq!(value["buffers"][0]["byteLength"], bin);
        }
    }

    #[test]
    fn the_json_has_the_label_and_the_true_bounds() {
        let (solid, mut bytes) = (dome(9), Vec::new());
        write_glb(&mut bytes, &solid, &label()).unwrap();
        let value: Value = serde_json::from_slice(&bytes[20..20 + word(&bytes, 12)]).unwrap();
        let extras = &value["asset"]["extras"];
        assert_eq!(value["nodes"][0]["name"], *label().profile);
        assert_eq!(extras["profile"], *label().profile);
        assert_eq!(extras["sha256"], *label().sha256);
        assert_eq!(extras["tolerances"], *label().tolerances);
        assert_eq!(extras["mounting"][0], *label().mounting[0]);
        let of = |name: &str, k: usize| value["accessors"][0][name][k].as_f64().unwrap();
        for k in 0..3 {
            let column = solid.mesh().vertices.iter().map(|v| v[k]);
            assert_eq!(of("min", k), column.clone().fold(f64::INFINITY, f64::min));
            assert_eq!(of("max", k), column.fold(f64::NEG_INFINITY, f64::max));
        }
    }

    #[test]
    fn every_number_of_the_bounds_is_equally_long() {
        let odd = [0.0, -1.0, f32::MIN, f32::MIN_POSITIVE, -1.234_567_9e-38, 1e-45, 30.1];
        for x in odd {
            assert_eq!(fixed(x).len(), 23, "{x}");
            assert_eq!(fixed(x).trim().parse(), Ok(f64::from(x)));
        }
    }
}
