//! The package of a 3MF (Open Packaging Conventions): its parts, their content types, and their XML.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::str::FromStr;
use thiserror::Error;
use zip::ZipArchive;

/// Most bytes of a part of the package, unpacked: as of any file that is read.
const MOST_BYTES: u64 = 8_000_000_000;
/// Longest tag, or text between two tags, bytes.
const LONGEST: usize = 1 << 20;
/// The parts of any package that list its content types and where it begins.
const TYPES: &str = "[Content_Types].xml";
const RELATIONS: &str = "_rels/.rels";
/// Content types of the relations and of the model.
const RELATIONS_CONTENT: &str = "application/vnd.openxmlformats-package.relationships+xml";
const MODEL_CONTENT: &str = "application/vnd.ms-package.3dmanufacturing-3dmodel+xml";
/// Type of the relation that leads to the model.
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

/// Hands the elements of the package's model to `visit`, in order.
///
/// # Errors
/// [`ThreeMfError`] of the package, of the XML, or of what `visit` says.
pub(super) fn model_elements(
    bytes: &[u8],
    visit: impl FnMut(&BytesStart) -> Result<(), String>,
) -> Result<(), ThreeMfError> {
    let mut zip = ZipArchive::new(Cursor::new(bytes)).map_err(broken("the archive"))?;
    let mut types = ContentTypes::default();
    let listed = zip.by_name(TYPES).map_err(broken(TYPES))?;
    elements(listed, TYPES, |element| types.add(element))?;
    types.require(RELATIONS, RELATIONS_CONTENT)?;
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
        return Err(ThreeMfError::Model { part: RELATIONS.into(), at: 0, fault });
    };
    let name = target.trim_start_matches('/');
    types.require(name, MODEL_CONTENT)?;
    let part = zip.by_name(name).map_err(broken(name))?;
    if part.size() > MOST_BYTES {
        let fault = format!("it has {} bytes unpacked, over {MOST_BYTES}", part.size());
        return Err(ThreeMfError::Model { part: name.to_owned(), at: 0, fault });
    }
    elements(part, name, visit)
}

/// The error of a part that the archive does not give.
fn broken(part: &str) -> impl FnOnce(zip::result::ZipError) -> ThreeMfError {
    let part = part.to_owned();
    move |source| ThreeMfError::Zip { part, source }
}

/// Content types of the parts of a package, by their names or by how these end.
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

    /// Fails unless a part has that content type, as the Open Packaging Conventions ask for.
    fn require(&self, part: &str, content: &str) -> Result<(), ThreeMfError> {
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

/// Reader of a part that fails where a tag, or the text between two, is so long that it would fill memory.
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
pub(super) fn attribute(element: &BytesStart, name: &str) -> Result<Option<String>, String> {
    for attribute in element.attributes().with_checks(false) {
        let attribute = attribute.map_err(|error| error.to_string())?;
        if attribute.key.0 == name {
            return Ok(Some(attribute.value.into_owned()));
        }
    }
    Ok(None)
}

/// The numbers that an element's attributes hold.
pub(super) fn numbers<T: FromStr + Copy, const N: usize>(
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
