//! Files: read whole, hashed, and published together. Nothing appears under its own name before all files
//! of a command are whole.

mod error;
mod folder;
mod hash;
mod journal;
mod read;
mod transaction;

pub use crate::profile::sha256;
pub use error::FileError;
pub use folder::abandon;
pub use hash::{HashingWriter, hash_pieces};
pub use journal::{Journal, journal_lines, journal_under_way};
pub use read::{files_of, read, read_at_most, read_below, read_named};
pub use transaction::{OutputFile, StagedFile, Transaction};
