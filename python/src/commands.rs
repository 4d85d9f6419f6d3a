//! The program's commands: each gives its report as JSON and as text, its files in memory, and the folder of those that were published.

use crate::errors;
use crate::long_call::{Watch, long_call};
use crate::profile::Profile;
use morion::{
    Answer, BlurOptions, BuildOptions, Command, Effort, FrameOptions, MachiningOptions,
    ProgramOptions, RenderOptions, ReplayOptions, TableOptions, ToleranceOptions, Verify,
    VerifyOptions,
};
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a command came to.
struct Outcome {
    json: String,
    text: String,
    files: Vec<morion::OutputFile>,
    folder: Option<PathBuf>,
}

/// JSON, text, files in memory and folder.
type Found<'py> = (String, String, Bound<'py, PyDict>, Option<PathBuf>);

/// The keyword arguments of every command.
type Place = (Option<PathBuf>, Option<Py<PyAny>>);

fn run<'py>(
    py: Python<'py>,
    profile: &Profile,
    (out, progress): Place,
    work: impl FnOnce(&Job<'_>) -> Result<Outcome, String> + Send + 'static,
) -> PyResult<Found<'py>> {
    let profile = Arc::clone(&profile.inner);
    let Outcome { json, text, files, folder } = long_call(py, progress, move |watch| {
        work(&Job { profile: &profile, out: out.as_deref(), watch })
    })?;
    let found = PyDict::new(py);
    for file in files {
        found.set_item(file.name, PyBytes::new(py, &file.bytes))?;
    }
    Ok((json, text, found, folder))
}

/// A command to be run: on a profile, into a folder or into memory.
struct Job<'a> {
    profile: &'a morion::Profile,
    out: Option<&'a Path>,
    watch: &'a Watch,
}

impl Job<'_> {
    fn run<C: Command<Report: Answer>>(&self, command: &C) -> Result<Outcome, String> {
        let told = |error: morion::Error| error.to_string();
        let (report, files, folder) = match self.out {
            Some(out) => {
                let report = command.publish(self.profile, out, self.watch).map_err(told)?;
                (report, Vec::new(), Some(out.join(command.folder(self.profile))))
            }
            None => {
                let (report, files) = command.in_memory(self.profile, self.watch).map_err(told)?;
                (report, files, None)
            }
        };
        Ok(Outcome { json: report.json(), text: report.text(), files, folder })
    }
}

/// Every stage of a part.
#[pyfunction]
pub(crate) fn build<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    afresh: bool,
) -> PyResult<Found<'py>> {
    let effort = if afresh { Effort::Afresh } else { Effort::Least };
    run(py, profile, place, move |job| job.run(&BuildOptions { effort }))
}

/// A mesh file of any making, traced.
#[pyfunction]
pub(crate) fn verify<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    path: PathBuf,
    align: bool,
    radii_mm: [Option<f64>; 5],
) -> PyResult<Found<'py>> {
    let [probe_mm, ball_mm, cutter_mm, corner_mm, nose_mm] = radii_mm;
    let options =
        VerifyOptions { units: None, align, probe_mm, ball_mm, cutter_mm, corner_mm, nose_mm };
    run(py, profile, place, move |job| job.run(&Verify { path: &path, options }))
}

/// A study of the profile's tolerances.
#[pyfunction]
pub(crate) fn tolerance<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    range: [u64; 2],
    seed: u64,
    until: Option<f64>,
) -> PyResult<Found<'py>> {
    if range[0] >= range[1] {
        return Err(errors::error(
            py,
            "trials must be a number of at least 1, or (first, last + 1)",
        ));
    }
    let options = ToleranceOptions { range: range[0]..range[1], seed, until };
    run(py, profile, place, move |job| job.run(&options))
}

/// A trial as a part, with its pose.
#[pyfunction]
pub(crate) fn replay<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    trial: u64,
    seed: u64,
    without: Vec<String>,
) -> PyResult<Found<'py>> {
    run(py, profile, place, move |job| job.run(&ReplayOptions { trial, seed, without: &without }))
}

/// What the camera sees of a scene.
#[pyfunction]
pub(crate) fn render<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    scene: String,
    smooth: bool,
    sizes_mm: [Option<f64>; 2],
    allow_outside: bool,
) -> PyResult<Found<'py>> {
    run(py, profile, place, move |job| {
        let [square_mm, unit_mm] = sizes_mm;
        job.run(&RenderOptions { scene: &scene, smooth, square_mm, unit_mm, allow_outside })
    })
}

/// How well the sensor is filled.
#[pyfunction]
pub(crate) fn frame<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    min: Option<f64>,
) -> PyResult<Found<'py>> {
    run(py, profile, place, move |job| job.run(&FrameOptions { min }))
}

/// The blur of each pixel by the profile's aperture.
#[pyfunction]
pub(crate) fn blur<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    focus_mm: Option<f64>,
) -> PyResult<Found<'py>> {
    run(py, profile, place, move |job| job.run(&BlurOptions { focus_mm, ..BlurOptions::default() }))
}

/// What a ball cutter leaves.
#[pyfunction]
pub(crate) fn machining<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    ball_mm: f64,
    stepover_mm: Option<f64>,
) -> PyResult<Found<'py>> {
    let options = MachiningOptions { ball_mm, stepover_mm, ..MachiningOptions::default() };
    run(py, profile, place, move |job| job.run(&options))
}

/// Programs that mill or turn the mirror.
#[pyfunction]
pub(crate) fn program<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
) -> PyResult<Found<'py>> {
    run(py, profile, place, move |job| job.run(&ProgramOptions))
}

/// Tables of what each pixel looks at.
#[pyfunction]
pub(crate) fn table<'py>(
    py: Python<'py>,
    profile: &Profile,
    place: Place,
    every: usize,
    floor_mm: Option<f64>,
    range_mm: Option<f64>,
    pose: Option<PathBuf>,
) -> PyResult<Found<'py>> {
    run(py, profile, place, move |job| {
        let pose = pose.as_deref();
        job.run(&TableOptions { every, floor_mm, range_mm, pose, ..TableOptions::default() })
    })
}

/// Light of a PNG: shape (rows, columns, channels).
#[pyfunction]
pub(crate) fn decode_png<'py>(py: Python<'py>, bytes: &[u8]) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let fail = |error: png::DecodingError| errors::error(py, &error.to_string());
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(fail)?;
    let size = reader.output_buffer_size().unwrap_or(0);
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(fail)?;
    pixels.truncate(info.buffer_size());
    let shape = [info.height as usize, info.width as usize, info.color_type.samples()];
    PyArray1::from_vec(py, pixels).reshape(shape)
}
