//! Reading 3MF: `zip` for the package, `quick-xml` for the model.

use super::{ImportedMesh, ReadError, add_finite, not_empty};
use crate::geom::{DVec3, Welder};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::str::FromStr;
use thiserror::Error;
use zip::ZipArchive;

/// Most vertices or facets of a file: packed text may unfold to far more than memory holds.
const MOST: usize = 100_000_000;
/// Most bytes of a part of the package, unpacked: as of any file that is read.
const MOST_BYTES: u64 = 8_000_000_000;
/// Most objects, and most places where they are put.
const MOST_PARTS: usize = 100_000;
/// Longest tag or text between two tags.
const LONGEST: usize = 1 << 20;
/// Most steps from the build plate to an object, which may consist of others.
const DEEPEST: usize = 16;
/// The parts of any package that say what is in it and where it begins.
const TYPES: &str = "[Content_Types].xml";
const RELATIONS: &str = "_rels/.rels";
/// What a package says that these are.
const RELATIONS_CONTENT: &str = "application/vnd.openxmlformats-package.relationships+xml";
const MODEL_CONTENT: &str = "application/vnd.ms-package.3dmanufacturing-3dmodel+xml";
/// The relation that leads to the model.
const MODEL_TYPE: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

/// Why a 3MF could not be read.
#[derive(Debug, Error)]
pub enum ThreeMfError {
    /// The archive is broken, or lacks a part.
    #[error("{part}: {source}")]
    Zip {
        /// The part of the package.
        part: String,
        /// Why.
        source: zip::result::ZipError,
    },
    /// A part is not XML.
    #[error("{part}, byte {at}: {source}")]
    Xml {
        /// The part of the package.
        part: String,
        /// Where in it, unpacked.
        at: u64,
        /// Why.
        source: quick_xml::Error,
    },
    /// A part is XML, but not as 3MF has it.
    #[error("{part}, byte {at}: {fault}")]
    Model {
        /// The part of the package.
        part: String,
        /// Where in it, unpacked.
        at: u64,
        /// What is wrong.
        fault: String,
    },
    /// The build holds what cannot be placed.
    #[error("{0}")]
    Build(String),
}

/// Reads 3MF: all objects on the build plate, in millimetres. Coordinates are single-precision
/// numbers, as in lib3mf.
///
/// # Errors
/// [`ReadError`].
pub fn read_3mf(bytes: &[u8]) -> Result<ImportedMesh, ReadError> {
    let broken = |part: &str| {
        let part = part.to_owned();
        move |source| ThreeMfError::Zip { part, source }
    };
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(broken("the archive"))?;
    let mut types = ContentTypes::default();
    let listed = zip.by_name(TYPES).map_err(broken(TYPES))?;
    elements(listed, TYPES, |element| types.add(element))?;
    types.hold(RELATIONS, RELATIONS_CONTENT)?;
    let mut target = None;
    let relations = zip.by_name(RELATIONS).map_err(broken(RELATIONS))?;
    elements(relations, RELATIONS, |element| {
        if element.local_name().as_ref() == "Relationship"
            && attribute(element, "Type")? == Some(MODEL_TYPE.to_owned())
        {
            target = attribute(element, "Target")?;
        }
        Ok(())
    })?;
    let Some(target) = target else {
        let fault = "it leads to no model".to_owned();
        return Err(ThreeMfError::Model { part: RELATIONS.into(), at: 0, fault }.into());
    };
    let name = target.trim_start_matches('/');
    types.hold(name, MODEL_CONTENT)?;
    let mut model =
        Model { unit_mm: 1.0, objects: BTreeMap::new(), last: None, build: Vec::new(), parts: 0 };
    let part = zip.by_name(name).map_err(broken(name))?;
    if part.size() > MOST_BYTES {
        let fault = format!("it has {} bytes unpacked, over {MOST_BYTES}", part.size());
        return Err(ThreeMfError::Model { part: name.to_owned(), at: 0, fault }.into());
    }
    elements(part, name, |element| model.add(element))?;
    let Some([vertices, facets]) = model.size(&model.build, 0) else {
        let fault = format!(
            "the build must hold known objects of at most {MOST} vertices and facets, not nested \
             deeper than {DEEPEST}"
        );
        return Err(ThreeMfError::Build(fault).into());
    };
    let Some(welder) = Welder::reserved(vertices, facets) else {
        return Err(ReadError::Memory { vertices, facets });
    };
    let mut placed = BuildMesh { welder, count: 0 };
    let to_mm = Transform([
        [model.unit_mm, 0.0, 0.0],
        [0.0, model.unit_mm, 0.0],
        [0.0, 0.0, model.unit_mm],
        [0.0; 3],
    ]);
    for item in &model.build {
        placed.add(&model, item, &to_mm)?;
    }
    Ok(ImportedMesh { mesh: not_empty(placed.welder.finish())?, normals: None })
}

/// What the package says that its parts are: by their names, or by how these end.
#[derive(Default)]
struct ContentTypes {
    /// Names and endings in lower case.
    of: BTreeMap<String, String>,
}

impl ContentTypes {
    fn add(&mut self, element: &BytesStart) -> Result<(), String> {
        let key = match element.local_name().as_ref() {
            "Default" => attribute(element, "Extension")?,
            "Override" => attribute(element, "PartName")?,
            _ => return Ok(()),
        };
        let key = key.ok_or("it must name a part or an extension")?.to_lowercase();
        let content = attribute(element, "ContentType")?.ok_or("it must have a ContentType")?;
        self.of.insert(key, content);
        Ok(())
    }

    /// Fails unless the part is said to be of that type, as the Open Packaging Conventions ask for.
    fn hold(&self, part: &str, content: &str) -> Result<(), ThreeMfError> {
        let name = format!("/{}", part.to_lowercase());
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
        let said = self.of.get(&name).or_else(|| self.of.get(ending));
        if said.is_some_and(|said| said.eq_ignore_ascii_case(content)) {
            return Ok(());
        }
        let fault = format!("it must say that {part} is {content}");
        Err(ThreeMfError::Model { part: TYPES.to_owned(), at: 0, fault })
    }
}

/// Hands the elements of an XML part to `visit`, in order.
fn elements(
    part: impl Read,
    name: &str,
    mut visit: impl FnMut(&BytesStart) -> Result<(), String>,
) -> Result<(), ThreeMfError> {
    let mut reader =
        Reader::from_reader(BufReader::with_capacity(1 << 16, BoundedReader { part, since: 0 }));
    let (mut buffer, mut open) = (Vec::new(), 0_usize);
    loop {
        let event = next(&mut reader, &mut buffer, name)?;
        let at = reader.buffer_position();
        let wrong = |fault: String| ThreeMfError::Model { part: name.to_owned(), at, fault };
        match &event {
            Event::Start(element) => {
                open += 1;
                visit(element).map_err(wrong)?;
            }
            Event::Empty(element) => visit(element).map_err(wrong)?,
            Event::DocType(_) => {
                return Err(wrong("it has a document type (DTD), which 3MF forbids".to_owned()));
            }
            Event::End(_) => open = open.saturating_sub(1),
            Event::Eof if open > 0 => return Err(wrong(format!("it ends inside {open} elements"))),
            Event::Eof => return Ok(()),
            _ => {}
        }
        buffer.clear();
    }
}

/// Ends where the text between two tags, or a tag, is so long that it would fill memory.
struct BoundedReader<R> {
    part: R,
    /// Bytes since a tag ended.
    since: usize,
}

impl<R: Read> Read for BoundedReader<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.part.read(bytes)?;
        let last = bytes[..count].iter().rposition(|&byte| byte == b'>');
        self.since = last.map_or(self.since + count, |last| count - last);
        if self.since > LONGEST {
            let text = format!("a tag, or the text between two, is longer than {LONGEST} bytes");
            return Err(io::Error::new(io::ErrorKind::InvalidData, text));
        }
        Ok(count)
    }
}

fn next<'b>(
    reader: &mut Reader<impl BufRead>,
    buffer: &'b mut Vec<u8>,
    part: &str,
) -> Result<Event<'b>, ThreeMfError> {
    let event = reader.read_event_into(buffer);
    event.map_err(|source| ThreeMfError::Xml {
        part: part.to_owned(),
        at: reader.error_position(),
        source,
    })
}

/// The text of an attribute, if there is one.
fn attribute(element: &BytesStart, name: &str) -> Result<Option<String>, String> {
    for attribute in element.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        if attribute.key.0 == name {
            return Ok(Some(attribute.value.into_owned()));
        }
    }
    Ok(None)
}

/// The numbers that an element's attributes hold.
fn numbers<T: FromStr + Copy, const N: usize>(
    element: &BytesStart,
    names: [&str; N],
) -> Result<[T; N], String> {
    let mut found = [None; N];
    for attribute in element.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        if let Some(k) = names.iter().position(|&name| name == attribute.key.0) {
            found[k] = attribute.value.trim().parse().ok();
        }
    }
    if let Some(k) = found.iter().position(Option::is_none) {
        return Err(format!("{} must have a number {}", element.name().0, names[k]));
    }
    Ok(found.map(|number| number.expect("all are there")))
}

/// An affine map of row vectors: three rows for the axes and one for the origin.
struct Transform([[f64; 3]; 4]);

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

    /// First `self`, then `next`.
    fn then(&self, next: &Self) -> Self {
        let [x, y, z, origin] = self.0.map(DVec3::from_array);
        let still = next.apply(DVec3::ZERO);
        let turned = |axis: DVec3| (next.apply(axis) - still).to_array();
        Self([turned(x), turned(y), turned(z), next.apply(origin).to_array()])
    }

    /// Whether it turns the inside out.
    fn reflects(&self) -> bool {
        let [x, y, z, _] = self.0.map(DVec3::from_array);
        x.cross(y).dot(z) < 0.0
    }
}

/// An object somewhere.
struct BuildItem {
    object: u32,
    place: Transform,
}

impl BuildItem {
    fn of(element: &BytesStart) -> Result<Self, String> {
        if element.attributes().with_checks(false).flatten().any(|a| a.key.0.ends_with(":path")) {
            return Err("objects in other parts of the package are not read".to_owned());
        }
        let [object] = numbers(element, ["objectid"])?;
        Ok(Self { object, place: Transform::of(element)? })
    }
}

/// A mesh, or other objects.
#[derive(Default)]
struct ModelObject {
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    components: Vec<BuildItem>,
}

/// The model part, as far as it matters here.
struct Model {
    unit_mm: f64,
    objects: BTreeMap<u32, ModelObject>,
    last: Option<u32>,
    build: Vec<BuildItem>,
    /// Objects, and places where they are put.
    parts: usize,
}

impl Model {
    fn add(&mut self, element: &BytesStart) -> Result<(), String> {
        match element.local_name().as_ref() {
            "vertex" => {
                let vertices = &mut self.object()?.vertices;
                push(vertices, numbers(element, ["x", "y", "z"])?)?;
                few(vertices.len())
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
                few(object.triangles.len())
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
                self.unit_mm = match attribute(element, "unit")?.as_deref() {
                    None | Some("millimeter") => 1.0,
                    Some("micron") => 1e-3,
                    Some("centimeter") => 10.0,
                    Some("inch") => 25.4,
                    Some("foot") => 304.8,
                    Some("meter") => 1000.0,
                    Some(unit) => return Err(format!("unknown unit {unit}")),
                };
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

    /// How many vertices and facets the items have with all that they consist of; none if one is
    /// unknown, too deep, or they are too many.
    fn size(&self, items: &[BuildItem], depth: usize) -> Option<[usize; 2]> {
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

/// Adds an item to the list, if memory holds it.
fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), String> {
    let count = list.len();
    if list.try_reserve(1).is_err() {
        return Err(format!("there is not enough memory for more than {count} of them"));
    }
    list.push(item);
    Ok(())
}

fn few(count: usize) -> Result<(), String> {
    if count <= MOST { Ok(()) } else { Err(format!("more than {MOST} of them")) }
}

/// The facets of the whole build.
struct BuildMesh {
    welder: Welder,
    count: usize,
}

impl BuildMesh {
    fn add(&mut self, model: &Model, item: &BuildItem, next: &Transform) -> Result<(), ReadError> {
        let place = item.place.then(next);
        let ModelObject { vertices, triangles, components } = &model.objects[&item.object];
        let turned = place.reflects();
        for &triangle in triangles {
            let [a, b, c] = triangle.map(|v| {
                let single = vertices[v as usize];
                place.apply(DVec3::from_array(single.map(f64::from)))
            });
            add_finite(&mut self.welder, self.count, if turned { [a, c, b] } else { [a, b, c] })?;
            self.count += 1;
        }
        components.iter().try_for_each(|part| self.add(model, part, &place))
    }
}
