//! The JSON of a GLB: what of it holds triangles and places them.

use super::GlbError;
use serde::de::{Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;

/// Most items of a list: three bytes of JSON may unfold to hundreds.
pub(super) const MOST_ITEMS: usize = 100_000;

/// Beginnings of the names of extensions that change how a surface looks, not where it is.
const APPEARANCE: [&str; 4] = ["KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_"];

/// The whole document.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    asset: Asset,
    #[serde(default)]
    extensions_required: BoundedList<String>,
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: BoundedList<SceneRoots>,
    #[serde(default)]
    pub nodes: BoundedList<Node>,
    #[serde(default)]
    pub meshes: BoundedList<Mesh>,
    #[serde(default)]
    pub accessors: BoundedList<Accessor>,
    #[serde(default)]
    pub buffer_views: BoundedList<BufferView>,
    #[serde(default)]
    pub buffers: BoundedList<Buffer>,
}

impl Document {
    /// Fails if a reader of glTF 2.0 without extensions does not read it as it is meant.
    pub(super) fn check(&self) -> Result<(), GlbError> {
        let Asset { version, min_version } = &self.asset;
        let needed = min_version.as_ref().unwrap_or(version);
        if needed != "2.0" {
            let fault = format!("it is of version {needed}: save it as glTF 2.0");
            return Err(GlbError::of("asset", fault));
        }
        let shape = |name: &&String| !APPEARANCE.iter().any(|start| name.starts_with(start));
        match self.extensions_required.0.iter().find(shape) {
            None => Ok(()),
            Some(name) => {
                let remedy = match name.contains("compression") {
                    true => "save it without compression",
                    false => "save it without this extension",
                };
                Err(GlbError::of("extensionsRequired", format!("{name} is not read: {remedy}")))
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

/// Numbers of the nodes at the roots of a scene.
#[derive(Deserialize)]
pub(super) struct SceneRoots {
    #[serde(default)]
    pub nodes: BoundedList<usize>,
}

/// A node: a mesh and other nodes, placed by a matrix (by columns), or by scale, rotation (a quaternion, its real
/// part last) and translation.
#[derive(Deserialize)]
pub(super) struct Node {
    pub mesh: Option<usize>,
    pub skin: Option<IgnoredAny>,
    #[serde(default)]
    pub children: BoundedList<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    #[serde(default)]
    pub extensions: NodeExtensions,
}

/// The extension by which a node is there more than once.
#[derive(Deserialize, Default)]
pub(super) struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instances: Option<IgnoredAny>,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub primitives: BoundedList<Primitive>,
}

/// A piece of a mesh; its attributes and indices are numbers of accessors.
#[derive(Deserialize)]
pub(super) struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<usize>,
    pub mode: Option<u32>,
    pub targets: Option<IgnoredAny>,
}

#[derive(Deserialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<usize>,
}

/// A sequence of numbers or vectors.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<IgnoredAny>,
}

/// A piece of a buffer.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

/// Bytes: those of the binary chunk, or of another file.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub byte_length: usize,
    pub uri: Option<IgnoredAny>,
}

/// A list of at most [`MOST_ITEMS`].
pub(super) struct BoundedList<T>(pub Vec<T>);

impl<T> Default for BoundedList<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for BoundedList<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(ListVisitor(PhantomData))
    }
}

struct ListVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for ListVisitor<T> {
    type Value = BoundedList<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a list of at most {MOST_ITEMS}")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = list.next_element()? {
            if items.len() == MOST_ITEMS {
                return Err(A::Error::custom(format!("a list has more than {MOST_ITEMS} items")));
            }
            items.push(item);
        }
        Ok(BoundedList(items))
    }
}
