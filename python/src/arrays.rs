//! Arrays of NumPy: out of vectors without a copy, and rows of them as slices.

use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Array of shape (n, N), C-contiguous, which owns the vector's memory.
pub(crate) fn rows<'py, T: Element, const N: usize>(
    py: Python<'py>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([count, N])
}

/// Rows of an array of shape (n, N) and C-contiguous.
pub(crate) fn vectors<const N: usize>(
    array: &PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<[f64; N]>> {
    let fits = array.shape()[1] == N;
    let flat = array.as_slice().ok().filter(|_| fits);
    let flat = flat.ok_or_else(|| {
        PyValueError::new_err(format!("a contiguous array of shape (n, {N}) is needed"))
    })?;
    Ok(flat.as_chunks().0.to_vec())
}

/// Each of `values`, and NaN in the place of none.
pub(crate) fn or_nan<const N: usize>(values: Vec<Option<[f64; N]>>) -> Vec<[f64; N]> {
    values.into_iter().map(|value| value.unwrap_or([f64::NAN; N])).collect()
}
