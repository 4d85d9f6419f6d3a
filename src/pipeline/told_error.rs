//! Errors as other programs read them.

use super::SourceError;
use crate::profile::Complaint;
use serde::Serialize;
use std::error::Error;

/// An error, as far as its place is known; in JSON null what is not.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct ToldError {
    /// The file.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Column in characters, from 1.
    pub column: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// Hint at what would be right.
    pub hint: Option<String>,
}

impl ToldError {
    /// An error that is a sentence.
    #[must_use]
    pub fn said(sentence: impl Into<String>) -> Self {
        Self { message: sentence.into(), ..Self::default() }
    }

    /// The errors of which `error` consists: every complaint about a profile is one.
    #[must_use]
    pub fn all_of(error: &(dyn Error + 'static)) -> Vec<Self> {
        match error.downcast_ref() {
            Some(SourceError::Faulty(complaints)) => complaints.0.iter().map(Self::from).collect(),
            _ => vec![Self::said(error.to_string())],
        }
    }
}

impl From<&Complaint> for ToldError {
    fn from(complaint: &Complaint) -> Self {
        let Complaint { file, line, column, message, hint } = complaint.clone();
        Self { file: Some(file), line: Some(line), column: Some(column), message, hint }
    }
}
