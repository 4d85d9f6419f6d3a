//! Formats: with how many digits each carries a mesh, how it is written, and how it is read.

use crate::design::Design;
use crate::export::{
    ImportedMesh, Label, MeshCounts, ReadError, obj_bytes, read_3mf, read_obj, read_stl, stl_bytes,
    threemf_bytes, write_3mf, write_obj, write_obj_bare, write_stl,
};
use crate::geom::Precision;
use crate::mesh::Face;
use crate::profile::{Format, Profile};
use crate::solid::Solid;
use std::io::{self, Write};

/// Digits of a format's coordinates.
pub fn precision(format: Format) -> Precision {
    match format {
        Format::Stl | Format::ThreeMf => Precision::Single,
        Format::Obj | Format::Step | Format::Csv => Precision::Double,
    }
}

/// The format of a mesh that is written to be traced alone.
pub const TRACED: Format = Format::Obj;

/// The mesh formats of which files are made: those asked for. Where none is, the one that any mesh
/// suits, so that there is something to trace; it is not published.
pub fn meshes(profile: &Profile) -> Vec<Format> {
    let asked: Vec<Format> = profile.formats.iter().copied().filter(|f| f.is_mesh()).collect();
    if asked.is_empty() { vec![TRACED] } else { asked }
}

/// The other formats asked for.
pub fn drawings(profile: &Profile) -> impl Iterator<Item = Format> {
    profile.formats.iter().copied().filter(|format| !format.is_mesh())
}

/// Writes a solid whose optical face is `face`.
pub fn write_mesh(
    mut out: impl Write,
    format: Format,
    solid: &Solid,
    (face, design): (&Face, &Design),
    label: &Label,
) -> io::Result<()> {
    match format {
        Format::Stl => write_stl(&mut out, solid, label),
        Format::Obj => write_obj(&mut out, solid, &design.mirror, face.designed, label),
        Format::ThreeMf => write_3mf(&mut out, solid, label),
        Format::Step | Format::Csv => unreachable!("no mesh"),
    }
}

/// Writes a solid whose optical face is not the designed mirror.
pub fn write_solid(
    mut out: impl Write,
    format: Format,
    solid: &Solid,
    label: &Label,
) -> io::Result<()> {
    match format {
        Format::Stl => write_stl(&mut out, solid, label),
        Format::Obj => write_obj_bare(&mut out, solid, label),
        Format::ThreeMf => write_3mf(&mut out, solid, label),
        Format::Step | Format::Csv => unreachable!("no mesh"),
    }
}

/// Reads a mesh file.
pub fn read_mesh(format: Format, bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    match format {
        Format::Stl => read_stl(bytes),
        Format::Obj => read_obj(bytes),
        Format::ThreeMf => read_3mf(bytes),
        Format::Step | Format::Csv => unreachable!("no mesh"),
    }
}

/// Foresees the length of a mesh file.
pub fn mesh_bytes(
    format: Format,
    size: &MeshCounts,
    design: &Design,
    made: Precision,
    label: &Label,
) -> u64 {
    match format {
        Format::Stl => stl_bytes(size.optical + size.more),
        Format::Obj => obj_bytes(size, &design.mirror, made, label),
        Format::ThreeMf => threemf_bytes(size),
        Format::Step | Format::Csv => unreachable!("no mesh"),
    }
}
