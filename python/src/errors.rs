//! Errors of the library as exceptions of Python.

use morion::SourceError;
use pyo3::prelude::*;

/// Module of the exceptions.
const MODULE: &str = "morion._errors";

/// An exception of a class of the package.
fn exception<'py>(
    py: Python<'py>,
    class: &str,
    arguments: impl pyo3::call::PyCallArgs<'py>,
) -> PyErr {
    let made = py.import(MODULE).and_then(|module| module.getattr(class)?.call1(arguments));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// `MorionError`: why something could not be done.
pub(crate) fn error(py: Python<'_>, message: &str) -> PyErr {
    exception(py, "MorionError", (message,))
}

/// `ProfileError` with all complaints about a profile, or `MorionError` where there is none to complain about.
pub(crate) fn source_error(py: Python<'_>, error: &SourceError) -> PyErr {
    let SourceError::Faulty(complaints) = error else {
        return self::error(py, &error.to_string());
    };
    let complaints = complaints.0.iter().map(|complaint| {
        let complaint = complaint.clone();
        (complaint.file, complaint.line, complaint.column, complaint.message, complaint.hint)
    });
    let all: Vec<_> = complaints.collect();
    exception(py, "ProfileError", (error.to_string(), all))
}
