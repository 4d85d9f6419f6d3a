//! Reading meshes back, and measured points, as a stranger would: nothing is taken from the writer but the file.

mod glb;
mod plain_obj;
mod ply;
mod points;
mod threemf;

pub use glb::{GlbError, read_glb};
pub use ply::PlyError;
pub use points::{MOST_POINTS, PointFormat, PointsError, read_points};
pub use threemf::{ThreeMfError, read_3mf};

use crate::geom::{DVec3, TriMesh, Welder};
use crate::parallel;
use std::io::{self, Cursor};
use thiserror::Error;

/// A mesh as read from a file, with the file's normals.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedMesh {
    /// Facets; corners at the same place are joined.
    pub mesh: TriMesh,
    /// Unit normals at each facet's corners, if the file has any. Facets without normals of their
    /// own have arbitrary ones.
    pub normals: Option<Vec<[DVec3; 3]>>,
}

/// Reason why a file could not be read.
#[derive(Debug, Error)]
pub enum ReadError {
    /// A binary STL is shorter or longer than its facet count says.
    #[error("the STL says {facets} facets, which take {expected} bytes, but it has {found}")]
    Length {
        /// Facets promised.
        facets: u32,
        /// Bytes they take.
        expected: u64,
        /// Bytes there are.
        found: u64,
    },
    /// Not an STL.
    #[error("not a readable STL: {0}")]
    Stl(io::Error),
    /// Not an OBJ.
    #[error("not a readable OBJ: {0}")]
    Obj(tobj::LoadError),
    /// Not a 3MF.
    #[error("not a readable 3MF: {0}")]
    ThreeMf(#[from] ThreeMfError),
    /// Not a GLB.
    #[error("not a readable GLB: {0}")]
    Glb(#[from] GlbError),
    /// A coordinate is not a finite number.
    #[error("facet {facet} has a coordinate that is not a finite number")]
    NotFinite {
        /// The facet.
        facet: usize,
    },
    /// Memory does not hold it.
    #[error("there is not enough memory for its {vertices} vertices and {facets} facets")]
    Memory {
        /// Vertices, those of objects that are there more than once as often.
        vertices: usize,
        /// Facets, likewise.
        facets: usize,
    },
    /// There is nothing in it.
    #[error("the file holds no facets")]
    Empty,
}

/// Bytes before the first facet of a binary STL, and of each facet.
const HEAD: usize = 84;
const FACET: usize = 50;
/// Facets that a thread reads at a time.
const PART: usize = 1 << 15;

/// The corners of a facet of a binary STL.
#[inline]
fn corners(facet: &[u8]) -> [DVec3; 3] {
    let number = |at: &[u8]| f64::from(f32::from_le_bytes([at[0], at[1], at[2], at[3]]));
    let corner = |at: &[u8]| DVec3::new(number(at), number(&at[4..]), number(&at[8..]));
    [corner(&facet[12..]), corner(&facet[24..]), corner(&facet[36..])]
}

/// Comparison of the bytes of a binary STL with a mesh whose vertices are at places of their own: if all corners
/// agree, it is known without a search which of them are the same.
#[derive(Debug)]
pub struct StlComparison<'a> {
    mesh: &'a TriMesh,
    /// Pieces and facets so far.
    pieces: usize,
    facets: usize,
    equal: bool,
}

impl<'a> StlComparison<'a> {
    /// Lengths of the first piece of the bytes, and of the others but for the last.
    pub const PIECES: [usize; 2] = [HEAD, PART * FACET];

    /// The comparison with `mesh`, before the first piece.
    #[must_use]
    pub fn new(mesh: &'a TriMesh) -> Self {
        Self { mesh, pieces: 0, facets: 0, equal: true }
    }

    /// Adds the next of the [`Self::PIECES`].
    pub fn add(&mut self, piece: &[u8]) {
        let facets = self.mesh.triangles.len();
        self.pieces += 1;
        if self.pieces == 1 {
            // (What begins so may be text.)
            self.equal = piece.len() == HEAD
                && !piece.starts_with(b"solid")
                && u32::try_from(facets).is_ok_and(|count| piece[80..] == count.to_le_bytes());
            return;
        }
        let first = self.facets;
        self.facets += piece.len() / FACET;
        self.equal &= piece.len().is_multiple_of(FACET) && self.facets <= facets && {
            let found = piece.chunks_exact(FACET).map(corners);
            (first..).zip(found).all(|(t, corners)| self.mesh.corners(t) == corners)
        };
    }

    /// Whether the file holds the facets of the mesh and nothing else.
    #[must_use]
    pub fn is_equal(&self) -> bool {
        self.equal && self.facets > 0 && self.facets == self.mesh.triangles.len()
    }
}

/// Reads binary or text STL.
///
/// # Errors
/// [`ReadError`].
pub fn read_stl(bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    if bytes.starts_with(b"solid") || bytes.len() < HEAD {
        return read_text_stl(bytes);
    }
    let facets = u32::from_le_bytes([bytes[80], bytes[81], bytes[82], bytes[83]]);
    let (expected, found) = (HEAD as u64 + FACET as u64 * u64::from(facets), bytes.len() as u64);
    if expected != found {
        return Err(ReadError::Length { facets, expected, found });
    }
    // `stl_io` reads one number after another.
    let part = |&(k, part): &(usize, &[u8])| {
        let mut welder = Welder::new(PART);
        for (index, facet) in part.chunks_exact(FACET).enumerate() {
            add_finite(&mut welder, k * PART + index, corners(facet))?;
        }
        Ok(welder.finish())
    };
    let parts: Vec<_> = bytes[HEAD..].chunks(PART * FACET).enumerate().collect();
    let parts: Vec<Result<TriMesh, ReadError>> = parallel::map_slice(&parts, 1, part);
    let mesh = Welder::join(parts.into_iter().collect::<Result<_, _>>()?);
    Ok(ImportedMesh { mesh: not_empty(mesh)?, normals: None })
}

/// STL that begins like text; `stl_io` looks more closely.
fn read_text_stl(bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    let mut cursor = Cursor::new(bytes);
    let facets = stl_io::create_stl_reader(&mut cursor).map_err(ReadError::Stl)?;
    let mut welder = Welder::new(0);
    for (index, facet) in facets.enumerate() {
        let facet = facet.map_err(ReadError::Stl)?;
        let corners = facet.vertices.map(|v| DVec3::from_array(v.0.map(f64::from)));
        add_finite(&mut welder, index, corners)?;
    }
    Ok(ImportedMesh { mesh: not_empty(welder.finish())?, normals: None })
}

/// Reads OBJ, with normals where it has them.
///
/// # Errors
/// [`ReadError`].
pub fn read_obj(bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    plain_obj::read_plain_obj(bytes).map_or_else(|| read_any_obj(bytes), Ok)
}

/// Reads OBJ of any kind.
fn read_any_obj(bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let no_materials = |_: &std::path::Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials)
        .map_err(ReadError::Obj)?;
    let at = |array: &[f64], k: u32| DVec3::from_slice(&array[3 * k as usize..]);
    let facets: usize = models.iter().map(|model| model.mesh.indices.len() / 3).sum();
    let (mut welder, mut normals) = (Welder::new(facets), Vec::new());
    let mut index = 0;
    for tobj::Model { mesh, .. } in &models {
        for corners in mesh.indices.chunks_exact(3) {
            let corners = [corners[0], corners[1], corners[2]];
            add_finite(&mut welder, index, corners.map(|k| at(&mesh.positions, k)))?;
            index += 1;
        }
        normals.extend(mesh.normal_indices.iter().map(|&k| at(&mesh.normals, k)));
    }
    let has_normals = normals.len() == 3 * facets;
    let triples = |n: &[DVec3]| [n[0], n[1], n[2]].map(DVec3::normalize_or_zero);
    let normals = has_normals.then(|| normals.chunks_exact(3).map(triples).collect());
    Ok(ImportedMesh { mesh: not_empty(welder.finish())?, normals })
}

fn add_finite(welder: &mut Welder, facet: usize, corners: [DVec3; 3]) -> Result<(), ReadError> {
    if corners.iter().all(|corner| corner.is_finite()) {
        welder.add(corners);
        Ok(())
    } else {
        Err(ReadError::NotFinite { facet })
    }
}

fn not_empty(mesh: TriMesh) -> Result<TriMesh, ReadError> {
    if mesh.triangles.is_empty() { Err(ReadError::Empty) } else { Ok(mesh) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{Label, write_stl};
    use crate::geom::{PartFeatures, Precision};
    use crate::solid::Solid;

    fn stl() -> Vec<u8> {
        let vertices = vec![
            DVec3::new(-1.0, -1.0, 2.0),
            DVec3::new(1.0, -1.0, 2.5),
            DVec3::new(0.0, 1.5, 3.0),
        ];
        let face = TriMesh { vertices, triangles: vec![[0, 1, 2]] };
        let solid = Solid::from_face(&face.into(), PartFeatures::NONE, Precision::Single).unwrap();
        let label = Label {
            profile: "solid\nof a long name ".repeat(9),
            sha256: "0123456789abcdef".into(),
            tolerances: "chord 2 um".into(),
            mounting: vec!["telecentric camera".into()],
        };
        let mut bytes = Vec::new();
        write_stl(&mut bytes, &solid, &label).unwrap();
        assert_eq!(read_stl(&bytes).unwrap().mesh.triangles.len(), solid.mesh().triangles.len());
        bytes
    }

    #[test]
    fn the_header_is_ours_and_80_bytes_long() {
        let bytes = stl();
        assert!(bytes.starts_with(b"Morion solid?of a long name "));
        assert_eq!(bytes.len() as u64 - 84, 50 * u64::from(bytes[80]));
    }

    #[test]
    fn a_file_that_compares_equal_is_read_as_the_mesh_welded() {
        let bytes = stl();
        let read = read_stl(&bytes).unwrap().mesh;
        let compared = |bytes: &[u8], mesh: &TriMesh| {
            let mut comparison = StlComparison::new(mesh);
            comparison.add(&bytes[..HEAD.min(bytes.len())]);
            bytes[HEAD.min(bytes.len())..].chunks(3 * FACET).for_each(|b| comparison.add(b));
            comparison.is_equal()
        };
        assert!(compared(&bytes, &read) && read.as_welded().as_ref() == Some(&read));
        let mut turned = read.clone();
        turned.triangles[2].rotate_left(1);
        assert!(!compared(&bytes, &turned));
        let mut fewer = read.clone();
        fewer.triangles.pop();
        assert!(!compared(&bytes, &fewer));
        for length in [0, 5, HEAD, HEAD + FACET, bytes.len() - 1] {
            assert!(!compared(&bytes[..length], &read), "{length}");
        }
        // Every bit of a corner counts, but for the sign of zero, and that of no normal.
        let mut accepted = 0;
        for at in 80..bytes.len() {
            for bit in 0..8 {
                let mut altered = bytes.clone();
                altered[at] ^= 1 << bit;
                let searched = read_stl(&altered).is_ok_and(|found| found.mesh == read);
                assert_eq!(compared(&altered, &read), searched, "bit {bit} of byte {at}");
                let in_corner = at >= HEAD && (12..48).contains(&((at - HEAD) % FACET));
                accepted += usize::from(searched && in_corner);
            }
        }
        let corners = bytes[HEAD..].chunks(FACET).flat_map(|facet| facet[12..48].chunks(4));
        assert_eq!(accepted, corners.filter(|number| **number == [0; 4]).count());
    }

    #[test]
    fn no_coordinate_is_minus_zero() {
        for facet in stl()[84..].chunks(50) {
            for number in facet[..48].chunks(4) {
                assert_ne!(number, (-0.0f32).to_le_bytes(), "{facet:?}");
            }
        }
    }

    #[test]
    fn a_truncated_file_says_how_much_is_missing() {
        let bytes = stl();
        let Err(ReadError::Length { expected, found, .. }) = read_stl(&bytes[..bytes.len() - 7])
        else {
            panic!("not refused")
        };
        assert_eq!(expected - found, 7);
        assert!(read_stl(&bytes[..60]).is_err());
        assert!(read_stl(b"").is_err());
    }

    #[test]
    fn a_header_that_claims_gigabytes_is_refused_before_memory_is_asked_for() {
        let mut bytes = stl();
        bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(matches!(read_stl(&bytes), Err(ReadError::Length { .. })));
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        let mut bytes = stl();
        bytes[84 + 50 + 12..84 + 50 + 16].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(matches!(read_stl(&bytes), Err(ReadError::NotFinite { facet: 1 })));
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 inf 0\nf 1 2 3\n";
        assert!(matches!(read_obj(obj), Err(ReadError::NotFinite { facet: 0 })));
    }

    #[test]
    fn obj_normals_stay_with_their_corners() {
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 0 0 2\nvn 0 1 0\n\
                    f 1//1 2//1 3//2\nf 2 4 3\n";
        let read = read_obj(obj).unwrap();
        assert_eq!(read.mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(read.normals.unwrap()[0], [DVec3::Z, DVec3::Z, DVec3::Y]);
    }

    #[test]
    fn an_obj_that_points_nowhere_is_an_error() {
        assert!(matches!(read_obj(b"v 0 0 0\nf 1 2 3\n"), Err(ReadError::Obj(_))));
        assert!(matches!(read_obj(b"# nothing\n"), Err(ReadError::Empty)));
    }
}
