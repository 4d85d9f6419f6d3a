//! The scene of a GLB: its nodes, where they are, and the triangles of their meshes.

use super::super::{ReadError, add_finite, not_empty};
use super::GlbError;
use super::accessor::{Corners, Indices, Positions, item};
use super::document::{Document, MOST_ITEMS, Node, Primitive};
use crate::geom::{DVec3, TriMesh, Welder};
use glam::{DAffine3, DMat3, DQuat};
use std::collections::BTreeSet;

/// Most vertices or facets of all meshes as often as they are there: a few bytes may repeat a mesh.
const MOST: usize = 100_000_000;
/// The mode of a primitive of triangles, each of three corners of its own.
const TRIANGLES: u32 = 4;
/// Largest deviation of a rotation's length from 1: more than single precision and few decimals leave.
const UNIT: f64 = 1e-3;
/// Largest deviation from -1, 0 or 1 that a number of a product of matrices has by rounding.
const ROUNDING: f64 = 1e-12;

/// A primitive and the map from its coordinates to millimetres in the part's frame.
struct PlacedPrimitive<'a> {
    part: String,
    positions: Positions<'a>,
    corners: Corners<'a>,
    to_part: DAffine3,
}

/// Primitives of a scene, and how many vertices and facets they have.
#[derive(Default)]
struct PlacedPrimitives<'a> {
    all: Vec<PlacedPrimitive<'a>>,
    vertices: usize,
    facets: usize,
}

/// The mesh of the scene, vertices at the same place joined.
pub(super) fn mesh(document: &Document, bin: &[u8]) -> Result<TriMesh, ReadError> {
    let placed = placed(document, bin)?;
    let (vertices, facets) = (placed.vertices, placed.facets);
    let Some(mut welder) = Welder::reserved(vertices.min(3 * facets), facets) else {
        return Err(ReadError::Memory { vertices, facets });
    };
    let mut number = 0;
    for PlacedPrimitive { part, positions, corners, to_part } in placed.all {
        let reflected = to_part.matrix3.determinant() < 0.0;
        let count = positions.count();
        for t in 0..corners.count() / 3 {
            let facet = corners.facet(t);
            if let Some(v) = facet.into_iter().find(|&v| v >= count) {
                let fault = format!("facet {t} has vertex {v} of {count}");
                return Err(GlbError::of(part, fault).into());
            }
            let [a, b, c] = facet.map(|v| to_part.transform_point3(positions.get(v)));
            add_finite(&mut welder, number, if reflected { [a, c, b] } else { [a, b, c] })?;
            number += 1;
        }
    }
    not_empty(welder.finish())
}

/// Metres with Y up to millimetres with Z up.
fn metres_to_part() -> DAffine3 {
    let axes = [DVec3::X, DVec3::Z, -DVec3::Y].map(|axis| 1000.0 * axis);
    DAffine3::from_mat3(DMat3::from_cols(axes[0], axes[1], axes[2]))
}

/// The primitives of the scene that is shown, in the order of its nodes, each before its children.
fn placed<'a>(document: &Document, bin: &'a [u8]) -> Result<PlacedPrimitives<'a>, GlbError> {
    let scenes = &document.scenes.0;
    let scene = match (document.scene, scenes.len()) {
        (Some(scene), _) => item(scenes, scene, "scene", "scene")?,
        (None, 1) => &scenes[0],
        (None, count) => {
            let fault = format!("it must say which of {count} scenes is meant");
            return Err(GlbError::of("scene", fault));
        }
    };
    let nodes = &document.nodes.0;
    let mut seen = vec![false; nodes.len()];
    let mut placed = PlacedPrimitives::default();
    // (Nesting is not recursion: it may be deep.)
    let mut next = Vec::new();
    add_nodes(&mut next, document, "scene", &scene.nodes.0, metres_to_part())?;
    while let Some((number, above)) = next.pop() {
        let (node, name) = (&nodes[number], format!("nodes[{number}]"));
        if std::mem::replace(&mut seen[number], true) {
            return Err(GlbError::of(name, "it is there twice, but nodes form trees"));
        }
        let to_part = above * own_transform(node, &name)?;
        if let Some(mesh) = node.mesh {
            ensure_alone(node, &name)?;
            placed.add(document, bin, mesh, &name, cleaned(to_part))?;
        }
        add_nodes(&mut next, document, &name, &node.children.0, to_part)?;
    }
    Ok(placed)
}

/// Puts nodes with the map above them on the pile of those that come next, the first on top.
fn add_nodes(
    next: &mut Vec<(usize, DAffine3)>,
    document: &Document,
    user: &str,
    numbers: &[usize],
    above: DAffine3,
) -> Result<(), GlbError> {
    for &number in numbers.iter().rev() {
        item(&document.nodes.0, number, user, "node")?;
        next.push((number, above));
    }
    Ok(())
}

/// Fails if a node's mesh is not there once and as it is.
fn ensure_alone(node: &Node, name: &str) -> Result<(), GlbError> {
    if node.skin.is_some() {
        return Err(GlbError::of(name, "skins are not read: apply them before saving"));
    }
    if node.extensions.instances.is_some() {
        let fault = "EXT_mesh_gpu_instancing is not read: save a node for each instance";
        return Err(GlbError::of(name, fault));
    }
    Ok(())
}

/// The map of a node's own coordinates to those of its parent.
fn own_transform(node: &Node, name: &str) -> Result<DAffine3, GlbError> {
    let Node { matrix, translation, rotation, scale, .. } = node;
    let Some(matrix) = matrix else {
        let [x, y, z, w] = rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let rotation = DQuat::from_xyzw(x, y, z, w);
        if !((rotation.length() - 1.0).abs() <= UNIT) {
            return Err(GlbError::of(name, "rotation must be a unit quaternion"));
        }
        return Ok(DAffine3::from_scale_rotation_translation(
            scale.map_or(DVec3::ONE, DVec3::from_array),
            rotation.normalize(),
            translation.map_or(DVec3::ZERO, DVec3::from_array),
        ));
    };
    if translation.is_some() || rotation.is_some() || scale.is_some() {
        let fault = "it has both a matrix and translation, rotation or scale";
        return Err(GlbError::of(name, fault));
    }
    if [matrix[3], matrix[7], matrix[11], matrix[15]] != [0.0, 0.0, 0.0, 1.0] {
        return Err(GlbError::of(name, "the last row of its matrix must be 0 0 0 1"));
    }
    let column = |k: usize| DVec3::from_slice(&matrix[4 * k..]);
    Ok(DAffine3::from_mat3_translation(
        DMat3::from_cols(column(0), column(1), column(2)),
        column(3),
    ))
}

/// The map without the rounding of its product: one that places nothing elsewhere keeps every bit.
fn cleaned(map: DAffine3) -> DAffine3 {
    DAffine3::from_cols_array(&map.to_cols_array().map(|x| {
        let whole = x.round();
        if whole.abs() <= 1.0 && (x - whole).abs() <= ROUNDING { whole } else { x }
    }))
}

impl<'a> PlacedPrimitives<'a> {
    /// Adds a mesh, which the node `name` has.
    fn add(
        &mut self,
        document: &Document,
        bin: &'a [u8],
        number: usize,
        name: &str,
        to_part: DAffine3,
    ) -> Result<(), GlbError> {
        let mesh = item(&document.meshes.0, number, name, "mesh")?;
        // Primitives may share their vertices.
        let mut known = BTreeSet::new();
        for (k, primitive) in mesh.primitives.0.iter().enumerate() {
            let part = format!("meshes[{number}].primitives[{k}]");
            let (accessor, positions) = positions(document, bin, &part, primitive)?;
            let corners = match primitive.indices {
                Some(indices) => Corners::Listed(Indices::new(document, bin, &part, indices)?),
                None => Corners::InTurn(positions.count()),
            };
            if !corners.count().is_multiple_of(3) {
                let fault = format!("it has {} corners, no multiple of 3", corners.count());
                return Err(GlbError::of(part, fault));
            }
            if known.insert(accessor) {
                self.vertices = self.vertices.saturating_add(positions.count());
            }
            self.facets = self.facets.saturating_add(corners.count() / 3);
            if self.vertices > MOST || self.facets > MOST || self.all.len() == MOST_ITEMS {
                let fault = format!(
                    "with it the scene has more than {MOST} vertices or facets, or more than \
                     {MOST_ITEMS} primitives"
                );
                return Err(GlbError::of(part, fault));
            }
            self.all.push(PlacedPrimitive { part, positions, corners, to_part });
        }
        Ok(())
    }
}

/// The positions of a primitive of triangles, and the number of their accessor.
fn positions<'a>(
    document: &Document,
    bin: &'a [u8],
    part: &str,
    primitive: &Primitive,
) -> Result<(usize, Positions<'a>), GlbError> {
    let wrong = |fault: String| Err(GlbError::of(part, fault));
    let mode = primitive.mode.unwrap_or(TRIANGLES);
    if mode != TRIANGLES {
        let kind = match mode {
            0 => "points",
            1..=3 => "lines",
            5 => "triangle strips",
            6 => "triangle fans",
            _ => "unknown primitives",
        };
        return wrong(format!("{kind} (mode {mode}) are not read: save it as triangles"));
    }
    if primitive.targets.is_some() {
        return wrong("morph targets are not read: apply them before saving".to_owned());
    }
    let Some(accessor) = primitive.attributes.position else {
        return wrong("it has no POSITION".to_owned());
    };
    Ok((accessor, Positions::new(document, bin, part, accessor)?))
}
