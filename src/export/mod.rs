//! Files: solid -> STL, OBJ, 3MF and GLB bytes; mirror -> STEP and sag table; how many bytes; the bytes of
//! a mesh or a table -> triangles or rows.

mod glb;
mod obj;
mod read;
mod sag;
pub mod step;
mod stl;
mod text;
mod threemf;

pub use glb::{glb_bytes, write_glb};
pub use obj::{obj_bytes, write_obj, write_obj_bare};
pub use read::{
    GlbError, ImportedMesh, MOST_POINTS, PlyError, PointFormat, PointsError, ReadError,
    StlComparison, ThreeMfError, read_3mf, read_glb, read_obj, read_points, read_stl,
};
pub use sag::{
    SagDeviation, SagError, SagRow, compare_sag, read_sag, sag_bytes, sag_heights, sag_points,
    write_sag,
};
pub use stl::{stl_bytes, write_stl};
pub use text::ByteCounter;
pub use threemf::{threemf_bytes, write_3mf};

/// Numbers of facets and vertices of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshCounts {
    /// Facets of the optical face.
    pub optical: usize,
    /// The other facets.
    pub more: usize,
    /// Vertices of the optical face.
    pub face_vertices: usize,
    /// The other vertices.
    pub more_vertices: usize,
}

/// Text about the part in the header of every file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// Profile name.
    pub profile: String,
    /// SHA-256 of the profile, hexadecimal.
    pub sha256: String,
    /// Tolerances asked for and reached, on one line.
    pub tolerances: String,
    /// How the part is mounted, in short statements, that of the camera first; may be empty.
    pub mounting: Vec<String>,
}

impl Label {
    /// Tolerances and how the part is mounted, on one line.
    fn about(&self) -> String {
        let all: Vec<&str> =
            std::iter::once(&self.tolerances).chain(&self.mounting).map(String::as_str).collect();
        Self::plain(&all.join("; "))
    }

    /// `text` with everything but printable ASCII replaced: headers and comments end at a newline.
    fn plain(text: &str) -> String {
        text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
    }
}
