//! Upper bounds of errors, the limits that they are held to, and the two kinds of errors.

use crate::geom::Precision;
use crate::num::max_or_nan;

/// Upper bounds of the errors of one facet, or of all facets of a mesh, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorBound {
    /// Chord error: distance between facet and mirror along the rays of the mirror's chart, mm.
    pub chord_mm: f64,
    /// Facet error: displacement of the image against the smooth mirror, mm on the mirror.
    pub facet_mm: f64,
    /// Displacement of the image by rounding the vertices to single precision, mm on the mirror.
    pub rounding_mm: f64,
}

impl ErrorBound {
    /// The bound of a triangle that is no facet: none.
    pub(crate) const INFINITE: Self =
        Self { chord_mm: f64::INFINITY, facet_mm: f64::INFINITY, rounding_mm: f64::INFINITY };

    /// The bound that holds for both; NaN where either is.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            chord_mm: max_or_nan(self.chord_mm, other.chord_mm),
            facet_mm: max_or_nan(self.facet_mm, other.facet_mm),
            rounding_mm: max_or_nan(self.rounding_mm, other.rounding_mm),
        }
    }
}

/// The largest errors that a facet may have; an absent limit does not count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Limit of the chord error, mm.
    pub chord_mm: Option<f64>,
    /// Limit of the facet error, mm on the mirror.
    pub facet_mm: Option<f64>,
    /// Precision of the file for which they hold.
    pub precision: Precision,
}

impl Limits {
    /// Whether `bound` is within the limits.
    #[must_use]
    pub fn hold(&self, bound: &ErrorBound) -> bool {
        self.chord_mm.is_none_or(|limit| bound.chord_mm <= limit)
            && self.facet_mm.is_none_or(|limit| bound.facet_mm <= limit)
    }

    /// Whether a facet that attains these chord and facet errors (mm) may still be within the limits.
    pub(crate) fn may_hold(&self, [chord, facet]: [f64; 2]) -> bool {
        self.chord_mm.is_none_or(|limit| chord <= limit)
            && self.facet_mm.is_none_or(|limit| facet <= limit)
    }
}

/// The two errors that have limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ErrorKind {
    /// The chord error.
    Chord,
    /// The facet error.
    Facet,
}

impl ErrorKind {
    /// Both kinds, in the order of arrays of attained errors.
    pub(crate) const ALL: [Self; 2] = [Self::Chord, Self::Facet];

    /// The bound of this kind of error, mm.
    pub(crate) fn of(self, bound: &ErrorBound) -> f64 {
        match self {
            Self::Chord => bound.chord_mm,
            Self::Facet => bound.facet_mm,
        }
    }

    /// Sets the bound of this kind of error to `to` mm.
    pub(crate) fn set(self, bound: &mut ErrorBound, to: f64) {
        match self {
            Self::Chord => bound.chord_mm = to,
            Self::Facet => bound.facet_mm = to,
        }
    }

    /// The limit of this kind of error, mm.
    pub(crate) fn limit(self, limits: &Limits) -> Option<f64> {
        match self {
            Self::Chord => limits.chord_mm,
            Self::Facet => limits.facet_mm,
        }
    }

    /// The element of this kind in an array of chord and facet error.
    pub(crate) fn of_both(self, both: [f64; 2]) -> f64 {
        both[self as usize]
    }
}
