//! Reading GLB: the chunks of binary glTF 2.0 (Khronos Group, glTF 2.0 Specification, 2.0.1), its JSON by
//! `serde_json`, and the triangles of its scene.
//!
//! The `gltf` crate would bring six packages, two of them for procedural macros, for a schema of which the part
//! that holds triangles is small; and its readers compute with counts and offsets of the file unchecked.

mod accessor;
mod document;
mod scene;

use super::super::glb::{BIN_CHUNK, CHUNK_HEADER, FILE_HEADER, JSON_CHUNK, MAGIC, VERSION};
use super::{ImportedMesh, ReadError};
use document::Document;
use thiserror::Error;

/// Why a GLB could not be read.
#[derive(Debug, Error)]
pub enum GlbError {
    /// The bytes are not the chunks of a GLB.
    #[error("{0}")]
    Chunks(String),
    /// The JSON chunk is not JSON, or not as glTF has it.
    #[error("the JSON chunk: {0}")]
    Json(#[from] serde_json::Error),
    /// A part of the model is not as glTF has it, or is something that is not read.
    #[error("{part}: {fault}")]
    Model {
        /// The part, as the JSON chunk names it.
        part: String,
        /// What is wrong.
        fault: String,
    },
}

impl GlbError {
    /// A fault of a part of the model.
    fn of(part: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Model { part: part.into(), fault: fault.into() }
    }
}

/// Longest JSON chunk, bytes: what is unpacked of it takes some ten times as much memory.
const MOST_JSON: usize = 1 << 26;

/// Reads GLB: all triangles of its scene, in millimetres and the part's frame, where Z points as glTF's Y does.
/// Node transforms are double-precision numbers, positions single-precision ones. Normals, materials, cameras and
/// animations are left alone.
///
/// # Errors
/// [`ReadError`].
pub fn read_glb(bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    let Chunks { json, bin } = chunks(bytes)?;
    let document: Document = serde_json::from_slice(json).map_err(GlbError::Json)?;
    document.check()?;
    let mesh = scene::mesh(&document, bin)?;
    Ok(ImportedMesh { mesh, normals: None })
}

/// Contents of the chunks that are read.
struct Chunks<'a> {
    json: &'a [u8],
    /// Empty if there is none.
    bin: &'a [u8],
}

/// Splits a file into its chunks.
fn chunks(bytes: &[u8]) -> Result<Chunks<'_>, GlbError> {
    let wrong = |fault: String| Err(GlbError::Chunks(fault));
    if !bytes.starts_with(&MAGIC) {
        return wrong("it does not begin with \"glTF\": save it as binary glTF".to_owned());
    }
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return wrong(format!("it ends within its header of {FILE_HEADER} bytes"));
    };
    if version != VERSION {
        return wrong(format!("it is of version {version}: save it as glTF 2.0"));
    }
    if u64::from(length) != bytes.len() as u64 {
        return wrong(format!("it says that it has {length} bytes, but it has {}", bytes.len()));
    }
    let (mut json, mut bin) = (None, None);
    let (mut at, mut number) = (FILE_HEADER, 0);
    while at < bytes.len() {
        let (Some(length), Some(kind)) = (word(bytes, at), bytes.get(at + 4..at + CHUNK_HEADER))
        else {
            return wrong(format!("it ends within the header of chunk {number}"));
        };
        if !length.is_multiple_of(4) {
            return wrong(format!("chunk {number} has {length} bytes, no multiple of 4"));
        }
        let start = at + CHUNK_HEADER;
        let Some(chunk) = bytes[start..].get(..length as usize) else {
            return wrong(format!(
                "chunk {number} says that it has {length} bytes, but {} are left",
                bytes.len() - start
            ));
        };
        match (kind == JSON_CHUNK, kind == BIN_CHUNK, number) {
            (true, _, 0) => json = Some(chunk),
            (_, true, 1) => bin = Some(chunk),
            (true, ..) => return wrong(format!("chunk {number} is JSON, which chunk 0 must be")),
            (_, true, _) => return wrong(format!("chunk {number} is BIN, which chunk 1 must be")),
            // Chunks of other kinds are for others.
            _ => {}
        }
        at = start + chunk.len();
        number += 1;
    }
    let Some(json) = json else {
        return wrong("its first chunk is not JSON".to_owned());
    };
    if json.len() > MOST_JSON {
        return wrong(format!("its JSON has {} bytes, over {MOST_JSON}", json.len()));
    }
    Ok(Chunks { json, bin: bin.unwrap_or_default() })
}

/// The little-endian number of four bytes there.
fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..)?.first_chunk()?;
    Some(u32::from_le_bytes(*word))
}
