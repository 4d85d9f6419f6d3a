//! JSON, with the comments that OpenCV writes into it.

use super::CalibrationError;
use super::tree::{TreeNode, Value};
use serde::de::{self, DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use std::cell::Cell;
use std::fmt;
use std::io::{self, Read};

/// The value of a text. (The parser refuses nesting deeper than 128 levels.)
pub(super) fn parse(text: &str) -> Result<TreeNode, CalibrationError> {
    let line = Cell::new(1);
    let reader = LineReader { bytes: &without_comments(text), line: &line, is_broken: false };
    let mut json = serde_json::Deserializer::from_reader(reader);
    let parsed = AtLine(&line).deserialize(&mut json).and_then(|node| json.end().map(|()| node));
    parsed.map_err(|error| {
        let told = error.to_string();
        let reason = told.rsplit_once(" at line ").map_or(told.as_str(), |(reason, _)| reason);
        CalibrationError::Syntax {
            line: error.line().max(1),
            format: "JSON",
            reason: reason.into(),
        }
    })
}

/// The text with blanks for comments from `//` to the end of a line, outside strings.
fn without_comments(text: &str) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    let (mut in_string, mut in_comment, mut k) = (false, false, 0);
    while k < bytes.len() {
        match bytes[k] {
            b'\n' => (in_comment, in_string) = (false, false),
            _ if in_comment => bytes[k] = b' ',
            b'\\' if in_string => k += 1,
            b'"' => in_string = !in_string,
            b'/' if !in_string && bytes.get(k + 1) == Some(&b'/') => {
                in_comment = true;
                bytes[k] = b' ';
            }
            _ => {}
        }
        k += 1;
    }
    bytes
}

/// Bytes handed out one at a time, as the parser asks for them, and the line of the last of them.
struct LineReader<'t> {
    bytes: &'t [u8],
    line: &'t Cell<usize>,
    /// The last byte ended its line.
    is_broken: bool,
}

impl Read for LineReader<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let ([first, rest @ ..], Some(out)) = (self.bytes, out.first_mut()) else { return Ok(0) };
        (*out, self.bytes) = (*first, rest);
        self.line.set(self.line.get() + usize::from(self.is_broken));
        self.is_broken = *first == b'\n';
        Ok(1)
    }
}

/// A value whose line is that of the byte read last: it, or the one behind a number, which may end the line
/// but begins no other.
#[derive(Clone, Copy)]
struct AtLine<'t>(&'t Cell<usize>);

impl AtLine<'_> {
    fn node<E>(self, value: Value) -> Result<TreeNode, E> {
        Ok(TreeNode { line: self.0.get(), value })
    }
}

impl<'de> DeserializeSeed<'de> for AtLine<'_> {
    type Value = TreeNode;

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<TreeNode, D::Error> {
        json.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for AtLine<'_> {
    type Value = TreeNode;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_f64<E: de::Error>(self, number: f64) -> Result<TreeNode, E> {
        self.node(Value::Number(number))
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<TreeNode, E> {
        self.node(Value::Number(number as f64))
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<TreeNode, E> {
        self.node(Value::Number(number as f64))
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<TreeNode, E> {
        self.node(Value::Text(text.to_owned()))
    }

    fn visit_bool<E: de::Error>(self, flag: bool) -> Result<TreeNode, E> {
        self.node(Value::Text(flag.to_string()))
    }

    fn visit_unit<E: de::Error>(self) -> Result<TreeNode, E> {
        self.node(Value::Text("null".to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<TreeNode, A::Error> {
        let line = self.0.get();
        let mut list = Vec::new();
        while let Some(item) = items.next_element_seed(self)? {
            list.push(item);
        }
        Ok(TreeNode { line, value: Value::List(list) })
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<TreeNode, A::Error> {
        let line = self.0.get();
        let mut table = Vec::new();
        while let Some(key) = entries.next_key::<String>()? {
            let at = self.0.get();
            let value = entries.next_value_seed(self)?.value;
            table.push((key, TreeNode { line: at, value }));
        }
        Ok(TreeNode { line, value: Value::Table(table) })
    }
}
