//! The vertices of a PLY (Stanford polygon format 1.0), text or binary; faces and colours are left out.
//!
//! The crates that read PLY make a map of names for each vertex; a scan has millions.

use crate::geom::DVec3;
use std::str::FromStr;
use thiserror::Error;

/// Reason why a PLY could not be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlyError {
    /// It does not begin as one.
    #[error(
        "it does not begin with `ply` and `format ascii`, `binary_little_endian` or `binary_big_endian` 1.0"
    )]
    NotPly,
    /// A line of the header says something else.
    #[error("line {line} of its header is {found:?}")]
    Header {
        /// Line, from 1.
        line: usize,
        /// Its text, cut short.
        found: String,
    },
    /// The header does not end.
    #[error("its header has no end_header within {MOST_HEADER} bytes")]
    Endless,
    /// No vertices with places.
    #[error("it has no element vertex with the properties x, y and z")]
    NoVertices,
    /// More vertices than are taken.
    #[error("it has {found} vertices, more than {most} are not taken; thin it out")]
    TooMany {
        /// Vertices.
        found: usize,
        /// Most of them.
        most: usize,
    },
    /// Its data end before its elements do.
    #[error("its data end before element {element} of {name:?}")]
    Short {
        /// Name of the element, cut short.
        name: String,
        /// Its number, from 1.
        element: usize,
    },
    /// A coordinate is not a finite number.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// Its number, from 1.
        vertex: usize,
    },
}

/// Longest header, bytes.
const MOST_HEADER: usize = 1 << 16;
/// Characters of a line that a message quotes.
const QUOTED: usize = 40;

/// How values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

/// A type of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number in bytes of its size, the least first.
    fn number(self, bytes: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = bytes;
        match self {
            Self::I8 => f64::from(a as i8),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(bytes),
        }
    }
}

/// A property: of a list the type of its length too.
struct Property {
    name: String,
    length: Option<Kind>,
    kind: Kind,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes of one of it.
    fn least_bytes(&self, encoding: Encoding) -> usize {
        let least = |property: &Property| match (encoding, property.length) {
            (Encoding::Ascii, _) => 2,
            (_, Some(length)) => length.size(),
            (_, None) => property.kind.size(),
        };
        self.properties.iter().map(least).sum()
    }
}

/// Reads at most `most` vertices of a PLY, in its unit.
///
/// # Errors
/// The first [`PlyError`] met.
pub(super) fn read_ply(bytes: &[u8], most: usize) -> Result<Vec<DVec3>, PlyError> {
    let (encoding, elements, start) = header(bytes)?;
    let mut data = PlyData { rest: &bytes[start..], encoding };
    for element in &elements {
        let name = || element.name.chars().take(QUOTED).collect();
        let short = |k: usize| PlyError::Short { name: name(), element: k + 1 };
        let room = data.rest.len().saturating_add(1);
        let least = element.least_bytes(encoding).max(1);
        if element.count > 0 && element.count.saturating_sub(1) > room / least {
            return Err(short(room / least));
        }
        if element.name != "vertex" {
            for k in 0..element.count {
                data.element(element, |_, _| {}).ok_or_else(|| short(k))?;
            }
            continue;
        }
        let axis = |name: &str| {
            let scalar = |p: &Property| p.name == name && p.length.is_none();
            element.properties.iter().position(scalar).ok_or(PlyError::NoVertices)
        };
        let axes = [axis("x")?, axis("y")?, axis("z")?];
        if element.count > most {
            return Err(PlyError::TooMany { found: element.count, most });
        }
        let mut points = Vec::with_capacity(element.count);
        for k in 0..element.count {
            let mut at = [f64::NAN; 3];
            let take = |property: usize, value: f64| {
                if let Some(axis) = axes.iter().position(|&axis| axis == property) {
                    at[axis] = value;
                }
            };
            data.element(element, take).ok_or_else(|| short(k))?;
            if at.iter().any(|x| !x.is_finite()) {
                return Err(PlyError::NotFinite { vertex: k + 1 });
            }
            points.push(DVec3::from_array(at));
        }
        return Ok(points);
    }
    Err(PlyError::NoVertices)
}

/// Encoding and elements, and where the data begin.
fn header(bytes: &[u8]) -> Result<(Encoding, Vec<Element>, usize), PlyError> {
    let (mut at, mut encoding, mut elements) = (0, None, Vec::<Element>::new());
    for number in 1.. {
        let head = &bytes[at..bytes.len().min(MOST_HEADER)];
        let end = head.iter().position(|&byte| byte == b'\n').ok_or(match number {
            1 => PlyError::NotPly,
            _ => PlyError::Endless,
        })?;
        let line = String::from_utf8_lossy(&head[..end]);
        at += end + 1;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let bad =
            || PlyError::Header { line: number, found: line.trim().chars().take(QUOTED).collect() };
        match words[..] {
            ["ply"] if number == 1 => {}
            _ if number == 1 => return Err(PlyError::NotPly),
            ["format", name, "1.0"] if encoding.is_none() => {
                encoding = Some(match name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(PlyError::NotPly),
                });
            }
            [] | ["comment" | "obj_info", ..] => {}
            ["element", name, count] => {
                let count = usize::from_str(count).map_err(|_| bad())?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", "list", length, kind, name] => {
                let kinds = (Kind::named(length), Kind::named(kind), elements.last_mut());
                let (Some(length), Some(kind), Some(element)) = kinds else { return Err(bad()) };
                let property = Property { name: name.to_owned(), length: Some(length), kind };
                element.properties.push(property);
            }
            ["property", kind, name] => {
                let (Some(kind), Some(element)) = (Kind::named(kind), elements.last_mut()) else {
                    return Err(bad());
                };
                element.properties.push(Property { name: name.to_owned(), length: None, kind });
            }
            ["end_header"] => break,
            _ => return Err(bad()),
        }
    }
    Ok((encoding.ok_or(PlyError::NotPly)?, elements, at))
}

/// What is left of the data.
struct PlyData<'a> {
    rest: &'a [u8],
    encoding: Encoding,
}

impl PlyData<'_> {
    /// Reads an element, whose numbers that are no lists go to `take` with the property's index; none where the data end.
    fn element(&mut self, element: &Element, mut take: impl FnMut(usize, f64)) -> Option<()> {
        for (k, property) in element.properties.iter().enumerate() {
            match property.length {
                None => take(k, self.number(property.kind)?),
                Some(length) => self.skip_list(length, property.kind)?,
            }
        }
        Some(())
    }

    fn number(&mut self, kind: Kind) -> Option<f64> {
        if self.encoding == Encoding::Ascii {
            let rest = self.rest.trim_ascii_start();
            let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
            let (word, rest) = rest.split_at(end);
            self.rest = rest;
            // What is no number is none that is finite.
            let text = std::str::from_utf8(word).unwrap_or("");
            return (end > 0).then(|| f64::from_str(text).unwrap_or(f64::NAN));
        }
        let (own, rest) = self.rest.split_at_checked(kind.size())?;
        self.rest = rest;
        let mut bytes = [0; 8];
        bytes[..own.len()].copy_from_slice(own);
        if self.encoding == Encoding::Big {
            bytes[..own.len()].reverse();
        }
        Some(kind.number(bytes))
    }

    fn skip_list(&mut self, length: Kind, kind: Kind) -> Option<()> {
        let count = self.number(length)?;
        if !(count >= 0.0) {
            return None;
        }
        let count = count as usize;
        if self.encoding == Encoding::Ascii {
            return (0..count).try_for_each(|_| self.number(kind).map(|_| ()));
        }
        self.rest = self.rest.get(count.checked_mul(kind.size())?..)?;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "element camera 1\nproperty list uchar int ids\nproperty float f\n\
                        element vertex 2\nproperty double x\nproperty uchar red\nproperty float y\nproperty short z\n\
                        element face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn ply(format: &str, data: &[u8]) -> Vec<u8> {
        let head = format!("ply\nformat {format} 1.0\ncomment of a scan\n{HEAD}");
        [head.as_bytes(), data].concat()
    }

    fn binary(order: fn(&mut [u8])) -> Vec<u8> {
        let mut data = vec![2];
        let mut put = |bytes: &[u8]| {
            let mut bytes = bytes.to_vec();
            order(&mut bytes);
            data.extend(bytes);
        };
        [7i32, -9].iter().for_each(|id| put(&id.to_le_bytes()));
        put(&1.5f32.to_le_bytes());
        for (x, y, z) in [(1.25f64, -2.5f32, 3i16), (1e-3, 0.5, -400)] {
            put(&x.to_le_bytes());
            put(&[255]);
            put(&y.to_le_bytes());
            put(&z.to_le_bytes());
        }
        data
    }

    #[test]
    fn every_encoding_has_the_same_vertices() {
        let wanted = Ok(vec![DVec3::new(1.25, -2.5, 3.0), DVec3::new(1e-3, 0.5, -400.0)]);
        let text = ply("ascii", b"2 7 -9 1.5\n1.25 255 -2.5 3\n1e-3 0 0.5 -400\n3 0 1 1\n");
        assert_eq!(read_ply(&text, 2), wanted);
        assert_eq!(read_ply(&ply("binary_little_endian", &binary(|_| {})), 2), wanted);
        assert_eq!(read_ply(&ply("binary_big_endian", &binary(<[u8]>::reverse)), 2), wanted);
    }

    #[test]
    fn what_is_missing_or_too_much_is_told() {
        let data = binary(|_| {});
        let cut = read_ply(&ply("binary_little_endian", &data[..data.len() - 1]), 9);
        assert_eq!(cut, Err(PlyError::Short { name: "vertex".into(), element: 2 }));
        let many = read_ply(&ply("binary_little_endian", &data), 1);
        assert_eq!(many, Err(PlyError::TooMany { found: 2, most: 1 }));
        let word = read_ply(&ply("ascii", b"0 1.5 1 0 two 3 1 0 0 0"), 9);
        assert_eq!(word, Err(PlyError::NotFinite { vertex: 1 }));
        let huge =
            b"ply\nformat ascii 1.0\nelement vertex 18446744073709551615\nproperty float x\n\
                     property float y\nproperty float z\nend_header\n0 0 0\n";
        assert!(matches!(read_ply(huge, 9), Err(PlyError::Short { .. })));
        for (text, wanted) in [
            ("PLY\n", PlyError::NotPly),
            (
                "ply\nformat ascii 2.0\n",
                PlyError::Header { line: 2, found: "format ascii 2.0".into() },
            ),
            ("ply\nformat ascii 1.0\n", PlyError::Endless),
            (
                "ply\nformat ascii 1.0\nproperty float x\n",
                PlyError::Header { line: 3, found: "property float x".into() },
            ),
            (
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                PlyError::NoVertices,
            ),
            ("ply\nformat ascii 1.0\nend_header\n", PlyError::NoVertices),
            ("ply\nelement vertex 1\nend_header\n", PlyError::NotPly),
        ] {
            assert_eq!(read_ply(text.as_bytes(), 9), Err(wanted), "{text}");
        }
        // A name that would steer a terminal.
        let steering = b"ply\nformat ascii 1.0\nelement \x1b[31m 9\nproperty int n\nend_header\n";
        let said = read_ply(steering, 9).unwrap_err().to_string();
        assert!(said.contains("of \"\\u{1b}[31m\"") && !said.contains(char::is_control), "{said}");
        // Lists of negative length, and of one that no memory has.
        let lists = |length: &[u8]| {
            let head = "ply\nformat binary_little_endian 1.0\nelement a 1\nproperty list int double ids\n\
                        element vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
            read_ply(&[head.as_bytes(), length].concat(), 9)
        };
        let short = Err(PlyError::Short { name: "a".into(), element: 1 });
        assert_eq!(lists(&(-1i32).to_le_bytes()), short);
        assert_eq!(lists(&i32::MAX.to_le_bytes()), short);
        assert_eq!(lists(&0i32.to_le_bytes()), Ok(Vec::new()));
    }
}
