//! A picture given as data: its keys and its file.

use super::super::MapSpec;
use super::super::profile_file::sha256;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, file, word};
use super::super::vector_map::{MOST_BYTES, VectorMap};
use crate::geom::DVec3;
use crate::optics::{DirectionSamples, Target};
use std::sync::Arc;

/// What the vectors of a map are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VectorKind {
    /// Unit vectors.
    Direction,
    /// Points of the target, mm from the middle of the mirror.
    Point,
}

/// A map's keys.
pub(super) struct MapKeys {
    pub(super) file: Located<String>,
    sha256: String,
    pub(super) kind: VectorKind,
    /// As the file has them.
    pub(super) map: VectorMap,
    samples: DirectionSamples,
}

impl MapKeys {
    pub(super) fn finish(self, target: Target) -> MapSpec {
        let Self { file, sha256, samples, .. } = self;
        MapSpec { file: file.value, sha256, samples: Arc::new(samples), target }
    }
}

/// `viewpoint_mm`: where directions start, mm from the middle of the mirror.
pub(super) fn read(
    reader: &mut ProfileReader,
    section: &Section,
    viewpoint_mm: DVec3,
) -> Option<MapKeys> {
    let kinds = [("direction", VectorKind::Direction), ("point", VectorKind::Point)];
    let hint =
        "direction: unit vectors; point: millimetres on the target; both in the part's frame";
    let kind = if section.has("kind") {
        word(reader, section, "kind", &kinds, hint)
    } else {
        Some(VectorKind::Direction)
    };
    let file = named_file(reader, section)?;
    loaded(reader, section, file, (kind?, viewpoint_mm))
}

/// The same of a section that has directions, in the part's frame, alone.
pub(super) fn directions(reader: &mut ProfileReader, section: &Section) -> Option<MapKeys> {
    let file = named_file(reader, section)?;
    loaded(reader, section, file, (VectorKind::Direction, DVec3::ZERO))
}

fn named_file(reader: &mut ProfileReader, section: &Section) -> Option<Located<String>> {
    let hint = "an array of (rows, columns, 3) beside the profile, as in file = \"wanted.npy\"";
    file(reader, section, hint)
}

fn loaded(
    reader: &mut ProfileReader,
    section: &Section,
    file: Located<String>,
    (kind, viewpoint_mm): (VectorKind, DVec3),
) -> Option<MapKeys> {
    let read = reader.file(&file.value, MOST_BYTES).and_then(|bytes| {
        let fault = |error: &dyn std::fmt::Display| format!("{}: {error}", file.value);
        let map = VectorMap::parse(&bytes).map_err(|error| fault(&error))?;
        let towards = |v: &DVec3| match kind {
            VectorKind::Direction => *v,
            // (Of a gap it is none.)
            VectorKind::Point => (*v - viewpoint_mm).normalize(),
        };
        let directions = map.vectors.iter().map(towards).collect();
        let samples =
            DirectionSamples::new(map.columns, directions).map_err(|error| fault(&error))?;
        Ok((map, samples, sha256(&bytes)))
    });
    match read {
        Ok((map, samples, sha256)) => Some(MapKeys { file, sha256, kind, map, samples }),
        Err(reason) => {
            let message = format!("{}: {reason}", section.path_of("file"));
            reader.complain(file.at, message, "");
            None
        }
    }
}
