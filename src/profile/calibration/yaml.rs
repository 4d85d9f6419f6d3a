//! YAML, of OpenCV and of ROS.

use super::CalibrationError;
use super::tree::{DEEPEST, TreeNode, Value};
use saphyr_parser::{Event, Parser, ScalarStyle, Span, StrInput};

type Events<'t> = Parser<'t, StrInput<'t>>;

fn fault(line: usize, reason: impl Into<String>) -> CalibrationError {
    CalibrationError::Syntax { line, format: "YAML", reason: reason.into() }
}

/// The one document of a text. OpenCV's older header, `%YAML:1.0`, is none of YAML's own; its tags say nothing
/// that the keys do not say.
pub(super) fn parse(text: &str) -> Result<TreeNode, CalibrationError> {
    let mended;
    let text = match text.strip_prefix("%YAML:") {
        Some(rest) => {
            mended = format!("#YAML:{rest}");
            &mended
        }
        None => text,
    };
    let mut events = Parser::new_from_str(text);
    let mut root = None;
    loop {
        let (event, span) = next(&mut events)?;
        match event {
            Event::StreamEnd => {
                let empty = TreeNode { line: 1, value: Value::Text(String::new()) };
                return Ok(root.unwrap_or(empty));
            }
            Event::StreamStart | Event::DocumentStart(_) | Event::DocumentEnd => {}
            event => {
                let node = node(&mut events, event, span, 0)?;
                // A printed ROS message ends with a line `---`, which opens an empty one.
                let is_empty = node.value == Value::Text(String::new());
                match root {
                    Some(_) if !is_empty => {
                        return Err(fault(node.line, "one document alone is read"));
                    }
                    Some(_) => {}
                    None => root = Some(node),
                }
            }
        }
    }
}

fn next<'t>(events: &mut Events<'t>) -> Result<(Event<'t>, Span), CalibrationError> {
    match events.next_event() {
        Some(Ok(event)) => Ok(event),
        Some(Err(error)) => Err(fault(error.marker().line(), error.info())),
        None => Ok((Event::StreamEnd, Span::default())),
    }
}

fn node(
    events: &mut Events<'_>,
    event: Event<'_>,
    span: Span,
    depth: usize,
) -> Result<TreeNode, CalibrationError> {
    let line = span.start.line();
    if depth > DEEPEST {
        return Err(fault(line, format!("at most {DEEPEST} levels are read")));
    }
    let value = match event {
        Event::Scalar(text, ScalarStyle::Plain, ..) => return Ok(TreeNode::plain(line, &text)),
        Event::Scalar(text, ..) => Value::Text(text.into_owned()),
        Event::SequenceStart(..) => {
            let mut list = Vec::new();
            loop {
                match next(events)? {
                    (Event::SequenceEnd, _) => break Value::List(list),
                    (event, span) => list.push(node(events, event, span, depth + 1)?),
                }
            }
        }
        Event::MappingStart(..) => {
            let mut table = Vec::new();
            loop {
                let (event, span) = next(events)?;
                let key = match event {
                    Event::MappingEnd => break Value::Table(table),
                    Event::Scalar(text, ..) => text.into_owned(),
                    _ => return Err(fault(span.start.line(), "keys must be words")),
                };
                let at = span.start.line();
                let (event, span) = next(events)?;
                let value = node(events, event, span, depth + 1)?.value;
                table.push((key, TreeNode { line: at, value }));
            }
        }
        Event::Alias(_) => return Err(fault(line, "aliases are not read")),
        _ => return Err(fault(line, "the text ends too soon")),
    };
    Ok(TreeNode { line, value })
}
