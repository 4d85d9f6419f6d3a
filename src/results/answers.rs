//! Answers of a line: small results that are printed as JSON only.

use super::ProfileId;
use crate::design::LeastError;
use crate::profile::AcceptanceLimits;
use serde::Serialize;

/// A valid profile, and what no single mirror can do better: the answer of `morion check`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ProfileCheck {
    /// Name and fingerprint of the profile.
    #[serde(flatten)]
    pub profile: ProfileId,
    /// The least error that any single mirror has for its camera and picture; absent without a projection, and where it is
    /// not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_error: Option<LeastError>,
    /// Changes of one key that leave at least a tenth less of it; each was tried.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<LesserErrorFacts>,
    /// The limits that the picture will be held to; absent without a least error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accepted: Option<AcceptanceLimits>,
    /// Why the least error is not known: no mirror can be designed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unsolved: Option<String>,
}

/// A change of one key of a profile, and the least error after it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct LesserErrorFacts {
    /// The change, in words.
    pub change: String,
    /// The least error.
    pub least_error: LeastError,
}

/// A shipped profile: a line of `morion profiles`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ShippedProfile {
    /// Its name.
    pub name: String,
    /// What it is for, in a sentence.
    pub summary: String,
}

/// The trials of a part of a run: the answer of `morion tolerance --part`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct PartTrials {
    /// Path of the file that holds them.
    pub part: String,
    /// Number of trials in it.
    pub trials: u64,
}

/// A JSON output of the program: a line of `morion schema`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct NamedOutput {
    /// Name by which `morion schema NAME` prints its JSON Schema.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Commands that print or write it.
    pub from: &'static str,
}

/// Why a command could not be done: a line on standard output for each error.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ErrorLine {
    /// The error.
    pub error: ToldError,
}

/// An error, as far as its place is known.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct ToldError {
    /// Profile with the fault, as it was named; null where the error is about no profile's text.
    pub file: Option<String>,
    /// Line of the fault, from 1; null without a place.
    pub line: Option<usize>,
    /// Column of the fault, from 1; null without a place.
    pub column: Option<usize>,
    /// What is wrong, with figures.
    pub message: String,
    /// A way out; null where none is known.
    pub hint: Option<String>,
}

impl ToldError {
    /// An error that is a sentence.
    #[must_use]
    pub fn said(sentence: impl Into<String>) -> Self {
        Self { message: sentence.into(), ..Self::default() }
    }
}
