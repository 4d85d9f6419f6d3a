//! What may be wrong with a calibration file.

use super::{LensModel, MOST_BYTES};
use thiserror::Error;

/// Reason why a file holds no calibration that can be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrationError {
    /// Too many bytes.
    #[error("a calibration must have at most {MOST_BYTES} bytes, found {bytes}")]
    TooLong {
        /// Their number.
        bytes: usize,
    },
    /// Not text.
    #[error("line {line}: a calibration must be UTF-8 text, found other bytes")]
    NotText {
        /// Line, from 1.
        line: usize,
    },
    /// Text that breaks the rules of its format.
    #[error("line {line}: the text must be {format}: {reason}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// YAML, JSON or XML.
        format: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// A key that is not there.
    #[error("{key} must be {must}, found nothing")]
    Missing {
        /// The key as OpenCV writes it.
        key: String,
        /// What it must be.
        must: String,
    },
    /// A value that cannot be used.
    #[error("line {line}: {key} must be {must}, found {found}")]
    Value {
        /// Line, from 1.
        line: usize,
        /// The key as the file has it.
        key: String,
        /// What it must be.
        must: String,
        /// What it is.
        found: String,
    },
    /// File and profile name different models.
    #[error("the file is of the model \"{file}\", found model = \"{profile}\" in the profile")]
    Models {
        /// The file's.
        file: LensModel,
        /// The profile's.
        profile: LensModel,
    },
    /// File and profile have different frames.
    #[error(
        "the file is of a frame of {} x {} pixels, found pixels = [{}, {}] in the profile",
        .file[0], .file[1], .profile[0], .profile[1]
    )]
    Frames {
        /// The file's.
        file: [u32; 2],
        /// The profile's.
        profile: [u32; 2],
    },
}
