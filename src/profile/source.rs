//! From a file's bytes to text that is safe to parse.
//!
//! The parser builds, and later drops, one level of tables for each bracket and for each dot of a
//! key, by recursion. It limits brackets and dots, but not the product of the two, with which a
//! hostile file could exhaust the stack of a thread. No real profile nests more than a few levels,
//! so depth is checked before anything is built.

use super::complaint::{Complaint, Complaints};
use super::lines::LineIndex;

/// Largest profile, in bytes.
pub(super) const MAX_BYTES: usize = 64 * 1024;
const MAX_BRACKETS: usize = 16;
const MAX_DOTS: usize = 8;

/// The text of a profile, or the one complaint that stops all others.
pub(crate) fn text<'b>(file: &str, bytes: &'b [u8]) -> Result<&'b str, Complaints> {
    let one = |(line, column): (usize, usize), message: String, hint: &str| {
        Complaints(vec![Complaint {
            file: file.to_owned(),
            line,
            column,
            message,
            hint: Some(hint.to_owned()),
        }])
    };
    if bytes.len() > MAX_BYTES {
        return Err(one(
            (1, 1),
            format!("the file must be at most {MAX_BYTES} bytes long, found {}", bytes.len()),
            "a page of text is meant; is this a mesh or a picture?",
        ));
    }
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let good = &bytes[..error.valid_up_to()];
        let place = LineIndex::new(std::str::from_utf8(good).unwrap_or("")).place(good.len());
        let bad = bytes.get(good.len()).copied().unwrap_or(0);
        let hint = match bytes {
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "this looks like UTF-16; save it as UTF-8",
            _ => "save the file as UTF-8",
        };
        let message = format!("the file must be UTF-8 text, found the byte 0x{bad:02X}");
        one(place, message, hint)
    })?;
    if let Some(deep) = too_deep(text) {
        let (offset, message, hint) = match deep {
            NestingError::Brackets(offset) => (
                offset,
                format!("brackets must be nested at most {MAX_BRACKETS} deep, found one more"),
                "the values of a profile are numbers, words and short lists of them",
            ),
            NestingError::Key(offset) => (
                offset,
                format!("a key must have at most {MAX_DOTS} dots, found one more"),
                "the longest keys look like projection.cylindrical.azimuth_deg",
            ),
        };
        return Err(one(LineIndex::new(text).place(offset), message, hint));
    }
    Ok(text)
}

enum NestingError {
    Brackets(usize),
    Key(usize),
}

/// The first place where the text nests too deep. Cuts strings and comments out just as the parser does.
fn too_deep(text: &str) -> Option<NestingError> {
    let bytes = text.as_bytes();
    let (mut at, mut brackets, mut dots) = (0, 0_usize, 0);
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'#' => {
                at += until(&bytes[at..], b"\r\n");
                continue;
            }
            b'"' | b'\'' => {
                at = end_of_string(bytes, at);
                continue;
            }
            b'[' | b'{' => {
                brackets += 1;
                dots = 0;
                if brackets > MAX_BRACKETS {
                    return Some(NestingError::Brackets(at));
                }
            }
            b']' | b'}' => {
                brackets = brackets.saturating_sub(1);
                dots = 0;
            }
            b'=' | b',' | b'\r' | b'\n' => dots = 0,
            b'.' => {
                dots += 1;
                if dots > MAX_DOTS {
                    return Some(NestingError::Key(at));
                }
            }
            _ => {}
        }
        at += 1;
    }
    None
}

fn until(bytes: &[u8], stops: &[u8]) -> usize {
    bytes.iter().position(|b| stops.contains(b)).unwrap_or(bytes.len())
}

/// The offset after the string that opens at `at`. An unclosed one ends with its line, or with the
/// text if it is a long one.
fn end_of_string(bytes: &[u8], at: usize) -> usize {
    let quote = bytes[at];
    let escapes = quote == b'"';
    let triple = [quote; 3];
    let long = bytes[at..].starts_with(&triple);
    let mut end = at + if long { 3 } else { 1 };
    while let Some(&byte) = bytes.get(end) {
        if byte == b'\\' && escapes {
            end += 1;
            // Only these two can change where the string ends.
            if matches!(bytes.get(end), Some(b'\\' | b'"')) {
                end += 1;
            }
        } else if long && bytes[end..].starts_with(&triple) {
            // Up to two quotes before the closing three belong to the string.
            let closing = bytes[end..].iter().take(5).take_while(|b| **b == quote);
            return end + closing.count();
        } else if !long && byte == quote {
            return end + 1;
        } else if !long && byte == b'\n' {
            return end;
        } else {
            end += 1;
        }
    }
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaint(bytes: &[u8]) -> Option<Complaint> {
        text("p.toml", bytes).err().map(|c| c.0[0].clone())
    }

    #[test]
    fn size_is_checked_before_anything_else() {
        assert!(complaint(&vec![b'#'; MAX_BYTES]).is_none());
        let complaint = complaint(&vec![0xff; MAX_BYTES + 1]).expect("too long");
        assert!(complaint.message.ends_with("found 65537"));
    }

    #[test]
    fn the_first_bad_byte_is_placed_in_characters() {
        let complaint = complaint(b"# \xc2\xb1\n# \xc2\xb1 \xfe\n").expect("not UTF-8");
        assert_eq!((complaint.line, complaint.column), (2, 5));
        assert!(complaint.message.ends_with("0xFE"));
    }

    #[test]
    fn depth_in_strings_and_comments_does_not_count() {
        let brackets = "[".repeat(100);
        let dots = "a.".repeat(100);
        for quiet in [
            format!("# {brackets} {dots}\na = 1"),
            format!("a = \"{brackets}{dots}\""),
            format!("a = \"\\\"{brackets}\\\\\""),
            format!("a = '{brackets}\\'"),
            format!("a = '''\n'{brackets}''{dots}\n'''"),
            format!("a = \"\"\"\n\"{brackets}\\\"\"\"{dots}\"\"\"\"\""),
        ] {
            assert!(too_deep(&quiet).is_none(), "{quiet}");
        }
        for loud in [
            format!("a = \"x\n{brackets}"),
            format!("a = 'x'{brackets}"),
            format!("a = '\\'{brackets}"),
            format!("a = \"\\\\\"{brackets}"),
            format!("a = '''x'''{brackets}"),
            format!("# x\n{dots}b = 1"),
            format!("[{dots}b]"),
        ] {
            assert!(too_deep(&loud).is_some(), "{loud}");
        }
    }

    #[test]
    fn many_shallow_values_are_fine() {
        let list = "[0.5, 1.5], ".repeat(500);
        assert!(too_deep(&format!("a = [{list}]\n[a.b.c]\nd.e.f = 1.5\n")).is_none());
    }
}
