//! The mirror stage by stage: design, mesh, and the camera with it.

use crate::arrays::{or_nan, rows, vectors};
use crate::long_call::long_call;
use crate::profile::Profile;
use morion::{Rows, Stage, UnwrapPicture, ViewAngles};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A designed mirror.
#[pyclass(frozen, module = "morion._morion")]
pub(crate) struct NativeDesign {
    inner: Arc<morion::Design>,
}

/// Origins and directions.
type Rays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Sag, normals and second derivatives over places.
type Surface<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl NativeDesign {
    #[new]
    #[pyo3(signature = (profile, progress=None))]
    fn new(py: Python<'_>, profile: &Profile, progress: Option<Py<PyAny>>) -> PyResult<Self> {
        let profile = Arc::clone(&profile.inner);
        let design = long_call(py, progress, move |watch| {
            let design = watch.stage(Stage::Design, || profile.design());
            design.map_err(|error| format!("cannot design {}: {error}", profile.name))
        })?;
        Ok(Self { inner: Arc::new(design) })
    }

    /// Figures of merit, as JSON.
    #[getter]
    fn facts(&self) -> PyResult<String> {
        let facts = serde_json::to_string(&self.inner.facts);
        facts.map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Least and largest X and Y of the part, mm.
    #[getter]
    fn plan_bounds(&self) -> [[f64; 2]; 2] {
        let bounds = self.inner.plan_bounds();
        [bounds.min.to_array(), bounds.max.to_array()]
    }

    /// Side of a pixel on the reference plane, mm.
    #[getter]
    fn pixel_mm(&self) -> f64 {
        self.inner.camera.pixel_mm
    }

    /// Volume of the part, mm^3.
    #[getter]
    fn volume_mm3(&self) -> f64 {
        self.inner.volume()
    }

    /// Sag, normals and second derivatives over places, shape (n, 2).
    fn surface<'py>(
        &self,
        py: Python<'py>,
        places: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Surface<'py>> {
        let (design, places) = (Arc::clone(&self.inner), vectors(&places)?);
        let (sag, normals, hessians) = long_call(py, None, move |_| {
            let found = design.points_over(&places);
            let sag = found.iter().map(|point| point.map_or(f64::NAN, |point| point.sag_mm));
            let sag: Vec<f64> = sag.collect();
            let normals = found.iter().map(|point| point.map(|point| point.normal)).collect();
            let hessians = found.iter().map(|point| point.map(|point| point.hessian)).collect();
            Ok((sag, or_nan(normals), or_nan(hessians)))
        })?;
        Ok((PyArray1::from_vec(py, sag), rows(py, normals)?, rows(py, hessians)?))
    }

    /// The optical face.
    #[pyo3(signature = (progress=None))]
    fn mesh(&self, py: Python<'_>, progress: Option<Py<PyAny>>) -> PyResult<NativeMesh> {
        let design = Arc::clone(&self.inner);
        let face = long_call(py, progress, move |watch| {
            watch.stage(Stage::Mesh, || design.mesh().map_err(|error| error.to_string()))
        })?;
        let pixel_mm = self.inner.camera.pixel_mm;
        let bounds = vec![
            ("chord_um", 1e3 * face.bound.chord_mm),
            ("facet_px", face.bound.facet_mm / pixel_mm),
            ("rounding_px", face.bound.rounding_mm / pixel_mm),
        ];
        let mesh = face.mesh.into_mesh();
        let vertices = mesh.vertices.into_iter().map(|vertex| vertex.to_array()).collect();
        let vertices = rows::<f64, 3>(py, vertices)?.unbind();
        let triangles = rows(py, mesh.triangles)?.unbind();
        Ok(NativeMesh { vertices, triangles, bounds })
    }

    /// The camera with the mirror, as designed or as mounted by a `pose.json`.
    fn mounted(&self, py: Python<'_>, pose: Option<PathBuf>) -> PyResult<NativeCamera> {
        let design = Arc::clone(&self.inner);
        let camera = long_call(py, None, move |_| {
            design.mounted(pose.as_deref()).map_err(|error| error.to_string())
        })?;
        Ok(NativeCamera { inner: Arc::new(camera) })
    }

    /// Column and row of photos for each pixel of a picture.
    fn unwrap_map<'py>(
        &self,
        py: Python<'py>,
        picture: PictureArguments,
        photo: [usize; 2],
        pose: Option<PathBuf>,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let (design, picture) = (Arc::clone(&self.inner), picture.picture()?);
        let (entries, [width, height]) = long_call(py, None, move |_| {
            let map = design.unwrap_map(&picture, photo, pose.as_deref());
            map.map(|map| (map.entries(), map.size)).map_err(|error| error.to_string())
        })?;
        PyArray1::from_vec(py, entries.into_flattened()).reshape([height, width, 2])
    }
}

/// What photos are unwrapped to: a law's name, angles of a view, or the height of a floor; and the size.
#[derive(FromPyObject)]
struct PictureArguments {
    #[pyo3(item)]
    projection: Option<String>,
    #[pyo3(item)]
    view: Option<[f64; 3]>,
    #[pyo3(item)]
    ground_mm: Option<f64>,
    #[pyo3(item)]
    width: Option<usize>,
    #[pyo3(item)]
    height: Option<usize>,
    #[pyo3(item)]
    range_mm: Option<f64>,
    #[pyo3(item)]
    mm_per_px: Option<f64>,
}

impl PictureArguments {
    fn picture(self) -> PyResult<UnwrapPicture> {
        let Self { projection, view, ground_mm, width, height, range_mm, mm_per_px } = self;
        if let Some(height_mm) = ground_mm {
            return Ok(UnwrapPicture::Ground { height_mm, range_mm, mm_per_px });
        }
        if let Some([azimuth_deg, elevation_deg, field_deg]) = view {
            let angles = ViewAngles { azimuth_deg, elevation_deg, field_deg };
            return Ok(UnwrapPicture::View { angles, width, height });
        }
        let projection = match projection.as_deref() {
            None => None,
            Some("cylindrical") => Some(Rows::Cylindrical),
            Some("equirectangular") => Some(Rows::Equirectangular),
            Some("mercator") => Some(Rows::Mercator),
            Some(other) => {
                let must = "projection must be cylindrical, equirectangular or mercator";
                return Err(PyValueError::new_err(format!("{must}, found {other}")));
            }
        };
        Ok(UnwrapPicture::Panorama { projection, width })
    }
}

/// Triangles of the optical face.
#[pyclass(frozen, get_all, module = "morion._morion")]
pub(crate) struct NativeMesh {
    /// Positions, mm: shape (n, 3).
    vertices: Py<PyArray2<f64>>,
    /// Numbers of vertices: shape (m, 3).
    triangles: Py<PyArray2<u32>>,
    /// Names and values of the bounds that are proven.
    bounds: Vec<(&'static str, f64)>,
}

/// The camera with the mirror, as designed or as mounted.
#[pyclass(frozen, module = "morion._morion")]
pub(crate) struct NativeCamera {
    inner: Arc<morion::MountedCamera>,
}

#[pymethods]
impl NativeCamera {
    /// A warning where the pose was written for another profile.
    #[getter]
    fn warning(&self) -> Option<&str> {
        self.inner.warning()
    }

    /// Picture points of points, or of directions, shape (n, 3).
    fn project<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        at_infinity: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (camera, points) = (Arc::clone(&self.inner), vectors(&points)?);
        let found = long_call(py, None, move |_| {
            Ok(or_nan(match at_infinity {
                true => camera.project_directions(&points),
                false => camera.project(&points),
            }))
        })?;
        rows(py, found)
    }

    /// Origins and directions of the rays that picture points see, shape (n, 2).
    fn unproject<'py>(
        &self,
        py: Python<'py>,
        pixels: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<Rays<'py>> {
        let (camera, pixels) = (Arc::clone(&self.inner), vectors(&pixels)?);
        let (origins, ways) = long_call(py, None, move |_| {
            let rays = camera.unproject(&pixels);
            let of = |k: usize| rays.iter().map(|ray| ray.map(|ray| ray[k])).collect();
            Ok((or_nan(of(0)), or_nan(of(1))))
        })?;
        Ok((rows(py, origins)?, rows(py, ways)?))
    }
}
