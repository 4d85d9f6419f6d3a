//! Reasons of a negative verdict, each of a kind.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Deref;

/// What a reason is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ReasonKind {
    /// The bytes on the disk are others than were written.
    Altered,
    /// The bytes are no file of their format.
    Unreadable,
    /// The mesh is not closed, not oriented, in pieces or inside out.
    NotSolid,
    /// The volume is another than the design's.
    Volume,
    /// A vertex is off the designed part.
    OffSurface,
    /// The part is too large or too small, as with another unit.
    Size,
    /// Facets lie far from the part.
    FarFacets,
    /// No camera ray is aimed at the mirror.
    NothingAimed,
    /// Rays miss the part.
    Missed,
    /// Rays are shadowed by the part.
    Shadowed,
    /// Rays meet the back of a facet.
    BackFace,
    /// Facets displace the image by more than was asked for or proven.
    FacetError,
    /// The picture is farther off the projection than the profile accepts.
    PixelError,
    /// An error has no finite value.
    NotFinite,
    /// Less of the frame is filled than the profile accepts.
    FrameFilled,
    /// Spots are longer than the profile accepts.
    Blur,
    /// A measured part departs from the design by more than its limit.
    FormError,
    /// A drawing or table does not agree with the design.
    OffDesign,
    /// A table has no rows.
    EmptyTable,
    /// Single precision does not carry the tolerances.
    SinglePrecision,
    /// No mesh keeps the tolerances.
    NoMesh,
}

/// Why a verdict is negative: one sentence with figures, which is all that files hold of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", from = "String")]
pub struct Reason {
    /// What it is about; none of a reason that was read from a file.
    pub kind: Option<ReasonKind>,
    sentence: String,
}

impl Reason {
    /// A reason of a kind.
    pub fn new(kind: ReasonKind, sentence: impl Into<String>) -> Self {
        Self { kind: Some(kind), sentence: sentence.into() }
    }

    /// The same with a way out.
    #[must_use]
    pub fn with(self, way: &str) -> Self {
        Self { sentence: format!("{}; {way}", self.sentence), ..self }
    }

    /// The same, said of the file `name`.
    #[must_use]
    pub fn of_file(self, name: &str) -> Self {
        Self { sentence: format!("{name}: {}", self.sentence), ..self }
    }
}

impl Deref for Reason {
    type Target = str;

    fn deref(&self) -> &str {
        &self.sentence
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}

impl From<Reason> for String {
    fn from(reason: Reason) -> Self {
        reason.sentence
    }
}

impl From<String> for Reason {
    fn from(sentence: String) -> Self {
        Self { kind: None, sentence }
    }
}
