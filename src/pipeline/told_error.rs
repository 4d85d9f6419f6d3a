//! Errors as their JSON tells them.

use super::SourceError;
use crate::profile::Complaint;
use crate::results::ToldError;
use std::error::Error;

/// The errors of which `error` consists: every complaint about a profile is one.
#[must_use]
pub fn all_errors(error: &(dyn Error + 'static)) -> Vec<ToldError> {
    match error.downcast_ref() {
        Some(SourceError::Faulty(complaints)) => complaints.0.iter().map(ToldError::from).collect(),
        _ => vec![ToldError::said(error.to_string())],
    }
}

impl From<&Complaint> for ToldError {
    fn from(complaint: &Complaint) -> Self {
        let Complaint { file, line, column, message, hint } = complaint.clone();
        Self { file: Some(file), line: Some(line), column: Some(column), message, hint }
    }
}
