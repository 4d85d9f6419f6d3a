//! Text of one place a line: X, Y and Z in any of the usual dialects.

use std::str::FromStr;
use thiserror::Error;

/// A line's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct XyzLine {
    /// X, Y and Z, finite.
    pub at: [f64; 3],
    /// Number of the line, from 1.
    pub line: u32,
}

/// Why a line is none of X, Y and Z, with its number from 1.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum XyzFault {
    /// Not text.
    #[error("line {line}: a list of points must be UTF-8 text, found other bytes")]
    NotText {
        /// Line.
        line: usize,
    },
    /// A line with fewer than three columns.
    #[error("line {line}: a line must hold X, Y and Z, found {found:?}")]
    Columns {
        /// Line.
        line: usize,
        /// Its text, cut short.
        found: String,
    },
    /// A column that is no finite number.
    #[error(
        "line {line}: {axis} must be a finite number, found {found:?}; the first three columns are X, Y and Z, with \
         decimal points"
    )]
    Number {
        /// Line.
        line: usize,
        /// X, Y or Z.
        axis: char,
        /// Its text, cut short.
        found: String,
    },
    /// One line more than may be.
    #[error("a list must have at most {most} points, found more; thin it out")]
    TooMany {
        /// The first line too many.
        line: usize,
        /// Most that there may be.
        most: usize,
    },
}

/// Reads at most `most` lines of X, Y, Z, separated by commas, semicolons, tabs or spaces. Further columns do not
/// matter; `#` begins a comment, and one line of titles may come first.
///
/// # Errors
/// The first [`XyzFault`] met.
pub fn xyz_lines(bytes: &[u8], most: usize) -> Result<Vec<XyzLine>, XyzFault> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut places = Vec::new();
    let mut titles = true;
    for (k, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let number = k + 1;
        let text = std::str::from_utf8(line).map_err(|_| XyzFault::NotText { line: number })?;
        let text = text.split('#').next().unwrap_or("").trim();
        if text.is_empty() {
            continue;
        }
        let may_be_titles = std::mem::take(&mut titles);
        let fields = fields(text);
        if may_be_titles && fields[0].is_some_and(|field| f64::from_str(field).is_err()) {
            continue;
        }
        let [Some(x), Some(y), Some(z)] = fields else {
            return Err(XyzFault::Columns { line: number, found: short(text) });
        };
        let value = |axis: char, field: &str| match f64::from_str(field) {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(XyzFault::Number { line: number, axis, found: short(field) }),
        };
        let at = [value('X', x)?, value('Y', y)?, value('Z', z)?];
        if places.len() == most {
            return Err(XyzFault::TooMany { line: number, most });
        }
        places.push(XyzLine { at, line: u32::try_from(number).unwrap_or(u32::MAX) });
    }
    Ok(places)
}

/// The first three columns.
fn fields(text: &str) -> [Option<&str>; 3] {
    let mark = [';', ','].into_iter().find(|&mark| text.contains(mark));
    match mark {
        Some(mark) => {
            let mut fields = text.split(mark).map(str::trim);
            std::array::from_fn(|_| fields.next())
        }
        None => {
            let mut fields = text.split_whitespace();
            std::array::from_fn(|_| fields.next())
        }
    }
}

fn short(text: &str) -> String {
    const MOST: usize = 40;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
