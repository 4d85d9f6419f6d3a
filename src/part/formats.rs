//! Mesh formats: the digits that each carries, how it is written and read, and how long it will be.

use crate::design::Design;
use crate::export::{
    ImportedMesh, Label, MeshCounts, ReadError, StlComparison, glb_bytes, obj_bytes, read_3mf,
    read_glb, read_obj, read_stl, stl_bytes, threemf_bytes, write_3mf, write_glb, write_obj,
    write_obj_bare, write_stl,
};
use crate::geom::{Precision, TriMesh};
use crate::mesh::Face;
use crate::profile::{CadFormat, FileFormat, MeshFormat, Profile};
use crate::solid::Solid;
use std::io::{self, Write};

/// The format of a mesh that is written to be traced alone: the one that any mesh suits.
pub(crate) const TRACED: MeshFormat = MeshFormat::Obj;

/// The mesh formats that a profile asks for.
pub(crate) fn meshes(profile: &Profile) -> impl Iterator<Item = MeshFormat> {
    profile.formats.iter().filter_map(|format| match format {
        FileFormat::Mesh(format) => Some(*format),
        FileFormat::Cad(_) => None,
    })
}

/// The other formats that it asks for.
pub(crate) fn cad(profile: &Profile) -> impl Iterator<Item = CadFormat> {
    profile.formats.iter().filter_map(|format| match format {
        FileFormat::Mesh(_) => None,
        FileFormat::Cad(format) => Some(*format),
    })
}

/// Whether a build of the profile needs a mesh: where it asks for no mesh file, the rays are traced at the curved faces
/// of its STEP file, or else, and of what is formed on a tool, at a mesh that is not kept.
pub(crate) fn needs_mesh(profile: &Profile) -> bool {
    meshes(profile).next().is_some()
        || profile.part.forming.is_some()
        || cad(profile).all(|format| format != CadFormat::Step)
}

/// Writer and reader of a mesh format.
pub(crate) trait MeshCodec: Sync {
    /// Digits of its coordinates.
    fn precision(&self) -> Precision;

    /// Whether the file says what its unit is.
    fn declares_unit(&self) -> bool {
        false
    }

    /// Whether its length is in proportion to the number of triangles, few or many.
    fn is_proportional(&self) -> bool {
        true
    }

    /// Writes a solid; `face` is its optical face, and the mirror that this has the normals of, where it is
    /// the designed one.
    ///
    /// # Errors
    /// That of `out`.
    fn write(
        &self,
        out: &mut dyn Write,
        solid: &Solid,
        face: Option<(&Face, &Design)>,
        label: &Label,
    ) -> io::Result<()>;

    /// Reads a file's bytes.
    ///
    /// # Errors
    /// [`ReadError`] when they are no such file.
    fn read(&self, bytes: &[u8]) -> Result<ImportedMesh, ReadError>;

    /// The comparison of a file with the mesh that it was written of, where that takes less time than reading it.
    fn comparison<'a>(&self, _mesh: &'a TriMesh) -> Option<StlComparison<'a>> {
        None
    }

    /// Foresees the length of a file of a solid of this size, with a face made to these digits.
    fn bytes(&self, size: &MeshCounts, design: &Design, made: Precision, label: &Label) -> u64;
}

/// The codec of a format.
pub(crate) fn codec(format: MeshFormat) -> &'static dyn MeshCodec {
    match format {
        MeshFormat::Stl => &Stl,
        MeshFormat::Obj => &Obj,
        MeshFormat::ThreeMf => &ThreeMf,
        MeshFormat::Glb => &Glb,
    }
}

struct Stl;

impl MeshCodec for Stl {
    fn precision(&self) -> Precision {
        Precision::Single
    }

    fn write(
        &self,
        mut out: &mut dyn Write,
        solid: &Solid,
        _face: Option<(&Face, &Design)>,
        label: &Label,
    ) -> io::Result<()> {
        write_stl(&mut out, solid, label)
    }

    fn read(&self, bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
        read_stl(bytes)
    }

    fn comparison<'a>(&self, mesh: &'a TriMesh) -> Option<StlComparison<'a>> {
        Some(StlComparison::new(mesh))
    }

    fn bytes(&self, size: &MeshCounts, _design: &Design, _made: Precision, _label: &Label) -> u64 {
        stl_bytes(size.optical + size.more)
    }
}

struct Obj;

impl MeshCodec for Obj {
    fn precision(&self) -> Precision {
        Precision::Double
    }

    fn write(
        &self,
        mut out: &mut dyn Write,
        solid: &Solid,
        face: Option<(&Face, &Design)>,
        label: &Label,
    ) -> io::Result<()> {
        match face {
            Some((face, design)) => {
                write_obj(&mut out, solid, &design.mirror, face.designed, label)
            }
            None => write_obj_bare(&mut out, solid, label),
        }
    }

    fn read(&self, bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
        read_obj(bytes)
    }

    fn bytes(&self, size: &MeshCounts, design: &Design, made: Precision, label: &Label) -> u64 {
        obj_bytes(size, &design.mirror, made, label)
    }
}

struct ThreeMf;

impl MeshCodec for ThreeMf {
    fn precision(&self) -> Precision {
        Precision::Single
    }

    fn declares_unit(&self) -> bool {
        true
    }

    fn is_proportional(&self) -> bool {
        false
    }

    fn write(
        &self,
        mut out: &mut dyn Write,
        solid: &Solid,
        _face: Option<(&Face, &Design)>,
        label: &Label,
    ) -> io::Result<()> {
        write_3mf(&mut out, solid, label)
    }

    fn read(&self, bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
        read_3mf(bytes)
    }

    fn bytes(&self, size: &MeshCounts, _design: &Design, _made: Precision, _label: &Label) -> u64 {
        threemf_bytes(size)
    }
}

struct Glb;

impl MeshCodec for Glb {
    fn precision(&self) -> Precision {
        Precision::Single
    }

    fn declares_unit(&self) -> bool {
        true
    }

    fn write(
        &self,
        mut out: &mut dyn Write,
        solid: &Solid,
        _face: Option<(&Face, &Design)>,
        label: &Label,
    ) -> io::Result<()> {
        write_glb(&mut out, solid, label)
    }

    fn read(&self, bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
        read_glb(bytes)
    }

    fn bytes(&self, size: &MeshCounts, _design: &Design, _made: Precision, label: &Label) -> u64 {
        glb_bytes(size, label)
    }
}
