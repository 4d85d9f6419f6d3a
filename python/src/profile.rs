//! Profiles.

use crate::errors::source_error;
use morion::SourceError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A checked profile.
#[pyclass(frozen, module = "morion")]
pub(crate) struct Profile {
    pub(crate) inner: Arc<morion::Profile>,
}

#[pymethods]
impl Profile {
    /// The profile of a file, or the shipped one of that name.
    #[staticmethod]
    fn load(py: Python<'_>, named: PathBuf) -> PyResult<Self> {
        let named = named.to_string_lossy().into_owned();
        let found = py.detach(|| morion::Profile::load(&named));
        Self::made(py, found)
    }

    /// The profile of a text.
    #[staticmethod]
    fn parse(py: Python<'_>, name: &str, text: &str) -> PyResult<Self> {
        let file = format!("{name}.toml");
        let found = morion::Profile::parse(name, &file, text.as_bytes());
        Self::made(py, found.map_err(SourceError::from))
    }

    /// Name that output goes under.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// SHA-256 of the profile's bytes, in hexadecimal.
    #[getter]
    fn sha256(&self) -> &str {
        &self.inner.sha256
    }

    /// Purpose of the mirror in the author's words.
    #[getter]
    fn summary(&self) -> &str {
        &self.inner.summary
    }

    /// Columns and rows of the camera's frame.
    #[getter]
    fn pixels(&self) -> (u32, u32) {
        self.inner.camera.pixels().into()
    }

    fn __repr__(&self) -> String {
        let [columns, rows] = self.inner.camera.pixels();
        format!("<morion.Profile {}, {columns} x {rows} pixels>", self.inner.name)
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }
}

impl Profile {
    fn made(py: Python<'_>, found: Result<morion::Profile, SourceError>) -> PyResult<Self> {
        match found {
            Ok(profile) => Ok(Self { inner: Arc::new(profile) }),
            Err(error) => Err(source_error(py, &error)),
        }
    }
}

/// Name and text of each shipped profile.
#[pyfunction]
pub(crate) fn shipped() -> Vec<(&'static str, &'static str)> {
    morion::shipped().iter().map(|shipped| (shipped.name, shipped.text)).collect()
}
