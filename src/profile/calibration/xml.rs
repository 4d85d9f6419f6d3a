//! XML, as OpenCV writes it: an element for a key, numbers in a row as its text.

use super::CalibrationError;
use super::tree::{DEEPEST, TreeNode, Value};
use quick_xml::Reader;
use quick_xml::events::Event;

/// The element around all others.
const ROOT: &str = "opencv_storage";

/// An element that is not closed yet.
struct Element {
    name: String,
    line: usize,
    children: Vec<(String, TreeNode)>,
    text: String,
    /// Line on which the text begins.
    text_line: usize,
}

/// Lines of places that are asked for in their order.
struct Lines<'t> {
    text: &'t str,
    at: usize,
    line: usize,
}

impl Lines<'_> {
    fn at(&mut self, place: u64) -> usize {
        let place = usize::try_from(place).unwrap_or(usize::MAX).clamp(self.at, self.text.len());
        let bytes = &self.text.as_bytes()[self.at..place];
        self.line += bytes.iter().filter(|byte| **byte == b'\n').count();
        self.at = place;
        self.line
    }
}

fn fault(line: usize, reason: impl Into<String>) -> CalibrationError {
    CalibrationError::Syntax { line, format: "XML", reason: reason.into() }
}

/// The keys below the root.
pub(super) fn parse(text: &str) -> Result<TreeNode, CalibrationError> {
    let mut reader = Reader::from_str(text);
    let mut lines = Lines { text, at: 0, line: 1 };
    let mut open: Vec<Element> = Vec::new();
    let mut root = None;
    loop {
        let line = lines.at(reader.buffer_position());
        let event = reader.read_event().map_err(|error| fault(line, error.to_string()))?;
        let (start, is_empty) = match event {
            Event::Start(start) => (start, false),
            Event::Empty(start) => (start, true),
            Event::Text(text) => {
                add(open.last_mut(), &text.into_inner(), line)?;
                continue;
            }
            Event::CData(text) => {
                add(open.last_mut(), &text.into_inner(), line)?;
                continue;
            }
            Event::GeneralRef(name) => {
                add(open.last_mut(), &format!("&{};", name.into_inner()), line)?;
                continue;
            }
            Event::End(_) => {
                close(&mut open, &mut root)?;
                continue;
            }
            Event::Eof => break,
            Event::DocType(_) => return Err(fault(line, "document types are not read")),
            Event::Comment(_) | Event::Decl(_) | Event::PI(_) => continue,
        };
        let name = start.name().as_ref().to_owned();
        if open.len() > DEEPEST {
            return Err(fault(line, format!("at most {DEEPEST} levels are read")));
        }
        if open.is_empty() && (name != ROOT || root.is_some()) {
            return Err(fault(line, format!("one element <{ROOT}> must hold all others")));
        }
        open.push(Element {
            name,
            line,
            children: Vec::new(),
            text: String::new(),
            text_line: line,
        });
        if is_empty {
            close(&mut open, &mut root)?;
        }
    }
    let line = lines.at(u64::MAX);
    match (open.last(), root) {
        (None, Some(root)) => Ok(root),
        (Some(open), _) => {
            Err(fault(line, format!("<{}> of line {} is not closed", open.name, open.line)))
        }
        (None, None) => Err(fault(line, format!("there is no element <{ROOT}>"))),
    }
}

/// Adds text to an element.
fn add(element: Option<&mut Element>, text: &str, line: usize) -> Result<(), CalibrationError> {
    let Some(element) = element else {
        return match text.trim() {
            "" => Ok(()),
            _ => Err(fault(line, format!("text stands outside <{ROOT}>"))),
        };
    };
    if element.text.is_empty() {
        element.text_line = line;
    }
    element.text += text;
    Ok(())
}

/// Closes the innermost element.
fn close(open: &mut Vec<Element>, root: &mut Option<TreeNode>) -> Result<(), CalibrationError> {
    let Some(element) = open.pop() else { return Ok(()) };
    let (name, node) = finished(element)?;
    match open.last_mut() {
        Some(parent) => parent.children.push((name, node)),
        None => *root = Some(node),
    }
    Ok(())
}

fn finished(element: Element) -> Result<(String, TreeNode), CalibrationError> {
    let Element { name, line, children, text, text_line } = element;
    if children.is_empty() {
        return Ok((name, TreeNode { line, value: texts(&text, line, text_line) }));
    }
    if !text.trim().is_empty() {
        return Err(fault(text_line, format!("<{name}> holds text beside elements")));
    }
    let is_list = children.iter().all(|(name, _)| name == "_");
    let value = if is_list {
        Value::List(children.into_iter().map(|(_, node)| node).collect())
    } else {
        Value::Table(children)
    };
    Ok((name, TreeNode { line, value }))
}

/// A number, several of them, or text.
fn texts(text: &str, line: usize, text_line: usize) -> Value {
    let whole = text.trim();
    if let Some(quoted) = whole.strip_prefix('"') {
        return Value::Text(quoted.strip_suffix('"').unwrap_or(quoted).to_owned());
    }
    let mut items = Vec::new();
    for (row, words) in text.split('\n').enumerate() {
        items.extend(words.split_whitespace().map(|word| TreeNode::plain(text_line + row, word)));
    }
    let is_numeric = items.iter().any(|item| matches!(item.value, Value::Number(_)));
    match items.len() {
        1 => TreeNode::plain(line, whole).value,
        2.. if is_numeric => Value::List(items),
        _ => Value::Text(whole.to_owned()),
    }
}
