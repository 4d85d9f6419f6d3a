//! The model of a 3MF: objects, their instances, and the mesh of the whole build.

use super::super::{ReadError, add_finite};
use super::package::{attribute, numbers};
use crate::geom::{DVec3, TriMesh, Welder};
use quick_xml::events::BytesStart;
use std::collections::BTreeMap;

/// Most vertices or facets of a file: packed text may unfold to far more than memory holds.
pub(super) const MOST: usize = 100_000_000;
/// Most objects and instances of them.
const MOST_PARTS: usize = 100_000;
/// Deepest nesting of objects on the build plate.
pub(super) const DEEPEST: usize = 16;

/// Affine map of row vectors: three rows for the axes and one for the origin.
pub(super) struct Transform(pub [[f64; 3]; 4]);

impl Transform {
    /// From an attribute `transform` of twelve numbers.
    fn of(element: &BytesStart) -> Result<Self, String> {
        let Some(text) = attribute(element, "transform")? else {
            let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis.to_array());
            return Ok(Self([x, y, z, [0.0; 3]]));
        };
        let numbers: Result<Vec<f64>, _> = text.split_whitespace().map(str::parse).collect();
        let rows = numbers.ok().and_then(|numbers| <[f64; 12]>::try_from(numbers).ok());
        let m = rows.ok_or("transform must hold twelve numbers")?;
        Ok(Self(std::array::from_fn(|row| std::array::from_fn(|k| m[3 * row + k]))))
    }

    fn apply(&self, p: DVec3) -> DVec3 {
        let [x, y, z, origin] = self.0.map(DVec3::from_array);
        x * p.x + y * p.y + z * p.z + origin
    }

    /// The composition of `self` and, after it, `next`.
    fn then(&self, next: &Self) -> Self {
        let [x, y, z, origin] = self.0.map(DVec3::from_array);
        let still = next.apply(DVec3::ZERO);
        let turned = |axis: DVec3| (next.apply(axis) - still).to_array();
        Self([turned(x), turned(y), turned(z), next.apply(origin).to_array()])
    }

    /// Whether it reverses orientation.
    fn reflects(&self) -> bool {
        let [x, y, z, _] = self.0.map(DVec3::from_array);
        x.cross(y).dot(z) < 0.0
    }
}

/// Instance of an object: its number and its transform.
pub(super) struct BuildItem {
    object: u32,
    transform: Transform,
}

impl BuildItem {
    fn of(element: &BytesStart) -> Result<Self, String> {
        if element.attributes().with_checks(false).flatten().any(|a| a.key.0.ends_with(":path")) {
            return Err("objects in other parts of the package are not read".to_owned());
        }
        let [object] = numbers(element, ["objectid"])?;
        Ok(Self { object, transform: Transform::of(element)? })
    }
}

/// An object: a mesh, or instances of other objects.
#[derive(Default)]
struct ModelObject {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    components: Vec<BuildItem>,
}

/// The model part of a package: unit, objects and build, without materials and metadata.
pub(super) struct ThreeMfModel {
    /// Length of its unit, mm.
    pub unit_mm: f64,
    objects: BTreeMap<u32, ModelObject>,
    /// Number of the object that is being read.
    last: Option<u32>,
    /// Instances on the build plate.
    pub build: Vec<BuildItem>,
    /// Number of objects and of their instances.
    parts: usize,
}

impl Default for ThreeMfModel {
    fn default() -> Self {
        Self { unit_mm: 1.0, objects: BTreeMap::new(), last: None, build: Vec::new(), parts: 0 }
    }
}

impl ThreeMfModel {
    /// Takes in an element of the model part.
    pub(super) fn add(&mut self, element: &BytesStart) -> Result<(), String> {
        match element.local_name().as_ref() {
            "vertex" => {
                let vertices = &mut self.object()?.vertices;
                push(vertices, numbers(element, ["x", "y", "z"])?)?;
                ensure_few(vertices.len())
            }
            "triangle" => {
                let corners: [u32; 3] = numbers(element, ["v1", "v2", "v3"])?;
                let object = self.object()?;
                let count = object.vertices.len();
                if let Some(corner) = corners.iter().find(|&&v| v as usize >= count) {
                    let t = object.triangles.len();
                    return Err(format!("facet {t} has vertex {corner} of {count}"));
                }
                push(&mut object.triangles, corners)?;
                ensure_few(object.triangles.len())
            }
            "component" => {
                let item = BuildItem::of(element)?;
                self.object()?.components.push(item);
                self.part()
            }
            "object" => {
                let [id] = numbers(element, ["id"])?;
                self.last = Some(id);
                match self.objects.insert(id, ModelObject::default()) {
                    Some(_) => Err(format!("object {id} is there twice")),
                    None => self.part(),
                }
            }
            "item" => {
                self.build.push(BuildItem::of(element)?);
                self.part()
            }
            "model" => {
                self.unit_mm = unit_mm(attribute(element, "unit")?.as_deref())?;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn part(&mut self) -> Result<(), String> {
        self.parts += 1;
        let few = self.parts <= MOST_PARTS;
        few.then_some(())
            .ok_or_else(|| format!("more than {MOST_PARTS} objects and places of them"))
    }

    fn object(&mut self) -> Result<&mut ModelObject, String> {
        let last = self.last.and_then(|last| self.objects.get_mut(&last));
        last.ok_or_else(|| "it must stand in an object".to_owned())
    }

    /// Numbers of vertices and facets of instances with all that they consist of; `None` if an object is
    /// unknown, nested too deep, or they are too many.
    pub(super) fn size(&self, items: &[BuildItem], depth: usize) -> Option<[usize; 2]> {
        items.iter().try_fold([0, 0], |sum: [usize; 2], item| {
            let object = self.objects.get(&item.object).filter(|_| depth < DEEPEST)?;
            let parts = self.size(&object.components, depth + 1)?;
            let own = [object.vertices.len(), object.triangles.len()];
            // An empty part counts too: it takes time.
            let sum = [0, 1].map(|k| sum[k] + own[k] + parts[k] + 1);
            sum.iter().all(|&sum| sum <= MOST).then_some(sum)
        })
    }
}

/// Length of a unit that 3MF knows, mm.
fn unit_mm(name: Option<&str>) -> Result<f64, String> {
    match name {
        None | Some("millimeter") => Ok(1.0),
        Some("micron") => Ok(1e-3),
        Some("centimeter") => Ok(10.0),
        Some("inch") => Ok(25.4),
        Some("foot") => Ok(304.8),
        Some("meter") => Ok(1000.0),
        Some(unit) => Err(format!("unknown unit {unit}")),
    }
}

/// Adds an item to the list, if memory holds it.
fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), String> {
    let count = list.len();
    if list.try_reserve(1).is_err() {
        return Err(format!("there is not enough memory for more than {count} of them"));
    }
    list.push(item);
    Ok(())
}

fn ensure_few(count: usize) -> Result<(), String> {
    if count <= MOST { Ok(()) } else { Err(format!("more than {MOST} of them")) }
}

/// Facets of the whole build in millimetres, vertices at the same place joined.
pub(super) struct BuildMesh {
    welder: Welder,
    count: usize,
}

impl BuildMesh {
    /// An empty mesh with room for so many vertices and facets; `None` if memory does not hold them.
    pub(super) fn reserved(vertices: usize, facets: usize) -> Option<Self> {
        Some(Self { welder: Welder::reserved(vertices, facets)?, count: 0 })
    }

    /// The mesh of all instances that were added.
    pub(super) fn finish(self) -> TriMesh {
        self.welder.finish()
    }

    /// Adds an instance and all that its object consists of, transformed by its own map and `next`.
    pub(super) fn add(
        &mut self,
        model: &ThreeMfModel,
        item: &BuildItem,
        next: &Transform,
    ) -> Result<(), ReadError> {
        let transform = item.transform.then(next);
        let ModelObject { vertices, triangles, components } = &model.objects[&item.object];
        let reflected = transform.reflects();
        for &triangle in triangles {
            let [a, b, c] = triangle.map(|v| {
                let single = vertices[v as usize];
                transform.apply(DVec3::from_array(single.map(f64::from)))
            });
            add_finite(
                &mut self.welder,
                self.count,
                if reflected { [a, c, b] } else { [a, b, c] },
            )?;
            self.count += 1;
        }
        components.iter().try_for_each(|part| self.add(model, part, &transform))
    }
}
