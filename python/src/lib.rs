//! The native part of the Python package `morion`: the library's front door with NumPy arrays. What users see is in `morion/*.py`.

mod arrays;
mod commands;
mod errors;
mod long_call;
mod mirror;
mod profile;

use pyo3::prelude::*;

/// Native part of the package `morion`.
#[pymodule]
mod _morion {
    #[pymodule_export]
    use super::commands::decode_png;
    #[pymodule_export]
    use super::commands::{
        blur, build, frame, machining, program, render, replay, table, tolerance, verify,
    };
    #[pymodule_export]
    use super::mirror::{NativeCamera, NativeDesign, NativeMesh};
    #[pymodule_export]
    use super::profile::{Profile, shipped};
}
