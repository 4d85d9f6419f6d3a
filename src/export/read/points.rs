//! Reading lists of measured points: lines of X, Y and Z, and the vertices of a PLY.

use super::ply::{PlyError, read_ply};
use crate::geom::{DVec3, XyzFault, xyz_lines};
use thiserror::Error;

/// Most points of a list.
pub const MOST_POINTS: usize = 20_000_000;

/// A format of measured points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointFormat {
    /// Lines of X, Y and Z between commas, semicolons, tabs or spaces.
    Text,
    /// PLY, text or binary.
    Ply,
}

/// Reason why a list of points could not be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PointsError {
    /// Not text.
    #[error("line {line}: a list of points must be UTF-8 text, found other bytes")]
    NotText {
        /// Line, from 1.
        line: usize,
    },
    /// A line with fewer than three columns.
    #[error("line {line}: a line must hold X, Y and Z, found {found:?}")]
    Columns {
        /// Line, from 1.
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
        /// Line, from 1.
        line: usize,
        /// X, Y or Z.
        axis: char,
        /// Its text, cut short.
        found: String,
    },
    /// Too many points.
    #[error("a list must have at most {MOST_POINTS} points, found more; thin it out")]
    TooMany,
    /// Not a PLY with vertices.
    #[error("not a readable PLY: {0}")]
    Ply(#[from] PlyError),
}

impl From<XyzFault> for PointsError {
    fn from(fault: XyzFault) -> Self {
        match fault {
            XyzFault::NotText { line } => Self::NotText { line },
            XyzFault::Columns { line, found } => Self::Columns { line, found },
            XyzFault::Number { line, axis, found } => Self::Number { line, axis, found },
            XyzFault::TooMany { .. } => Self::TooMany,
        }
    }
}

/// Reads a list of measured points, in the file's unit.
///
/// # Errors
/// [`PointsError`] with its line, or with what of a PLY is not as it should be.
pub fn read_points(format: PointFormat, bytes: &[u8]) -> Result<Vec<DVec3>, PointsError> {
    match format {
        PointFormat::Text => {
            let lines = xyz_lines(bytes, MOST_POINTS)?;
            Ok(lines.iter().map(|line| DVec3::from_array(line.at)).collect())
        }
        PointFormat::Ply => Ok(read_ply(bytes, MOST_POINTS)?),
    }
}
