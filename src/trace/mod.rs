//! The witness: rays against the triangles of a file.
//!
//! It knows only those triangles and a table of intended rays handed to it, so it cannot agree
//! with a wrong design.

mod closed;
mod coverage;
mod drawing;
mod frame;
mod grid;
mod ground;
mod lattice;
mod line;
mod rays;
mod scene;
mod spot;
mod sweep;
mod witness;

pub use coverage::{Column, Coverage, Range, Seam};
pub use frame::{Fate, Frame, Lost, fates};
pub use scene::{Hit, Scene};
pub use sweep::{Glimpse, Sweep, Tally};
pub use witness::{Errors, Intent, Outcome, Seen, Witness, glance, look};
