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
    /// A line that is no point, or one too many.
    #[error(transparent)]
    Lines(#[from] XyzFault),
    /// Not a PLY with vertices.
    #[error("not a readable PLY: {0}")]
    Ply(#[from] PlyError),
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
