//! A picture given as data: its file, and whether its directions meet the target.

use super::super::MapSpec;
use super::super::reader::{ProfileReader, Section};
use super::super::values::{Located, file, word};
use super::super::vector_map::{MOST_BYTES, VectorMap};
use super::projection::{ProjectionEntry, ProjectionKeys};
use super::{Entries, hex};
use crate::geom::DVec3;
use crate::optics::{DirectionSamples, Target};
use sha2::{Digest, Sha256};
use std::sync::Arc;

/// What the vectors of a map are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum VectorKind {
    /// Unit vectors.
    Direction,
    /// Points of the target, mm.
    Point,
}

/// Largest distance of a point from the target, as a share of its own from the origin: a table of five digits is
/// within.
const OFF: f64 = 1e-4;

/// A map's keys.
pub(super) struct MapKeys {
    file: Located<String>,
    sha256: String,
    kind: VectorKind,
    map: VectorMap,
    samples: DirectionSamples,
}

impl MapKeys {
    pub(super) fn finish(self, target: Target) -> MapSpec {
        let Self { file, sha256, samples, .. } = self;
        MapSpec { file: file.value, sha256, samples: Arc::new(samples), target }
    }
}

pub(super) fn read(reader: &mut ProfileReader, section: &Section) -> Option<MapKeys> {
    let kinds = [("direction", VectorKind::Direction), ("point", VectorKind::Point)];
    let hint =
        "direction: unit vectors; point: millimetres on the target; both in the part's frame";
    let kind = if section.has("kind") {
        word(reader, section, "kind", &kinds, hint)
    } else {
        Some(VectorKind::Direction)
    };
    let hint = "an array of (rows, columns, 3) beside the profile, as in file = \"wanted.npy\"";
    let file = file(reader, section, hint)?;
    let kind = kind?;
    let read = reader.file(&file.value, MOST_BYTES).and_then(|bytes| {
        let fault = |error: &dyn std::fmt::Display| format!("{}: {error}", file.value);
        let map = VectorMap::parse(&bytes).map_err(|error| fault(&error))?;
        let towards = |v: &DVec3| match kind {
            VectorKind::Direction => *v,
            // (Of a gap it is none.)
            VectorKind::Point => v.normalize(),
        };
        let directions = map.vectors.iter().map(towards).collect();
        let samples =
            DirectionSamples::new(map.columns, directions).map_err(|error| fault(&error))?;
        Ok((map, samples, hex(&Sha256::digest(&bytes))))
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

/// Whether the directions meet the target, and the points are on it.
pub(super) fn check(reader: &mut ProfileReader, parts: &Entries) {
    let Some(projection) = &parts.projection else { return };
    let ProjectionKeys::Map(Some(keys)) = &projection.keys else { return };
    let target = projection.target();
    if keys.kind == VectorKind::Point && target == Target::Infinity {
        let path = projection.section.path_of("kind");
        let message =
            format!("{path} = \"point\" must come with target_plane_mm or target_radius_mm");
        let hint = "points lie on a plane across the axis or on a cylinder about it; what is far away is given \
                    by directions";
        reader.complain(keys.file.at, message, hint);
        return;
    }
    let off = |v: &DVec3| -> f64 {
        let share = match target {
            Target::Infinity => 0.0,
            Target::Plane { height_mm } => height_mm / v.z,
            Target::Cylinder { radius_mm } => radius_mm / v.truncate().length(),
        };
        match keys.kind {
            // It must be met ahead.
            VectorKind::Direction if share >= 0.0 && share.is_finite() => 0.0,
            VectorKind::Direction => f64::INFINITY,
            VectorKind::Point => (share - 1.0).abs(),
        }
    };
    let found = keys.map.vectors.iter().position(|v| !v.is_nan() && !(off(v) <= OFF));
    if let Some(k) = found {
        complain_of_target(reader, projection, keys, k);
    }
}

fn complain_of_target(
    reader: &mut ProfileReader,
    projection: &ProjectionEntry,
    keys: &MapKeys,
    k: usize,
) {
    let (row, column) = (k / keys.map.columns + 1, k % keys.map.columns + 1);
    let target = match projection.target() {
        Target::Plane { height_mm } => format!("target_plane_mm = {height_mm}"),
        Target::Cylinder { radius_mm } => format!("target_radius_mm = {radius_mm}"),
        Target::Infinity => return,
    };
    let (what, hint) = match keys.kind {
        VectorKind::Direction => (
            "direction must meet the target",
            "directions lead from the middle of the mirror; NaN leaves out what is not wanted",
        ),
        VectorKind::Point => (
            "point must be on the target",
            "points are mm in the part's frame, from the middle of the mirror: X to the right of the picture, Y up \
             in it, Z towards the camera",
        ),
    };
    let v = keys.map.vectors[k];
    let path = projection.section.path_of("file");
    let message = format!(
        "{path}: {}: row {row}, column {column}: each {what}, {target}; found ({}, {}, {})",
        keys.file.value, v.x, v.y, v.z
    );
    reader.complain(keys.file.at, message, hint);
}
